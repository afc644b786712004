"""Configurations in which the loops of a closed chain hold less than elsewhere, so that more than one way leads on."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.loops.closed_chain import ClosedChain
from robodyn.dynamics.loops.closed_start import FEW, independent_equations
from robodyn.dynamics.plan import Plan
from robodyn.errors import InputError
from robodyn.programs.program import traced
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar
from robodyn.simulation.equations import STATE, Equations, state_runner
from robodyn.simulation.fixed import Motion
from robodyn.support.caveats import Caveat
from robodyn.support.floats import Floats

KEPT = 1e-4
"""Of the square of the speeds: what they may miss of staying on the loops, as those typed with six digits do."""
WORK = 5e8
"""Operations for the singular values of J along a motion, about; between the records looked at, where they change."""


class Singular(NamedTuple):
    """When [s] the loops leave more degrees of freedom than elsewhere, and how many they leave then."""

    time: float
    freedoms: int


def start_caveats(plan: Plan, state: Floats) -> tuple[Caveat, ...]:
    """Return the caveats about a start in which the equations of the loops depend on each other.

    With u^T J = 0 a motion keeps u^T J' qd = 0 too, a quadratic form of the speeds: they are along one of the ways on.

    Raises:
        InputError: they are along none.
    """
    if not plan.scene.loops:
        return ()
    chain, model = independent_equations(plan), plan.model
    q, qd = state[: model.nq].tolist(), state[model.nq : model.nq + model.n]
    left, across = _lost(chain, q)
    if not left.shape[1]:
        return ()
    freedoms, usual = across.shape[1], model.n - chain.count
    leave = f"the loops leave {freedoms} degrees of freedom where the motion begins, and {usual} nearby"
    missed = float(np.abs(_turned(chain, q, qd, left)).max())
    if missed > KEPT * max(float(qd @ qd), 1e-300):
        what = f"{leave}: with the speeds given they come apart at {missed:.3g} m/s^2 or rad/s^2, whatever happens"
        raise InputError(what, remedy=_ways(plan, chain, q, qd, left, across))
    how = "they follow the speeds given, and errors fall only with the step" if qd.any() else "at rest none is marked"
    said = f"{leave}: ways part there, and which one is taken is assumed ({how}); begin a little away from there"
    return (Caveat("by one of several motions that are possible (assumed)", said),)


def _lost(chain: ClosedChain, q: list[float]) -> tuple[Floats, Floats]:
    """(equations, lost) and (n, freedoms): what the equations do not ask for, and the speeds that they leave."""
    U, values, V = np.linalg.svd(chain.jacobian(chain.sample(q)))
    rank = int((values > FEW * values.max(initial=0.0)).sum())
    return U[:, rank:], V[rank:].T


def _turned(chain: ClosedChain, q: list[float], qd: Floats, left: Floats) -> Floats:
    """u^T J' qd of each u."""
    bias = np.array(chain.equations(chain.sample(q, qd.tolist())).bias, dtype=float)
    return np.asarray(bias @ left)


def _ways(plan: Plan, chain: ClosedChain, q: list[float], qd: Floats, left: Floats, across: Floats) -> str:
    """Return a remedy that names the speeds of the ways on, where two numbers and one equation are left."""
    away = "begin a little away from there"
    if left.shape[1] != 1 or across.shape[1] != 2:
        return away
    a, c, both = (float(_turned(chain, q, across @ x, left)[0]) for x in ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0)))
    ways = [across @ x for x in _lines(a, both - a - c, c)]
    names = plan.model.rates
    first = next((names.index(name) for name in plan.scene.initial_qd), int(np.argmax(np.abs(qd))))
    some = [way * (qd[first] / way[first]) for way in ways if abs(way[first]) > FEW * np.abs(way).max()]
    clean = [np.where(np.abs(way) < FEW * np.abs(way).max(), 0.0, way).tolist() for way in some]
    listed = [", ".join(f"{n} = {x:.6g}" for n, x in zip(names, way, strict=True)) for way in clean]
    return f"{away}, or give all [initial] qd of one way on: {'; or '.join(listed)}" if listed else away


def _lines(a: float, b: float, c: float) -> list[tuple[float, float]]:
    """Return the directions (x, y) with `a x^2 + b x y + c y^2 = 0`."""
    square = b * b - 4.0 * a * c
    if square < 0.0:
        return []
    big = -0.5 * (b + np.copysign(np.sqrt(square), b))
    return [(big, a), (c, big)] if big else [(1.0, 0.0)]


def passed(plan: Plan, motion: Motion) -> tuple[Singular, ...]:
    """Return when a motion begins in such configurations or passes through them.

    Along a smooth motion J = U S V^T has smooth singular values that may change their sign: from one record to a later
    one J_2, the eigenvalues of S^-1 U^T J_2 V are near 1 but for those, which become negative.
    """
    chain, n = independent_equations(plan), plan.model.n
    if not chain.count:
        return ()
    rows = max(int(WORK / (20 * n * chain.count**2)), 2)
    found: list[Singular] = []

    def look(first: int, last: int) -> None:
        places = np.unique(np.linspace(first, last, min(rows, last - first + 1)).astype(int))
        J = _jacobians(plan, motion.states[places])
        for k, share, lost in _changes(J):
            a, b = int(places[k]), int(places[min(k + 1, len(places) - 1)])
            if b > a + 1 and share:
                look(a, b)
            else:
                time = motion.time[a] + share * (motion.time[b] - motion.time[a])
                found.append(Singular(float(time), n - chain.count + lost))

    look(0, len(motion.time) - 1)
    return tuple(found)


def _changes(J: Floats) -> list[tuple[int, float, int]]:
    """Return where J (N, m, n) loses rank: a row, the share of the way to the next one, and by how much."""
    U, values, V = np.linalg.svd(J, full_matrices=False)
    none = values <= FEW * values[:, :1]
    lost = none.sum(axis=1)
    begun = np.flatnonzero((lost > 0) & (np.append(0, lost[:-1]) == 0))
    found = [(int(k), 0.0, int(lost[k])) for k in begun]
    pairs = np.flatnonzero((lost[:-1] == 0) & (lost[1:] == 0))
    after = U[pairs].transpose(0, 2, 1) @ J[pairs + 1] @ V[pairs].transpose(0, 2, 1)
    ratios = np.linalg.eigvals(after / values[pairs][:, :, None]).real
    for k, ratio in zip(pairs.tolist(), ratios, strict=True):
        if ratio.min() < 0.0:
            found.append((k, 1.0 / (1.0 - float(ratio.min())), int((ratio < 0.0).sum())))
    return sorted(found)


def _jacobians(plan: Plan, states: Floats) -> Floats:
    """Return (N, m, n) J at some states."""
    columns = state_runner(_jacobian_program, plan)({STATE: states}, len(states), executor="numpy")
    return columns.reshape(len(states), -1, plan.model.n)


@traced
def _jacobian_program(equations: Equations, tape: Tape) -> Iterable[Scalar]:
    chain = independent_equations(equations.plan)
    rows = chain.equations(chain.sample(equations.state(tape).q)).J
    return [row.get(rate, 0.0) for row in rows for rate in range(chain.model.n)]


def passing_notes(found: tuple[Singular, ...], usual: int) -> list[str]:
    """Return a line on the configurations that a motion passes through on the way."""
    later = [each for each in found if each.time > 0.0]
    if not later:
        return []
    most = max(each.freedoms for each in later)
    times = ", ".join(f"{each.time:.4g}" for each in later[:4]) + (", ..." if len(later) > 4 else "")
    return [
        f"the loops leave up to {most} degrees of freedom, and {usual} elsewhere, where the motion passes at {times} s "
        f"({len(later)} in all): ways part there, and it is assumed to go straight on"
    ]
