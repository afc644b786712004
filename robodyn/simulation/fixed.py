"""Steps of a fixed length: records, the end at a joint's limit, and motions that leave what can be computed."""

from __future__ import annotations

from functools import lru_cache
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import InputError
from robodyn.execute.choice import EXECUTORS, Work, times
from robodyn.execute.llvm.machine import compiler, one_line
from robodyn.execute.repeated import SINGLE, CompiledSteps, NumpySteps
from robodyn.plan import Plan
from robodyn.simulation.equations import STATE, Equations
from robodyn.simulation.how import TooMuchError
from robodyn.simulation.limits import Limits, moment
from robodyn.simulation.methods import Method
from robodyn.simulation.steps import Steps
from robodyn.simulation.table import Signal
from robodyn.trace.program import Program
from robodyn.wording import alternatives

Floats = NDArray[np.float64]
CHUNK = 1024
"""Records made at a time; limits are looked at after each."""
SWEEPS_USUAL = 8
"""That an implicit step takes."""
MOST_STEPS = 1e9
"""Some minutes of work for a small robot."""
MOST_RECORDS = 100_000
"""A longer motion is recorded every so many steps, as the report says."""


class Motion(NamedTuple):
    """Times (N,), states (N, width), steps done, steps between records, the executor, why it ended early, and how often
    the equations were evaluated."""

    time: Floats
    states: Floats
    steps: int
    every: int
    executor: str
    ended: str = ""
    evaluations: int = 0


class FixedSteps:
    """A method with steps of one length, ready to run on one robot in one scene."""

    def __init__(self, plan: Plan, method: Method, executor: str, steps: int, signal: Signal) -> None:
        """
        Args:
            executor: "auto", "numpy" or "compiled".
            steps: about how many will be done.
            signal: what the scene takes from a table.

        Raises:
            InputError: the compiled executor cannot run.
        """
        self.method, self.width, self.signal = method, Equations(plan).width, signal
        self.run = stepper(plan, method, executor, steps)
        self._sweeps, self._most = 0, inf

    def motion(self, state: Floats, duration: float, step: float, limits: Limits, most: float = inf) -> Motion:
        """The motion from a state (width,), in whole steps that fill the duration, none longer than `step`.

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
        total = -(-asked // every)
        h = duration / (total * every)
        self._most = most
        if total * every * len(self.method.b) > most:
            what = f"{total * every} steps of {self.method.name} take more than {most:.3g} evaluations"
            raise TooMuchError(what, 0.0, state, "give a longer --step")
        first = np.zeros(self.run.width)
        first[: self.width], first[self.width - 1] = state, h
        chunk = max(CHUNK // every, 1) if self.signal.curves else CHUNK
        parts, done, ended = [first[None]], 0, None
        self._sweeps = 0
        while done < total and ended is None:
            block = self._advance(parts[-1][-1], min(chunk, total - done), every, h, done * every)
            ended = limits.first_beyond(block)
            parts.append(block if ended is None else block[:ended])
            done += len(parts[-1])
            parts = [part for part in parts if len(part)]
        time: Floats = np.arange(done + 1.0) * (every * h)
        if ended is None:
            return Motion(time, self._own(parts), total * every, every, self.name, "", self._evaluations(total * every))
        last, more, late = self._to_limit(parts[-1][-1], every, h, limits, done * every)
        end, steps = float(time[-1] + late), done * every + more
        why = limits.nearest(last).reached(end)
        if end > time[-1]:
            time, parts = np.array([*time, end]), [*parts, last[None]]
        return Motion(time, self._own(parts), steps, every, self.name, why, self._evaluations(steps))

    @property
    def name(self) -> str:
        """Of the executor."""
        return "compiled" if isinstance(self.run, CompiledSteps) else "numpy"

    def _evaluations(self, steps: int) -> int:
        """Of the equations of motion: each sweep of an implicit step takes as many as the method has stages."""
        return len(self.method.b) * (self._sweeps if self.method.implicit else steps)

    def _own(self, parts: list[Floats]) -> Floats:
        return np.concatenate(parts)[:, : self.width]

    def _advance(self, state: Floats, count: int, every: int, h: float, first: int) -> Floats:
        """(count, width) states, each `every` steps after the one before, of which `first` of length h are done."""
        slots = np.empty((count + 1, self.run.width, self.run.lanes))
        slots[0] = state[:, None]
        time, given = first * h, None
        if self.signal.curves:
            begin = np.arange(float(first), float(first + count * every)) * h
            given = self.signal.in_steps(begin, float(state[self.width - 1]), self.method.moments)
        done = self.run(slots, every, given)
        if done.steps < count * every:
            at = f"at {time + done.steps * h:.6g} s"
            if not done.settled:
                raise InputError(f"the steps of {self.method.name} do not settle {at}", remedy=SHORTER)
            raise InputError(f"the motion cannot be followed {at}: a number overflows", remedy=SHORTER)
        self._sweeps += done.sweeps
        if len(self.method.b) * self._sweeps > self._most:
            what = f"{self.method.name} has taken {self._most:.3g} evaluations and is at {time:.3g} s"
            raise TooMuchError(what, time, state, "give a shorter --duration")
        if not np.isfinite(slots).all():
            raise InputError(f"a number overflows after {time:.6g} s", remedy=SHORTER)
        states: Floats = slots[1:, :, 0]
        return states

    def _to_limit(self, state: Floats, every: int, h: float, limits: Limits, first: int) -> tuple[Floats, int, float]:
        """The state at a limit within the next `every` steps; how many steps that takes, and how long."""
        whole = 0
        while limits.first_beyond(after := self._advance(state, 1, 1, h, first + whole)) is None and whole < every:
            state, whole = after[0], whole + 1

        def part(length: float) -> Floats:
            begun = state.copy()
            begun[self.width - 1] = length
            after: Floats = self._advance(begun, 1, 1, h, first + whole)[0]
            return after

        length = moment(lambda length: limits.first_beyond(part(length)[None]) is not None, h)
        return part(length), whole + 1, whole * h + length


SHORTER = "give a shorter --step, or --method radau where friction or a drive is stiff"


class Programs(NamedTuple):
    """A method's programs, and how many numbers they read of the state and of a table."""

    step: Program
    sweep: Program | None
    width: int
    columns: int

    @property
    def work(self) -> int:
        """Operations per step, about."""
        return self.step.size + (SWEEPS_USUAL * self.sweep.size if self.sweep else 0)


@lru_cache(maxsize=16)
def _programs(plan: Plan, method: Method) -> Programs:
    steps = Steps(Equations(plan), method)
    return Programs(steps.step(), steps.sweep(), steps.width, steps.columns)


@lru_cache(maxsize=16)
def _compiled(plan: Plan, method: Method, lanes: int) -> CompiledSteps:
    programs = _programs(plan, method)
    return CompiledSteps(STATE, programs.width, programs.step, programs.sweep, lanes, programs.columns)


def stepper(plan: Plan, method: Method, executor: str, steps: int, lanes: int = SINGLE) -> CompiledSteps | NumpySteps:
    """The programs of a step, made ready by the executor that is asked for or is quicker for so many steps.

    Raises:
        InputError: no such executor, or the compiled one cannot run here.
    """
    if executor not in EXECUTORS:
        raise InputError(f"there is no executor {executor!r}", remedy=alternatives(executor, EXECUTORS, "executors"))
    programs = _programs(plan, method)
    by_numpy, by_code = times(Work(programs.work, steps, 1, steps))
    if executor == "compiled" or (executor == "auto" and by_code < by_numpy):
        problem = compiler().problem
        try:
            if not problem:
                return _compiled(plan, method, lanes)
        except (OSError, RuntimeError) as error:
            problem = f"LLVM fails on this program ({one_line(error)})"
        if executor == "compiled":
            raise InputError(f"the compiled executor cannot run: {problem}", remedy="choose auto or numpy")
    return NumpySteps(STATE, programs.width, programs.step, programs.sweep, programs.columns)
