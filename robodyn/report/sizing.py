"""What motors, gears, bearings, foundation, loops and contacts bear along a motion, and how sure that is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from robodyn.loads.constraint_result import Constraints
from robodyn.loads.result import Exceeded, JointLoad, JointSizing, Result, Sizing
from robodyn.loads.uncertainty_result import UncertainLoad
from robodyn.report.document import Facts, Paragraph, Section, Table, paragraphs
from robodyn.report.sizes import result_sizes, speed_unit
from robodyn.report.table import axis_text, first_names, is_noise, moment, number, point_text, printable
from robodyn.support.wording import count, figure

if TYPE_CHECKING:
    from robodyn.simulation.result import JointUse

_WORDS = {
    "motor torque": ("the motor's torque", "the peak curve allows"),
    "motor speed": ("the motor's speed", "it may have"),
    "RMS motor torque": ("the motor's RMS torque", "the continuous curve allows"),
    "gear torque": ("the gear's torque", "the gear bears"),
    "mean gear torque": ("the gear's cubic mean torque", "the gear bears"),
    "effort": ("the joint's torque", "the description allows"),
    "velocity": ("the joint's speed", "the description allows"),
}
"""Of a quantity what it is, and what limits it."""
_WORST = ("over peak", "over continuous", "OK", "no limits")
_FEW, _NAMED = 3, 8
"""Joints that are named instead of counted, and that are named at most."""
_MISSING = {"slip": "would slip", "pull": "had to pull", "tip": "would tip over", "fly": "stands on nothing"}
_SHOWN = 3
"""Parameters that are named of each load, with more than `_LEAST` of its variance."""
_LEAST = 0.01
_OF_LINKS = {"mass": "mass", "com": "centre of mass", "inertia": "inertia", "friction": "friction"}


def sizing_sections(result: Result) -> Iterator[Section]:
    """Yield use of joints, motors, bearings, foundation, and a verdict for each joint."""
    sizing, size = result.sizing, result_sizes(result)
    if sizing is None:
        return
    if sizing.joints:
        yield [_use(result, sizing)]
    if any(joint.motor for joint in sizing.joints):
        yield [_motors(result, sizing)]
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
    rows = []
    for load in sizing.foundation:
        scale, row = size[load.unit], [f"{load.name[0].upper()}{load.name[1:]}"]
        for value, time, unit in (
            (load.greatest, load.greatest_time, f" {load.unit}"),
            (load.least, load.least_time, ""),
        ):
            row += [f"{number(value, scale)}{unit}", moment(time, value, scale)]
        rows.append((*row, number(load.mean, scale)))
    foundation = ("", "greatest", "at [s]", "least", "at [s]", "mean")
    yield [Table("Foundation: ground on robot, in the base's axes", foundation, rows)]
    if sizing.joints:
        yield [Paragraph("Verdicts"), verdicts(result.joints, sizing)]


def verdicts(loads: Sequence[JointLoad], sizing: Sizing) -> Facts:
    """Return of each joint in plain words what it exceeds, or how near it comes to its limits, the worst first."""
    items = []
    for load, joint in sorted(zip(loads, sizing.joints, strict=True), key=lambda pair: _WORST.index(pair[1].level)):
        if not joint.exceeded:
            nearness = ", ".join(
                f"{'<1' if 0.0 < share < 0.5 else f'{share:.0f}'} % of {what}" for share, what in uses(load, joint)
            )
            known = "OK" if joint.level == "OK" else "no limits are known"
            items.append((joint.name, f"OK: {nearness}" if nearness else known))
        for k, exceeded in enumerate(joint.exceeded):
            items.append(("" if k else joint.name, f"{exceeded.level.upper()}: {in_words(exceeded)}"))
    return Facts(tuple(items))


def uses(load: JointLoad | JointUse, joint: JointSizing | None) -> list[tuple[float, str]]:
    """Return how much of each limit a joint uses [%], and of which."""
    found: list[tuple[float, float | None, str]] = []
    if joint is not None and (motor := joint.motor) is not None:
        if (near := motor.nearest) is not None:
            found.append((near.torque, near.limit, f"the peak curve at {near.time:.6g} s"))
        found.append((motor.rms, motor.continuous_limit, "the continuous torque"))
        found.append((abs(motor.max_speed), motor.speed_limit, "the motor's speed"))
    found.append((abs(load.peak), load.effort_limit, "the effort limit"))
    found.append((abs(load.max_speed), load.velocity_limit, "the velocity limit"))
    return [(100.0 * x / limit if limit > 0 else 0.0, what) for x, limit, what in found if limit is not None]


def in_words(exceeded: Exceeded) -> str:
    """Return what is too large, by how much, when, and for how long."""
    unit, limit, (what, allowed) = exceeded.unit, exceeded.limit, _WORDS[exceeded.quantity]
    text = f"{what} is {number(exceeded.value)} {unit}, "
    text += f"{100 * exceeded.excess / limit:.3g} % above the {number(limit)}" if limit > 0 else "above the 0"
    text += f" {unit} that {allowed}"
    if exceeded.speed is not None:
        mean = "a mean speed of " if exceeded.time is None else ""
        text += f" at {mean}{number(exceeded.speed)} {'m/s' if unit == 'N' else 'rad/s'}"
    if exceeded.time is not None:
        text += f"; worst at {exceeded.time:.6g} s (row {exceeded.row})"
    return text if exceeded.seconds is None else f"{text}, over for {exceeded.seconds:.3g} s in all"


def _use(result: Result, sizing: Sizing) -> Table:
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
    head = ["joint", "duty", "mean speed", "peak in row", "speed then", "max speed at [s]", "torque then"]
    head += ["least power [W]", "static peak", "static RMS", "hold share"]
    return Table("How joints are used", head, rows)


def _motors(result: Result, sizing: Sizing) -> Table:
    size, rows = result_sizes(result), []
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
    head = ["joint", "gear", "efficiency", "peak", "at [s]", "speed then", "RMS", "max speed", "torque then"]
    head += ["mean speed", "peak power [W]", "least", "work [J]", "returned [J]", "inertia ratio"]
    return Table("Motors, torque and speed at their shafts", head, rows)


def constraint_tables(result: Result) -> Iterator[Table]:
    """Yield tables of loops, contacts, spans without contact forces, what passive joints lack."""
    found, size = result.constraints, result_sizes(result)
    assert found is not None
    if found.loops:
        rows = []
        for loop in found.loops:
            most, turning = loop.force.value, loop.moment.value
            row = [loop.name, loop.link, loop.to, loop.kind, size.number(most, "N")]
            row += [size.moment(loop.force.time, most, "N"), size.number(loop.rms_force, "N")]
            row += [size.number(turning, "N m"), size.number(loop.rms_moment, "N m")]
            rows.append([*row, "yes" if loop.determined else f"but {', '.join(loop.open)}"])
        head = ["loop", "on", "by", "kind", "force [N]", "at [s]", "RMS", "moment [N m]", "RMS", "determined"]
        yield Table("Loops: force and moment on the link", head, rows)
    if found.contacts:
        rows = []
        for each in found.contacts:
            force, used, margin = each.force, each.friction_used, each.margin
            row = [each.name, f"{100 * each.on:.0f} %", size.number(force.value, "N")]
            row += [size.moment(force.time, force.value, "N")]
            row += [f"{size.number(each.least_normal.value, 'N')} to {size.number(each.normal.value, 'N')}"]
            row += [f"{each.friction:g}", *([f"{100 * used.value:.0f}%", f"{used.time:.4g}"] if used else ["", ""])]
            row += [f"{1e3 * margin.value:.3g}", f"{margin.time:.4g}"] if margin else ["", ""]
            rows.append([*row, point_text((1e3 * x for x in each.centre), reach=1e3) if each.centre else ""])
        head = ["contact", "on", "force [N]", "at [s]", "along normal [N]", "friction", "of it used", "at [s]"]
        head += ["margin [mm]", "at [s]", "centre of pressure [mm]"]
        kept = 11 if any(each.margin for each in found.contacts) else 8
        yield Table("Contacts: what the link stands on, while it does", head[:kept], [row[:kept] for row in rows])
    if found.missing:
        rows = [
            [f"{x.start:.4g}", f"{x.end:.4g}", _MISSING[x.kind], figure(x.force.value), figure(x.moment.value)]
            for x in found.missing
        ]
        head = ["from [s]", "to [s]", "the robot", "force missing [N]", "moment missing [N m]"]
        yield Table("Where no contact forces balance the motion", head, rows)
    if found.unbalanced:
        rows = [[x.name, f"{figure(x.most.value)} {x.unit}", f"{x.most.time:.4g}"] for x in found.unbalanced]
        title = "What the motion takes at passive joints and nothing gives"
        yield Table(title, ["joint", "most", "at [s]"], rows)


def constraint_lines(found: Constraints) -> Iterator[str]:
    """Yield in words: ranks and freedoms, which torques are determined, how others were chosen, the least friction."""
    names = list(found.determined)
    who = first_names(names, _FEW) if len(names) <= _FEW else count(len(names), "joint")
    drives = f"{who} {'drives' if len(names) == 1 else 'drive'}" if names else "no joint drives"
    if found.equations:
        over = f", {found.overconstrained} of which others imply" if found.overconstrained else ""
        freedoms = count(found.freedoms, "degree of freedom", "degrees of freedom")
        spare = f", {found.redundancy} more than the freedoms that they drive" if found.redundancy else ""
        yield f"{count(found.equations, 'equation')} of loops{over}; {freedoms}; {drives}{spare}."
    else:
        yield f"{drives}." if names else f"{drives[0].upper()}{drives[1:]}."
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
        least = found.least_friction
        some = f"The least friction that suffices, alike at all contacts: {figure(least or 0.0)}."
        none = "No friction suffices for this motion."
        yield none if least is None else some if least else "The motion takes no friction."
    if found.beyond_limits is not None:
        since = figure(found.beyond_limits)
        yield f"From {since} s on there are samples at which no contact forces keep the effort limits."


def uncertainty_sections(result: Result) -> Iterator[Section]:
    """Yield error bars of joints, motors, bearings and the base, what makes them, and how likely limits are kept."""
    found = result.uncertainty
    if found is None:
        return
    size, drawn = result_sizes(result), list[str]()
    motors = [each.motor for each in found.joints if each.motor is not None]
    resultants = [
        (joint, load) for joint, loads in found.bearings.items() for load in loads if load.name in ("radial", "tilting")
    ]
    joints = f"Joints: error bars of {count(len(found.parameters), 'uncertain parameter')}"
    groups: dict[str, list[tuple[str, UncertainLoad]]] = {
        joints: [(each.load.name, each.load) for each in found.joints],
        "Motors: error bars": [(load.name, load) for load in motors],
        "Bearings: error bars": [(f"{joint} {load.name}", load) for joint, load in resultants],
        "Base wrench: error bars": [(load.name, load) for load in found.base],
    }
    for title, loads in groups.items():
        if not any(load.shares or load.rms_shares for _, load in loads):
            continue
        rows = []
        for name, load in loads:
            row = [name]
            for bar, unit in ((load.peak, f" {load.unit}"), (load.rms, "")):
                error = "0" if is_noise(bar.standard_error, size[load.unit]) else f"{bar.standard_error:.2g}"
                row += [f"{size.number(bar.value, load.unit)}{unit}", error]
                row += [f"{size.number(bar.low, load.unit)} to {size.number(bar.high, load.unit)}"]
            rows.append(row)
            bars = {"peak": load.peak, "RMS": load.rms}
            drawn += [f"{what} of {printable(name)}" for what, bar in bars.items() if bar.method == "draws"]
        yield [Table(title, ("", "peak", "std error", "95 %", "RMS", "std error", "95 %"), rows)]
    if found.joints:
        ranked = [(each.load.name, ranks(each.load.shares), ranks(each.load.rms_shares)) for each in found.joints]
        title = "Which parameters matter most, by their share of the variance"
        yield [Table(title, ("joint", "of the peak", "of the RMS"), ranked)]
    notes = []
    if drawn:
        what = (
            f"By {found.draws} draws of the parameters, for they are not linear in them: {first_names(drawn, _SHOWN)}."
        )
        notes.append(f"{what} The other error bars are by derivatives.")
    if any(name.rpartition(".")[2] not in _OF_LINKS for name in found.parameters):
        notes.append(
            "Parameters that the covariance does not name count as sure: what a log did not show, such as most of what "
            "bearings and the base bear, is less sure than this."
        )
    yield paragraphs(notes)
    chances = []
    for joint in found.joints:
        if joint.suffices is not None:
            limits = [x for x in joint.limits if x.probability < 0.999]
            unsure = ", ".join(f"{each.quantity} {probability(each.probability)}" for each in limits)
            each = f"suffices with {probability(joint.suffices)}"
            chances.append((joint.load.name, f"{each}: {unsure}" if unsure else each))
    if found.suffices is not None and len(chances) > 1:
        chances.append(("all joints", f"suffice with {probability(found.suffices)}"))
    if chances:
        yield [Paragraph("Limits are kept with these probabilities"), Facts(tuple(chances))]


def ranks(shares: Mapping[str, float]) -> str:
    """Return the parameters with most of a variance in words: "mass of forearm 61 %, friction of elbow 30 %"."""
    words = []
    for name, share in list(shares.items())[:_SHOWN]:
        owner, _, quantity = name.rpartition(".")
        of = f"{_OF_LINKS[quantity]} of {owner}" if quantity in _OF_LINKS else name  # as the regressor has it
        words += [f"{printable(of)} {100.0 * share:.0f} %"] * (share >= _LEAST)
    return ", ".join(words) or "-"


def probability(p: float) -> str:
    """Return a probability in percent, as precisely as it is known."""
    if not 0.001 < p < 0.999:
        return "more than 99.9 %" if p > 0.5 else "less than 0.1 %"
    return f"{100.0 * p:.1f} %" if not 0.01 < p < 0.99 else f"{100.0 * p:.0f} %"
