"""A simulation as accurate as asked: methods and steps by errors that are measured on the motion itself."""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import Any, NoReturn

from robodyn.errors import InputError
from robodyn.measure.accuracy.effort import Effort
from robodyn.measure.accuracy.motion_error import apart, seen
from robodyn.measure.accuracy.refined import FIRST_STEP, TINY, Settled, UnsettledError, graze, refined, shown
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.simulation.balance import DRIFTS
from robodyn.simulation.methods import LEAST_RTOL, method_named
from robodyn.simulation.result import Simulation
from robodyn.simulation.stiff_steps import TOO_LONG

HALVED, TIGHTENED = ("rk4", "gauss6"), ("radau",)
"""Methods whose steps are halved, or whose tolerance is tightened."""
CONFIRMING = {"rk4": ("dop853", "gauss6", "radau"), "gauss6": ("dop853", "rk4", "radau"), "radau": ("bdf",)}
"""Methods of which one has to agree; those with fixed steps where SciPy's are too much work, as with many rows."""
TIGHTER = 30.0, 1000.0
"""Parts of the target to which a motion is refined once more, where another method does not agree."""
ROUNDING = 2.0**-51
"""Of the largest number of a motion: no error is below."""
APART = 'move the limit or the start, or write joint_limits = "spring" or "ignore" in the scene'


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
    settled, checked, error = _agreed(effort, target, effort.is_stiff())
    quicker, other = sorted((settled.motion, checked.motion), key=effort.work)
    said = (
        f"accuracy: {target:g} asked, {_named(quicker)} is expected to be within {error:.0e} of the largest angle, "
        f"length, rate or speed (from step to step: {settled.error:.0e}, {_named(other)} differs by "
        f"{checked.error:.0e})"
    )
    settled_now = (TOO_LONG, DRIFTS)  # of which there is no more doubt
    shaky = tuple(caveat for caveat in quicker.shaky if caveat.kind not in settled_now)
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
    """Return the first method that can be refined until that changes less than half of what is wanted.

    Raises:
        InputError: none can.
    """
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
    """Return the motion by another method, and how far it is from the first.

    Raises:
        InputError: no other method gets through.
    """
    motion = settled.motion
    best, problem = Settled(motion, inf), ""
    for name in CONFIRMING[motion.method.name]:
        effort.next_way(0.5 * effort.left)
        fixed = {"step": 0.5 * (motion.step or FIRST_STEP)}
        options: dict[str, float] | None = {"rtol": target / 10.0} if method_named(name).adaptive else fixed
        while options:
            try:
                other = effort.run(name, also=seen(motion), **options)
            except InputError as error:
                problem = error.what
                break
            off = apart(motion, other)
            best = min(best, Settled(other, off), key=lambda each: each.error)
            options = _closer(options, motion, off / target)
            if off + settled.error <= target and (off <= settled.error or off <= 0.1 * target or options is None):
                return best
        if best.error + settled.error <= target:
            return best
    if best.error == inf or problem:
        what = f"no second method gets through to confirm it: {problem}"
        _refuse(effort, target, what, settled.error + (best.error if best.error < inf else 0.0))
    return best


def _closer(options: dict[str, float], motion: Simulation, off: float) -> dict[str, float] | None:
    """Return a smaller tolerance or step, of a method that is so many targets off from a motion; None at the end."""
    if "rtol" in options:
        rtol = max(options["rtol"] * min(0.01, 0.1 / max(off, TINY)), LEAST_RTOL)
        return {"rtol": rtol} if options["rtol"] > LEAST_RTOL else None
    step = 0.5 * options["step"]
    return {"step": step} if step > 0.2 * (motion.step or FIRST_STEP) else None


def _named(motion: Simulation) -> str:
    return f"{motion.method.name} with {shown({'step': motion.step} if motion.step else {'rtol': motion.rtol})}"


def _refuse(effort: Effort, target: float, why: str, reached: float) -> NoReturn:
    got = f"reached {reached:.0e}" if reached < inf else "nothing is known of its error"
    remedy = "ask for less, give a shorter --duration, or choose --method and --step yourself"
    what = f"an accuracy of {target:g} cannot be promised: {got} after {effort.steps} steps in all; {why}"
    raise InputError(what, remedy=remedy)
