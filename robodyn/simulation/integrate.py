"""Motions by steps of a fixed length, or as long as a tolerance allows (DOP853 and Radau of SciPy): records, the end at
a joint's limit, and motions that leave what can be computed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache, partial
from itertools import groupby, pairwise
from math import inf
from typing import Any, NamedTuple

import numpy as np

from robodyn.dynamics.plan import Plan, runner_of
from robodyn.errors import InputError
from robodyn.programs.run.llvm.machine import compiler_problem, one_line
from robodyn.programs.run.runner import EXECUTORS, Work, times
from robodyn.programs.run.stepper import COLUMNS, SINGLE, CompiledSteps, NumpySteps
from robodyn.robot.kinematics import unit_rows
from robodyn.simulation.equations import STATE, Equations, Steps
from robodyn.simulation.events import Limits, Touch, first_passed, hermite_touches
from robodyn.simulation.methods import Method, TooMuchError
from robodyn.simulation.table import NEAR, Piece, Signal, pieces
from robodyn.support.floats import Floats
from robodyn.support.wording import alternatives

CHUNK = 4096  # steps made at a time; limits are looked at after each
SWEEPS_USUAL = 8  # that an implicit step takes
MOST_STEPS = 1e9  # some minutes of work for a small robot
MOST_RECORDS = 100_000  # a longer motion is recorded every so many steps, as the report says
SHORTER = "give a shorter --step, or --method radau where friction or a drive is stiff"


class Motion(NamedTuple):
    """Times (N,), states (N, width), steps done, whole steps between records, the executor, why it ended early, how
    often the equations were evaluated, and a note about the steps."""

    time: Floats
    states: Floats
    steps: int
    every: int
    executor: str
    ended: str = ""
    evaluations: int = 0
    note: str = ""


class FixedSteps:
    """A method with steps of one length, about so many, ready to run on one robot in one scene."""

    def __init__(self, plan: Plan, method: Method, executor: str, steps: int, signal: Signal) -> None:
        self.method, self.width, self.signal = method, plan.model.nq + plan.model.n + 2, signal
        self.run, self._begin = stepper(plan, method, executor, steps), steps_of(plan, method).begin
        self._sweeps, self._most = 0, inf

    def motion(self, state: Floats, duration: float, step: float, limits: Limits, most: float = inf) -> Motion:
        """The motion from a state (width,), in whole steps that fill the duration, none longer than `step`.

        They end at the rows of a table too; all of these are recorded, and a limit that is reached. TooMuchError if it
        takes more than `most` evaluations; InputError if an implicit method does not settle, or a number overflows.
        """
        if duration / step > MOST_STEPS:
            raise InputError(f"{duration / step:.3g} steps are too many", remedy="give a longer --step")
        asked = max(int(np.ceil(duration / step * (1.0 - 1e-12))), 1)
        every = -(-asked // MOST_RECORDS)
        total = -(-asked // every) * every
        h, corners, self._most = duration / total, self.signal.corners(), most
        if (total + int(np.searchsorted(corners, duration))) * len(self.method.b) > most:
            what = f"{total} steps of {self.method.name} take more than {most:.3g} evaluations"
            raise TooMuchError(what, 0.0, state, "give a longer --step")
        now = self._begin(state[None])[0]
        now[self.width - 1] = h
        records, times, done, end, self._sweeps = [now[None, : self.width]], [np.zeros(1)], 0, None, 0
        for steps in pieces(corners, h, total, CHUNK):
            states, problem = self._advance(now, steps)
            end = self._limit_within(now, states, steps, limits)
            if end is None and problem is not None:
                raise problem
            kept = steps.recorded(every)
            kept = kept[kept < (len(states) if end is None else end[0])]
            records.append(states[kept, : self.width])
            times.append(steps.end[kept])
            if end is not None:
                break
            done, now = done + len(states), states[-1]
        time, states = np.concatenate(times), np.concatenate(records)
        why, note = "", f"steps end at rows of the table too: {done} steps instead of {total}" if done > total else ""
        if end is not None:
            step_of_end, reached, last = end
            done, why, note = done + step_of_end + 1, limits.reached(last, reached), ""
            if reached > time[-1]:
                time, states = np.append(time, reached), np.vstack((states, last[: self.width]))
        name = "compiled" if isinstance(self.run, CompiledSteps) else "numpy"
        evaluations = len(self.method.b) * (self._sweeps if self.method.implicit else done)
        return Motion(time, states, done, every, name, why, evaluations, note)

    def _advance(self, state: Floats, steps: Piece) -> tuple[Floats, InputError | None]:
        """(N, width) the states after some steps, and why they are not all that were asked for."""
        slots = np.empty((len(steps.begin) + 1, self.run.width, self.run.lanes))
        slots[0] = state[:, None]
        slots[0, self.width - 1] = steps.length[0]
        given = self.signal.in_steps(steps, self.method.moments) if self.signal.curves else None
        done = self.run(slots, 1, given)
        self._sweeps += done.sweeps
        if len(self.method.b) * self._sweeps > self._most:
            time = float(steps.begin[0])
            what = f"{self.method.name} has taken {self._most:.3g} evaluations and is at {time:.3g} s"
            raise TooMuchError(what, time, state, "give a shorter --duration")
        bad = np.flatnonzero(~np.isfinite(slots[1 : done.steps + 1]).all(axis=(1, 2)))
        count = int(bad[0]) if len(bad) else done.steps
        problem = None
        if count < len(steps.begin):
            at = f"at {steps.begin[count]:.6g} s"
            overflows = f"the motion cannot be followed {at}: a number overflows"
            what = overflows if done.settled else f"the steps of {self.method.name} do not settle {at}"
            problem = InputError(what, remedy=SHORTER)
        return slots[1 : count + 1, :, 0], problem

    def _limit_within(
        self, state: Floats, states: Floats, steps: Piece, limits: Limits
    ) -> tuple[int, float, Floats] | None:
        """Where a limit is first reached in some steps from a state: within which step, when [s], in what state."""
        nq, n = limits.model.nq, limits.model.n
        states = np.vstack((state, states))
        touches = hermite_touches(limits, states[:, :nq], states[:, nq : nq + n], steps.length[: len(states) - 1])
        for step, some in groupby(touches, key=lambda touch: touch.step):

            def after(length: float, step: int = step) -> Floats:
                begin = steps.begin[step : step + 1]
                part = Piece(begin, begin + length, np.array([length]), steps.whole[:1], steps.row[:1])
                found, problem = self._advance(states[step], part)
                if problem is not None:
                    raise problem
                return np.asarray(found[0])

            length = first_passed(some, lambda time: limits.room(after(time)), float(steps.length[step]))
            if length is not None:
                return step, float(steps.begin[step]) + length, after(length)
        return None


@lru_cache(maxsize=16)
def steps_of(plan: Plan, method: Method) -> Steps:
    """The programs of a method for a robot in its scene."""
    return Steps(Equations(plan), method)


@lru_cache(maxsize=16)
def _compiled(plan: Plan, method: Method, lanes: int) -> CompiledSteps:
    steps = steps_of(plan, method)
    return CompiledSteps(STATE, steps.width, steps.step, steps.sweep, lanes, steps.columns)


def stepper(plan: Plan, method: Method, executor: str, steps: int, lanes: int = SINGLE) -> CompiledSteps | NumpySteps:
    """A step made ready by the executor that is asked for, or is quicker for so many steps; raises if it cannot run."""
    if executor not in EXECUTORS:
        raise InputError(f"there is no executor {executor!r}", remedy=alternatives(executor, EXECUTORS, "executors"))
    made = steps_of(plan, method)
    work = made.step.size + (SWEEPS_USUAL * made.sweep.size if made.sweep else 0)
    by_numpy, by_code = times(Work(work, steps, 1, steps))
    if executor == "compiled" or (executor == "auto" and by_code < by_numpy):
        problem = compiler_problem()
        try:
            if not problem:
                return _compiled(plan, method, lanes)
        except (OSError, RuntimeError) as error:
            problem = f"LLVM fails on this program ({one_line(error)})"
        if executor == "compiled":
            raise InputError(f"the compiled executor cannot run: {problem}", remedy="choose auto or numpy")
    return NumpySteps(STATE, made.width, made.step, made.sweep, made.columns)


EXPECTED = 4000  # evaluations that a motion usually takes at least, for which machine code may be quicker
MOST_ROWS = 300_000  # some minutes of work
LEAST = {"dop853": 14, "radau": 9, "bdf": 6}
"""Evaluations for the steps from one row of a table to the next, at least."""
PARTS = 8  # of a step, between which its dense output is as good as cubics where limits are looked for
KNOTS = 8  # rows of a reference, a smooth spline, that a step may pass over

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
        self.executor, self.evaluations, self._count, self._most = "", 0, 0, most

    def motion(self, state: Floats, duration: float, limits: Limits, also: Sequence[float] = ()) -> Motion:
        """The motion from a state (width,), recorded at every step that the method takes, and at the times `also` [s].

        The error of each step is kept below `rtol (1 + |y|)` in q, qd and work. Steps end at rows of a table.
        Quaternions are four numbers of any length here, of unit length in the record. TooMuchError if it takes more
        evaluations than it may; InputError if the method gives up.
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
                    between = wanted[(wanted > solver.t_old) & (wanted < when)]
                    if self.name == "radau":  # which has no dense output as fine as its steps
                        states += [self.after(float(solver.t_old), y, each) for each in between.tolist()]
                    elif len(between):
                        states += [*solver.dense_output()(between).T]
                    states.append(after)
                    time += [*between.tolist(), when]
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
        expected = EXPECTED if self._most == inf else int(self._most)
        found = self.runner.run(sources, samples, executor=self.asked, expected=expected)
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
        states = solver.dense_output()(np.linspace(begin, solver.t, PARTS + 1)).T
        states[0], states[-1] = y, solver.y
        q, qd, _ = np.split(states, [self.model.nq, self.model.nq + self.model.n], axis=1)
        touches = [
            Touch(0, touch.stop, (touch.step + touch.at) / PARTS)
            for touch in hermite_touches(limits, q, qd, np.full(PARTS, length / PARTS))
        ]
        time = first_passed(touches, lambda time: limits.room(self.after(begin, y, begin + time)), length)
        return None if time is None else (begin + time, self.after(begin, y, begin + time))

    def after(self, begin: float, y: Floats, end: float) -> Floats:
        """The state at the end of a part of a step, by steps of the method itself."""
        for solver in self(begin, y, end) if end > begin else ():
            y = solver.y
        return y
