"""What motors, gears, bearings and the foundation bear, as text for a person."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from robodyn.report.table import Content, Page, number, printable
from robodyn.result import JointLoad, Result
from robodyn.sizing_result import BearingLoad, Exceeded, JointSizing, MotorLoad, Sizing

_WORDS = {
    "motor torque": "the motor's torque",
    "motor speed": "the motor's speed",
    "RMS motor torque": "the motor's RMS torque",
    "gear torque": "the gear's torque",
    "mean gear torque": "the gear's cubic mean torque",
    "effort": "the joint's torque",
    "velocity": "the joint's speed",
}
_LIMITS = {
    "motor torque": "the peak curve allows",
    "motor speed": "it may have",
    "RMS motor torque": "the continuous curve allows",
    "gear torque": "the gear bears",
    "mean gear torque": "the gear bears",
    "effort": "the description allows",
    "velocity": "the description allows",
}


def sizing_parts(result: Result, page: Page) -> Iterator[str]:
    """The parts of the report on sizing: use of joints, motors, bearings, foundation, and a verdict for each joint."""
    sizing = result.sizing
    if sizing is None:
        return
    if sizing.joints:
        yield f"How joints are used\n{page.table(_use(result, sizing))}"
    driven = [(joint.name, joint.motor) for joint in sizing.joints if joint.motor is not None]
    if driven:
        yield f"Motors, torque and speed at their shafts\n{page.table(_motors(driven))}"
    if sizing.bearings:
        yield f"Bearings: largest loads, parent on child, at the joint's origin\n{page.table(_bearings(sizing))}"
    yield f"Foundation: ground on robot, in the base's axes\n{page.table(_foundation(result, sizing))}"
    if sizing.joints:
        yield "".join(["Verdicts\n", *(f"{line}\n" for line in verdicts(result.joints, sizing))])


def verdicts(loads: Sequence[JointLoad], sizing: Sizing) -> Iterator[str]:
    """For each joint one line in plain words for everything that it exceeds, or how near it comes to its limits."""
    wide = max((len(printable(joint.name)) for joint in sizing.joints), default=0)
    for load, joint in zip(loads, sizing.joints, strict=True):
        for name, line in _verdict(load, joint):
            yield f"{printable(name):{wide}}  {line}"


def _verdict(load: JointLoad, joint: JointSizing) -> Iterator[tuple[str, str]]:
    if not joint.exceeded:
        nearness = ", ".join(_nearness(load, joint.motor))
        yield joint.name, f"OK: {nearness}" if nearness else "OK" if joint.level == "OK" else "no limits are known"
    for k, exceeded in enumerate(joint.exceeded):
        yield "" if k else joint.name, f"{exceeded.level.upper()}: {in_words(exceeded)}"


def in_words(exceeded: Exceeded) -> str:
    """What is too large, by how much, when, and for how long."""
    unit, limit = exceeded.unit, exceeded.limit
    text = f"{_WORDS[exceeded.quantity]} is {number(exceeded.value)} {unit}, "
    text += f"{100 * exceeded.excess / limit:.3g} % above the {number(limit)}" if limit > 0 else "above the 0"
    text += f" {unit} that {_LIMITS[exceeded.quantity]}"
    if exceeded.speed is not None:
        mean = "a mean speed of " if exceeded.time is None else ""
        text += f" at {mean}{number(exceeded.speed)} {'m/s' if unit == 'N' else 'rad/s'}"
    if exceeded.time is not None:
        text += f"; worst at {exceeded.time:.6g} s (row {exceeded.row})"
    return text if exceeded.seconds is None else f"{text}, over for {exceeded.seconds:.3g} s in all"


def _nearness(load: JointLoad, motor: MotorLoad | None) -> Iterator[str]:
    if motor is not None:
        near = motor.nearest
        if near is not None:
            yield f"{_percent(near.torque, near.limit)} of the peak curve at {near.time:.6g} s"
        if motor.continuous_limit is not None:
            yield f"{_percent(motor.rms, motor.continuous_limit)} of the continuous torque"
        if motor.speed_limit is not None:
            yield f"{_percent(abs(motor.max_speed), motor.speed_limit)} of the motor's speed"
    if load.effort_limit is not None:
        yield f"{_percent(abs(load.peak), load.effort_limit)} of the effort limit"
    if load.velocity_limit is not None:
        yield f"{_percent(abs(load.max_speed), load.velocity_limit)} of the velocity limit"


def _percent(value: float, limit: float) -> str:
    percent = 100.0 * value / limit if limit > 0 else 0.0
    return "<1 %" if 0.0 < percent < 0.5 else f"{percent:.0f} %"


def _use(result: Result, sizing: Sizing) -> Content:
    rows = [
        (
            joint.name,
            f"{100 * joint.duty_cycle:.3g} %",
            f"{number(joint.mean_speed, load.max_speed)} {'rad/s' if joint.unit == 'N m' else 'm/s'}",
            str(load.peak_row),
            number(load.peak_speed, load.max_speed),
            f"{load.max_speed_time:.6g}",
            number(load.torque_at_max_speed, load.peak),
            number(load.least_power, max(load.peak_power, -load.least_power)),
            f"{number(joint.static_peak, load.peak)} {joint.unit}",
            number(joint.static_rms, load.peak),
            f"{number(100 * joint.static_share, 100.0)} %",
        )
        for joint, load in zip(sizing.joints, result.joints, strict=True)
    ]
    head = ("joint", "duty", "mean speed", "peak in row", "speed then", "max speed at [s]", "torque then")
    return (*head, "least power [W]", "static peak", "static RMS", "hold share"), rows


def _motors(driven: list[tuple[str, MotorLoad]]) -> Content:
    rows = [
        (
            name,
            f"{motor.gear:.6g}",
            f"{motor.efficiency:g}",
            f"{number(motor.peak)} {motor.unit}",
            f"{motor.peak_time:.6g}",
            number(motor.peak_speed, motor.max_speed),
            number(motor.rms),
            f"{number(motor.max_speed)} {motor.speed_unit}",
            number(motor.torque_at_max_speed, motor.peak),
            number(motor.mean_speed, motor.max_speed),
            number(motor.peak_power, max(motor.peak_power, -motor.least_power)),
            number(motor.least_power, max(motor.peak_power, -motor.least_power)),
            number(motor.work_positive),
            number(motor.work_negative),
            "-" if motor.inertia_ratio is None else f"{motor.inertia_ratio:.3g}",
        )
        for name, motor in driven
    ]
    head = ("joint", "gear", "efficiency", "peak", "at [s]", "speed then", "RMS", "max speed", "torque then")
    return (*head, "mean speed", "peak power [W]", "least", "work [J]", "returned [J]", "inertia ratio"), rows


def _bearings(sizing: Sizing) -> Content:
    rows = []
    for bearing in sizing.bearings:
        found = {part.name: part for part in (*bearing.components, bearing.radial, bearing.tilting)}
        scale = {"N": 0.0, "N m": 0.0}
        for other in sizing.bearings:
            for part in other.components:
                scale[part.unit] = max(scale[part.unit], abs(part.peak))
        cells = [
            number(found[name].peak, scale[found[name].unit]) if name in found else "-"
            for name in ("fu", "fv", "fa", "mu", "mv", "ma", "radial", "tilting")
        ]
        when = [f"{found[name].peak_time:.6g}" for name in ("radial", "tilting")]
        rows.append((bearing.joint, *_axes(bearing), *cells[:6], cells[6], when[0], cells[7], when[1]))
    head = ("joint", "u", "v", "axis a", "fu [N]", "fv", "fa", "mu [N m]", "mv", "ma")
    return (*head, "radial f", "at [s]", "tilting m", "at [s]"), rows


def _axes(bearing: BearingLoad) -> list[str]:
    """x, y, z, -x ... where a direction is along a coordinate axis, and otherwise its components."""
    names = []
    for direction in bearing.directions:
        k = max(range(3), key=lambda i: abs(direction[i]))
        whole = abs(direction[k]) == 1.0
        sign = "-" if direction[k] < 0 else ""
        names.append(f"{sign}{'xyz'[k]}" if whole else "({:.3g} {:.3g} {:.3g})".format(*direction))
    return names


def _foundation(result: Result, sizing: Sizing) -> Content:
    scale = {"N": result.checks.largest_force, "N m": result.checks.largest_moment}
    rows = []
    for load in sizing.foundation:
        least, greatest, mean = (number(x, scale[load.unit]) for x in (load.least, load.greatest, load.mean))
        name = f"{load.name[0].upper()}{load.name[1:]}"
        row = (name, f"{greatest} {load.unit}", f"{load.greatest_time:.6g}", least, f"{load.least_time:.6g}", mean)
        rows.append(row)
    return ("", "greatest", "at [s]", "least", "at [s]", "mean"), rows
