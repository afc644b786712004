"""How hot motors get and what they take from the DC bus, as charts."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robodyn.loads.result import DEGREES, Sizing
from robodyn.loads.temperature import Heat
from robodyn.report import document as doc
from robodyn.report.charts import plane_chart, time_chart
from robodyn.report.table import number, printable
from robodyn.support.floats import Floats

_FLAT = 0.1
"""A winding whose temperature changes less than this share of its rise along a cycle is not drawn along it."""


def heat_charts(sizing: Sizing, heat: Heat) -> Iterator[doc.Chart]:
    """Yield how windings get hot, cycle by cycle, with limits that are near; then along one cycle of the steady state
    those that change in it, and the power of the bus."""
    limits = {joint.name: joint.motor.heat for joint in sizing.joints if joint.motor}
    lines, colours, along = dict[str, tuple[Floats, Floats]](), dict[str, str](), dict[str, Floats]()
    for course in heat.courses:
        name, given, minutes = printable(course.name), limits[course.name], course.begins / 60.0
        assert given is not None
        lines[name] = minutes, course.hottest[:, 0]
        if course.hottest[:, 0].max() - given.ambient >= 0.5 * (given.winding_limit - given.ambient):
            lines[f"limit of {name}"] = minutes[[0, -1]], np.full(2, given.winding_limit)
            colours[f"limit of {name}"] = "bad"
        winding = course.winding
        if winding is not None and np.ptp(winding) > _FLAT * (winding.max() - given.ambient):
            along[name] = winding
    title, axes = "Windings: hottest of each cycle", ("time since the start [min]", f"temperature [{DEGREES}]")
    ends = ", ".join(f"{printable(each.name)} {number(each.hottest[-1, 0])} {DEGREES}" for each in heat.courses)
    yield plane_chart(title, f"{title}; at the end {ends}", *axes, lines=lines, colours=colours)
    if along:
        title = f"Windings, repeated for ever [{DEGREES}]"
        yield time_chart(title, "Temperatures of windings along the motion", heat.time, along, DEGREES)
    alt = f"Power of the DC bus over time: at most {number(heat.bus.peak_power)} W, at least"
    power = {"bus": heat.power}
    yield time_chart("DC bus: power [W]", f"{alt} {number(heat.bus.least_power)} W", heat.time, power, "W")
