"""The branch of a closed chain on which a motion begins, and what is wrong where there is none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robodyn.dynamics.initial_state import initial_state
from robodyn.dynamics.loops.block_equations import BlockEquations
from robodyn.dynamics.loops.branch import FEW, Branch
from robodyn.dynamics.loops.branch_search import search
from robodyn.dynamics.loops.closed_start import closed_by, closed_start
from robodyn.dynamics.loops.find import independent
from robodyn.dynamics.loops.independent_equations import nearby
from robodyn.dynamics.plan import plan
from robodyn.errors import InputError, TrajectoryError
from robodyn.programs.linear import null_space, range_basis
from robodyn.robot.configuration import unit_rows
from robodyn.support.floats import Floats
from robodyn.support.wording import count

TRIALS = 6
"""Configurations at which the rank of J is looked at before one that is closed is known."""
OFF = 1e-2
"""rad, or of the loops' size: what given coordinates may miss of closing the loops.

Encoders of 12 bits, rounded degrees and links that were measured to 1e-3 of their lengths miss by a few 1e-3; an offset
of a degree, a wrong sign or unit misses by more than this. Torques are off by about the same share.
"""
CLOSED = 1e-9
"""The same where coordinates follow that are free to close them."""
SHOWN = 3


def first_pose(equations: BlockEquations) -> tuple[Floats, bool]:
    """Return (nq,) where a simulation of the scene begins, and whether its loops close there.

    Initial positions that are columns count as nothing said.
    """
    model, scene = equations.model, equations.plan.scene
    numbers = {name: entry for name, entry in scene.initial_q.items() if not isinstance(entry, str)}
    begun = replace(scene, initial_q=numbers, initial_qd={})
    state = initial_state(model, begun)
    try:
        return closed_start(plan(model, begun), state)[: model.nq], True
    except InputError:
        return state[: model.nq], False


def begin(branch: Branch, q: Floats, where: str) -> tuple[Floats, list[str]]:
    """Return the closed configuration (nq,) of the first row, and notes.

    It is that to which the given coordinates lead from where a simulation of the scene begins, in a straight line; else
    the one nearest to this. Those within the joints' limits come first.

    Args:
        q: (nq,), of which given coordinates count. where: row and time, as messages have them.

    Raises:
        TrajectoryError: too little is given, the loops do not close, or what follows depends on each other there.
    """
    equations = branch.equations
    _refuse_few(branch, _generic(branch))
    near, closed = first_pose(equations)
    tolerance = CLOSED if len(branch.followed) == equations.count else OFF
    led = q[None].copy()
    if closed and branch.along(near, led) is None:
        near = led[0]
    found = search(branch, q, near, tolerance)
    if not len(found.places):
        guess = q.copy()
        guess[branch.coordinates] = near[branch.coordinates]
        place = closed_by(equations.chain, guess, branch.followed.tolist())
        if place is None:
            raise TrajectoryError(f"{where}: {found.missed} at least with {given(branch, q)}", remedy=UNREACHED)
        found = found._replace(places=place[None])
    place = found.places[0]
    J = equations.places(place[None])[1][0][:, branch.own]
    if len(range_basis(J, FEW)) < len(branch.own):
        rows = [equations.places(each[None])[1][0] for each in nearby(equations.chain, place)]
        _refuse_few(branch, [J, *(row[:, branch.own] for row in rows)])
        raise singular(branch, where)
    return place, _choice(branch, found.places)


UNREACHED = "correct these columns, the loop's points or the links' lengths"


def singular(branch: Branch, where: str) -> TrajectoryError:
    """Return the error about a row at which what follows is not determined."""
    names = [f"q_{name}" for name in _names(branch)]
    what = f"{where}: the loops are singular, so that {', '.join(names)} do not follow from the other columns there"
    return TrajectoryError(what, remedy=f"give {' or '.join(names[:SHOWN])} as well, or leave the rows there out")


def given(branch: Branch, q: Floats) -> str:
    """Return the values of given coordinates of the loops, of the first few."""
    model = branch.equations.model
    joints = [joint for joint in model.independent if joint.rate in branch.given and joint.kind != "floating"]
    shown = [f"q_{joint.name} = {q[joint.coordinate]:.6g}" for joint in joints[:SHOWN]]
    return ", ".join(shown) + (" ..." if len(joints) > SHOWN else "") if shown else "the columns given"


def _generic(branch: Branch) -> list[Floats]:
    """Return J_d at some configurations drawn at random."""
    model = branch.equations.model
    drawn = np.random.default_rng(0).uniform(-1.0, 1.0, (TRIALS, model.nq))
    return list(branch.equations.places(unit_rows(model, drawn))[1][:, :, branch.own])


def _refuse_few(branch: Branch, matrices: Sequence[Floats]) -> None:
    """Raise if no J_d (equations, followed) determines all that is to follow."""
    best = max(matrices, key=lambda J: len(range_basis(J, FEW)))
    rank, k = len(range_basis(best, FEW)), len(branch.followed)
    if rank == k:
        return
    free = null_space(best, FEW) if rank else np.eye(k)
    names = _names(branch)
    actuated = branch.equations.plan.scene.actuated or ()
    order = sorted(range(k), key=lambda i: names[i] not in actuated)
    chosen = [order[i] for i in independent(np.ascontiguousarray(free.T[order]), FEW)]
    if k - rank == 1:
        chosen = [i for i in order if np.abs(free[:, i]).max() > FEW]
    others = chosen[1:] if k - rank == 1 else []
    what = f"{count(k - rank, 'freedom')} of the loops follow{'s' if k - rank == 1 else ''} from no column"
    columns = ", ".join(f"q_{names[i]}" for i in sorted(chosen) if i not in others)
    instead = f", or one of {', '.join(f'q_{names[i]}' for i in others[:SHOWN])}" if others else ""
    followed = ", ".join(f"q_{name}" for name in names)
    raise TrajectoryError(f"{what}: {followed} have none", remedy=f"give {columns}{instead}")


def _names(branch: Branch) -> list[str]:
    return [branch.equations.model.rates[rate] for rate in branch.followed]


def _choice(branch: Branch, places: Floats) -> list[str]:
    """Return a note on the branch that was taken, where there are others and the scene does not choose."""
    model = branch.equations.model
    names = [model.coordinates[k] for k in branch.coordinates]
    if len(places) < 2 or any(name in branch.equations.plan.scene.initial_q for name in names):
        return []
    shown = [
        ", ".join(f"{name} = {place[k]:.4g}" for name, k in zip(names[:SHOWN], branch.coordinates, strict=False))
        for place in places[:2]
    ]
    return [
        f"the loops close in {len(places)} ways or more at the first row: taken is {shown[0]}, not {shown[1]} "
        "([initial] q in the scene chooses)"
    ]
