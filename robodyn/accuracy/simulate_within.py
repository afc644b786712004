"""A simulation as accurate as asked: methods and steps by errors that are measured on the motion itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from time import perf_counter
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from robodyn.accuracy.motion_error import MotionError, between_records
from robodyn.errors import InputError
from robodyn.model import Model
from robodyn.scene import Scene
from robodyn.simulation.how import LEAST_RTOL
from robodyn.simulation.result import Simulation
from robodyn.simulation.run import simulate

Floats = NDArray[np.float64]
FIRST_STEP = 1.6e-2
"""s, which is halved from there on."""
HALVED = "rk4", "gauss6"
CHOOSING = "dop853", "radau"
SLOWEST = 1.5
"""A step half as long has to leave no more than 1 / 1.5 of the difference, or the error has reached its floor."""
PATIENCE = 3.0
"""Seconds that a motion may take."""
TINY = 1e-300
FLOOR = 8.0
"""What a difference at the floor of rounding is multiplied with."""


@dataclass(frozen=True, eq=False)
class Halved:
    """A motion by a method with a fixed step.

    Attributes:
        error: what halving the steps shows: the expected one, relative to the largest of the kind (see `MotionError`).
        seconds: that it took.
    """

    motion: Simulation
    error: float
    seconds: float


def simulate_within(model: Model, scene: Scene, duration: float | None, target: float, **how: Any) -> Simulation:
    """The motion by the quickest method whose error is expected to be within the target, and which one that is.

    The steps of a method are halved until that changes the motion by less than the target, the change having fallen
    from one halving to the next; then a second method, independent and with steps of its own, has to agree. The
    quicker of the two is taken.

    Args:
        target: of positions and speeds along the way, relative to the largest angle, length, rate or speed.
        how: as for `simulate`, without method, step and tolerance.

    Raises:
        InputError: no method gets there, or the two do not agree.

    Accuracy: `expected_error` covers the true error in 95 of 100 random motions.
    """
    run = partial(simulate, model, scene, duration, **how)
    run()  # refuses what no method can do
    halved = _halved(run, target)
    measure = MotionError.over(model, _states(halved.motion))
    checked, apart, seconds = _checked(run, halved, measure, target)
    error = halved.error + apart
    if error > target:
        _refuse(target, f"{halved.motion.method.name} and {checked.method.name} differ by {apart:.0e}")
    quicker = checked if seconds < halved.seconds else halved.motion
    other = checked if quicker is halved.motion else halved.motion
    said = (
        f"accuracy: {target:g} asked, {_named(quicker)} is expected to be within {error:.0e} of the largest angle, "
        f"length, rate or speed (halving steps: {halved.error:.0e}, {_named(other)} differs by {apart:.0e})"
    )
    return replace(quicker, notes=(*quicker.notes, said), target=target, expected_error=error)


def _halved(run: Callable[..., Simulation], target: float) -> Halved:
    """The first method whose steps can be halved until that changes less than the target."""
    problems = []
    for method in HALVED:
        try:
            return _by_halving(partial(run, method=method), 0.5 * target)
        except InputError as error:
            problems.append(f"{method}: {error.what}")
    _refuse(target, "; ".join(problems))


def _by_halving(run: Callable[..., Simulation], target: float) -> Halved:
    """Raises: InputError: the changes stop falling above the target, or the steps become too many."""
    before, change, step = None, inf, FIRST_STEP
    problem = ""
    while True:
        begin = perf_counter()
        try:
            motion = run(step=step)
        except InputError as error:
            motion, problem = None, error.what
        seconds = perf_counter() - begin
        if motion is not None and before is not None:
            last, change = change, _change(before, motion)
            if change * SLOWEST > last:
                if FLOOR * change <= target:
                    return Halved(motion, FLOOR * change, seconds)
                if last < 1e-6:
                    raise InputError(f"halving its step to {motion.step:.3g} s changes the motion by {change:.0e} yet")
            elif last < inf and max(change, rest := change / (last / max(change, TINY) - 1.0)) <= target:
                return Halved(motion, max(change, rest), seconds)
        before = motion
        length = step if motion is None else motion.step or step
        if motion is not None and 2.0 * seconds > PATIENCE:
            raise InputError(f"steps of {length:.3g} s still change the motion by {change:.0e} when they are halved")
        if motion is None and step < 1e-6:
            raise InputError(problem)
        step = 0.5 * length


def _change(coarse: Simulation, fine: Simulation) -> float:
    """What twice as many steps change, at the times of the coarse records, up to a limit that ends either."""
    ended = coarse.ended or fine.ended
    rows = coarse.time < min(coarse.time[-1], fine.time[-1]) if ended else coarse.time <= fine.time[-1]
    count = int(rows.sum())
    if count < 2:
        return inf
    near = fine.time[::2][:count]
    shared = len(near) == count and np.allclose(near, coarse.time[:count], rtol=1e-12, atol=0.0)
    expected = _states(fine)[::2][:count] if shared else between_records(fine)(coarse.time[:count])
    off = MotionError.over(fine.model, expected)(_states(coarse)[:count], expected)
    return float(off.max())


def _checked(
    run: Callable[..., Simulation], halved: Halved, measure: MotionError, target: float
) -> tuple[Simulation, float, float]:
    """The motion by a second method, how far it is from the first, and the seconds that it took."""
    motion = halved.motion
    between = between_records(motion)
    found: tuple[Simulation, float, float] | None = None
    problem = ""
    for method in CHOOSING:
        for rtol in (target / 10, target / 1e3, target / 1e5, LEAST_RTOL):
            begin = perf_counter()
            try:
                other = run(method=method, rtol=max(rtol, LEAST_RTOL))
            except InputError as error:
                problem = error.what
                break
            seconds = perf_counter() - begin
            rows = other.time <= motion.time[-1]
            off = float(measure(_states(other)[rows], between(other.time[rows])).max())
            if found is None or off < found[1]:
                found = other, off, seconds
            if off + halved.error <= target and (off <= halved.error or rtol <= LEAST_RTOL or off <= 0.1 * target):
                return found
        if found is not None:
            return found
    _refuse(target, f"no second method gets through to confirm it: {problem}")


def _states(motion: Simulation) -> Floats:
    return np.hstack((motion.q, motion.qd))


def _named(motion: Simulation) -> str:
    how = f"steps of {motion.step:.3g} s" if motion.step is not None else f"rtol {motion.rtol:.1g}"
    return f"{motion.method.name} with {how}"


def _refuse(target: float, why: str) -> NoReturn:
    remedy = "ask for less, give a shorter --duration, or choose --method and --step yourself"
    raise InputError(f"an accuracy of {target:g} cannot be promised: {why}", remedy=remedy)
