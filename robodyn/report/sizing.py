"""What motors, gears, bearings, the foundation, loops and contacts bear along a motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from robodyn.loads.constraint_result import Constraints, ContactLoad
from robodyn.loads.result import Exceeded, JointLoad, JointSizing, MotorLoad, Result, Sizing
from robodyn.report.document import Facts, Paragraph, Section, Table
from robodyn.report.sizes import Sizes, result_sizes, speed_unit
from robodyn.report.table import (
    Content,
    axis_text,
    first_names,
    is_noise,
    moment,
    number,
    point_text,
)
from robodyn.support.wording import count, figure

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
        yield [Table(title, (*head, "radial f", "at [s]", "tilting m", "at [s]"), rows)]
    yield [Table("Foundation: ground on robot, in the base's axes", *_foundation(sizing, size))]
    if sizing.joints:
        yield [Paragraph("Verdicts"), verdicts(result.joints, sizing)]


def verdicts(loads: Sequence[JointLoad], sizing: Sizing) -> Facts:
    """Return of each joint in plain words everything that it exceeds, or how near it comes to its limits, the worst
    first."""
    pairs = sorted(zip(loads, sizing.joints, strict=True), key=lambda pair: _WORST.index(pair[1].level))
    each = [_verdict(load, joint) for load, joint in pairs]
    return Facts(tuple(line for lines in each for line in lines))


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
        row = [joint.name, f"{100 * joint.duty_cycle:.3g} %", f"{number(joint.mean_speed, speed)} {unit}"]
        row += [moment(load.peak_row, load.peak, torque), number(load.peak_speed, speed)]
        row += [moment(load.max_speed_time, load.max_speed, speed), number(load.torque_at_max_speed, torque)]
        row += [number(load.least_power, size["W"]), f"{number(joint.static_peak, torque)} {joint.unit}"]
        share = f"{number(100 * joint.static_share)} %" if joint.static_share >= 1e-5 else "0 %"
        rows.append((*row, number(joint.static_rms, torque), "-" if is_noise(load.rms, torque) else share))
    head = ("joint", "duty", "mean speed", "peak in row", "speed then", "max speed at [s]", "torque then")
    return (*head, "least power [W]", "static peak", "static RMS", "hold share"), rows


def _motors(sizing: Sizing, size: Sizes) -> Content:
    rows = []
    for joint in sizing.joints:
        motor = joint.motor
        if motor is None:
            continue
        torque = max(size[joint.unit] / motor.gear, abs(motor.peak))
        speed = max(size[speed_unit(joint.unit)] * motor.gear, abs(motor.max_speed))
        row = [joint.name, f"{motor.gear:.6g}", f"{motor.efficiency:g}", f"{number(motor.peak, torque)} {motor.unit}"]
        row += [moment(motor.peak_time, motor.peak, torque), number(motor.peak_speed, speed), number(motor.rms, torque)]
        row += [f"{number(motor.max_speed, speed)} {motor.speed_unit}", number(motor.torque_at_max_speed, torque)]
        row += [number(motor.mean_speed, speed)]
        row += [number(power, size["W"]) for power in (motor.peak_power, motor.least_power)]
        row += [number(work, size["J"]) for work in (motor.work_positive, motor.work_negative)]
        rows.append((*row, "-" if motor.inertia_ratio is None else f"{motor.inertia_ratio:.3g}"))
    head = ("joint", "gear", "efficiency", "peak", "at [s]", "speed then", "RMS", "max speed", "torque then")
    return (*head, "mean speed", "peak power [W]", "least", "work [J]", "returned [J]", "inertia ratio"), rows


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


_FINE = 1e3
"""mm beside which the places of centres of pressure are noise or not."""
_FEW, _NAMED = 3, 8
"""Joints that are named instead of counted, and that are named at most."""
_MISSING = {"slip": "would slip", "pull": "had to pull", "tip": "would tip over", "fly": "stands on nothing"}


def constraint_tables(result: Result) -> Iterator[tuple[str, Content]]:
    """Yield titles and tables: loops, contacts, spans without contact forces, what passive joints lack."""
    found, size = result.constraints, result_sizes(result)
    assert found is not None
    if found.loops:
        rows = []
        for loop in found.loops:
            force, turning = loop.force.value, loop.moment.value
            row = [loop.name, loop.link, loop.to, loop.kind, size.number(force, "N")]
            row += [size.moment(loop.force.time, force, "N"), size.number(loop.rms_force, "N")]
            row += [size.number(turning, "N m"), size.number(loop.rms_moment, "N m")]
            rows.append((*row, "yes" if loop.determined else f"but {', '.join(loop.open)}"))
        head = ("loop", "on", "by", "kind", "force [N]", "at [s]", "RMS", "moment [N m]", "RMS", "determined")
        yield "Loops: force and moment on the link", (head, rows)
    if found.contacts:
        yield "Contacts: what the link stands on, while it does", _contact_table(found.contacts, size)
    if found.missing:
        span_head = ("from [s]", "to [s]", "the robot", "force missing [N]", "moment missing [N m]")
        spans = [
            (f"{x.start:.4g}", f"{x.end:.4g}", _MISSING[x.kind], figure(x.force.value), figure(x.moment.value))
            for x in found.missing
        ]
        yield "Where no contact forces balance the motion", (span_head, spans)
    if found.unbalanced:
        lacks = [(x.name, f"{figure(x.most.value)} {x.unit}", f"{x.most.time:.4g}") for x in found.unbalanced]
        title = "What the motion takes at passive joints and nothing gives"
        yield title, (("joint", "most", "at [s]"), lacks)


def constraint_lines(found: Constraints) -> Iterator[str]:
    """Yield in words: ranks and freedoms, which torques are determined, how others were chosen, the least friction."""
    yield _ranks(found)
    open_drives = [name for name, sure in found.determined.items() if not sure]
    if found.determined and not open_drives:
        yield "All torques are determined: no others balance the motion."
    elif open_drives and len(open_drives) == len(found.determined):
        yield f"No torque is determined by the motion alone: of all that balance it, {found.share} are taken."
    elif open_drives:
        open_names = first_names(open_drives, _NAMED)
        yield f"Not determined by the motion alone: {open_names}; of all that balance it, {found.share} are taken."
    if open_loops := [f"{loop.name} {', '.join(loop.open)}" for loop in found.loops if not loop.determined]:
        yield f"Loop forces that are not determined, of which the least are given: {first_names(open_loops, _NAMED)}."
    if found.undriven:
        yield f"Moved by no drive: {first_names(found.undriven, _NAMED)}."
    if found.followed:
        yield f"Follow from the loops, for want of columns: {first_names(found.followed, _NAMED)}."
    if found.contacts:
        if found.least_friction is None:
            yield "No friction suffices for this motion."
        elif not found.least_friction:
            yield "The motion takes no friction."
        else:
            yield f"The least friction that suffices, alike at all contacts: {figure(found.least_friction)}."
    if found.beyond_limits is not None:
        since = figure(found.beyond_limits)
        yield f"From {since} s on there are samples at which no contact forces keep the effort limits."


def _ranks(found: Constraints) -> str:
    names = list(found.determined)
    who = first_names(names, _FEW) if len(names) <= _FEW else count(len(names), "joint")
    drives = f"{who} {'drives' if len(names) == 1 else 'drive'}" if names else "no joint drives"
    if not found.equations:
        return f"{drives[:1].upper()}{drives[1:]}." if not found.determined else f"{drives}."
    over = f", {found.overconstrained} of which others imply" if found.overconstrained else ""
    freedoms = "degree of freedom" if found.freedoms == 1 else "degrees of freedom"
    spare = f", {found.redundancy} more than the freedoms that they drive" if found.redundancy else ""
    return f"{count(found.equations, 'equation')} of loops{over}; {found.freedoms} {freedoms}; {drives}{spare}."


def _contact_table(contacts: tuple[ContactLoad, ...], size: Sizes) -> Content:
    rows = []
    for each in contacts:
        force, used, margin = each.force, each.friction_used, each.margin
        row = [each.name, f"{100 * each.on:.0f} %", size.number(force.value, "N")]
        row += [size.moment(force.time, force.value, "N")]
        row += [f"{size.number(each.least_normal.value, 'N')} to {size.number(each.normal.value, 'N')}"]
        row += [f"{each.friction:g}", f"{100 * used.value:.0f}%" if used else "", f"{used.time:.4g}" if used else ""]
        row += [f"{1e3 * margin.value:.3g}", f"{margin.time:.4g}"] if margin else ["", ""]
        rows.append([*row, point_text((1e3 * x for x in each.centre), _FINE) if each.centre else ""])
    head = ["contact", "on", "force [N]", "at [s]", "along normal [N]", "friction", "of it used", "at [s]"]
    head += ["margin [mm]", "at [s]", "centre of pressure [mm]"]
    kept = 11 if any(each.margin for each in contacts) else 8
    return head[:kept], [row[:kept] for row in rows]
