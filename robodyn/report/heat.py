"""How hot motors get and what they take from the DC bus, as charts."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robodyn.loads.result import DEGREES, Result
from robodyn.loads.temperature import Heat, MotorHeat
from robodyn.report import document as doc
from robodyn.report.charts import plane_chart, time_chart
from robodyn.report.table import number, printable


def heat_charts(result: Result, heat: Heat) -> Iterator[doc.Chart]:
    """Yield of each motor its temperatures over the motion, done once and in the steady state, and how they get there
    over cycles; then losses in windings, and power of motors and of the bus over time."""
    over_cycles, found = (
        list[doc.Chart](),
        {joint.name: joint.motor.heat for joint in (result.sizing.joints if result.sizing else ()) if joint.motor},
    )
    for course in heat.courses:
        motor = found[course.name]
        assert motor is not None
        name, curves = printable(course.name), {}
        for label, states in (("repeated", course.steady), ("once", course.once)):
            if states is not None:
                curves |= {f"winding, {label}": states[:, 0]}
                curves |= {f"housing, {label}": states[:, 1]} if motor.housed else {}
        levels = _levels(motor)
        said = f"Temperature of the motor of {name}: winding {_degrees(motor.winding_once)} once, {_degrees(motor.winding)} repeated"
        caption = f"{name}: temperature along the motion [{DEGREES}], limit {motor.winding_limit:g}"
        yield time_chart(caption, said, course.time, curves, DEGREES, levels=levels)
        minutes, parts = course.begins / 60.0, ("winding", "housing")[: 1 + motor.housed]
        lines = {part: (minutes, course.hottest[:, k]) for k, part in enumerate(parts)}
        if levels:
            lines["limit"] = np.array((0.0, minutes[-1])), np.full(2, motor.winding_limit)
        last = f"{number(minutes[-1])} min: {_degrees(float(course.hottest[-1, 0]))}"
        alt = f"Greatest temperatures of the motor of {name}, cycle by cycle, up to {last}"
        chart = plane_chart(
            f"{name}: greatest temperature of each cycle",
            alt,
            "time since the start [min]",
            f"temperature [{DEGREES}]",
            dots={},
            lines=lines,
            colours={"winding": "c1", "housing": "c2", "limit": "bad"},
        )
        over_cycles.append(chart)
    for caption, key in (("Losses in windings [W]", "copper"), ("Power from the DC bus, by motor [W]", "power")):
        bands = {printable(course.name): getattr(course, key) for course in heat.courses[:10]}
        yield time_chart(caption, caption, heat.courses[0].time, bands, "W")
    bus = heat.bus
    alt = f"Power of the DC bus over time: at most {number(bus.peak_power)} W, at least {number(bus.least_power)} W"
    yield time_chart("DC bus: power of all motors [W]", alt, heat.courses[0].time, {"bus": heat.bus_power}, "W")
    yield from over_cycles


def _levels(motor: MotorHeat) -> list[tuple[float, str]]:
    """Return the limits that are near: half of the rise that is allowed, or more."""
    hottest = max(each for each in (motor.start, motor.winding_once, motor.winding) if each is not None)
    near = hottest - motor.ambient >= 0.5 * (motor.winding_limit - motor.ambient)
    return [(motor.winding_limit, "limit")] if near or motor.winding is None else []


def _degrees(temperature: float | None) -> str:
    return "runs away" if temperature is None else f"{temperature:.4g} {DEGREES}"
