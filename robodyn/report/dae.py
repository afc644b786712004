"""The DAE form: what is unknown, what holds, the numbers, and how the reactions go."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from robodyn.equations.dae.connections import Connection
from robodyn.equations.dae.counts import Counts
from robodyn.equations.dae.dae import Dae
from robodyn.report.dae_numbers import MOST, acting, both_lines, elimination_lines, numbers_sections, shortened
from robodyn.report.document import Paragraph, Section, Table, paragraphs, remarks
from robodyn.report.equations import base_text
from robodyn.report.table import Content, axis_text, gravity_text, number, printable
from robodyn.support.wording import count

ALONG = """\
  force along n     n . (x - y) = 0
    differentiated  n . u = 0,  u = v + w x r - v_p - w_p x s
    and again       n . (dv/dt + wd x r - dv_p/dt - wd_p x s) = n . (w_p x (w_p x s) + 2 w_p x u - w x (w x r))
"""
ACROSS = """\
  moment about a x b  a . b = 0,  a fixed in the body, b in its parent
    differentiated    (a x b) . (w - w_p) = 0
    and again         (a x b) . (wd - wd_p) = -((w x a) x b + a x (w_p x b)) . (w - w_p)
"""
MIMIC = """\
  mimic joint  q_i - k q_j - q_0 = 0, and so on for its velocities and accelerations
"""
WORDS = {
    "fixed": "x = y; does not turn",
    "revolute": "x = y; axis keeps its direction",
    "prismatic": "x stays on the axis; does not turn",
    "floating": "none",
    "point": "x = y",
    "hinge": "x = y; axis keeps its direction",
    "weld": "x = y; does not turn",
    "directions": "x level with y along n",
    "mimic": "q_i - k q_j - q_0 = 0",
}
FEW = 5
"""Joints whose forces on a body are written out."""


def dae_sections(found: Dae) -> Iterator[Section]:
    """Yield the report; long tables are cut after `MOST` rows, and say so."""
    robot, counts = found.robot, found.counts
    several = count(counts.bodies, "body", "bodies")
    head = f"{robot.model.name}: DAE form, {several}, {base_text(robot.model.floating)}, "
    head += gravity_text(robot.scene.gravity)
    yield paragraphs([head, "M a = f + G^T lambda,  g = 0,  G v = 0,  G a = gamma"])
    yield [Table("Unknowns and equations", *_unknowns(counts)), *paragraphs(_ranks(counts))]
    yield _bodies(found)
    yield _connections(found)
    yield paragraphs(_levels(found))
    yield from numbers_sections(found)
    yield paragraphs(elimination_lines(found))
    yield paragraphs(both_lines(found))
    yield remarks("warning", found.warnings)


def _unknowns(counts: Counts) -> Content:
    six, m = 6 * counts.bodies, counts.reactions
    rows = [
        ("differential", "positions R, c", str(six), "their rates are the velocities", str(six)),
        ("", "velocities w, v", str(six), "Newton's and Euler's laws", str(six)),
        ("algebraic", "reactions lambda", str(m), "constraints", str(m)),
        ("together", "", str(counts.unknowns), "", str(counts.unknowns)),
    ]
    return ("", "unknowns", "", "equations", ""), rows


def _ranks(counts: Counts) -> list[str]:
    six, rank, m = 6 * counts.bodies, counts.rank, counts.reactions
    lines = f"rank of G: {rank} of {m}, {_redundant(counts)}".split("\n")
    lines.append(f"degrees of freedom: 6 x {counts.bodies} - {rank} = {six - rank}")
    if counts.index is None:
        lines.append("index: not defined, as accelerations and reactions do not follow from the equations")
    elif not m:
        lines.append("index: 0, there are no reactions")
    else:
        p, v, a = counts.index
        ranks = ", ".join(map(str, counts.coefficients))
        lines.append(f"index: {p}; {v} with constraints differentiated once, {a} twice")
        lines.append(f"  coefficients of (a, lambda) then have rank {ranks} of {counts.size}")
    return lines


def _redundant(counts: Counts) -> str:
    if not counts.redundant:
        return "no constraint is redundant"
    names: dict[str, list[str]] = {}
    for connection, reaction in counts.redundant:
        names.setdefault(connection, []).append(reaction)
    listed = "; ".join(f"{printable(name)} {' '.join(parts)}" for name, parts in list(names.items())[:MOST])
    return (
        f"{len(counts.redundant)} redundant ({listed}{'; ...' * (len(names) > MOST)})\n"
        f"  rigid bodies leave {len(counts.undetermined)} reactions open; those of redundant equations count as 0"
    )


def _bodies(found: Dae) -> Section:
    model, system = found.robot.model, found.robot.system
    pushed = {i for i, _ in found.robot.terms.wrenches}
    rows = []
    for i, (body, inertia) in enumerate(zip(model.bodies, system.inertias, strict=True)):
        forces, moments = law_of(found, i)
        outside = ["E"] if i in pushed else []
        weight = [f"m{i} g"] if inertia.m and any(found.robot.scene.gravity) else []
        newton, euler = _sum(weight + forces + outside), _sum(moments + outside)
        rows.append((f"{i} {body.name}", f"{number(float(inertia.m))} kg", newton, euler))
    head = ("body", "mass", "m dv/dt =", "I_c wd + w x I_c w =")
    title = "Bodies: six coordinates each, Newton's and Euler's laws about the mass centre c"
    legend = "F_i and M_i, drives included, act through joint i on body i and, opposite, on its parent, r and s from c"
    return [*shortened(title, (head, rows), "bodies"), Paragraph(legend)]


def law_of(found: Dae, i: int) -> tuple[list[str], list[str]]:
    """Return the terms of forces and moments on body i: of its joint, of joints that it carries, and of loops."""
    forces, moments = [], []
    every = acting(found, i)
    for sign, name, moment in every[:FEW]:
        forces.append(f"{sign}F{name}")
        moments += [f"{sign}M{name}"] * moment + [f"{sign}{'s' if sign else 'r'}{name} x F{name}"]
    more = [f"... ({len(every) - FEW} more)"] * (len(every) > FEW)
    return forces + more, moments + more


def _sum(terms: Sequence[str]) -> str:
    return " + ".join(terms).replace("+ -", "- ") or "0"


def _connections(found: Dae) -> Section:
    model, system = found.robot.model, found.robot.system
    names = [body.name for body in model.bodies] + ["ground"]
    numbered = [(str(i), joint) for i, joint in enumerate(system.joints)]
    numbered += [("", mimic) for mimic in system.mimics]
    numbered += [(f"L{k}", loop) for k, loop in enumerate(system.loops, 1)]
    rows = []
    for label, connection in numbered:
        f = len(connection.free) if label.isdigit() else 6 - len(connection.equations)
        rows.append(
            (
                f"{label} {connection.name}".strip(),
                f"{names[connection.other]} - {names[connection.body]}",
                connection.kind,
                _axis(found, connection, label),
                str(f) if label else "-",
                str(len(connection.equations)),
                WORDS[connection.kind],
                " ".join(connection.reactions) or "-",
            )
        )
    head = ("joint", "between", "type", "axis", "f", "6 - f", "held", "reactions lambda")
    order = sorted(range(len(rows)), key=lambda k: numbered[k][0].isdigit())
    rows = [rows[k] for k in order] if len(rows) > MOST and system.loops else rows
    title = "Joints: a constraint equation and a reaction for each direction in which it holds"
    return [*shortened(title, (head, rows), "joints"), *paragraphs(_along(found))]


def _along(found: Dae) -> list[str]:
    """Return what the letters of directions mean, and what acts where a joint does not hold."""
    system = found.robot.system
    oblique = any(name.endswith("a") for connection in system.connections for name in connection.reactions)
    lines = ["1, 2 and a are perpendicular, a along an oblique axis"] * oblique
    if system.rotors or found.robot.matrices.along.any():
        taken = ", less friction and springs" if found.robot.terms.at_joint else ""
        rotors = "; a rotor J adds S^T J S to M" if system.rotors else ""
        lines.append(
            f"along its own coordinates, whose velocity is S v, a joint passes on tau{taken}: S^T tau in f{rotors}"
        )
    return lines


def _axis(found: Dae, connection: Connection, label: str) -> str:
    if not label.isdigit() or connection.kind not in ("revolute", "prismatic"):
        return "-"
    axis = axis_text(found.robot.model.bodies[int(label)].joint.axis)
    return f"a = {axis}" if axis[0] == "(" else axis


def _levels(found: Dae) -> list[str]:
    equations = found.robot.system.equations
    kinds = {type(equation).__name__ for equation in equations}
    text = (
        (ALONG if "Along" in kinds else "") + (ACROSS if "Across" in kinds else "") + (MIMIC if "Sum" in kinds else "")
    )
    if not text:
        return []
    where = "x is the joint's point of a body, y that of its parent p; r = x - c, s = x - c_p; n moves with p"
    return [f"Constraints: {where}", *text.splitlines()]
