"""The DAE form: what is unknown, what holds, the numbers, and how the reactions go."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from robodyn.equations.dae.constraints import Across, Connection, Equation
from robodyn.equations.dae.dae import Counts, Dae
from robodyn.programs.linear import eigen
from robodyn.report.document import Paragraph, Section, Table, encode, paragraphs, remarks, select, written
from robodyn.report.equations import base_text
from robodyn.report.sizes import sizes
from robodyn.report.table import Content, axis_text, gravity_text, number, printable, relative_text
from robodyn.support.floats import first_largest
from robodyn.support.wording import count

MOST = 16
"""Rows of a table."""


def _shortened(title: str, content: Content, what: str) -> Section:
    """Return a table of at most `MOST` rows, and how many more there are."""
    head, rows = content
    more = f"... and {len(rows) - MOST} more {what}; --format json has them all"
    return [Table(title, head, rows[:MOST]), *paragraphs([more] if len(rows) > MOST else [])]


def _numbers(found: Dae) -> Iterator[Section]:
    """Yield state, accelerations and reactions; what vanishes beside the largest acceleration, of bodies and of free
    fall, is 0."""
    model, qdd, solution = found.system.model, found.qdd, found.solution
    scale = float(np.abs([*([] if solution is None else solution.a), *found.system.scene.gravity]).max())
    at = dict(zip(model.coordinates, found.q.tolist(), strict=True))
    rows = []
    for k, name in enumerate(model.rates):
        given = [number(float(x)) if x else "0" for x in (found.qd[k], found.tau[k])]
        falling = [] if qdd is None else [number(float(qdd[k]), scale)]
        rows.append((name, f"{at[name]:.6g}" if name in at else "-", *given, *falling))
    head = ("coordinate", "q", "qd", "tau", *(["qdd"] if qdd is not None else []))
    yield [*_shortened("State", (head, rows), "coordinates"), *paragraphs(_consistent(found))]
    if solution is None:
        return
    bodies = enumerate(zip(model.bodies, solution.a.reshape(-1, 6).tolist(), strict=True))
    cells = [(f"{i} {body.name}", *(number(x, scale) for x in row)) for i, (body, row) in bodies]
    title = "Accelerations of the bodies: wd in the body's axes, dv/dt of the mass centre in the ground's"
    yield _shortened(title, (("body", "wd x [rad/s^2]", "y", "z", "dv/dt x [m/s^2]", "y", "z"), cells), "bodies")
    if found.counts.reactions:
        title = "Reactions lambda on the body that a joint carries, along its axes at q = 0, fixed in the parent"
        yield _shortened(title, _reactions(found, solution.reactions.tolist()), "joints")


def _consistent(found: Dae) -> Iterator[str]:
    off, rate = found.residuals
    if len(off):
        turns = np.array([isinstance(equation, Across) for equation in found.system.equations])
        points, angles = (float(np.abs(off[which]).max(initial=0.0)) for which in (~turns, turns))
        yield (
            f"consistent: g = 0 within {relative_text(points)} m and {relative_text(angles)} rad, "
            f"G v = 0 within {relative_text(float(np.abs(rate).max()))} per s"
        )


def _reactions(found: Dae, reactions: list[float]) -> Content:
    """Return a row for each joint, forces before moments, and x, y, z before the directions of oblique joints."""
    values, places = iter(reactions), ("x", "y", "z", "1", "2", "a", "3", "")
    own = [
        (connection, {name: next(values) for name in connection.reactions}) for connection in found.system.connections
    ]
    names = sorted({name for _, part in own for name in part}, key=lambda name: (name[0], places.index(name[1:])))
    forces, moments = ([x for _, part in own for name, x in part.items() if name[0] == kind] for kind in "FM")
    weight = found.system.model.total_mass * float(np.abs(found.system.scene.gravity).max())
    scales = dict(zip("FM", sizes([*forces, weight], moments, found.system.model.reach).values(), strict=True))
    rows = [
        (connection.name, *(number(part[name], scales[name[0]]) if name in part else "-" for name in names))
        for connection, part in own
        if part
    ]
    return ("joint", *(f"{name} [{'N' if name[0] == 'F' else 'N m'}]" for name in names)), rows


def _eliminated(found: Dae) -> Iterator[str]:
    yield f"Elimination of the reactions, to the ODE form with {found.system.model.n} velocities qd"
    for k, step in enumerate(found.steps, 1):
        yield from (f"{k}  {step.title}", f"   {step.formula}", f"   {step.checks}: within {relative_text(step.error)}")
    yield "errors are parts of the sum of magnitudes that add up to the largest number"


def _both(found: Dae) -> Iterator[str]:
    """Yield how far the DAE and the ODE form are apart, or what the mass matrix resists least."""
    both = found.comparison
    if both is None:
        sizes, motions = eigen(found.reduced.M)
        weakest = found.system.model.rates[first_largest(np.abs(motions[first_largest(-np.abs(sizes))]))]
        yield f'hardly anything resists "{printable(weakest)}": accelerations and reactions are not defined'
        return
    other = "the closed chain in joint coordinates" if found.system.scene.loops else "the ODE form's recursions"
    largest = f"{relative_text(both.accelerations)} of the largest"
    yield f"Both forms: against {other} accelerations qdd differ by {largest},"
    yield f"forces at joints by {relative_text(both.forces)} and moments by {relative_text(both.moments)}"


def acting(found: Dae, i: int) -> list[tuple[str, str, bool]]:
    """Return what acts on body i: its own joint i, those of the bodies that it carries, and L1, L2 ... for loops.

    Returns:
        "-" on the body that holds the other, the name, and whether it carries a moment beside a force.
    """
    model, system = found.system.model, found.system
    rates = [body.joint.rate for body in model.bodies]
    driven = [bool(found.tau[rate : rate + 6].any()) for rate in rates]
    felt = [k for k, joint in enumerate(system.joints) if joint.kind != "floating" or driven[k]]
    own = [("", str(i), True)] if i in felt else []
    carried = [("-", str(k), True) for k in felt if model.parents[k] == i]
    loops = [
        (sign, f"L{k}", loop.kind not in ("point", "directions"))
        for k, loop in enumerate(system.loops, 1)
        for sign, end in (("", loop.body), ("-", loop.other))
        if end == i
    ]
    return own + carried + loops


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
    system, counts = found.system, found.counts
    several = count(counts.bodies, "body", "bodies")
    head = f"{system.model.name}: DAE form, {several}, {base_text(system.model.floating)}, "
    head += gravity_text(system.scene.gravity)
    yield paragraphs([head, "M a = f + G^T lambda,  g = 0,  G v = 0,  G a = gamma"])
    six, m = 6 * counts.bodies, counts.reactions
    rows = [
        ("differential", "positions R, c", str(six), "their rates are the velocities", str(six)),
        ("", "velocities w, v", str(six), "Newton's and Euler's laws", str(six)),
        ("algebraic", "reactions lambda", str(m), "constraints", str(m)),
        ("together", "", str(counts.unknowns), "", str(counts.unknowns)),
    ]
    unknowns = Table("Unknowns and equations", ("", "unknowns", "", "equations", ""), rows)
    yield [unknowns, *paragraphs(_ranks(counts))]
    yield _bodies(found)
    yield _connections(found)
    yield paragraphs(_levels(found))
    yield from _numbers(found)
    yield paragraphs(_eliminated(found))
    yield paragraphs(_both(found))
    yield remarks("warning", found.warnings)


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
    model, system = found.system.model, found.system
    pushed = {i for i, _ in found.system.terms.wrenches}
    rows = []
    for i, (body, inertia) in enumerate(zip(model.bodies, system.inertias, strict=True)):
        forces, moments = _law_of(found, i)
        outside = ["E"] if i in pushed else []
        weight = [f"m{i} g"] if inertia.m and any(found.system.scene.gravity) else []
        newton, euler = _sum(weight + forces + outside), _sum(moments + outside)
        rows.append((f"{i} {body.name}", f"{number(float(inertia.m))} kg", newton, euler))
    head = ("body", "mass", "m dv/dt =", "I_c wd + w x I_c w =")
    title = "Bodies: six coordinates each, Newton's and Euler's laws about the mass centre c"
    legend = "F_i and M_i, drives included, act through joint i on body i and, opposite, on its parent, r and s from c"
    return [*_shortened(title, (head, rows), "bodies"), Paragraph(legend)]


def _law_of(found: Dae, i: int) -> tuple[list[str], list[str]]:
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
    model, system = found.system.model, found.system
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
    return [*_shortened(title, (head, rows), "joints"), *paragraphs(_along(found))]


def _along(found: Dae) -> list[str]:
    """Return what the letters of directions mean, and what acts where a joint does not hold."""
    system = found.system
    oblique = any(name.endswith("a") for connection in system.connections for name in connection.reactions)
    lines = ["1, 2 and a are perpendicular, a along an oblique axis"] * oblique
    if system.rotors or found.system.matrices.along.any():
        taken = ", less friction and springs" if found.system.terms.at_joint else ""
        rotors = "; a rotor J adds S^T J S to M" if system.rotors else ""
        lines.append(
            f"along its own coordinates, whose velocity is S v, a joint passes on tau{taken}: S^T tau in f{rotors}"
        )
    return lines


def _axis(found: Dae, connection: Connection, label: str) -> str:
    if not label.isdigit() or connection.kind not in ("revolute", "prismatic"):
        return "-"
    axis = axis_text(found.system.model.bodies[int(label)].joint.axis)
    return f"a = {axis}" if axis[0] == "(" else axis


def _levels(found: Dae) -> list[str]:
    equations = found.system.equations
    kinds = {type(equation).__name__ for equation in equations}
    text = "".join(words for kind, words in (("Along", ALONG), ("Across", ACROSS), ("Sum", MIMIC)) if kind in kinds)
    if not text:
        return []
    where = "x is the joint's point of a body, y that of its parent p; r = x - c, s = x - c_p; n moves with p"
    return [f"Constraints: {where}", *text.splitlines()]


def dae_json(found: Dae) -> str:
    """Return the DAE form; what is not defined where nothing resists some motion is null."""
    system, both = found.system, found.comparison
    steps = [select(step, "title formula check:checks error scale") for step in found.steps]
    elimination = select(
        found.reduced,
        "steps J Jdot_qd:drift M tau_less_bias:free loops",
        steps=steps,
        loops=select(found.reduced, "G gamma"),
    )
    counts, index = found.counts, found.counts.index
    out, row, free = [], 0, 0
    names = dict(enumerate(body.name for body in found.system.model.bodies))
    for connection in found.system.connections:
        held = [_held_json(found, connection, j, row + j) for j in range(len(connection.equations))]
        own = [_free_json(found, equation, k) for k, equation in enumerate(connection.free, free)]
        row, free = row + len(held), free + len(own)
        ends = {"body": names.get(connection.body), "other": names.get(connection.other)}
        keys = "name kind body other equations coordinates"
        out.append(select(connection, keys, **ends, equations=held, coordinates=own))
    return written(
        {
            "robot": system.model.name,
            "form": "dae",
            "gravity": system.scene.gravity,
            **select(system.model, "coordinates rates"),
            **select(found, "q qd tau"),
            "counts": select(
                counts,
                "bodies positions velocities reactions equations:unknowns rank degrees_of_freedom:freedom redundant "
                "undetermined coefficient_ranks:coefficients coefficient_size:size index",
                positions=6 * counts.bodies,
                velocities=6 * counts.bodies,
                index=index and dict(zip(("positions", "velocities", "accelerations"), index, strict=True)),
            ),
            "bodies": [_body_json(found, i) for i in range(found.counts.bodies)],
            "connections": out,
            "residual": {
                name: float(np.abs(part).max(initial=0.0)) for name, part in found.residuals._asdict().items()
            },
            "qdd": None if found.solution is None else found.qdd,
            "elimination": elimination,
            "comparison": both and select(both, "qdd accelerations forces moments"),
            "warnings": found.warnings,
        }
    )


def _body_json(found: Dae, i: int) -> dict[str, Any]:

    system, solution = found.system, found.solution
    inertia, place = system.inertias[i], system.at.places[i]
    a = None if solution is None else solution.a[6 * i : 6 * i + 6]
    wrench = found.wrenches[i] if found.wrenches else None
    return {
        "name": system.model.bodies[i].name,
        "mass": float(inertia.m),
        "com": inertia.centre_of_mass,
        "inertia": inertia.about_centre,
        "rotation": place.R,
        "centre": place.c - system.at.places[-1].c,
        **select(system.at.speeds[i], "w v"),
        "f": system.matrices.f[6 * i : 6 * i + 6],
        "wd": None if a is None else a[:3],
        "vd": None if a is None else a[3:],
        "joint_wrench": wrench and select(wrench, "force:f moment:n"),
    }


def _held_json(found: Dae, connection: Connection, j: int, k: int) -> dict[str, Any]:
    """Return equation j of a connection, row k of G."""
    name = connection.reactions[j]
    return {
        "reaction": name,
        "rows": _rows_json(found, connection.equations[j]),
        "gamma": float(found.system.matrices.gamma[k]),
        "g": float(found.residuals.places[k]),
        "Gv": float(found.residuals.speeds[k]),
        "lambda": None if found.solution is None else float(found.solution.reactions[k]),
        "redundant": (connection.name, name) in found.counts.redundant,
        "undetermined": (connection.name, name) in found.counts.undetermined,
    }


def _free_json(found: Dae, equation: Equation, k: int) -> dict[str, Any]:
    matrices = found.system.matrices
    rows, rotor = _rows_json(found, equation), np.diag(matrices.armature)[k]
    return {"rows": rows, "sigma": matrices.sigma[k], "along": matrices.along[k], "rotor": rotor}


def _rows_json(found: Dae, equation: Equation) -> list[dict[str, Any]]:
    """Return entries of a row of G or S by number of the body: three for w, three for v."""
    entries: dict[int, Any] = {}
    for body, row in equation.row(found.system.at):
        if body >= 0:
            entries[body] = entries.get(body, 0.0) + row
    return [{"body": body, "row": encode(row)} for body, row in entries.items()]
