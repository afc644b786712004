"""How hot motors get and what they take from the DC bus, as charts."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robodyn.loads.result import DEGREES, Sizing
from robodyn.loads.temperature import Heat
from robodyn.report import document as doc
from robodyn.report.charts import plane_chart, time_chart
from robodyn.report.table import number, printable


def heat_charts(sizing: Sizing, heat: Heat) -> Iterator[doc.Chart]:
    """Yield how each motor gets hot, cycle by cycle; then along one cycle of the steady state windings and the power of
    the bus."""
    limits = {joint.name: joint.motor.heat for joint in sizing.joints if joint.motor}
    for course in heat.courses:
        given = limits[course.name]
        assert given is not None
        minutes, limit = course.begins / 60.0, given.winding_limit
        lines = {part: (minutes, course.hottest[:, k]) for k, part in enumerate(("winding", "housing"))}
        if course.hottest.max() - given.ambient >= 0.5 * (limit - given.ambient):  # else it would flatten the curves
            lines["limit"] = minutes[[0, -1]], np.full(2, limit)
        title, (first, last) = f"{printable(course.name)}: hottest of each cycle", course.hottest[[0, -1], 0]
        alt = f"{title}, the winding from {number(first)} to {number(last)} {DEGREES}; its limit is {limit:g}"
        axes, colours = ("time since the start [min]", f"temperature [{DEGREES}]"), {"limit": "bad"}
        yield plane_chart(title, alt, *axes, lines=lines, colours=colours)
    windings = {printable(each.name): each.winding for each in heat.courses if each.winding is not None}
    if windings:
        title = f"Windings, repeated for ever [{DEGREES}]"
        yield time_chart(title, "Temperatures of windings along the motion", heat.time, windings, DEGREES)
    alt = f"Power of the DC bus over time: at most {number(heat.bus.peak_power)} W, at least"
    power = {"bus": heat.power}
    yield time_chart("DC bus: power [W]", f"{alt} {number(heat.bus.least_power)} W", heat.time, power, "W")
