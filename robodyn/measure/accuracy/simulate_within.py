"""A simulation as accurate as asked: methods and steps by errors that are measured on the motion itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf
from typing import Any, NamedTuple, NoReturn

import numpy as np

from robodyn.dynamics.plan import plan
from robodyn.errors import InputError
from robodyn.measure.accuracy.simulation import MotionError, apart, seen
from robodyn.programs.run.llvm.machine import compiler_problem
from robodyn.programs.run.runner import CALL
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.simulation.equations import Equations
from robodyn.simulation.events import Limits, Stop, lowest_of_cubic
from robodyn.simulation.methods import LEAST_RTOL, Method, TooMuchError, method_named
from robodyn.simulation.result import Simulation
from robodyn.simulation.simulate import simulate
from robodyn.simulation.stiff_steps import DRIFTS, TOO_LONG, with_friction
from robodyn.support.floats import first_largest

CODE, SCIPY, CALLED = 2e-9, 1e-4, 1e-7
"""Seconds of machine code per operation, one step after another; that a method of SciPy takes per evaluation, beside
the evaluation; and of machine code per evaluation, beside its operations."""
ALLOWED, SHARES = 20.0, 4
"""Seconds of work on a typical machine that the search for an accuracy may take in all; ways that share it."""
FIRST = 5e4  # evaluations for the usual motion, which the search begins with
FIRST_STEP, LAST_STEP, TINY = 1.6e-2, 1e-8, 1e-300  # s: the steps that are halved, from the first to the last
SLOWEST, FLOOR = 1.5, 8.0
"""A step half as long has to leave no more than 1 / 1.5 of the difference, or the error has reached its floor, where it
is multiplied with 8."""
GROWN = 1.5  # twice as many whole steps have to make at least so many times as many in all
NEAREST = 16  # turns that are looked at closely
HALVED, TIGHTENED = ("rk4", "gauss6"), ("radau",)  # methods whose steps are halved, or whose tolerance is tightened
CONFIRMING = {"rk4": ("dop853", "gauss6", "radau"), "gauss6": ("dop853", "rk4", "radau"), "radau": ("bdf",)}
"""Methods of which one has to agree; those with fixed steps where SciPy's are too much work, as with many rows."""
TIGHTER = 1.0, 30.0, 1000.0
"""Parts of the target to which a motion is refined, one after the other where another method does not agree."""
ROUNDING = 2.0**-51  # of the largest number of a motion: no error is below
APART = 'move the limit or the start, or write joint_limits = "spring" or "ignore" in the scene'


@dataclass(eq=False)
class Effort:
    """Runs of one simulation by methods and steps, with what else `simulate` is given; left: seconds of work that are
    left; floor: what the others of the ways that are tried shall find."""

    model: Model
    scene: Scene
    duration: float | None
    given: dict[str, Any]
    left: float = field(default_factory=lambda: ALLOWED)
    floor: float = 0.0
    steps: int = 0

    @cached_property
    def _evaluation(self) -> float:
        """Seconds of work for the equations of motion once."""
        size = Equations(plan(self.model, with_friction(self.model, self.scene)[0])).derivatives().size
        interpreted = self.given.get("executor") == "numpy" or bool(compiler_problem())
        return CALLED + size * (CALL if interpreted else CODE)

    def cost(self, method: Method) -> float:
        """Return seconds of work per evaluation."""
        return self._evaluation + (SCIPY if method.adaptive else 0.0)

    def work(self, motion: Simulation) -> float:
        return motion.evaluations * self.cost(motion.method)

    def is_stiff(self) -> bool:
        """Return whether the motion, made as usual, asks for an implicit method; raise InputError if none can do it."""
        try:
            return self._counted(most=FIRST).method.name == "radau"
        except TooMuchError as error:
            self.left -= FIRST * SCIPY if error.time else 0.0
            return error.time > 0.0

    def run(self, name: str, **options: Any) -> Simulation:
        """Return the motion by a method, with this step or tolerance; raise TooMuchError if the way's share is less."""
        cost = self.cost(method_named(name))
        most = int(max(self.left - self.floor, 0.0) / cost)
        try:
            return self._counted(method=name, most=most, **options)
        except TooMuchError as error:
            self.left -= cost * most if error.time else 0.0
            raise

    def _counted(self, **options: Any) -> Simulation:
        motion = simulate(self.model, self.scene, self.duration, **self.given, **options)
        self.left -= self.work(motion)
        self.steps += motion.steps
        return motion


class Settled(NamedTuple):
    """A motion by one method, and its expected error, relative to the largest of the kind (see `MotionError`)."""

    motion: Simulation
    error: float


class UnsettledError(InputError):
    """A method that does not get there; `reached` is the change that its last two motions leave."""

    def __init__(self, what: str, reached: float) -> None:
        super().__init__(what)
        self.reached = reached


def refined(effort: Effort, name: str, target: float) -> Settled:
    """Return the motion by a method, refined until that changes it by less than the target; raise UnsettledError if the
    changes stop falling above the target, or the work is done."""
    before, change, problem = None, inf, "one motion alone tells no error"
    effort.floor = max(effort.left - ALLOWED / SHARES, 0.0)
    finer: dict[str, float] | None = {"rtol": 0.2 * target} if method_named(name).adaptive else {"step": FIRST_STEP}
    while finer:
        options, motion = finer, None
        try:
            motion = effort.run(name, also=seen(before), **options)
        except TooMuchError:
            left = f"finer steps change it by {change:.0e} yet" if change < inf else problem
            what = f"{left}, and going to {shown(options)} is more work than is allowed"
            raise UnsettledError(what, change) from None
        except InputError as error:
            problem = error.what
        made = {"step": motion.step} if motion is not None and motion.step is not None else options
        finer = _finer(made, LAST_STEP)
        if motion is not None and before is not None:
            if motion.step is not None and motion.steps < GROWN * before.steps:
                continue  # where rows of a table or an early end make steps short, half of one is no finer
            last, change = change, apart(before, motion)
            expected = _expected(name, last, change, target)
            if expected <= 2.0 * target:
                return Settled(motion, expected)
            if change * SLOWEST > last and last < 1e-6:
                raise UnsettledError(f"going to {shown(options)} changes the motion by {change:.0e} yet", change)
        before = motion or before
    told = f"going to {shown(options)} changes the motion by {change:.0e} yet" if change < inf else problem
    raise UnsettledError(told, change)


def _finer(options: dict[str, float], least: float, part: float = 0.01) -> dict[str, float] | None:
    """Return half a step, down to the least, or a part of a tolerance; None at the end."""
    if "rtol" in options:
        return {"rtol": max(part * options["rtol"], LEAST_RTOL)} if options["rtol"] > LEAST_RTOL else None
    step = 0.5 * options["step"]
    return {"step": step} if step >= least else None


def _expected(name: str, last: float, change: float, target: float) -> float:
    """Return the error that is left after a change which followed another one; inf if that cannot be told."""
    if method_named(name).adaptive:
        return change if change <= target else inf
    if change * SLOWEST > last:
        return FLOOR * change if FLOOR * change <= 2.0 * target else inf
    rest = max(change, change / (last / max(change, TINY) - 1.0))
    return rest if last < inf and rest <= target else inf


def shown(options: Mapping[str, float | None]) -> str:
    return f"steps of {options['step']:.3g} s" if "step" in options else f"rtol {options['rtol']:.1g}"


class Graze(NamedTuple):
    """A limit that a motion passes by a depth [rad or m], negative where it misses, at a time [s]; error: relative to
    the largest of the kind (see `MotionError`), at which either could be true."""

    stop: Stop
    depth: float
    time: float
    error: float

    def __str__(self) -> str:
        met = self.stop.met("passes" if self.depth > 0.0 else "misses")
        return f"{met} by {abs(self.depth):.1g} {self.stop.unit}, at {self.time:.6g} s"


def graze(motion: Simulation) -> Graze | None:
    """Return the limit that the least error would turn from missed to reached, or back: of the nearest places at which
    joints turn back, and of how far the joint that ended the motion would have gone on, braked as it is there."""
    limits = Limits(motion.model, motion.scene.joint_limits == "stop")
    if not limits.stops:
        return None
    scale = MotionError.over(motion.model, np.hstack((motion.q, motion.qd))).scale[: motion.model.nq]
    moved = np.abs(limits.room(scale) - limits.room(0.0 * scale))
    found = list[tuple[int, float, float]]()
    room, rate, length = limits.room(motion.q), limits.rate(motion.qd), np.diff(motion.time)
    rows, places = np.nonzero((rate[:-1] < 0.0) & (rate[1:] >= 0.0))
    least = np.minimum(room[rows, places], room[rows + 1, places])
    slopes = length[rows] * (np.abs(rate[rows, places]) + np.abs(rate[rows + 1, places]))
    for k in np.argsort((least - 4.0 / 27.0 * slopes) / moved[places], kind="stable")[:NEAREST]:
        row, place, h = int(rows[k]), int(places[k]), float(length[rows[k]])
        ends = room[row, place], h * rate[row, place], room[row + 1, place], h * rate[row + 1, place]
        at, left = lowest_of_cubic(*map(float, ends))
        found.append((place, -left, float(motion.time[row] + at * h)))
    if motion.ended:
        place = first_largest(-room[-1])
        speed, braked = rate[-1, place], limits.rate(motion.qdd[-1])[place]
        if braked > 0.0:
            found.append((place, float(0.5 * speed * speed / braked), float(motion.time[-1])))
    if not found:
        return None
    errors = np.array([abs(depth) / moved[place] for place, depth, _ in found])
    first = first_largest(-errors)
    place, depth, time = found[first]
    return Graze(limits.stops[place], depth, time, float(errors[first]))


def simulate_within(model: Model, scene: Scene, duration: float | None, target: float, **options: Any) -> Simulation:
    """Return the motion by the quickest method whose error is expected to be within the target, and which one that is.

    The steps of a method are halved, or its tolerance is tightened, until that changes the motion by less than the
    target, the change having fallen from one halving to the next; then another method, independent and with steps of
    its own, has to agree. That which takes less work is returned. Work is counted, and ends at a bound.

    Args:
        target: of positions and speeds along the way, relative to the largest angle, length, rate or speed, and of the
            time at which a limit ends the motion, relative to that.
        options: as for `simulate`, without method, step and tolerance.

    Raises:
        InputError: no method gets there, or no two agree; it tells what was reached by how many steps.

    Accuracy: `expected_error` covers the true error in 95 of 100 random motions.
    """
    effort = Effort(model, scene, duration, options)
    stiff, aim, doubt = effort.is_stiff(), target, ""
    while True:
        try:
            settled, checked, error = _within(effort, aim, stiff)
        except InputError as problem:
            raise InputError(doubt or problem.what, remedy=APART if doubt else problem.remedy) from None
        near = graze(settled.motion)
        if near is None or error < near.error:
            break
        doubt = f"an accuracy of {target:g} cannot be promised: {near}, and an error of {error:.0e} does not tell which"
        aim = 0.5 * min(near.error, aim)
    quicker, other = sorted((settled.motion, checked.motion), key=effort.work)
    said = (
        f"accuracy: {target:g} asked, {_named(quicker)} is expected to be within {error:.0e} of the largest angle, "
        f"length, rate or speed (from step to step: {settled.error:.0e}, {_named(other)} differs by "
        f"{checked.error:.0e})"
    )
    settled_now = (TOO_LONG, DRIFTS)  # of which there is no more doubt
    shaky = tuple(caveat for caveat in quicker.shaky if caveat.kind not in settled_now)
    return replace(quicker, notes=(*quicker.notes, said), shaky=shaky, target=target, expected_error=error)


def _within(effort: Effort, target: float, stiff: bool) -> tuple[Settled, Settled, float]:
    """Motions by two methods and their error, the first refined until they agree; raise InputError if none do."""
    what, error = "", inf
    for tighter in TIGHTER:
        try:
            settled = _settled(effort, target, target / tighter, stiff)
            checked = _confirmed(effort, settled, target)
        except InputError:
            if not what:
                raise
            break
        error = settled.error + checked.error + ROUNDING
        if error <= target:
            return settled, checked, error
        what = f"{settled.motion.method.name} and {checked.motion.method.name} differ by {checked.error:.0e}"
    _refuse(effort, target, what, error)


def _settled(effort: Effort, target: float, wanted: float, stiff: bool) -> Settled:
    """Return the first method whose refinement changes less than half of what is wanted; raise InputError if none."""
    tightened = () if effort.scene.loops else TIGHTENED
    problems, reached = [], inf
    for name in (*tightened, *HALVED) if stiff else (*HALVED, *tightened):
        try:
            return refined(effort, name, 0.5 * wanted)
        except UnsettledError as error:
            problems.append(f"{name}: {error.what}")
            reached = min(reached, error.reached)
    _refuse(effort, target, "; ".join(problems), reached)


def _confirmed(effort: Effort, settled: Settled, target: float) -> Settled:
    """Return the motion by another method and how far it is from the first; raise InputError if none gets through."""
    motion = settled.motion
    best, problem = Settled(motion, inf), ""
    for name in CONFIRMING[motion.method.name]:
        effort.floor = 0.5 * effort.left
        step = motion.step or FIRST_STEP
        options: dict[str, float] | None = (
            {"rtol": target / 10.0} if method_named(name).adaptive else {"step": 0.5 * step}
        )
        while options:
            try:
                other = effort.run(name, also=seen(motion), **options)
            except InputError as error:
                problem = error.what
                break
            off = apart(motion, other)
            best = min(best, Settled(other, off), key=lambda each: each.error)
            options = _finer(options, 0.2 * step, min(0.01, 0.1 / max(off / target, TINY)))
            if off + settled.error <= target and (off <= settled.error or off <= 0.1 * target or options is None):
                return best
        if best.error + settled.error <= target:
            return best
    if best.error == inf or problem:
        what = f"no second method gets through to confirm it: {problem}"
        _refuse(effort, target, what, settled.error + (best.error if best.error < inf else 0.0))
    return best


def _named(motion: Simulation) -> str:
    return f"{motion.method.name} with {shown({'step': motion.step} if motion.step else {'rtol': motion.rtol})}"


def _refuse(effort: Effort, target: float, why: str, reached: float) -> NoReturn:
    got = f"reached {reached:.0e}" if reached < inf else "nothing is known of its error"
    remedy = "ask for less, give a shorter --duration, or choose --method and --step yourself"
    what = f"an accuracy of {target:g} cannot be promised: {got} after {effort.steps} steps in all; {why}"
    raise InputError(what, remedy=remedy)
