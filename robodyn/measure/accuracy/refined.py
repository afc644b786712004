"""A motion by one method, refined until that changes little; and limits that it only just reaches or misses."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import inf
from typing import NamedTuple

import numpy as np

from robodyn.errors import InputError
from robodyn.measure.accuracy.effort import Effort
from robodyn.measure.accuracy.motion_error import MotionError, apart, seen
from robodyn.simulation.events import Limits, Stop, lowest_of_cubic
from robodyn.simulation.methods import LEAST_RTOL, TooMuchError, method_named
from robodyn.simulation.result import Simulation
from robodyn.support.floats import Floats, first_largest

FIRST_STEP, LAST_STEP = 1.6e-2, 1e-8
"""s: the steps that are halved, from the first to the last."""
SLOWEST = 1.5
"""A step half as long has to leave no more than 1 / 1.5 of the difference, or the error has reached its floor."""
GROWN = 1.5
"""Twice as many whole steps have to make at least so many times as many in all."""
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


def refined(effort: Effort, name: str, target: float) -> Settled:
    """Return the motion by a method, refined until that changes it by less than the target.

    Raises:
        UnsettledError: the changes stop falling above the target, or the work is done.
    """
    before, change, problem = None, inf, "one motion alone tells no error"
    effort.next_way(effort.share)
    finer: dict[str, float] | None = {"rtol": 0.2 * target} if method_named(name).adaptive else {"step": FIRST_STEP}
    while finer:
        options, motion = finer, None
        try:
            motion = effort.run(name, also=seen(before), **options)
        except TooMuchError:
            left = f"finer steps change it by {change:.0e} yet" if change < inf else problem
            raise UnsettledError(
                f"{left}, and going to {shown(options)} is more work than is allowed", change
            ) from None
        except InputError as error:
            problem = error.what
        finer = _finer(options, motion)
        if motion is not None and before is not None:
            if not _is_finer(motion, before):
                continue
            last, change = change, apart(before, motion)
            expected = _expected(name, last, change, target)
            if expected <= 2.0 * target:
                return Settled(motion, expected)
            if change * SLOWEST > last and last < 1e-6:
                raise UnsettledError(f"going to {shown(options)} changes the motion by {change:.0e} yet", change)
        before = motion or before
    raise UnsettledError(
        f"going to {shown(options)} changes the motion by {change:.0e} yet" if change < inf else problem, change
    )


def _is_finer(motion: Simulation, before: Simulation) -> bool:
    """Whether steps are shorter indeed: where rows of a table or an early end make them short, half of one is none."""
    return motion.step is None or motion.steps >= GROWN * before.steps


def _finer(options: dict[str, float], motion: Simulation | None) -> dict[str, float] | None:
    """Half the step that a motion had, whose records these are too, or a smaller tolerance; None at the end."""
    if "rtol" in options:
        return {"rtol": max(options["rtol"] / 100.0, LEAST_RTOL)} if options["rtol"] > LEAST_RTOL else None
    step = 0.5 * (options["step"] if motion is None or motion.step is None else motion.step)
    return {"step": step} if step >= LAST_STEP else None


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


NEAREST = 16
"""Turns that are looked at closely."""


class Graze(NamedTuple):
    """A limit that a motion misses or passes by little.

    Attributes:
        depth: by how much, rad or m; negative where it misses.
        time: s, when.
        error: relative to the largest of the kind (see `MotionError`), at which either could be true.
    """

    stop: Stop
    depth: float
    time: float
    error: float

    def __str__(self) -> str:
        met = self.stop.met("passes" if self.depth > 0.0 else "misses")
        return f"{met} by {abs(self.depth):.1g} {self.stop.unit}, at {self.time:.6g} s"


def graze(motion: Simulation) -> Graze | None:
    """Return the limit that the least error of a motion would turn from missed to reached, or the other way round.

    Places at which joints turn back are looked at, and how far the joint would go on that ended the motion.
    """
    limits = Limits(motion.model, motion.scene.joint_limits == "stop")
    if not limits.stops:
        return None
    scale = MotionError.over(motion.model, np.hstack((motion.q, motion.qd))).scale[: motion.model.nq]
    moved = np.abs(limits.room(scale) - limits.room(0.0 * scale))
    found = [*_missed(limits, motion, moved), *_passed(limits, motion)]
    if not found:
        return None
    errors = [abs(depth) / moved[place] for place, depth, _ in found]
    first = first_largest(-np.array(errors))
    place, depth, time = found[first]
    return Graze(limits.stops[place], depth, time, float(errors[first]))


def _missed(limits: Limits, motion: Simulation, moved: Floats) -> Iterator[tuple[int, float, float]]:
    """Yield where joints turn back before a limit: which, minus what was left to it, and when; the nearest of them."""
    room, rate, length = limits.room(motion.q), limits.rate(motion.qd), np.diff(motion.time)
    rows, places = np.nonzero((rate[:-1] < 0.0) & (rate[1:] >= 0.0))
    least = np.minimum(room[rows, places], room[rows + 1, places])
    slopes = length[rows] * (np.abs(rate[rows, places]) + np.abs(rate[rows + 1, places]))
    for k in np.argsort((least - 4.0 / 27.0 * slopes) / moved[places], kind="stable")[:NEAREST]:
        row, place, h = int(rows[k]), int(places[k]), float(length[rows[k]])
        ends = room[row, place], h * rate[row, place], room[row + 1, place], h * rate[row + 1, place]
        at, left = lowest_of_cubic(*map(float, ends))
        yield place, -left, float(motion.time[row] + at * h)


def _passed(limits: Limits, motion: Simulation) -> Iterator[tuple[int, float, float]]:
    """Yield how far the joint that ended a motion would have gone on, braked as it is at the limit."""
    if not motion.ended:
        return
    place = first_largest(-limits.room(motion.q[-1]))
    speed, braked = limits.rate(motion.qd[-1])[place], limits.rate(motion.qdd[-1])[place]
    if braked > 0.0:
        yield place, float(0.5 * speed * speed / braked), float(motion.time[-1])
