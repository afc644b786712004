"""Steps of a fixed length: records, the end at a joint's limit, and motions that leave what can be computed."""

from __future__ import annotations

from functools import lru_cache
from itertools import groupby
from math import inf
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.plan import Plan
from robodyn.errors import InputError
from robodyn.programs.run.choice import EXECUTORS, Work, times
from robodyn.programs.run.llvm.machine import compiler_problem, one_line
from robodyn.programs.run.stepper import SINGLE, CompiledSteps, NumpySteps
from robodyn.simulation.equations import STATE, Equations
from robodyn.simulation.events import Limits, first_passed, hermite_touches
from robodyn.simulation.methods import Method, TooMuchError
from robodyn.simulation.steps import Steps
from robodyn.simulation.table import Piece, Signal, pieces
from robodyn.support.floats import Floats
from robodyn.support.wording import alternatives

CHUNK = 4096
"""Steps made at a time; limits are looked at after each."""
SWEEPS_USUAL = 8
"""That an implicit step takes."""
MOST_STEPS = 1e9
"""Some minutes of work for a small robot."""
MOST_RECORDS = 100_000
"""A longer motion is recorded every so many steps, as the report says."""
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


class End(NamedTuple):
    """Where a limit is reached: within which step, when [s], and in what state."""

    step: int
    time: float
    state: Floats


class FixedSteps:
    """A method with steps of one length, ready to run on one robot in one scene."""

    def __init__(self, plan: Plan, method: Method, executor: str, steps: int, signal: Signal) -> None:
        """Args: steps: about how many will be done."""
        self.method, self.width, self.signal = method, plan.model.nq + plan.model.n + 2, signal
        self.run = stepper(plan, method, executor, steps)
        self._sweeps, self._most = 0, inf

    def motion(self, state: Floats, duration: float, step: float, limits: Limits, most: float = inf) -> Motion:
        """The motion from a state (width,), in whole steps that fill the duration, none longer than `step`.

        They end at the rows of a table too; all of these are recorded, and a limit that is reached.

        Args:
            most: evaluations of the equations of motion.

        Raises:
            TooMuchError: it takes more.
            InputError: an implicit method does not settle, or a number is no longer finite.
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
        now = np.zeros(self.run.width)
        now[: self.width], now[self.width - 1] = state, h
        records, times, done, end, self._sweeps = [now[None, : self.width]], [np.zeros(1)], 0, None, 0
        for steps in pieces(corners, h, total, CHUNK):
            states, problem = self._advance(now, steps)
            end = self._limit_within(now, states, steps, limits)
            if end is None and problem is not None:
                raise problem
            kept = steps.recorded(every)
            kept = kept[kept < (len(states) if end is None else end.step)]
            records.append(states[kept, : self.width])
            times.append(steps.end[kept])
            if end is not None:
                break
            done, now = done + len(states), states[-1]
        time, states = np.concatenate(times), np.concatenate(records)
        why, note = "", f"steps end at rows of the table too: {done} steps instead of {total}" if done > total else ""
        if end is not None:
            done, why, note = done + end.step + 1, limits.reached(end.state, end.time), ""
            if end.time > time[-1]:
                time, states = np.append(time, end.time), np.vstack((states, end.state[: self.width]))
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

    def _limit_within(self, state: Floats, states: Floats, steps: Piece, limits: Limits) -> End | None:
        """Where a limit is first reached in some steps from a state."""
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
                state: Floats = found[0]
                return state

            length = first_passed(some, lambda time: limits.room(after(time)), float(steps.length[step]))
            if length is not None:
                return End(step, float(steps.begin[step]) + length, after(length))
        return None


@lru_cache(maxsize=16)
def _steps(plan: Plan, method: Method) -> Steps:
    return Steps(Equations(plan), method)


@lru_cache(maxsize=16)
def _compiled(plan: Plan, method: Method, lanes: int) -> CompiledSteps:
    steps = _steps(plan, method)
    return CompiledSteps(STATE, steps.width, steps.step, steps.sweep, lanes, steps.columns)


def stepper(plan: Plan, method: Method, executor: str, steps: int, lanes: int = SINGLE) -> CompiledSteps | NumpySteps:
    """A step made ready by the executor that is asked for, or is quicker for so many steps; raises if it cannot run."""
    if executor not in EXECUTORS:
        raise InputError(f"there is no executor {executor!r}", remedy=alternatives(executor, EXECUTORS, "executors"))
    made = _steps(plan, method)
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
