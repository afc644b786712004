"""Steps as long as a tolerance allows: DOP853 and Radau of SciPy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import pairwise
from math import inf
from typing import Any

import numpy as np

from robodyn.dynamics.plan import Plan, runner_of
from robodyn.errors import InputError
from robodyn.programs.run.stepper import COLUMNS
from robodyn.robot.configuration import unit_rows
from robodyn.simulation.equations import STATE, Equations
from robodyn.simulation.events import Limits, dense_touches, first_passed
from robodyn.simulation.fixed import Motion
from robodyn.simulation.methods import Method, TooMuchError
from robodyn.simulation.table import NEAR, Signal
from robodyn.support.floats import Floats

EXPECTED = 4000
"""Evaluations that a motion usually takes at least: machine code is made for them where that is quicker."""
MOST_ROWS = 300_000
"""Some minutes of work."""
LEAST = {"dop853": 14, "radau": 9, "bdf": 6}
"""Evaluations for the steps from one row of a table to the next, at least."""
KNOTS = 8
"""Rows of a reference, a smooth spline, that a step may pass over."""

GENTLER = "give a larger --rtol, or --method radau where friction or a drive is stiff"
SOFTER = "give a larger --rtol, or softer friction, drives or springs in the scene"


class AdaptiveSteps:
    """A method of SciPy on one robot in one scene."""

    def __init__(
        self, plan: Plan, method: Method, rtol: float, executor: str, signal: Signal, most: float = inf
    ) -> None:
        from scipy import integrate

        equations = Equations(plan)
        self.model, self.signal, self.asked = plan.model, signal, executor
        self.runner = runner_of(equations.derivatives(), plan, {STATE: equations.width, COLUMNS: len(signal.curves)})
        self.name, self.solver = method.name, getattr(integrate, method.scipy)
        self.options = {"rtol": rtol, "atol": rtol, "vectorized": True}
        self.executor, self.evaluations = "", 0
        self._count, self._most, self._expected = 0, most, EXPECTED if most == inf else int(most)

    def motion(self, state: Floats, duration: float, limits: Limits, also: Sequence[float] = ()) -> Motion:
        """The motion from a state (width,), recorded at every step that the method takes.

        The error of each step is kept below `rtol (1 + |y|)` in q, qd and work. Steps end at rows of a table.
        Quaternions are four numbers here, of any length; those of the record have unit length.

        Args:
            also: further times at which it is recorded [s].

        Raises:
            TooMuchError: it takes more evaluations than it may.
            InputError: the method gives up.
        """
        rows, remedy = self.signal.corners(KNOTS), "give --step instead of --rtol"
        rows = rows[(rows > 0.0) & (rows < duration * (1.0 - NEAR))]
        if len(rows) > MOST_ROWS:
            what = f"steps of {self.name} would have to end at {len(rows)} rows of the table, more than {MOST_ROWS}"
            raise InputError(what, remedy=remedy)
        if LEAST[self.name] * len(rows) > self._most:
            what = f"{len(rows)} rows of the table take more than {self._most:.3g} evaluations of {self.name}"
            raise TooMuchError(what, 0.0, state, remedy)
        inner = np.unique([0.0, *rows])
        corners = [*inner[np.diff(inner, prepend=-inf) > NEAR * duration].tolist(), duration]
        y, reached, wanted = state[:-1], None, np.array(also)
        time, states = [0.0], [y]
        for begin, end in pairwise(corners):
            for solver in () if reached else self(begin, y, end):
                reached = self.limit_within(solver, y, limits) if limits.stops else None
                when, after = reached or (solver.t, solver.y)
                if when > time[-1]:  # else a limit is reached where the motion begins
                    between = wanted[(wanted > solver.t_old) & (wanted < when)].tolist()
                    states += [*self.states(solver, y, between), after]
                    time += [*between, when]
                y = after
                if reached:
                    break
        found = np.column_stack((unit_rows(self.model, np.array(states)), np.zeros(len(states))))
        ended = limits.reached(found[-1], time[-1]) if reached else ""
        note = f"steps end at {len(rows)} rows of the table too" if len(rows) else ""
        return Motion(np.array(time), found, len(time) - 1, 1, self.executor, ended, self.evaluations, note)

    def rates(self, within: float, time: float, y: Any) -> Any:
        """The rates of states (width,) or (width, N) at a time in the same interval between rows as `within`."""
        columns = y.reshape(len(y), -1)
        samples = columns.shape[1]
        self._count += samples
        if self._count > self._most:
            what = f"{self.name} has taken {self._most:.3g} evaluations and is at {time:.3g} s"
            raise TooMuchError(what, time, columns[:, 0], GENTLER)
        sources = {STATE: np.vstack((columns, np.zeros(samples))).T}
        if self.signal.curves:
            curves = self.signal.at(np.array([time]), np.array([within]))
            sources[COLUMNS] = np.repeat(curves, samples, axis=0)
        found = self.runner.run(sources, samples, executor=self.asked, expected=self._expected)
        self.executor = found.choice.executor
        return found.values.T.reshape(y.shape)

    def __call__(self, begin: float, y: Floats, end: float) -> Iterator[Any]:
        """Yield the solver after each step to a time before which no row of a table lies; raises if it gives up."""
        with np.errstate(all="ignore"):
            solver = self.solver(partial(self.rates, 0.5 * (begin + end)), begin, y, end, **self.options)
        try:
            while solver.status == "running":
                message, finite = None, True
                with np.errstate(all="ignore"):
                    try:
                        message = solver.step()
                    except ValueError as error:
                        if "infs or NaNs" not in str(error):  # what SciPy says of a matrix that it cannot factorise
                            raise
                        finite = False
                if solver.status == "failed" or not (finite and np.isfinite(solver.y).all()):
                    why = f": {message.lower().rstrip('.')}" if message else ", a number overflows"
                    remedy = SOFTER if self.name == "radau" else GENTLER
                    raise InputError(f"{self.name} gives up at {solver.t:.6g} s{why}", remedy=remedy)
                yield solver
        finally:
            self.evaluations += solver.nfev

    def limit_within(self, solver: Any, y: Floats, limits: Limits) -> tuple[float, Floats] | None:
        """When, and in what state, the last step of a solver, from y, first reached a limit."""
        begin, length = float(solver.t_old), float(solver.t - solver.t_old)
        dense = solver.dense_output()
        touches = dense_touches(limits, lambda part: dense(begin + length * part).T, solver.y)
        time = first_passed(touches, lambda time: limits.room(self.after(begin, y, begin + time)), length)
        return None if time is None else (begin + time, self.after(begin, y, begin + time))

    def after(self, begin: float, y: Floats, end: float) -> Floats:
        """The state at the end of a part of a step, by steps of the method itself."""
        for solver in self(begin, y, end) if end > begin else ():
            y = solver.y
        return y

    def states(self, solver: Any, y: Floats, times: Sequence[float]) -> list[Floats]:
        """States at times within the last step of a solver, from y; Radau has no dense output as fine as its steps."""
        if self.name == "radau":
            return [self.after(float(solver.t_old), y, time) for time in times]
        return list(solver.dense_output()(np.array(times)).T) if times else []
