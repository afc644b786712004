"""Motions by steps that follow the stiffest of a scene, wherever on the way it comes, and that keep the balance of
energy and work, which tells of steps that are too long where nothing else does."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.plan import Plan
from robodyn.errors import InputError
from robodyn.simulation.fixed import SHORTER, Motion
from robodyn.simulation.methods import MethodOptions, TooMuchError, method_named
from robodyn.simulation.result import Figures
from robodyn.simulation.stiffness import Stiffest, reach, rounded, stiffest
from robodyn.support.caveats import Caveat
from robodyn.support.floats import Floats

MOST_UNASKED = 1e5
"""Steps, where one shorter than usual is chosen, or evaluations by dop853: rather than more of them, radau."""
MOST_EVER = 1e9
"""Evaluations that dop853 is left to: hours. A motion that would take more is not one of a robot."""
LOOKED_AT = 1e5
"""Rows of the mass matrices that a motion is looked at in, about; those around the stiffest come on top."""
KEPT = 1e-3
"""Of the energy that a motion turns over: by more than this its balance may not be off."""
ROUNDING = 1e-10
"""Of the stored energy, whose zero is arbitrary: what is less is rounding."""
TOO_LONG = "by steps that are too long for it (STEP TOO LONG)"
DRIFTS = "by steps that do not keep the energy (ENERGY DRIFTS)"
"""The kinds of caveats about steps that are kept though they are too long, and about motions whose balance is off."""


class Balanced(NamedTuple):
    """A motion with its figures, which say how well it keeps the balance E - E_0 = work."""

    motion: Motion
    figures: Figures

    @property
    def off(self) -> float:
        """max |E - E_0 - work| [J]."""
        return self.figures.drift(self.motion.states[:, -2])

    @property
    def share(self) -> float:
        """`off` as a share of what is turned over: kinetic and stored energy, work, what drives give and take."""
        figures, motion = self.figures, self.motion
        n = figures.tau.shape[1]
        power = np.abs(figures.tau * motion.states[:, -2 - n : -2]).sum(axis=1)
        driven = float((0.5 * (power[1:] + power[:-1]) * np.diff(motion.time)).sum())
        energy = figures.energy
        largest = max(figures.kinetic.max(), np.ptp(energy), np.ptp(motion.states[:, -2]), driven)
        return self.off / max(float(largest), ROUNDING * float(np.abs(energy).max()), 1e-300)


class Chosen(NamedTuple):
    """By which method and step a motion is followed, and notes about that."""

    options: MethodOptions
    notes: tuple[str, ...] = ()


class Free(NamedTuple):
    """What the caller leaves open."""

    step: bool
    method: bool


def stiff_steps(
    a_plan: Plan,
    options: MethodOptions,
    q: Floats,
    duration: float,
    free: Free,
    made: Callable[[MethodOptions], Balanced],
) -> tuple[Balanced, Chosen, list[Caveat]]:
    """The motion that is asked for, by steps that follow the stiffest of a scene where steps or method are open.

    What is stiff is looked at where the motion begins, and then along all of it: where steps were too long, the motion
    is made again with shorter ones, or by Radau's method where many would be needed; and so it is where something is
    stiff and the balance of energy and work is off, as of steps that are stable on a spring, but take its energy.

    Args:
        q: (nq,) where it begins; made: the motion by a method.

    Returns:
        The motion, how it was found, and what makes it doubtful.

    Raises:
        InputError: the method does not get through.
    """
    fastest = None if options.method.name == "radau" else stiffest(a_plan, q)
    free, most = Free(free.step, free.method and not a_plan.scene.loops), options.most
    chosen = _begun(options, fastest, duration, free)
    while True:
        options = chosen.options
        try:
            found = made(options)
        except InputError as error:
            chosen = _instead(a_plan, chosen, error, fastest, duration, free, most)
            chosen = chosen._replace(options=chosen.options._replace(most=most))
            continue
        outgrown = None if options.method.adaptive else _outgrown(a_plan, options, found.motion)
        if outgrown is not None and free.step:
            chosen = _shorter(options, *outgrown, duration, free)
            continue
        off = found.share > KEPT
        if off and fastest is not None and free.step and not options.method.adaptive:
            finer = rounded(0.25 * options.step)
            why = f"steps of {options.step:g} s are off by {100 * found.share:.2g} % of the energy"
            if duration / finer <= MOST_UNASKED:
                chosen = Chosen(options._replace(step=finer), (f"{why}: those of {finer:g} s keep it",))
                continue
            if free.method:
                chosen = _by_radau(options, why)
                continue
        caveats = [] if outgrown is None else [_too_long(a_plan, options, *outgrown)]
        return found, chosen, caveats + ([_drifts(options, found)] if off else [])


def _begun(options: MethodOptions, fastest: Stiffest | None, duration: float, free: Free) -> Chosen:
    """What follows the stiffest of where a motion begins, with room for more."""
    if fastest is not None and not options.method.adaptive:
        too_long = free.step and options.step > 0.5 * fastest.longest(options.method)
        return _shorter(options, fastest, 0.0, duration, free) if too_long else Chosen(options)
    if fastest is not None and free.method and fastest.rate * duration > MOST_UNASKED:
        return _by_radau(options, str(fastest))
    bounded = options.method.adaptive and free.method
    return Chosen(options._replace(most=min(options.most, MOST_UNASKED)) if bounded else options)


def _shorter(options: MethodOptions, fastest: Stiffest, since: float, duration: float, free: Free) -> Chosen:
    """Steps half as long as the stiffest allows, or Radau's."""
    step = rounded(0.5 * fastest.longest(options.method))
    if free.method and duration / step > MOST_UNASKED:
        return _by_radau(options, _when(fastest, since))
    return Chosen(options._replace(step=step), (f"{_when(fastest, since)}: steps of {step:g} s follow it",))


def _by_radau(options: MethodOptions, why: str) -> Chosen:
    return Chosen(options._replace(method=method_named("radau")), (f"{why}: radau follows it",))


def _when(fastest: Stiffest, since: float) -> str:
    return f"{fastest} on the way, too fast for the steps before from {since:.4g} s on" if since else str(fastest)


def _instead(
    a_plan: Plan, chosen: Chosen, error: InputError, fastest: Stiffest | None, duration: float, free: Free, most: float
) -> Chosen:
    """Radau's after another failed, or that without a bound if nothing stiff held it up; raises if neither helps."""
    options = chosen.options
    if isinstance(error, TooMuchError) and free.method and options.most < most:
        here = stiffest(a_plan, error.state[: a_plan.model.nq])
        if here is not None and here.rate * duration > MOST_UNASKED:
            return _by_radau(options, _when(here, error.time))
        if options.most * duration > MOST_EVER * error.time:
            raise error
        return chosen
    if fastest is None or error.remedy != SHORTER:
        raise error
    if free.method and free.step:
        return _by_radau(options, f"{options.method.name} does not get through ({error.what})")
    if options.step > fastest.longest(options.method):
        remedy = fastest.remedy(options.method, options.step, a_plan.scene.slip_speed)
        raise InputError(error.what, remedy=remedy) from None
    raise error


def _outgrown(a_plan: Plan, options: MethodOptions, motion: Motion) -> tuple[Stiffest, float] | None:
    """The stiffest of a motion whose steps were too long for it, and since when [s]; None if they were not."""
    q, every = motion.states[:, : a_plan.model.nq], int(np.ceil(len(motion.time) * a_plan.model.n / LOOKED_AT))
    rows = np.arange(0, len(q), every)
    found = stiffest(a_plan, q[rows])
    if found is not None and every > 1:
        middle = rows[int(np.argmax(found.along))]
        near = np.arange(max(middle - every, 0), min(middle + every + 1, len(q)))
        rows = np.union1d(rows, near)
        found = stiffest(a_plan, q[rows])
    if found is None or options.step <= found.longest(options.method):
        return None
    return found, float(motion.time[rows[int(np.argmax(found.along * options.step > reach(options.method)))]])


def _too_long(a_plan: Plan, options: MethodOptions, fastest: Stiffest, since: float) -> Caveat:
    longest = fastest.longest(options.method)
    when = f" from {since:.4g} s on" if since else ""
    remedy = fastest.remedy(options.method, options.step, a_plan.scene.slip_speed)
    said = f"STEP TOO LONG{when}: {fastest}, which {options.method.name} follows with steps of up to {longest:.2g} s"
    return Caveat(TOO_LONG, f"{said}; with {options.step:.3g} s it chatters ({remedy})")


def _drifts(options: MethodOptions, found: Balanced) -> Caveat:
    shorter = f"give --step {rounded(0.25 * options.step):g}, or --method radau"
    remedy = "give a smaller --rtol" if options.method.adaptive else shorter
    said = f"ENERGY DRIFTS: stored energy and work part by {found.off:.3g} J, {100 * found.share:.2g} % of what the "
    return Caveat(DRIFTS, f"{said}motion turns over, and more than {100 * KEPT:g} % ({remedy})")
