"""What motors, gears, bearings and the foundation bear."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from robodyn.loads.result import JointLoad, Result
from robodyn.loads.sizing_result import Exceeded, JointSizing, MotorLoad, Sizing
from robodyn.report.document import Facts, Paragraph, Section, Table
from robodyn.report.sizes import Sizes, result_sizes, speed_unit
from robodyn.report.table import Content, axis_text, is_noise, moment, number

_WORDS = {
    "motor torque": "the motor's torque",
    "motor speed": "the motor's speed",
    "RMS motor torque": "the motor's RMS torque",
    "gear torque": "the gear's torque",
    "mean gear torque": "the gear's cubic mean torque",
    "effort": "the joint's torque",
    "velocity": "the joint's speed",
}
_WORST = ("over peak", "over continuous", "OK", "no limits")
_LIMITS = {
    "motor torque": "the peak curve allows",
    "motor speed": "it may have",
    "RMS motor torque": "the continuous curve allows",
    "gear torque": "the gear bears",
    "mean gear torque": "the gear bears",
    "effort": "the description allows",
    "velocity": "the description allows",
}


def sizing_sections(result: Result) -> Iterator[Section]:
    """Yield use of joints, motors, bearings, foundation, and a verdict for each joint."""
    sizing = result.sizing
    if sizing is None:
        return
    if sizing.joints:
        yield [Table("How joints are used", *_use(result, sizing))]
    size = result_sizes(result)
    if any(joint.motor for joint in sizing.joints):
        yield [Table("Motors, torque and speed at their shafts", *_motors(sizing, size))]
    if sizing.bearings:
        title = "Bearings: largest loads, parent on child, at the joint's origin"
        yield [Table(title, *_bearings(sizing, size))]
    yield [Table("Foundation: ground on robot, in the base's axes", *_foundation(sizing, size))]
    if sizing.joints:
        yield [Paragraph("Verdicts"), verdicts(result.joints, sizing)]


def verdicts(loads: Sequence[JointLoad], sizing: Sizing) -> Facts:
    """Return of each joint in plain words everything that it exceeds, or how near it comes to its limits, the worst
    first."""
    pairs = sorted(zip(loads, sizing.joints, strict=True), key=lambda pair: _WORST.index(pair[1].level))
    each = [_verdict(load, joint) for load, joint in pairs]
    return Facts(tuple((name, line, "") for lines in each for name, line in lines))


def _verdict(load: JointLoad, joint: JointSizing) -> Iterator[tuple[str, str]]:
    if not joint.exceeded:
        nearness = ", ".join(_nearness(load, joint.motor))
        yield joint.name, f"OK: {nearness}" if nearness else "OK" if joint.level == "OK" else "no limits are known"
    for k, exceeded in enumerate(joint.exceeded):
        yield "" if k else joint.name, f"{exceeded.level.upper()}: {in_words(exceeded)}"


def in_words(exceeded: Exceeded) -> str:
    """Return what is too large, by how much, when, and for how long."""
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
    size = result_sizes(result)
    rows = []
    for joint, load in zip(sizing.joints, result.joints, strict=True):
        torque, unit = size[joint.unit], speed_unit(joint.unit)
        speed = size[unit]
        rows.append(
            (
                joint.name,
                f"{100 * joint.duty_cycle:.3g} %",
                f"{number(joint.mean_speed, speed)} {unit}",
                moment(load.peak_row, load.peak, torque),
                number(load.peak_speed, speed),
                moment(load.max_speed_time, load.max_speed, speed),
                number(load.torque_at_max_speed, torque),
                number(load.least_power, size["W"]),
                f"{number(joint.static_peak, torque)} {joint.unit}",
                number(joint.static_rms, torque),
                _share(joint.static_share) if not is_noise(load.rms, torque) else "-",
            )
        )
    head = ("joint", "duty", "mean speed", "peak in row", "speed then", "max speed at [s]", "torque then")
    return (*head, "least power [W]", "static peak", "static RMS", "hold share"), rows


def _share(share: float) -> str:
    """Return a share in percent, 0 where it is less than a thousandth of one."""
    return f"{number(100 * share)} %" if share >= 1e-5 else "0 %"


def _motors(sizing: Sizing, size: Sizes) -> Content:
    rows = []
    for joint in sizing.joints:
        motor = joint.motor
        if motor is None:
            continue
        torque = max(size[joint.unit] / motor.gear, abs(motor.peak))
        speed = max(size[speed_unit(joint.unit)] * motor.gear, abs(motor.max_speed))
        rows.append(
            (
                joint.name,
                f"{motor.gear:.6g}",
                f"{motor.efficiency:g}",
                f"{number(motor.peak, torque)} {motor.unit}",
                moment(motor.peak_time, motor.peak, torque),
                number(motor.peak_speed, speed),
                number(motor.rms, torque),
                f"{number(motor.max_speed, speed)} {motor.speed_unit}",
                number(motor.torque_at_max_speed, torque),
                number(motor.mean_speed, speed),
                number(motor.peak_power, size["W"]),
                number(motor.least_power, size["W"]),
                number(motor.work_positive, size["J"]),
                number(motor.work_negative, size["J"]),
                "-" if motor.inertia_ratio is None else f"{motor.inertia_ratio:.3g}",
            )
        )
    head = ("joint", "gear", "efficiency", "peak", "at [s]", "speed then", "RMS", "max speed", "torque then")
    return (*head, "mean speed", "peak power [W]", "least", "work [J]", "returned [J]", "inertia ratio"), rows


def _bearings(sizing: Sizing, size: Sizes) -> Content:
    rows = []
    for bearing in sizing.bearings:
        found = {part.name: part for part in (*bearing.components, bearing.radial, bearing.tilting)}
        cells = [
            number(found[name].peak, size[found[name].unit]) if name in found else "-"
            for name in ("fu", "fv", "fa", "mu", "mv", "ma", "radial", "tilting")
        ]
        most = (found[name] for name in ("radial", "tilting"))
        when = [moment(part.peak_time, part.peak, size[part.unit]) for part in most]
        axes = (axis_text(axis, "{:.3g}", " ") for axis in bearing.directions)
        rows.append((bearing.joint, *axes, *cells[:7], when[0], cells[7], when[1]))
    head = ("joint", "u", "v", "axis a", "fu [N]", "fv", "fa", "mu [N m]", "mv", "ma")
    return (*head, "radial f", "at [s]", "tilting m", "at [s]"), rows


def _foundation(sizing: Sizing, size: Sizes) -> Content:
    rows = []
    for load in sizing.foundation:
        scale = size[load.unit]
        name = f"{load.name[0].upper()}{load.name[1:]}"
        greatest, least = (
            (number(value, scale), moment(time, value, scale))
            for value, time in ((load.greatest, load.greatest_time), (load.least, load.least_time))
        )
        rows.append((name, f"{greatest[0]} {load.unit}", greatest[1], *least, number(load.mean, scale)))
    return ("", "greatest", "at [s]", "least", "at [s]", "mean"), rows
