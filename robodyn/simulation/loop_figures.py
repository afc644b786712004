"""What the loops of a closed chain carry along a motion, and how far they come apart."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from robodyn.dynamics.effects.effect import Sample
from robodyn.dynamics.loops.closed_chain import NOTHING, ClosedChain
from robodyn.dynamics.loops.closed_start import independent_equations
from robodyn.dynamics.plan import Plan, applied, runner_of
from robodyn.errors import InputError
from robodyn.programs.program import trace, traced
from robodyn.programs.run.stepper import COLUMNS
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar
from robodyn.simulation.equations import STATE, Equations, state_runner
from robodyn.simulation.fixed import Motion
from robodyn.simulation.singular import Singular, passed
from robodyn.simulation.table import Signal
from robodyn.support.floats import Floats

PARTS = ("fx", "fy", "fz", "mx", "my", "mz")


@dataclass(frozen=True, eq=False)
class LoopFigures:
    """At the recorded times, N of them, for L loops.

    Attributes:
        names: of the loops.
        wrenches: (N, L, 6) force and moment on each loop's `link` at its point, in the axes of `to` [N, N m].
        gap, slip: the largest |phi| [m and rad] and |phi'| [m/s and rad/s] of each loop along the motion.
        equations: how many the loops have, `dropped` those that others of their loop imply, and `rank` how many of the
            others are independent where the motion begins.
        freedoms: that are left there.
        stabilised: how the loops are kept closed.
        singular: when they leave more freedoms than elsewhere, at the start or on the way.
    """

    names: tuple[str, ...]
    wrenches: Floats
    gap: Floats
    slip: Floats
    equations: int
    dropped: tuple[str, ...]
    rank: int
    freedoms: int
    stabilised: str
    singular: tuple[Singular, ...] = ()

    @property
    def usual(self) -> int:
        """Degrees of freedom elsewhere."""
        return self.freedoms + self.rank - (self.equations - len(self.dropped))

    @property
    def drift(self) -> tuple[float, float]:
        """The largest |phi| and |phi'| of all."""
        return float(self.gap.max()), float(self.slip.max())

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the entries of the wrenches, loop after loop."""
        return tuple(f"{part}_{name}" for name in self.names for part in PARTS)


def loop_figures(plan: Plan, motion: Motion, executor: str, signal: Signal, projected: bool) -> LoopFigures | None:
    """Return the figures of a motion; None where the scene has no loops.

    Args:
        projected: whether its steps end with a projection where no Baumgarte rate is given.
    """
    if not plan.scene.loops:
        return None
    chain, count = independent_equations(plan), len(plan.scene.loops)
    rank = _rank(chain, motion.states[0])
    runner = state_runner(loop_program, plan, len(signal.curves))
    sources = {STATE: motion.states, COLUMNS: signal.at(motion.time)}
    columns = runner(sources, len(motion.states), executor=executor)
    of = [k for k, closure in enumerate(chain.closures) for _ in closure.equations]
    wrenches, errors, rates = np.split(columns, np.cumsum([6 * count, len(of)]), axis=1)
    largest = np.zeros((2, count))
    for found, values in zip(largest, (errors, rates), strict=True):
        np.maximum.at(found, of, np.abs(values).max(axis=0))
    kept = "projection after each step" if projected else "not stabilised, for which the scene has baumgarte"
    kept = f"Baumgarte's terms at {plan.scene.baumgarte:g}/s" if plan.scene.baumgarte else kept
    return LoopFigures(
        names=tuple(loop.name for loop in plan.scene.loops),
        wrenches=wrenches.reshape(len(columns), count, 6),
        gap=largest[0],
        slip=largest[1],
        equations=len(of) + len(chain.dropped),
        dropped=tuple(f"{closure.loop.name} {equation.about}" for closure, equation in chain.dropped),
        rank=rank,
        freedoms=plan.model.n - rank,
        stabilised=kept,
        singular=passed(plan, motion),
    )


@traced
def loop_program(equations: Equations, tape: Tape) -> Iterable[Scalar]:
    """Return the program of each loop's wrench, then of phi and phi' by equation."""
    chain = independent_equations(equations.plan)
    state, given = equations.state(tape), equations.given(tape)
    sample: Sample = equations.sample(chain.model, state.q, state.qd, given)
    terms = applied(equations.plan.effects, sample, equations.scene)
    tau = equations.drives(state.q, state.qd, given)
    here = chain.equations(sample)
    wrenches = chain.wrenches(here, chain.accelerations(sample, terms, tau)[1])
    return [*(x for wrench in wrenches for part in wrench for x in part), *here.error, *here.rate]


def _rank(chain: ClosedChain, state: Floats) -> int:
    J = chain.jacobian(chain.sample(state[: chain.model.nq].tolist()))
    return int(np.linalg.matrix_rank(J, tol=NOTHING * np.linalg.norm(J, 2))) if J.size else 0


OPEN = 1e-6
"""m or rad, and per s, by which a given state may miss the loops."""


def check_closed(plan: Plan, q: Floats, qd: Floats) -> None:
    """Raise if a state of q (N, nq) and qd (N, n) is not on the loops.

    Raises:
        InputError: the first row that is not, with its error.
    """
    chain = independent_equations(plan)

    def outputs(tape: Tape) -> Iterable[Scalar]:
        here = chain.equations(replace(plan.sample(tape), model=chain.model, qdd=(0.0,) * plan.model.n))
        return [*here.error, *here.rate]

    errors = np.abs(runner_of(trace(outputs), plan)({"q": q, "qd": qd}, len(q), executor="numpy")).max(axis=1)
    bad = np.flatnonzero(~(errors <= OPEN))
    if len(bad):
        what = f"row {bad[0]} misses the loops by {errors[bad[0]]:.3g} m or rad, or per s"
        raise InputError(what, remedy="begin where simulate begins: its first q and qd")
