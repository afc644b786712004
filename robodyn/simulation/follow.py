"""Motions by steps that follow the stiffest of a scene, wherever on the way it comes."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.plan import Plan
from robodyn.errors import InputError
from robodyn.simulation.fixed import SHORTER, Motion
from robodyn.simulation.methods import How, TooMuchError, method_named
from robodyn.simulation.stiffness import Stiffest, reach, rounded, stiffest
from robodyn.support.doubts import Doubt
from robodyn.support.floats import Floats

MOST_UNASKED = 1e5
"""Steps, where one shorter than usual is chosen, or evaluations by dop853: rather than more of them, radau."""
TOO_LONG = "by steps that are too long for it (STEP TOO LONG)"
"""The clause of steps that are kept though they are too long."""
LOOKED_AT = 1e5
"""Rows of the mass matrices that a motion is looked at in, about; those around the stiffest come on top."""


class Chosen(NamedTuple):
    """How a motion is followed, and what is to be said about that."""

    how: How
    notes: tuple[str, ...] = ()


class Followed(NamedTuple):
    """A motion, how it was found, what is to be said about that, and what makes it doubtful."""

    motion: Motion
    how: How
    notes: tuple[str, ...] = ()
    doubts: tuple[Doubt, ...] = ()


class Free(NamedTuple):
    """What the caller leaves open."""

    step: bool
    method: bool


def followed(a_plan: Plan, how: How, q: Floats, duration: float, free: Free, made: Callable[[How], Motion]) -> Followed:
    """The motion that is asked for, by steps that follow the stiffest of a scene where steps or method are open.

    What is stiff is looked at where the motion begins, and then along all of it: where steps were too long, the motion
    is made again with shorter ones, or by Radau's method where many would be needed.

    Args:
        q: (nq,) where it begins; made: the motion by a method.

    Raises:
        InputError: the method does not get through.
    """
    fastest = stiffest(a_plan, q) if how.method.name != "radau" else None
    if fastest is None:
        return Followed(made(how), how)
    free, most = Free(free.step, free.method and not a_plan.scene.loops), how.most
    chosen = _begun(how, fastest, duration, free)
    while True:
        how = chosen.how
        try:
            motion = made(how)
        except InputError as error:
            chosen = _instead(a_plan, chosen, error, fastest, duration, free, most)
            chosen = chosen._replace(how=chosen.how._replace(most=most))
            continue
        found = None if how.method.adaptive else _outgrown(a_plan, how, motion)
        if found is None:
            return Followed(motion, *chosen)
        if not free.step:
            return Followed(motion, *chosen, (_doubt(a_plan, how, *found),))
        chosen = _shorter(how, *found, duration, free)


def _begun(how: How, fastest: Stiffest, duration: float, free: Free) -> Chosen:
    """What follows the stiffest of where a motion begins, with room for more."""
    if not how.method.adaptive:
        too_long = free.step and how.step > 0.5 * fastest.longest(how.method)
        return _shorter(how, fastest, 0.0, duration, free) if too_long else Chosen(how)
    if free.method and fastest.rate * duration > MOST_UNASKED:
        return _by_radau(how, str(fastest))
    return Chosen(how._replace(most=min(how.most, MOST_UNASKED)) if free.method else how)


def _shorter(how: How, fastest: Stiffest, since: float, duration: float, free: Free) -> Chosen:
    """Steps half as long as the stiffest allows, or Radau's."""
    step = rounded(0.5 * fastest.longest(how.method))
    if free.method and duration / step > MOST_UNASKED:
        return _by_radau(how, _when(fastest, since))
    return Chosen(how._replace(step=step), (f"{_when(fastest, since)}: steps of {step:g} s follow it",))


def _by_radau(how: How, why: str) -> Chosen:
    return Chosen(how._replace(method=method_named("radau")), (f"{why}: radau follows it",))


def _when(fastest: Stiffest, since: float) -> str:
    return f"{fastest} on the way, too fast for the steps before from {since:.4g} s on" if since else str(fastest)


def _instead(
    a_plan: Plan, chosen: Chosen, error: InputError, fastest: Stiffest, duration: float, free: Free, most: float
) -> Chosen:
    """Radau's method after another failed, or that other without a bound where nothing stiff held it up.

    Args:
        most: evaluations that the caller allows.

    Raises:
        InputError: the caller wants the other, or that is not why it failed.
    """
    how = chosen.how
    if isinstance(error, TooMuchError) and free.method and how.most < most:
        here = stiffest(a_plan, error.state[: a_plan.model.nq])
        if here is None or here.rate * duration <= MOST_UNASKED:
            return chosen
        return _by_radau(how, _when(here, error.time))
    if error.remedy == SHORTER and free.method and free.step:
        return _by_radau(how, f"{how.method.name} does not get through ({error.what})")
    if error.remedy == SHORTER and how.step > fastest.longest(how.method):
        remedy = fastest.remedy(how.method, how.step, a_plan.scene.slip_speed)
        raise InputError(error.what, remedy=remedy) from None
    raise error


def _doubt(a_plan: Plan, how: How, fastest: Stiffest, since: float) -> Doubt:
    longest = fastest.longest(how.method)
    when = f" from {since:.4g} s on" if since else ""
    remedy = fastest.remedy(how.method, how.step, a_plan.scene.slip_speed)
    said = f"STEP TOO LONG{when}: {fastest}, which {how.method.name} follows with steps of up to {longest:.2g} s"
    return Doubt(
        TOO_LONG,
        f"{said}; with {how.step:.3g} s it chatters ({remedy})",
    )


def _outgrown(a_plan: Plan, how: How, motion: Motion) -> tuple[Stiffest, float] | None:
    """The stiffest of a motion whose steps were too long for it, and since when [s]; None if they were not."""
    q, every = motion.states[:, : a_plan.model.nq], int(np.ceil(len(motion.time) * a_plan.model.n / LOOKED_AT))
    rows = np.arange(0, len(q), every)
    found = stiffest(a_plan, q[rows])
    if found is not None and every > 1:
        middle = rows[int(np.argmax(found.along))]
        near = np.arange(max(middle - every, 0), min(middle + every + 1, len(q)))
        rows = np.union1d(rows, near)
        found = stiffest(a_plan, q[rows])
    if found is None or how.step <= found.longest(how.method):
        return None
    return found, float(motion.time[rows[int(np.argmax(found.along * how.step > reach(how.method)))]])
