"""The equations of a closed chain at blocks of samples, by programs that are traced once per plan."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property, lru_cache

import numpy as np

from robodyn.dynamics.initial_state import default_pose
from robodyn.dynamics.loops.closure import loops_size
from robodyn.dynamics.loops.find import tied_chain
from robodyn.dynamics.loops.local_coordinates import moved, unit
from robodyn.dynamics.plan import Plan, runner_of
from robodyn.programs.program import traced
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar
from robodyn.robot.model import Model
from robodyn.support.floats import Floats


class BlockEquations:
    """phi, J and J' qd of the loops of a plan, for arrays of samples.

    Attributes:
        chain: its equations, but for those that never change on their own.
        rates: those that move a loop; the columns of J.
        size: the longest offset between joints or points of the loops [m]; 1 where there is none.
        units: of each equation, "m" or "rad"; names: of its loop.
        rate_units: "rad" or "m" of each rate of the model, times a second.
        weights: (n,) by which rates are multiplied to compare them: 1 for rad, 1 / size for m.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan, self.model, self.chain = plan, plan.model, tied_chain(plan)
        rows = self.chain.equations(self.chain.sample(default_pose(self.model).tolist())).J
        self.rates = tuple(sorted({rate for row in rows for rate in row}))
        self.units = tuple(e.unit for closure in self.chain.closures for e in closure.equations)
        self.names = tuple(closure.loop.name for closure in self.chain.closures for _ in closure.equations)
        self.size = loops_size(self.model, self.chain.closures)
        self.scale = np.array([self.size if unit == "m" else 1.0 for unit in self.units])
        self.rate_units = _units(self.model)
        self.weights = np.array([1.0 / self.size if unit == "m" else 1.0 for unit in self.rate_units])

    @property
    def count(self) -> int:
        """Equations."""
        return self.chain.count

    def places(self, q: Floats) -> tuple[Floats, Floats]:
        """Return phi (N, equations) and J (N, equations, rates).

        Args:
            q: (N, nq); J is by the rates as `model.rates` has them, those of floating joints' positions along the axes
                of their parents.
        """
        columns = self._places({"q": q}, len(q))
        m = self.count
        return columns[:, :m], columns[:, m:].reshape(len(q), m, len(self.rates))

    def bias(self, q: Floats, qd: Floats) -> Floats:
        """Return (N, equations) J' qd."""
        return self._bias({"q": q, "qd": qd}, len(q))

    def moved(self, q: Floats, u: Floats) -> Floats:
        """Return q (N, nq) after displacements u (N, n), which turn floating joints about their bodies' axes."""
        if self.model.quaternions:
            return self._moved({"q": q, "u": u}, len(q))
        return q + u

    @cached_property
    def _places(self) -> Runner:
        return runner_of(_places_program(self), self.plan)

    @cached_property
    def _bias(self) -> Runner:
        return runner_of(_bias_program(self), self.plan)

    @cached_property
    def _moved(self) -> Runner:
        return runner_of(_moved_program(self), self.plan, {"u": self.model.n})


@lru_cache(maxsize=16)
def block_equations(plan: Plan) -> BlockEquations:
    """Return the equations of a plan, with what has been traced of them so far."""
    return BlockEquations(plan)


def _units(model: Model) -> tuple[str, ...]:
    """Return the unit of each rate, times a second."""
    found: list[str] = []
    for joint in model.independent:
        lengths = {"floating": ["rad"] * 3 + ["m"] * 3, "prismatic": ["m"]}
        found += lengths.get(joint.kind, ["rad"])
    return tuple(found)


@traced
def _places_program(equations: BlockEquations, tape: Tape) -> Iterable[Scalar]:
    chain = equations.chain
    sample = chain.sample(_inputs(tape, "q", equations.model.nq))
    here = chain.equations(sample)
    rows = [chain.along_parents(sample, [row.get(k, 0.0) for k in range(equations.model.n)]) for row in here.J]
    return [*here.error, *(row[rate] for row in rows for rate in equations.rates)]


@traced
def _bias_program(equations: BlockEquations, tape: Tape) -> Iterable[Scalar]:
    chain = equations.chain
    return chain.equations(
        chain.sample(_inputs(tape, "q", equations.model.nq), _inputs(tape, "qd", equations.model.n))
    ).bias


@traced
def _moved_program(equations: BlockEquations, tape: Tape) -> Iterable[Scalar]:
    model = equations.model
    return unit(model, moved(model, _inputs(tape, "q", model.nq), _inputs(tape, "u", model.n)))


def _inputs(tape: Tape, source: str, count: int) -> list[Scalar]:
    return [tape.input(source, k) for k in range(count)]
