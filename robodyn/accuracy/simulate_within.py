"""A simulation as accurate as asked: methods and steps by errors that are measured on the motion itself."""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import Any, NamedTuple, NoReturn

import numpy as np
from numpy.typing import NDArray

from robodyn.accuracy.effort import Effort
from robodyn.accuracy.motion_error import MotionError, between_records
from robodyn.accuracy.near_limits import graze
from robodyn.errors import InputError
from robodyn.model import Model
from robodyn.scene import Scene
from robodyn.simulation.follow import TOO_LONG
from robodyn.simulation.how import LEAST_RTOL, TooMuchError
from robodyn.simulation.methods import method_named
from robodyn.simulation.result import Simulation

Floats = NDArray[np.float64]
FIRST_STEP, LAST_STEP = 1.6e-2, 1e-8
"""s: the steps that are halved, from the first to the last."""
HALVED, TIGHTENED = ("rk4", "gauss6"), ("radau",)
"""Methods whose steps are halved, or whose tolerance is tightened."""
CONFIRMING = {"rk4": ("dop853", "gauss6", "radau"), "gauss6": ("dop853", "rk4", "radau"), "radau": ("bdf",)}
"""Methods of which one has to agree; those with fixed steps where SciPy's are too much work, as with many rows."""
TIGHTER = 30.0, 1000.0
"""Parts of the target to which a motion is refined once more, where another method does not agree."""
SLOWEST = 1.5
"""A step half as long has to leave no more than 1 / 1.5 of the difference, or the error has reached its floor."""
ROUNDING = 2.0**-51
"""Of the largest number of a motion: no error is below."""
GROWN = 1.5
"""Twice as many whole steps have to make at least so many times as many in all."""
APART = 'move the limit or the start, or write joint_limits = "spring" or "ignore" in the scene'
SEEN = 50
"""Records at which motions by different methods are compared."""
SAME = 1e-12
"""Times nearer than this part of them are the same."""
TINY = 1e-300
FLOOR = 8.0
"""What a difference at the floor of rounding is multiplied with."""


class Settled(NamedTuple):
    """A motion by one method, and its expected error, relative to the largest of the kind (see `MotionError`)."""

    motion: Simulation
    error: float


class UnsettledError(InputError):
    """A method that does not get there.

    Attributes:
        reached: the change that its last two motions leave; inf if there are no two.
    """

    def __init__(self, what: str, reached: float = inf) -> None:
        super().__init__(what)
        self.reached = reached


def simulate_within(model: Model, scene: Scene, duration: float | None, target: float, **how: Any) -> Simulation:
    """The motion by the quickest method whose error is expected to be within the target, and which one that is.

    The steps of a method are halved, or its tolerance is tightened, until that changes the motion by less than the
    target, the change having fallen from one halving to the next; then another method, independent and with steps of
    its own, has to agree. That which takes less work is returned. Work is counted, and ends at a bound.

    Args:
        target: of positions and speeds along the way, relative to the largest angle, length, rate or speed, and of the
            time at which a limit ends the motion, relative to that.
        how: as for `simulate`, without method, step and tolerance.

    Raises:
        InputError: no method gets there, or no two agree; it tells what was reached by how many steps.

    Accuracy: `expected_error` covers the true error in 95 of 100 random motions.
    """
    effort = Effort(model, scene, duration, how)
    settled, checked, error = _agreed(effort, target, effort.is_stiff())
    quicker, other = sorted((settled.motion, checked.motion), key=effort.work)
    said = (
        f"accuracy: {target:g} asked, {_named(quicker)} is expected to be within {error:.0e} of the largest angle, "
        f"length, rate or speed (from step to step: {settled.error:.0e}, {_named(other)} differs by "
        f"{checked.error:.0e})"
    )
    shaky = tuple(doubt for doubt in quicker.shaky if doubt.clause != TOO_LONG)  # of which there is no more doubt
    return replace(quicker, notes=(*quicker.notes, said), shaky=shaky, target=target, expected_error=error)


def _agreed(effort: Effort, target: float, stiff: bool) -> tuple[Settled, Settled, float]:
    """Two motions that agree, and the error of either, which leaves no doubt about limits that they only just reach.

    Raises:
        InputError: there are no two.
    """
    aim, doubt = target, ""
    while True:
        try:
            settled, checked, error = _within(effort, aim, stiff)
        except InputError as problem:
            raise InputError(doubt or problem.what, remedy=APART if doubt else problem.remedy) from None
        near = graze(settled.motion)
        if near is None or error < near.error:
            return settled, checked, error
        doubt = f"an accuracy of {target:g} cannot be promised: {near}, and an error of {error:.0e} does not tell which"
        aim = 0.5 * min(near.error, aim)


def _within(effort: Effort, target: float, stiff: bool) -> tuple[Settled, Settled, float]:
    """Motions by two methods and their error; where they do not agree, the first is refined further.

    Raises:
        InputError: no two agree to within the target.
    """
    settled, checked, error = _pair(effort, target, target, stiff)
    for tighter in TIGHTER:
        if error <= target:
            return settled, checked, error
        try:
            settled, checked, error = _pair(effort, target, target / tighter, stiff)
        except InputError:
            break
    if error > target:
        what = f"{settled.motion.method.name} and {checked.motion.method.name} differ by {checked.error:.0e}"
        _refuse(effort, target, what, error)
    return settled, checked, error


def _pair(effort: Effort, target: float, wanted: float, stiff: bool) -> tuple[Settled, Settled, float]:
    settled = _settled(effort, target, wanted, stiff)
    checked = _confirmed(effort, settled, target)
    return settled, checked, settled.error + checked.error + ROUNDING


def _settled(effort: Effort, target: float, wanted: float, stiff: bool) -> Settled:
    """The first method that can be refined until that changes less than half of what is wanted.

    Raises:
        InputError: none can.
    """
    tightened = () if effort.scene.loops else TIGHTENED
    problems, reached = [], inf
    for name in (*tightened, *HALVED) if stiff else (*HALVED, *tightened):
        try:
            return _refined(effort, name, 0.5 * wanted)
        except UnsettledError as error:
            problems.append(f"{name}: {error.what}")
            reached = min(reached, error.reached)
    _refuse(effort, target, "; ".join(problems), reached)


def _refined(effort: Effort, name: str, target: float) -> Settled:
    """Raises: UnsettledError: the changes stop falling above the target, or the work is done."""
    before, change, problem = None, inf, "one motion alone tells no error"
    effort.next_way(effort.share)
    finer: dict[str, float] | None = {"rtol": 0.2 * target} if method_named(name).adaptive else {"step": FIRST_STEP}
    while finer:
        how, motion = finer, None
        try:
            motion = effort.run(name, also=seen(before), **how)
        except TooMuchError:
            left = f"finer steps change it by {change:.0e} yet" if change < inf else problem
            raise UnsettledError(f"{left}, and going to {_shown(how)} is more work than is allowed", change) from None
        except InputError as error:
            problem = error.what
        finer = _finer(how, motion)
        if motion is not None and before is not None:
            if not _is_finer(motion, before):
                continue
            last, change = change, apart(before, motion)
            expected = _expected(name, last, change, target)
            if expected <= 2.0 * target:
                return Settled(motion, expected)
            if change * SLOWEST > last and last < 1e-6:
                raise UnsettledError(f"going to {_shown(how)} changes the motion by {change:.0e} yet", change)
        before = motion or before
    raise UnsettledError(
        f"going to {_shown(how)} changes the motion by {change:.0e} yet" if change < inf else problem, change
    )


def _is_finer(motion: Simulation, before: Simulation) -> bool:
    """Whether steps are shorter indeed: where rows of a table or an early end make them short, half of one is none."""
    return motion.step is None or motion.steps >= GROWN * before.steps


def _finer(how: dict[str, float], motion: Simulation | None) -> dict[str, float] | None:
    """Half the step that a motion had, whose records these are too, or a smaller tolerance; None at the end."""
    if "rtol" in how:
        return {"rtol": max(how["rtol"] / 100.0, LEAST_RTOL)} if how["rtol"] > LEAST_RTOL else None
    step = 0.5 * (how["step"] if motion is None or motion.step is None else motion.step)
    return {"step": step} if step >= LAST_STEP else None


def _expected(name: str, last: float, change: float, target: float) -> float:
    """The error that is left after a change which followed another one; inf if that cannot be told."""
    if method_named(name).adaptive:
        return change if change <= target else inf
    if change * SLOWEST > last:
        return FLOOR * change if FLOOR * change <= 2.0 * target else inf
    rest = max(change, change / (last / max(change, TINY) - 1.0))
    return rest if last < inf and rest <= target else inf


def apart(coarse: Simulation, fine: Simulation) -> float:
    """How far a motion is from a finer one: at times that both record, up to a limit that ends either.

    Where there are few of these, at those of the coarser, between records of the other. inf where one ends at another
    limit than the other, or both are too short.
    """
    if _limit(coarse) != _limit(fine):
        return inf
    end = min(coarse.time[-1], fine.time[-1])
    rows = np.flatnonzero(coarse.time < end if coarse.ended else coarse.time <= end)
    if len(rows) < 2:
        return inf
    times, states = coarse.time[rows], states_of(fine)
    near = np.searchsorted(fine.time, times * (1.0 - SAME))
    shared = np.abs(fine.time[near] - times) <= SAME * times
    few = shared.sum() < 0.5 * min(len(rows), SEEN)
    expected = between_records(fine)(times) if few else states[near[shared]]
    off = MotionError.over(fine.model, states)(states_of(coarse)[rows if few else rows[shared]], expected)
    return max(float(off.max()), _late(coarse, fine))


def seen(motion: Simulation | None) -> list[float]:
    """Times of some records of a motion, spread over it, at which another one is compared with it."""
    if motion is None:
        return []
    last = len(motion.time) - (2 if motion.ended else 1)
    rows = np.unique(np.linspace(0, max(last, 0), min(last, SEEN) + 1).astype(int))
    times: list[float] = motion.time[rows[1:]].tolist()
    return times


def _late(one: Simulation, other: Simulation) -> float:
    """By how much of the time two motions end apart."""
    return abs(float(one.time[-1] - other.time[-1])) / float(other.time[-1]) if one.ended else 0.0


def _limit(motion: Simulation) -> str:
    """The limit that ends a motion."""
    return motion.ended.rpartition(" at ")[0]


def _confirmed(effort: Effort, settled: Settled, target: float) -> Settled:
    """The motion by another method, and how far it is from the first.

    Raises:
        InputError: no other method gets through.
    """
    motion = settled.motion
    best, problem = Settled(motion, inf), ""
    for name in CONFIRMING[motion.method.name]:
        effort.next_way(0.5 * effort.left)
        fixed = {"step": 0.5 * (motion.step or FIRST_STEP)}
        how: dict[str, float] | None = {"rtol": target / 10.0} if method_named(name).adaptive else fixed
        while how:
            try:
                other = effort.run(name, also=seen(motion), **how)
            except InputError as error:
                problem = error.what
                break
            off = apart(motion, other)
            best = min(best, Settled(other, off), key=lambda each: each.error)
            how = _closer(how, motion, off / target)
            if off + settled.error <= target and (off <= settled.error or off <= 0.1 * target or how is None):
                return best
        if best.error + settled.error <= target:
            return best
    if best.error == inf or problem:
        what = f"no second method gets through to confirm it: {problem}"
        _refuse(effort, target, what, settled.error + (best.error if best.error < inf else 0.0))
    return best


def _closer(how: dict[str, float], motion: Simulation, off: float) -> dict[str, float] | None:
    """A smaller tolerance or step, of a method that is so many targets off from a motion; None at the end."""
    if "rtol" in how:
        rtol = max(how["rtol"] * min(0.01, 0.1 / max(off, TINY)), LEAST_RTOL)
        return {"rtol": rtol} if how["rtol"] > LEAST_RTOL else None
    step = 0.5 * how["step"]
    return {"step": step} if step > 0.2 * (motion.step or FIRST_STEP) else None


def states_of(motion: Simulation) -> Floats:
    return np.hstack((motion.q, motion.qd))


def _named(motion: Simulation) -> str:
    return f"{motion.method.name} with {_shown({'step': motion.step} if motion.step else {'rtol': motion.rtol})}"


def _shown(how: dict[str, Any]) -> str:
    return f"steps of {how['step']:.3g} s" if "step" in how else f"rtol {how['rtol']:.1g}"


def _refuse(effort: Effort, target: float, why: str, reached: float) -> NoReturn:
    got = f"reached {reached:.0e}" if reached < inf else "nothing is known of its error"
    remedy = "ask for less, give a shorter --duration, or choose --method and --step yourself"
    what = f"an accuracy of {target:g} cannot be promised: {got} after {effort.steps} steps in all; {why}"
    raise InputError(what, remedy=remedy)
