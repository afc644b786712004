"""By which method a motion is followed, and with what steps: what was asked for, or what a scene's stiffness allows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import InputError
from robodyn.plan import Plan
from robodyn.simulation.methods import Method, method_named
from robodyn.simulation.stiffness import Stiffest, rounded, stiffest

Floats = NDArray[np.float64]
STEP = 1e-3
"""s, where neither a step nor a tolerance is given."""
MOST_UNASKED = 1e5
"""Steps, where one shorter than STEP is chosen: rather than more of them, an implicit method."""
RTOL = 1e-9
"""Of an adaptive method, where none is given."""
LEAST_RTOL = 1e-13
"""Below, SciPy's methods only follow rounding."""


class How(NamedTuple):
    """A method, with the step of one that has fixed steps, or the tolerance of one that has not."""

    method: Method
    step: float
    rtol: float


class Way(NamedTuple):
    """How a motion is followed, what is to be said about that, and what to do where it does not get through."""

    how: How
    notes: tuple[str, ...] = ()
    remedy: str = ""


def how_of(step: float | None, rtol: float | None, name: str | None) -> How:
    """The method of this name with this step or tolerance, or with the usual ones.

    Raises:
        InputError: there is no such method, or it has no use for what is given.
    """
    method = method_named(name or ("rk4" if rtol is None else "dop853"))
    if method.adaptive and step is not None:
        raise InputError(f"{method.name} chooses its own steps", remedy="give --rtol instead of --step")
    if not method.adaptive and rtol is not None:
        raise InputError(f"{method.name} has steps of a fixed length", remedy="give --step instead of --rtol")
    return How(method, STEP if step is None else step, max(RTOL if rtol is None else rtol, LEAST_RTOL))


def way(a_plan: Plan, how: How, q: Floats, duration: float, any_step: bool, any_method: bool) -> Way:
    """A way that follows the stiffest of a scene at q, where the step, or also the method, may be chosen.

    Where many steps would be needed, Radau's method is chosen, which takes long ones.
    """
    explicit = not how.method.scipy or how.method.name == "dop853"
    fastest = stiffest(a_plan, q) if explicit else None
    if fastest is None:
        return Way(how)
    any_method = any_method and not a_plan.scene.loops
    if how.method.adaptive:
        return _by_radau(how, fastest) if any_method and fastest.rate * duration > MOST_UNASKED else Way(how)
    longest = fastest.longest(how.method)
    if how.step <= (0.5 if any_step else 1.0) * longest:
        return Way(how)
    if not any_step:
        remedy = fastest.remedy(how.method, how.step, a_plan.scene.slip_speed)
        said = f"STEP TOO LONG: {fastest}, which {how.method.name} follows with steps of up to {longest:.2g} s"
        return Way(how, (f"{said}; with {how.step:.3g} s it chatters ({remedy})",), remedy)
    shorter = rounded(0.5 * longest)
    if any_method and duration / shorter > MOST_UNASKED:
        return _by_radau(how, fastest)
    return Way(how._replace(step=shorter), (f"{fastest}: steps of {shorter:g} s follow it",))


def _by_radau(how: How, fastest: Stiffest) -> Way:
    return Way(how._replace(method=method_named("radau")), (f"{fastest}: radau follows it",))
