"""What motors, gears, bearings, foundation, loops and contacts bear along a motion, and how sure that is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from robodyn.loads.result import DEGREES, Exceeded, JointLoad, JointSizing, Result, Sizing
from robodyn.report.document import Facts, Paragraph, Section, Table, paragraphs
from robodyn.report.sizes import Sizes, result_sizes, speed_unit
from robodyn.report.table import axis_text, filled, first_names, is_noise, number, percent, printable
from robodyn.support.wording import count, figure

if TYPE_CHECKING:
    from robodyn.loads.constraint_result import Constraints
    from robodyn.loads.uncertainty_result import Uncertain
    from robodyn.simulation.result import JointUse

_WORDS = {
    "motor torque": ("the motor's torque", "the peak curve allows"),
    "motor speed": ("the motor's speed", "it may have"),
    "RMS motor torque": ("the motor's RMS torque", "the continuous curve allows"),
    "gear torque": ("the gear's torque", "the gear bears"),
    "mean gear torque": ("the gear's cubic mean torque", "the gear bears"),
    "winding temperature": ("the winding's temperature", "it bears"),
    "housing temperature": ("the motor housing's temperature", "it bears"),
    "effort": ("the joint's torque", "the description allows"),
    "velocity": ("the joint's speed", "the description allows"),
}
"""Of a quantity what it is, and what limits it."""
_WORST = ("over peak", "over temperature", "over continuous", "OK", "no limits")
_NAMED = 8
"""Joints that are named at most."""
_MISSING = {"slip": "would slip", "pull": "had to pull", "tip": "would tip over", "fly": "stands on nothing"}
_SHOWN = 3
"""Parameters that are named of each load, with more than `_LEAST` of its variance."""
_LEAST = 0.01
_OF_LINKS = {"mass": "mass", "com": "centre of mass", "inertia": "inertia", "friction": "friction"}


def sizing_sections(result: Result, sizing: Sizing) -> Iterator[Section]:
    """Yield use of joints, motors, bearings, foundation, and a verdict for each joint."""
    size = result_sizes(result)
    rows, shafts = [], []
    for joint, load in zip(sizing.joints, result.joints, strict=True):
        unit, motor = joint.unit, joint.motor
        row = [joint.name, f"{100 * joint.duty_cycle:.3g} %", size.amount(joint.mean_speed, speed_unit(unit))]
        row += [size.amount(joint.static_peak, unit), size.number(joint.static_rms, unit)]
        share = f"{number(100 * joint.static_share)} %" if joint.static_share >= 1e-5 else "0 %"
        rows.append([*row, "-" if is_noise(load.rms, size[unit]) else share])
        if motor is not None:
            own = Sizes({motor.unit: max(size[unit] / motor.gear, abs(motor.peak))})
            own[motor.speed_unit] = max(size[speed_unit(unit)] * motor.gear, abs(motor.max_speed))
            row = [joint.name, f"{motor.gear:.6g}", own.amount(motor.peak, motor.unit)]
            row += [own.moment(motor.peak_time, motor.peak, motor.unit), own.number(motor.rms, motor.unit)]
            row += [own.amount(motor.max_speed, motor.speed_unit), size.number(motor.peak_power, "W")]
            row += [size.number(work, "J") for work in (motor.work_positive, motor.work_negative)]
            shafts.append([*row, "-" if motor.inertia_ratio is None else f"{motor.inertia_ratio:.3g}"])
    head = ["joint", "duty", "mean speed", "static peak", "static RMS", "hold share"]
    yield [Table("How joints are used", head, rows)] if rows else []
    head = ["joint", "gear", "peak", "at [s]", "RMS", "max speed", "peak power [W]", "work [J]", "returned [J]"]
    title = "Motors, torque and speed at their shafts"
    yield [Table(title, [*head, "inertia ratio"], shafts)] if shafts else []
    yield from _heat_sections(sizing, size)
    rows = []
    for bearing in sizing.bearings:
        row = [bearing.joint, *(axis_text(axis, "{:.3g}", " ") for axis in bearing.directions)]
        loads = {part.name: part for part in (*bearing.components, bearing.radial, bearing.tilting)}
        for name in ("fu", "fv", "fa", "mu", "mv", "ma", "radial", "tilting"):
            row.append(size.number(loads[name].peak, loads[name].unit) if name in loads else "-")
            if name in ("radial", "tilting"):
                row.append(size.moment(loads[name].peak_time, loads[name].peak, loads[name].unit))
        rows.append(row)
    head = ["joint", "u", "v", "axis a", "fu [N]", "fv", "fa", "mu [N m]", "mv", "ma"]
    head += ["radial f", "at [s]", "tilting m", "at [s]"]
    yield [Table("Bearings: largest loads, parent on child, at the joint's origin", head, rows)] if rows else []
    rows = []
    for part in sizing.foundation:
        greatest = size.amount(part.greatest, part.unit), size.moment(part.greatest_time, part.greatest, part.unit)
        least = size.number(part.least, part.unit), size.moment(part.least_time, part.least, part.unit)
        rows.append([f"{part.name[0].upper()}{part.name[1:]}", *greatest, *least, size.number(part.mean, part.unit)])
    head = ["", "greatest", "at [s]", "least", "at [s]", "mean"]
    yield [Table("Foundation: ground on robot, in the base's axes", head, rows)]
    items = []
    for load, joint in sorted(
        zip(result.joints, sizing.joints, strict=True), key=lambda pair: _WORST.index(pair[1].level)
    ):
        nearness = ", ".join(f"{percent(share)} % of {what}" for share, what in uses(load, joint))
        known = "OK" if joint.level == "OK" else "no limits are known"
        if not joint.exceeded:
            items.append((joint.name, f"OK: {nearness}" if nearness else known))
        for k, exceeded in enumerate(joint.exceeded):
            items.append(("" if k else joint.name, f"{exceeded.level.upper()}: {in_words(exceeded)}"))
    if items:
        yield [Paragraph("Verdicts"), Facts(tuple(items))]


def _heat_sections(sizing: Sizing, size: Sizes) -> Iterator[Section]:
    """Yield temperatures of motors, what they take from the bus, and the life of gears."""
    hot, losses, lives = [], [], []
    for joint in sizing.joints:
        if (motor := joint.motor) is None:
            continue
        if motor.gear_life is not None:
            row = [joint.name, size.amount(motor.gear_mean, joint.unit), number(motor.mean_speed)]
            lives.append([*row, f"{motor.gear_life:.4g}"])
        if (heat := motor.heat) is None:
            continue
        temperatures = heat.winding_once, heat.winding, heat.housing_once, heat.housing
        row = ["runs away" if each is None else f"{each:.4g}" for each in temperatures]
        hot.append([joint.name, *row, f"{heat.winding_limit:g}"])
        row = [size.number(each, "J") for each in (heat.copper_loss, motor.gear_loss, heat.drawn, heat.returned)]
        losses.append([joint.name, *row, *(size.number(each, "W") for each in (heat.peak_power, heat.least_power))])
    head = ["joint", "winding once", "repeated for ever", "housing once", "repeated for ever", "winding's limit"]
    yield [Table("Temperatures of motors [degC], greatest", head, hot)] if hot else []
    if (bus := sizing.bus) is not None:
        row = [size.number(each, "J") for each in (bus.drawn, bus.returned)]
        row += [size.number(each, "W") for each in (bus.peak_power, bus.least_power)]
        losses += [["bus", "", "", *row]]
        head = ["joint", "copper loss [J]", "gear loss [J]", "drawn [J]", "returned [J]", "peak [W]", "least [W]"]
        others = [joint.name for joint in sizing.joints if joint.motor and not joint.motor.heat]
        without = f", without {first_names(others, most=4)}" if others else ""
        yield [Table(f"DC bus, per cycle in the steady state{without}", head, losses)]
    head = ["gear of", "mean torque", "mean input speed [rad/s]", "life [h]"]
    yield [Table("Life of gears, at this motion repeated", head, lives)] if lives else []


def uses(load: JointLoad | JointUse, joint: JointSizing | None) -> list[tuple[float, str]]:
    """Return how much of each limit a joint uses [%], and of which."""
    found: list[tuple[float, float | None, str]] = []
    if joint is not None and (motor := joint.motor) is not None:
        if (near := motor.nearest) is not None:
            found.append((near.torque, near.limit, f"the peak curve at {near.time:.6g} s"))
        if (heat := motor.heat) is None:
            found.append((motor.rms, motor.continuous_limit, "the continuous torque"))
        elif heat.winding is not None:
            rise = max(each or heat.ambient for each in (heat.winding, heat.winding_once)) - heat.ambient
            found.append((rise, heat.winding_limit - heat.ambient, "the warming allowed"))
        found.append((abs(motor.max_speed), motor.speed_limit, "the motor's speed"))
    found.append((abs(load.peak), load.effort_limit, "the effort limit"))
    found.append((abs(load.max_speed), load.velocity_limit, "the velocity limit"))
    return [(100.0 * x / limit if limit > 0 else 0.0, what) for x, limit, what in found if limit is not None]


def in_words(exceeded: Exceeded) -> str:
    """Return what is too large, by how much, when, and for how long."""
    if exceeded.quantity == "thermal runaway":
        return f"repeated, this heats the winding ever more (thermal runaway), beyond {exceeded.limit:g} degC"
    unit, limit, (what, allowed) = exceeded.unit, exceeded.limit, _WORDS[exceeded.quantity]
    text = f"{what} is {number(exceeded.value)} {unit}, "
    share = 100 * exceeded.excess / limit if limit > 0 else 0.0
    over = f"{exceeded.excess:.3g} K" if unit == DEGREES else f"{share:.3g} %"
    text += f"{over} above the {number(limit)}" if limit > 0 else "above the 0"
    text += f" {unit} that {allowed}"
    if exceeded.speed is not None:
        mean = "a mean speed of " if exceeded.time is None else ""
        text += f" at {mean}{number(exceeded.speed)} {'m/s' if unit == 'N' else 'rad/s'}"
    if exceeded.time is not None:
        text += f"; worst at {exceeded.time:.6g} s (row {exceeded.row})"
    return text if exceeded.seconds is None else f"{text}, over for {exceeded.seconds:.3g} s in all"


def constraint_sections(found: Constraints, size: Sizes) -> Iterator[Section]:
    """Yield ranks and freedoms in words, then tables of loops, contacts, and what the motion lacks."""
    yield paragraphs(["Constraints", *_constraint_lines(found)])
    rows = []
    for loop in found.loops:
        force, moment = loop.force, loop.moment.value
        row = [loop.name, loop.link, loop.to, loop.kind, size.number(force.value, "N")]
        row += [size.moment(force.time, force.value, "N"), size.number(loop.rms_force, "N")]
        row += [size.number(moment, "N m"), size.number(loop.rms_moment, "N m")]
        rows.append([*row, "yes" if loop.determined else f"but {', '.join(loop.open)}"])
    head = ["loop", "on", "by", "kind", "force [N]", "at [s]", "RMS", "moment [N m]", "RMS", "determined"]
    yield [Table("Loops: force and moment on the link", head, rows)] if rows else []
    rows = []
    for each in found.contacts:
        force, used, margin = each.force, each.friction_used, each.margin
        row = [each.name, f"{100 * each.on:.0f} %", size.number(force.value, "N")]
        row += [size.moment(force.time, force.value, "N")]
        row += [f"{size.number(each.least_normal.value, 'N')} to {size.number(each.normal.value, 'N')}"]
        row += [f"{each.friction:g}", *([f"{100 * used.value:.0f}%", f"{used.time:.4g}"] if used else ["", ""])]
        rows.append([*row, *([f"{1e3 * margin.value:.3g}", f"{margin.time:.4g}"] if margin else ["", ""])])
    head = ["contact", "on", "force [N]", "at [s]", "along normal [N]", "friction", "of it used", "at [s]"]
    head += ["margin [mm]", "at [s]"]
    yield [Table("Contacts: what the link stands on, while it does", *filled(head, rows))] if rows else []
    rows = [
        [f"{x.start:.4g}", f"{x.end:.4g}", _MISSING[x.kind], figure(x.force.value), figure(x.moment.value)]
        for x in found.missing
    ]
    head = ["from [s]", "to [s]", "the robot", "force missing [N]", "moment missing [N m]"]
    yield [Table("Where no contact forces balance the motion", head, rows)] if rows else []
    rows = [[x.name, f"{figure(x.most.value)} {x.unit}", f"{x.most.time:.4g}"] for x in found.unbalanced]
    title = "What the motion takes at passive joints and nothing gives"
    yield [Table(title, ["joint", "most", "at [s]"], rows)] if rows else []


def _constraint_lines(found: Constraints) -> Iterator[str]:
    drives = count(len(found.determined), "joint drives", "joints drive")
    if found.equations:
        over = f", {found.overconstrained} of which others imply" if found.overconstrained else ""
        freedoms = count(found.freedoms, "degree of freedom", "degrees of freedom")
        spare = f", {found.redundancy} more than the freedoms that they drive" if found.redundancy else ""
        drives = f"{count(found.equations, 'equation')} of loops{over}; {freedoms}; {drives}{spare}"
    yield f"{drives}."
    open_drives = [name for name, sure in found.determined.items() if not sure]
    if open_drives:
        every = len(open_drives) == len(found.determined)
        open_names = "all torques" if every else first_names(open_drives, _NAMED)
        yield f"Not determined by the motion alone: {open_names}; of all that balance it, {found.share} are taken."
    elif found.determined:
        yield "All torques are determined: no others balance the motion."
    open_loops = [f"{loop.name} {', '.join(loop.open)}" for loop in found.loops if not loop.determined]
    for what, names in (
        ("Loop forces that are not determined, of which the least are given", open_loops),
        ("Moved by no drive", found.undriven),
        ("Follow from the loops, for want of columns", found.followed),
    ):
        if names:
            yield f"{what}: {first_names(names, _NAMED)}."
    if found.contacts:
        least = found.least_friction
        some = f"The least friction that suffices, alike at all contacts: {figure(least or 0.0)}."
        none = "No friction suffices for this motion."
        yield none if least is None else some if least else "The motion takes no friction."
    if found.beyond_limits is not None:
        since = figure(found.beyond_limits)
        yield f"From {since} s on there are samples at which no contact forces keep the effort limits."


def uncertainty_sections(found: Uncertain, size: Sizes) -> Iterator[Section]:
    """Yield error bars of joints, motors, bearings and the base, what makes them, and how likely limits are kept."""
    loads = [(each.load.name, each.load) for each in found.joints]
    loads += [(f"motor of {each.motor.name}", each.motor) for each in found.joints if each.motor]
    for joint, parts in found.bearings.items():
        loads += [(f"bearing of {joint}, {part.name}", part) for part in parts if part.name in ("radial", "tilting")]
    loads += [(f"base {load.name}", load) for load in found.base]
    rows = []
    for name, load in loads:
        row = [name]
        for bar, unit in ((load.peak, f" {load.unit}"), (load.rms, "")):
            error = "0" if is_noise(bar.standard_error, size[load.unit]) else f"{bar.standard_error:.2g}"
            low, high = size.number(bar.low, load.unit), size.number(bar.high, load.unit)
            row += [f"{size.number(bar.value, load.unit)}{unit}", error, f"{low} to {high}"]
        rows.append(row)
    title = f"Error bars of {count(len(found.parameters), 'uncertain parameter')}"
    yield [Table(title, ("", "peak", "std error", "95 %", "RMS", "std error", "95 %"), rows)]
    if found.joints:
        ranked = [(each.load.name, ranks(each.load.shares), ranks(each.load.rms_shares)) for each in found.joints]
        title = "Which parameters matter most, by their share of the variance"
        yield [Table(title, ("joint", "of the peak", "of the RMS"), ranked)]
    notes = []
    if any("draws" in (load.peak.method, load.rms.method) for _, load in loads):
        what = f"are by {found.draws} draws of them; the others are by derivatives."
        notes.append(f"Error bars of what is not linear in the parameters {what}")
    if any(name.rpartition(".")[2] not in _OF_LINKS for name in found.parameters):
        notes.append(
            "Parameters that the covariance does not name count as sure: what a log did not show, such as most of what "
            "bearings and the base bear, is less sure than this."
        )
    yield paragraphs(notes)
    chances = []
    for each in found.joints:
        if each.suffices is not None:
            unsure = [f"{x.quantity} {probability(x.probability)}" for x in each.limits if x.probability < 0.999]
            which = f": {', '.join(unsure)}" if unsure else ""
            chances.append((each.load.name, f"suffices with {probability(each.suffices)}{which}"))
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
