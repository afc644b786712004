"""What loops and contacts bear along a motion, for people: tables and lines of the result of `torques`."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.loads.constraint_result import Constraints, ContactLoad, LoopLoad, Missing, Peak, Unbalanced
from robodyn.loads.result import Result
from robodyn.report.sizes import Sizes, result_sizes
from robodyn.report.table import Columns, Content, by_columns, number, printable
from robodyn.scene.parts import Vector
from robodyn.support.wording import count, figure

_FINE = 1e3
"""mm beside which the places of centres of pressure are noise or not."""
_FEW = 3
"""Joints that are named instead of counted."""
_MISSING = {"slip": "would slip", "pull": "had to pull", "tip": "would tip over", "fly": "stands on nothing"}


def constraint_tables(result: Result) -> Iterator[tuple[str, Content]]:
    """Yield titles and tables: loops, contacts, spans without contact forces, what passive joints lack."""
    found, size = result.constraints, result_sizes(result)
    assert found is not None
    if found.loops:
        yield "Loops: force and moment on the link", _loops(found.loops, size)
    if found.contacts:
        yield "Contacts: what the link stands on, while it does", _contacts(found.contacts, size)
    if found.missing:
        yield "Where no contact forces balance the motion", _spans(found.missing)
    if found.unbalanced:
        yield "What the motion takes at passive joints and nothing gives", _unbalanced(found.unbalanced)


def constraint_lines(found: Constraints, joints: int = 8) -> Iterator[str]:
    """Yield in words: ranks and freedoms, which torques are determined, how others were chosen, the least friction.

    Args:
        joints: that are named at most.
    """
    yield _ranks(found)
    open_drives = [name for name, sure in found.determined.items() if not sure]
    if found.determined and not open_drives:
        yield "All torques are determined: no others balance the motion."
    elif open_drives and len(open_drives) == len(found.determined):
        yield f"No torque is determined by the motion alone: of all that balance it, {found.share} are taken."
    elif open_drives:
        open_names = _names(open_drives, joints)
        yield f"Not determined by the motion alone: {open_names}; of all that balance it, {found.share} are taken."
    if open_loops := [f"{loop.name} {', '.join(loop.open)}" for loop in found.loops if not loop.determined]:
        yield f"Loop forces that are not determined, of which the least are given: {_names(open_loops, joints)}."
    if found.undriven:
        yield f"Moved by no drive: {_names(found.undriven, joints)}."
    if found.followed:
        yield f"Follow from the loops, for want of columns: {_names(found.followed, joints)}."
    if found.contacts:
        yield _friction(found)
    if found.beyond_limits is not None:
        since = figure(found.beyond_limits)
        yield f"From {since} s on there are samples at which no contact forces keep the effort limits."


def _ranks(found: Constraints) -> str:
    drives = _drives(list(found.determined))
    if not found.equations:
        return f"{drives[:1].upper()}{drives[1:]}." if not found.determined else f"{drives}."
    over = f", {found.overconstrained} of which others imply" if found.overconstrained else ""
    freedoms = "degree of freedom" if found.freedoms == 1 else "degrees of freedom"
    spare = f", {found.redundancy} more than the freedoms that they drive" if found.redundancy else ""
    return f"{count(found.equations, 'equation')} of loops{over}; {found.freedoms} {freedoms}; {drives}{spare}."


def _drives(names: list[str]) -> str:
    if not names:
        return "no joint drives"
    who = _names(names, len(names)) if len(names) <= _FEW else count(len(names), "joint")
    return f"{who} {'drives' if len(names) == 1 else 'drive'}"


def _friction(found: Constraints) -> str:
    if found.least_friction is None:
        return "No friction suffices for this motion."
    if not found.least_friction:
        return "The motion takes no friction."
    return f"The least friction that suffices, alike at all contacts: {figure(found.least_friction)}."


def _names(names: list[str] | tuple[str, ...], most: int) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(map(printable, names[:most])) + more


def _loops(loops: tuple[LoopLoad, ...], size: Sizes) -> Content:
    columns: Columns[LoopLoad] = [
        ("loop", lambda loop: loop.name),
        ("on", lambda loop: loop.link),
        ("by", lambda loop: loop.to),
        ("kind", lambda loop: loop.kind),
        ("force [N]", lambda loop: number(loop.force.value, size["N"])),
        ("at [s]", lambda loop: size.moment(loop.force.time, loop.force.value, "N")),
        ("RMS", lambda loop: number(loop.rms_force, size["N"])),
        ("moment [N m]", lambda loop: number(loop.moment.value, size["N m"])),
        ("RMS", lambda loop: number(loop.rms_moment, size["N m"])),
        ("determined", lambda loop: "yes" if loop.determined else f"but {', '.join(loop.open)}"),
    ]
    return by_columns(columns, loops)


def _contacts(contacts: tuple[ContactLoad, ...], size: Sizes) -> Content:
    columns: Columns[ContactLoad] = [
        ("contact", lambda each: each.name),
        ("on", lambda each: f"{100 * each.on:.0f} %"),
        ("force [N]", lambda each: number(each.force.value, size["N"])),
        ("at [s]", lambda each: size.moment(each.force.time, each.force.value, "N")),
        (
            "along normal [N]",
            lambda each: f"{number(each.least_normal.value, size['N'])} to {number(each.normal.value, size['N'])}",
        ),
        ("friction", lambda each: f"{each.friction:g}"),
        ("of it used", lambda each: "" if each.friction_used is None else f"{100 * each.friction_used.value:.0f}%"),
        ("at [s]", lambda each: _time(each.friction_used)),
        ("margin [mm]", lambda each: f"{1e3 * each.margin.value:.3g}" if each.margin else ""),
        ("at [s]", lambda each: _time(each.margin)),
        ("centre of pressure [mm]", lambda each: _centre(each.centre)),
    ]
    if all(each.margin is None for each in contacts):
        columns = columns[:-3]
    return by_columns(columns, contacts)


def _centre(centre: Vector | None) -> str:
    if centre is None:
        return ""
    return f"({', '.join(number(1e3 * x, _FINE) for x in centre)})"


def _time(peak: Peak | None) -> str:
    return "" if peak is None else f"{peak.time:.4g}"


def _spans(spans: tuple[Missing, ...]) -> Content:
    columns: Columns[Missing] = [
        ("from [s]", lambda span: f"{span.start:.4g}"),
        ("to [s]", lambda span: f"{span.end:.4g}"),
        ("the robot", lambda span: _MISSING[span.kind]),
        ("force missing [N]", lambda span: figure(span.force.value)),
        ("moment missing [N m]", lambda span: figure(span.moment.value)),
    ]
    return by_columns(columns, spans)


def _unbalanced(rates: tuple[Unbalanced, ...]) -> Content:
    columns: Columns[Unbalanced] = [
        ("joint", lambda rate: rate.name),
        ("most", lambda rate: f"{figure(rate.most.value)} {rate.unit}"),
        ("at [s]", lambda rate: f"{rate.most.time:.4g}"),
    ]
    return by_columns(columns, rates)
