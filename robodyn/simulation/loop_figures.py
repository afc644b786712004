"""What the loops of a closed chain carry along a motion, how far they come apart, and where ways part."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.effect import Sample
from robodyn.dynamics.initial_state import FEW, independent_equations
from robodyn.dynamics.loops.closed_chain import NOTHING
from robodyn.dynamics.plan import Plan, applied, runner_of
from robodyn.errors import Caveat, InputError
from robodyn.programs.program import trace, traced
from robodyn.programs.run.stepper import COLUMNS
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar
from robodyn.simulation.equations import STATE, Equations, state_runner
from robodyn.simulation.integrate import Motion
from robodyn.simulation.table import Signal
from robodyn.support.floats import Floats

OPEN = 1e-6  # m or rad, and per s, by which a given state may miss the loops
KEPT = 1e-4
"""Of the square of the speeds: what they may miss of staying on the loops, as those typed with six digits do."""
WORK = 5e8
"""Operations for the singular values of J along a motion, about; between the records looked at, where they change."""


class Singular(NamedTuple):
    """When [s] the loops leave more degrees of freedom than elsewhere, and how many they leave then."""

    time: float
    freedoms: int


@dataclass(frozen=True, eq=False)
class LoopFigures:
    """At the recorded times, N of them, for L loops.

    Attributes:
        wrenches: (N, L, 6) force and moment on each loop's `link` at its point, in the axes of `to` [N, N m].
        gap, slip: the largest |phi| [m and rad] and |phi'| [m/s and rad/s] of each loop along the motion.
        equations: how many the loops have, `dropped` those that others of their loop imply, and `rank` how many of the
            others are independent where the motion begins; `freedoms` are left there, and `usual` elsewhere.
        stabilised: how the loops are kept closed.
    """

    names: tuple[str, ...]
    wrenches: Floats
    gap: Floats
    slip: Floats
    equations: int
    dropped: tuple[str, ...]
    rank: int
    freedoms: int
    usual: int
    stabilised: str
    singular: tuple[Singular, ...] = ()

    @property
    def notes(self) -> list[str]:
        """A line on the configurations on the way in which ways part."""
        later = [each for each in self.singular if each.time > 0.0]
        most = max((each.freedoms for each in later), default=0)
        times = ", ".join(f"{each.time:.4g}" for each in later[:4]) + (", ..." if len(later) > 4 else "")
        said = (
            f"the loops leave up to {most} degrees of freedom, and {self.usual} elsewhere, where the motion passes at "
            f"{times} s ({len(later)} in all): ways part there, and it is assumed to go straight on"
        )
        return [said] * bool(later)


def loop_figures(plan: Plan, motion: Motion, executor: str, signal: Signal, projected: bool) -> LoopFigures | None:
    """The figures of a motion, `projected` by steps without a Baumgarte rate; None where the scene has no loops."""
    if not plan.scene.loops:
        return None
    chain, count, n = independent_equations(plan), len(plan.scene.loops), plan.model.n
    J = chain.jacobian(chain.sample(motion.states[0, : plan.model.nq].tolist()))
    rank = int(np.linalg.matrix_rank(J, tol=NOTHING * np.linalg.norm(J, 2))) if J.size else 0
    runner = state_runner(loop_program, plan, len(signal.curves))
    sources = {STATE: motion.states, COLUMNS: signal.at(motion.time)}
    columns = runner(sources, len(motion.states), executor=executor)
    of = [k for k, closure in enumerate(chain.closures) for _ in closure.equations]
    wrenches, errors, rates = np.split(columns, np.cumsum([6 * count, len(of)]), axis=1)
    gap, slip = np.zeros((2, count))
    np.maximum.at(gap, of, np.abs(errors).max(axis=0))
    np.maximum.at(slip, of, np.abs(rates).max(axis=0))
    kept = "projection after each step" if projected else "not stabilised, for which the scene has baumgarte"
    kept = f"Baumgarte's terms at {plan.scene.baumgarte:g}/s" if plan.scene.baumgarte else kept
    return LoopFigures(
        names=tuple(loop.name for loop in plan.scene.loops),
        wrenches=wrenches.reshape(len(columns), count, 6),
        gap=gap,
        slip=slip,
        equations=len(of) + len(chain.dropped),
        dropped=tuple(f"{closure.loop.name} {equation.about}" for closure, equation in chain.dropped),
        rank=rank,
        freedoms=n - rank,
        usual=n - len(of),
        stabilised=kept,
        singular=_passed(plan, motion),
    )


@traced
def loop_program(equations: Equations, tape: Tape) -> Iterable[Scalar]:
    """The program of each loop's wrench, then of phi and phi' by equation."""
    chain = independent_equations(equations.plan)
    state, given = equations.state(tape), equations.given(tape)
    sample: Sample = equations.sample(chain.model, state.q, state.qd, given)
    terms = applied(equations.plan.effects, sample, equations.scene)
    tau = equations.drives(state.q, state.qd, given)
    here = chain.equations(sample)
    wrenches = chain.wrenches(here, chain.accelerations(sample, terms, tau)[1])
    return [*(x for wrench in wrenches for part in wrench for x in part), *here.error, *here.rate]


def check_closed(plan: Plan, q: Floats, qd: Floats) -> None:
    """Raise if a state of q (N, nq) and qd (N, n) is not on the loops."""
    chain = independent_equations(plan)

    def outputs(tape: Tape) -> Iterable[Scalar]:
        here = chain.equations(replace(plan.sample(tape), model=chain.model, qdd=(0.0,) * plan.model.n))
        return [*here.error, *here.rate]

    errors = np.abs(runner_of(trace(outputs), plan)({"q": q, "qd": qd}, len(q), executor="numpy")).max(axis=1)
    bad = np.flatnonzero(~(errors <= OPEN))
    if len(bad):
        what = f"row {bad[0]} misses the loops by {errors[bad[0]]:.3g} m or rad, or per s"
        raise InputError(what, remedy="begin where simulate begins: its first q and qd")


def start_caveats(plan: Plan, state: Floats) -> tuple[Caveat, ...]:
    """The caveats about a start in which the loops' equations depend on each other: with u^T J = 0 a motion keeps
    u^T J' qd = 0 too, a quadratic form of the speeds; raises if they do not."""
    if not plan.scene.loops:
        return ()
    chain, model = independent_equations(plan), plan.model
    q, qd = state[: model.nq].tolist(), state[model.nq : model.nq + model.n]
    U, values, _ = np.linalg.svd(chain.jacobian(chain.sample(q)))
    rank = int((values > FEW * values.max(initial=0.0)).sum())
    left = U[:, rank:]  # what the equations do not ask for
    if not left.shape[1]:
        return ()
    freedoms, usual = model.n - rank, model.n - chain.count
    leave = f"the loops leave {freedoms} degrees of freedom where the motion begins, and {usual} nearby"
    turned = np.array(chain.equations(chain.sample(q, qd.tolist())).bias, dtype=float) @ left
    missed = float(np.abs(turned).max())
    if missed > KEPT * max(float(qd @ qd), 1e-300):
        what = f"{leave}: with the speeds given they come apart at {missed:.3g} m/s^2 or rad/s^2, whatever happens"
        raise InputError(what, remedy="begin a little away from there, or give all [initial] qd of one way on")
    how = "they follow the speeds given, and errors fall only with the step" if qd.any() else "at rest none is marked"
    said = f"{leave}: ways part there, and which one is taken is assumed ({how}); begin a little away from there"
    return (Caveat("by one of several motions that are possible (assumed)", said),)


def _passed(plan: Plan, motion: Motion) -> tuple[Singular, ...]:
    """When a motion begins in singular configurations or passes through them."""
    chain, n = independent_equations(plan), plan.model.n
    if not chain.count:
        return ()
    rows = max(int(WORK / (20 * n * chain.count**2)), 2)
    jacobians = state_runner(_jacobian_program, plan)
    found: list[Singular] = []

    def look(first: int, last: int) -> None:
        places = np.unique(np.linspace(first, last, min(rows, last - first + 1)).astype(int))
        J = jacobians({STATE: motion.states[places]}, len(places), executor="numpy")
        for k, share, lost in _rank_changes(J.reshape(len(places), -1, n)):
            a, b = int(places[k]), int(places[min(k + 1, len(places) - 1)])
            if b > a + 1 and share:
                look(a, b)
            else:
                time = motion.time[a] + share * (motion.time[b] - motion.time[a])
                found.append(Singular(float(time), n - chain.count + lost))

    look(0, len(motion.time) - 1)
    return tuple(found)


def _rank_changes(J: Floats) -> list[tuple[int, float, int]]:
    """Where J (N, m, n) loses rank: a row, the share of the way to the next, and by how much. Of J = U S V^T and a
    later J_2 the eigenvalues of S^-1 U^T J_2 V are near 1 but for those that change sign along a smooth motion."""
    U, values, V = np.linalg.svd(J, full_matrices=False)
    lost = (values <= FEW * values[:, :1]).sum(axis=1)
    begun = np.flatnonzero((lost > 0) & (np.append(0, lost[:-1]) == 0))
    found = [(int(k), 0.0, int(lost[k])) for k in begun]
    pairs = np.flatnonzero((lost[:-1] == 0) & (lost[1:] == 0))
    after = U[pairs].transpose(0, 2, 1) @ J[pairs + 1] @ V[pairs].transpose(0, 2, 1)
    ratios = np.linalg.eigvals(after / values[pairs][:, :, None]).real
    for k, ratio in zip(pairs.tolist(), ratios, strict=True):
        if ratio.min() < 0.0:
            found.append((k, 1.0 / (1.0 - float(ratio.min())), int((ratio < 0.0).sum())))
    return sorted(found)


@traced
def _jacobian_program(equations: Equations, tape: Tape) -> Iterable[Scalar]:
    chain = independent_equations(equations.plan)
    rows = chain.equations(chain.sample(equations.state(tape).q)).J
    return [row.get(rate, 0.0) for row in rows for rate in range(chain.model.n)]
