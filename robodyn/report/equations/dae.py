"""The DAE form: what is unknown, what holds, the numbers, and how the reactions go."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from robodyn.equations.dae.dae import Counts, Dae
from robodyn.equations.dae.system import Equation, Place, Sum
from robodyn.report.document import Block, Paragraph, Section, Table, encode, paragraphs, remarks, select, written
from robodyn.report.equations.equations import base_text
from robodyn.report.sizes import sizes
from robodyn.report.table import axis_text, gravity_text, number, printable, relative_text
from robodyn.support.floats import first_largest
from robodyn.support.linear import eigen
from robodyn.support.wording import count

MOST = 16
"""Rows of a table."""


def _shortened(title: str, head: Sequence[str], rows: Sequence[Sequence[str]], what: str) -> list[Block]:
    more = f"... and {len(rows) - MOST} more {what}; --format json has them all"
    return [Table(title, head, rows[:MOST]), *paragraphs([more] if len(rows) > MOST else [])]


def _numbers(found: Dae) -> Iterator[Section]:
    """Yield state, accelerations and reactions, beside the largest acceleration of bodies and of free fall."""
    model, qdd, solution = found.system.model, found.qdd, found.solution
    scale = float(np.abs([*([] if solution is None else solution.a), *found.system.scene.gravity]).max())
    at = dict(zip(model.coordinates, found.q.tolist(), strict=True))
    rows = []
    for k, name in enumerate(model.rates):
        given = [number(float(x)) if x else "0" for x in (found.qd[k], found.tau[k])]
        falling = [] if qdd is None else [number(float(qdd[k]), scale)]
        rows.append((name, f"{at[name]:.6g}" if name in at else "-", *given, *falling))
    head = ("coordinate", "q", "qd", "tau", *(["qdd"] if qdd is not None else []))
    state = _shortened("State", head, rows, "coordinates")
    off, rate = found.residuals
    if len(off):
        turns = np.array([isinstance(each, Place) and bool(each.E.any()) for each in found.system.equations])
        points, angles = (relative_text(float(np.abs(off[which]).max(initial=0.0))) for which in (~turns, turns))
        speeds = relative_text(float(np.abs(rate).max()))
        state.append(Paragraph(f"consistent: g = 0 within {points} m and {angles} rad, G v = 0 within {speeds} per s"))
    yield state
    if solution is None:
        return
    bodies = enumerate(zip(model.bodies, solution.a.reshape(-1, 6).tolist(), strict=True))
    rows = [(f"{i} {body.name}", *(number(x, scale) for x in row)) for i, (body, row) in bodies]
    title = "Accelerations of the bodies: wd in the body's axes, dv/dt of the mass centre in the ground's"
    yield _shortened(title, ("body", "wd x [rad/s^2]", "y", "z", "dv/dt x [m/s^2]", "y", "z"), rows, "bodies")
    if found.counts.reactions:
        values, places = iter(solution.reactions.tolist()), ("x", "y", "z", "1", "2", "a", "3", "")
        own = [(joint, {name: next(values) for name in joint.reactions}) for joint in found.system.connections]
        # forces before moments, and x, y, z before the directions of oblique joints
        names = sorted({name for _, part in own for name in part}, key=lambda name: (name[0], places.index(name[1:])))
        forces, moments = ([x for _, part in own for name, x in part.items() if name[0] == kind] for kind in "FM")
        weight = model.total_mass * float(np.abs(found.system.scene.gravity).max())
        scales = dict(zip("FM", sizes([*forces, weight], moments, model.reach).values(), strict=True))
        head = ("joint", *(f"{name} [{'N' if name[0] == 'F' else 'N m'}]" for name in names))
        rows = [
            (joint.name, *(number(part[name], scales[name[0]]) if name in part else "-" for name in names))
            for joint, part in own
            if part
        ]
        title = "Reactions lambda on the body that a joint carries, along its axes at q = 0, fixed in the parent"
        yield _shortened(title, head, rows, "joints")


def _ranks(counts: Counts) -> list[str]:
    six, rank, m = 6 * counts.bodies, counts.rank, counts.reactions
    lines = [f"rank of G: {rank} of {m}, no constraint is redundant"]
    if counts.redundant:
        listed = "; ".join(f"{printable(name)} {reaction}" for name, reaction in counts.redundant[:MOST])
        more = "; ..." if len(counts.redundant) > MOST else ""
        lines = [f"rank of G: {rank} of {m}, {len(counts.redundant)} redundant ({listed}{more})"]
        left = f"{len(counts.undetermined)} reactions open; those of redundant equations count as 0"
        lines.append(f"  rigid bodies leave {left}")
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


def laws(found: Dae, i: int) -> tuple[str, str]:
    """Return the sums of Newton's and Euler's laws of body i: weight, joints by number, loops L1, L2 ..., wrenches of
    the scene E; what it does to the bodies that it carries has a minus."""
    model, system = found.system.model, found.system
    driven = [bool(found.tau[body.joint.rate : body.joint.rate + 6].any()) for body in model.bodies]
    felt = [k for k, joint in enumerate(system.joints) if joint.kind != "floating" or driven[k]]
    acting = [("", str(i), True)] if i in felt else []
    acting += [("-", str(k), True) for k in felt if model.parents[k] == i]
    for k, loop in enumerate(system.loops, 1):
        turns = loop.kind not in ("point", "directions")
        acting += [(sign, f"L{k}", turns) for sign, end in (("", loop.body), ("-", loop.other)) if end == i]
    forces = [f"m{i} g"] if system.inertias[i].m and any(system.scene.gravity) else []
    moments = []
    for sign, name, turns in acting:
        forces.append(f"{sign}F{name}")
        moments += [f"{sign}M{name}"] * turns + [f"{sign}{'s' if sign else 'r'}{name} x F{name}"]
    if any(body == i for body, _ in system.terms.wrenches):
        forces.append(f"FE{i}")
        moments.append(f"ME{i}")
    newton, euler = (" + ".join(terms).replace("+ -", "- ") or "0" for terms in (forces, moments))
    return newton, euler


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
    bodies = zip(system.model.bodies, system.inertias, strict=True)
    each = [(f"{i} {body.name}", f"{number(float(own.m))} kg", *laws(found, i)) for i, (body, own) in enumerate(bodies)]
    title = "Bodies: six coordinates each, Newton's and Euler's laws about the mass centre c"
    legend = "F_i and M_i, drives included, act through joint i on body i and, opposite, on its parent, r and s from c"
    laws_of = ("body", "mass", "m dv/dt =", "I_c wd + w x I_c w =")
    yield [*_shortened(title, laws_of, each, "bodies"), Paragraph(legend)]
    yield _connections(found)
    places = [equation for equation in system.equations if isinstance(equation, Place)]
    held = ALONG * any(each.n.any() for each in places) + ACROSS * any(each.E.any() for each in places)
    held += MIMIC * any(isinstance(equation, Sum) for equation in system.equations)
    where = "x is the joint's point of a body, y that of its parent p; r = x - c, s = x - c_p; n moves with p"
    yield paragraphs([f"Constraints: {where}", *held.splitlines()] if held else [])
    yield from _numbers(found)
    lines = [f"Elimination of the reactions, to the ODE form with {system.model.n} velocities qd"]
    for k, step in enumerate(found.steps, 1):
        lines += [f"{k}  {step.title}", f"   {step.formula}"]
        lines.append(f"   {step.checks}: within {relative_text(step.error)}")
    yield paragraphs([*lines, "errors are parts of the sum of magnitudes that add up to the largest number"])
    if both := found.comparison:
        other = "the closed chain in joint coordinates" if system.scene.loops else "the ODE form's recursions"
        far, forces, moments = map(relative_text, (both.accelerations, both.forces, both.moments))
        said = [f"Both forms: against {other} accelerations qdd differ by {far} of the largest,"]
        said.append(f"forces at joints by {forces} and moments by {moments}")
    else:
        resistances, motions = eigen(found.reduced.M)
        weakest = system.model.rates[first_largest(np.abs(motions[first_largest(-np.abs(resistances))]))]
        said = [f'hardly anything resists "{printable(weakest)}": accelerations and reactions are not defined']
    yield paragraphs(said)
    yield remarks("warning", found.warnings)


def _connections(found: Dae) -> Section:
    model, system = found.system.model, found.system
    names = [body.name for body in model.bodies] + ["ground"]
    numbered = [(str(i), joint) for i, joint in enumerate(system.joints)]
    numbered += [("", mimic) for mimic in system.mimics]
    numbered += [(f"L{k}", loop) for k, loop in enumerate(system.loops, 1)]
    rows = []
    for label, connection in numbered:
        freedoms, axis = 6 - len(connection.equations), "-"
        if label.isdigit() and connection.kind in ("revolute", "prismatic"):
            axis = axis_text(model.bodies[int(label)].joint.axis)
            axis = f"a = {axis}" if axis[0] == "(" else axis
        row = [f"{label} {connection.name}".strip(), f"{names[connection.other]} - {names[connection.body]}"]
        row += [connection.kind, axis, str(freedoms) if label else "-", str(len(connection.equations))]
        rows.append((*row, " ".join(connection.reactions) or "-"))
    if len(rows) > MOST and system.loops:  # what closes the loops comes first
        rows = [rows[k] for k in sorted(range(len(rows)), key=lambda k: numbered[k][0].isdigit())]
    oblique = any(name.endswith("a") for connection in system.connections for name in connection.reactions)
    lines = ["1, 2 and a are perpendicular, a along an oblique axis"] * oblique
    if system.rotors or system.matrices.along.any():
        taken = ", less friction and springs" if system.terms.at_joint else ""
        rotors = "; a rotor J adds S^T J S to M" if system.rotors else ""
        own = f"along its own coordinates, whose velocity is S v, a joint passes on tau{taken}"
        lines.append(f"{own}: S^T tau in f{rotors}")
    title = "Joints: a constraint equation and a reaction for each direction in which it holds"
    head = ("joint", "between", "type", "axis", "f", "6 - f", "reactions lambda")
    return [*_shortened(title, head, rows, "joints"), *paragraphs(lines)]


def dae_json(found: Dae) -> str:
    """Return the DAE form; what is not defined where nothing resists some motion is null."""
    system, counts, index, matrices = found.system, found.counts, found.counts.index, found.system.matrices
    connections: list[dict[str, Any]] = []
    row, free = 0, 0
    names = dict(enumerate(body.name for body in system.model.bodies))
    for connection in system.connections:
        held, own = [], []
        for reaction, equation in zip(connection.reactions, connection.equations, strict=True):
            one = {"reaction": reaction, "rows": _rows_json(found, equation), "gamma": matrices.gamma[row]}
            one |= {"g": found.residuals.places[row], "Gv": found.residuals.speeds[row]}
            one["lambda"] = None if found.solution is None else found.solution.reactions[row]
            for name in ("redundant", "undetermined"):
                one[name] = (connection.name, reaction) in getattr(counts, name)
            held.append(one)
            row += 1
        for equation in connection.free:
            one = {"rows": _rows_json(found, equation), "sigma": matrices.sigma[free], "along": matrices.along[free]}
            own.append({**one, "rotor": np.diag(matrices.armature)[free]})
            free += 1
        ends = {"body": names.get(connection.body), "other": names.get(connection.other)}
        keys = "name kind body other equations coordinates"
        connections.append(select(connection, keys, **ends, equations=held, coordinates=own))
    bodies = []
    for i, (body, inertia) in enumerate(zip(system.model.bodies, system.inertias, strict=True)):
        at, part = system.at[i], slice(6 * i, 6 * i + 6)
        a = None if found.solution is None else found.solution.a[part].tolist()
        one = {"name": body.name, "mass": inertia.m, "com": inertia.centre_of_mass, "inertia": inertia.about_centre}
        one |= {"rotation": at.R, "centre": at.c - system.at[-1].c, "w": at.w, "v": at.v, "f": matrices.f[part]}
        one |= {"wd": a and a[:3], "vd": a and a[3:]}
        one["joint_wrench"] = select(found.wrenches[i], "force:f moment:n") if found.wrenches else None
        bodies.append(one)
    own_counts = select(
        counts,
        "bodies positions velocities reactions equations:unknowns rank degrees_of_freedom:freedom redundant "
        "undetermined coefficient_ranks:coefficients coefficient_size:size index",
        positions=6 * counts.bodies,
        velocities=6 * counts.bodies,
        index=index and dict(zip(("positions", "velocities", "accelerations"), index, strict=True)),
    )
    keys = "steps[title formula check:checks error scale] J Jdot_qd:drift M tau_less_bias:free loops"
    document = select(
        found,
        "robot:system.model.name form gravity:system.scene.gravity coordinates:system.model.coordinates "
        "rates:system.model.rates q qd tau counts bodies connections residual qdd elimination "
        "comparison[qdd accelerations forces moments] warnings",
        form="dae",
        counts=own_counts,
        bodies=bodies,
        connections=connections,
        residual={name: np.abs(part).max(initial=0.0) for name, part in found.residuals._asdict().items()},
        qdd=None if found.solution is None else found.qdd,
        elimination=select(found.reduced, keys, steps=found.steps, loops=select(found.reduced, "G gamma")),
    )
    return written(document)


def _rows_json(found: Dae, equation: Equation) -> list[dict[str, Any]]:
    entries: dict[int, Any] = {}
    for body, row in equation.row(found.system.at):
        if body >= 0:
            entries[body] = entries.get(body, 0.0) + row
    return [{"body": body, "row": encode(row)} for body, row in entries.items()]
