"""By which method a motion is followed, and with what steps or tolerance."""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import InputError
from robodyn.simulation.methods import Method, method_named

STEP = 1e-3
"""s, where neither a step nor a tolerance is given."""
RTOL = 1e-9
"""Of an adaptive method, where none is given."""
LEAST_RTOL = 1e-13
"""Below, SciPy's methods only follow rounding."""


class TooMuchError(InputError):
    """A motion takes more evaluations of the equations of motion than it may.

    Attributes:
        time, state: how far it got [s], and there (q, qd, work).
    """

    def __init__(self, what: str, time: float, state: NDArray[np.float64], remedy: str) -> None:
        super().__init__(what, remedy=remedy)
        self.time, self.state = time, state


class How(NamedTuple):
    """A method, with the step of one that has fixed steps, or the tolerance of one that has not.

    Attributes:
        most: evaluations of the equations of motion, after which it gives up.
    """

    method: Method
    step: float
    rtol: float
    most: float = inf


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
