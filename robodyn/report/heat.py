"""How hot motors get and what they take from the DC bus, as charts."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robodyn.loads.result import DEGREES, Result
from robodyn.loads.temperature import Heat
from robodyn.report import document as doc
from robodyn.report.charts import plane_chart, time_chart
from robodyn.report.table import number, printable
from robodyn.support.floats import Floats


def heat_charts(result: Result, heat: Heat) -> Iterator[doc.Chart]:
    """Yield of each motor its temperatures over the motion, done once and repeated for ever; losses in windings and the
    power of the bus; then how each motor gets hot, cycle by cycle."""
    motors = {joint.name: joint.motor for joint in (result.sizing.joints if result.sizing else ())}
    over_cycles = []
    for course in heat.courses:
        motor, name, curves = motors[course.name], printable(course.name), dict[str, Floats]()
        assert motor is not None
        assert motor.heat is not None
        limit, ambient = motor.heat.winding_limit, motor.heat.ambient
        for label, states in (("repeated", course.steady), ("once", course.once)):
            if states is not None:
                curves |= {f"winding, {label}": states[:, 0], f"housing, {label}": states[:, 1]}
        reached = max([course.hottest.max(), *(x.max() for x in (course.steady, course.once) if x is not None)])
        near = reached - ambient >= 0.5 * (limit - ambient)
        alt = f"Temperatures of the motor of {name} along the motion, once and for ever; limit {limit:g} {DEGREES}"
        levels = [(limit, "limit")] if near else []
        caption = f"{name}: temperature [{DEGREES}]"
        yield time_chart(caption, alt, course.time, curves, DEGREES, levels=levels)
        minutes = course.begins / 60.0
        lines = {part: (minutes, course.hottest[:, k]) for k, part in enumerate(("winding", "housing"))}
        lines |= {"limit": (minutes[[0, -1]], np.full(2, limit))} if near else {}
        title, colours = (
            f"{name}: hottest of each cycle",
            {"winding": "c1", "housing": "c2", "limit": "bad"},
        )
        alt = f"{title}, from {number(course.hottest[0, 0])} to {number(course.hottest[-1, 0])} {DEGREES}"
        axes = "time since the start [min]", f"temperature [{DEGREES}]"
        over_cycles.append(plane_chart(title, alt, *axes, lines=lines, colours=colours))
    time, bus = heat.courses[0].time, heat.bus
    losses = {printable(course.name): course.copper for course in heat.courses[:10]}
    yield time_chart("Copper losses [W]", "Losses in windings over time", time, losses, "W")
    alt = f"Power of the DC bus over time: at most {number(bus.peak_power)} W, at least {number(bus.least_power)} W"
    yield time_chart("DC bus: power [W]", alt, time, {"bus": heat.power}, "W")
    yield from over_cycles
