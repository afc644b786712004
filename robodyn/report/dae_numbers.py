"""The numbers of the DAE form at a state, the elimination, both forms side by side, and what acts on a body."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from robodyn.equations.dae.dae import Dae
from robodyn.equations.dae.equations import Across
from robodyn.programs.linear import eigen
from robodyn.report.document import Section, Table, paragraphs
from robodyn.report.sizes import sizes
from robodyn.report.table import Content, number, printable, relative_text
from robodyn.support.floats import first_largest

MOST = 16
"""Rows of a table."""


def shortened(title: str, content: Content, what: str) -> Section:
    """Return a table of at most `MOST` rows, and how many more there are."""
    head, rows = content
    more = f"... and {len(rows) - MOST} more {what}; --format json has them all"
    return [Table(title, head, rows[:MOST]), *paragraphs([more] if len(rows) > MOST else [])]


def numbers_sections(found: Dae) -> Iterator[Section]:
    """Yield the tables of numbers."""
    yield [*shortened("State", _state(found), "coordinates"), *paragraphs(_consistent(found))]
    if found.solution is not None:
        title = "Accelerations of the bodies: wd in the body's axes, dv/dt of the mass centre in the ground's"
        yield shortened(title, _accelerations(found), "bodies")
        if found.counts.reactions:
            title = "Reactions lambda on the body that a joint carries, along its axes at q = 0, fixed in the parent"
            yield shortened(title, _reactions(found), "joints")


def _state(found: Dae) -> Content:
    model, qdd = found.robot.model, found.qdd
    at = dict(zip(model.coordinates, found.q.tolist(), strict=True))
    rows = []
    for k, name in enumerate(model.rates):
        given = [number(float(x)) if x else "0" for x in (found.qd[k], found.tau[k])]
        falling = [] if qdd is None else [number(float(qdd[k]), _fastest(found))]
        rows.append((name, f"{at[name]:.6g}" if name in at else "-", *given, *falling))
    return ("coordinate", "q", "qd", "tau", *(["qdd"] if qdd is not None else [])), rows


def _fastest(found: Dae) -> float:
    """Return the largest acceleration, of bodies and of free fall too, beside which others vanish."""
    assert found.solution is not None
    return float(np.abs([*found.solution.a, *found.robot.scene.gravity]).max())


def _consistent(found: Dae) -> Iterator[str]:
    off, rate = found.residuals
    if not len(off):
        return
    turns = np.array([isinstance(equation, Across) for equation in found.robot.system.equations])
    points = float(np.abs(off[~turns]).max(initial=0.0))
    angles = float(np.abs(off[turns]).max(initial=0.0))
    yield (
        f"consistent: g = 0 within {relative_text(points)} m and {relative_text(angles)} rad, "
        f"G v = 0 within {relative_text(float(np.abs(rate).max()))} per s"
    )


def _accelerations(found: Dae) -> Content:
    assert found.solution is not None
    each = found.solution.a.reshape(-1, 6)
    scale = _fastest(found)
    rows = [
        (f"{i} {body.name}", *(number(x, scale) for x in row))
        for i, (body, row) in enumerate(zip(found.robot.model.bodies, each.tolist(), strict=True))
    ]
    return ("body", "wd x [rad/s^2]", "y", "z", "dv/dt x [m/s^2]", "y", "z"), rows


def _reactions(found: Dae) -> Content:
    assert found.solution is not None
    values = iter(found.solution.reactions.tolist())
    own = [
        (connection, {name: next(values) for name in connection.reactions})
        for connection in found.robot.system.connections
    ]
    names = sorted({name for _, part in own for name in part}, key=_place)
    forces, moments = ([x for _, part in own for name, x in part.items() if name[0] == kind] for kind in "FM")
    weight = found.robot.model.total_mass * float(np.abs(found.robot.scene.gravity).max())
    scales = dict(zip("FM", sizes([*forces, weight], moments, found.robot.model.reach).values(), strict=True))
    rows = [
        (connection.name, *(number(part[name], scales[name[0]]) if name in part else "-" for name in names))
        for connection, part in own
        if part
    ]
    return ("joint", *(f"{name} [{'N' if name[0] == 'F' else 'N m'}]" for name in names)), rows


def _place(name: str) -> tuple[str, int]:
    """Return a key that sorts forces before moments, and x, y, z before the directions of oblique joints."""
    return name[0], ("x", "y", "z", "1", "2", "a", "3", "").index(name[1:])


def elimination_lines(found: Dae) -> Iterator[str]:
    """Yield every step with its identity and its residual."""
    n = found.robot.model.n
    yield f"Elimination of the reactions, to the ODE form with {n} velocities qd"
    for k, step in enumerate(found.steps, 1):
        yield from (f"{k}  {step.title}", f"   {step.formula}", f"   {step.checks}: within {relative_text(step.error)}")
    yield "errors are parts of the sum of magnitudes that add up to the largest number"


def both_lines(found: Dae) -> tuple[str, ...]:
    """Return how far the DAE and the ODE form are apart."""
    both = found.comparison
    if both is None:
        return (f'hardly anything resists "{_weakest(found)}": accelerations and reactions are not defined',)
    loops = bool(found.robot.scene.loops)
    other = "the closed chain in joint coordinates" if loops else "the ODE form's recursions"
    return (
        f"Both forms: against {other} accelerations qdd differ by {relative_text(both.accelerations)} of the largest,",
        f"forces at joints by {relative_text(both.forces)} and moments by {relative_text(both.moments)}",
    )


def _weakest(found: Dae) -> str:
    """Return the rate that moves most in the motion that the mass matrix resists least."""
    sizes, motions = eigen(found.reduced.M)
    return printable(found.robot.model.rates[first_largest(np.abs(motions[first_largest(-np.abs(sizes))]))])


class Acting(NamedTuple):
    """A force F and, unless it can carry none, a moment M: what joint or loop, "-" on the body that holds the other."""

    sign: str
    name: str
    moment: bool = True


def acting(found: Dae, i: int) -> list[Acting]:
    """Return what acts on body i: its own joint i, those of the bodies that it carries, and L1, L2 ... for loops."""
    model, system = found.robot.model, found.robot.system
    felt = [k for k, joint in enumerate(system.joints) if joint.kind != "floating" or _driven(found, k)]
    own = [Acting("", str(i))] if i in felt else []
    carried = [Acting("-", str(k)) for k in felt if model.parents[k] == i]
    loops = [
        Acting(sign, f"L{k}", loop.kind not in ("point", "directions"))
        for k, loop in enumerate(system.loops, 1)
        for sign, end in (("", loop.body), ("-", loop.other))
        if end == i
    ]
    return own + carried + loops


def _driven(found: Dae, i: int) -> bool:
    """Return whether something drives the floating joint of body i."""
    rate = found.robot.model.bodies[i].joint.rate
    return bool(found.tau[rate : rate + 6].any())
