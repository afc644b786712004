"""The linear equations of a robot near a state, continuous or in steps."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf

import numpy as np

from robodyn.equations.linearized.modes import Modes, SmallMotion, modes_of
from robodyn.errors import InputError
from robodyn.programs.vectors import product
from robodyn.robot.limits import Excess, held_beyond
from robodyn.robot.model import Model
from robodyn.support.floats import Floats

_LOST = 1.0 / float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class Linearized:
    """x' = A x + B u near one state, x and u being differences from those of the state.

    Attributes:
        states: names of the entries of x, "q_elbow" and then "qd_elbow"; of a floating base turns about its axes and
            shifts along the ground's; of a closed chain those of as many joints as can move by themselves.
        inputs: names of the entries of u, torques beside those of the drives.
        A, B: (2 k, 2 k), (2 k, n).
        q, qd: (nq,), (n,) the state.
        drive: (n,) torques of the drives there [N m or N].
        held: (n,) torques that were added so that the robot does not accelerate [N m or N]; zero at an equilibrium.
        balanced: whether it is an equilibrium.
        motion: the equations of second order, and what modes rest on.
        step: s, where A and B are those of steps.
    """

    robot: str
    model: Model
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    A: Floats
    B: Floats
    q: Floats
    qd: Floats
    drive: Floats
    held: Floats
    balanced: bool
    motion: SmallMotion
    warnings: tuple[str, ...]
    step: float | None = None

    @cached_property
    def exceeded(self) -> tuple[Excess, ...]:
        """Limits of the description that the state exceeds: its positions, and the effort that holds it at rest."""
        return held_beyond(self.model, self.q, self.drive + self.held) if self.motion.at_rest else ()

    @property
    def stable(self) -> bool | None:
        """Whether it stays there: False too where limits do not allow the state; None where it is not decided."""
        return False if self.exceeded else self.modes.stable

    @property
    def verdict(self) -> str:
        """That of the modes, or "beyond limits"."""
        return "beyond limits" if self.exceeded else self.modes.verdict

    @cached_property
    def modes(self) -> Modes:
        """How it moves by itself, drives closed.

        `modes.modes`, the slowest first, have `frequency` [Hz], `damping_ratio`, `time_constant` [s], `real`, `imag`,
        the `error` of both [1/s], and `shape`. `modes.stable` is True, False, or None where that is not decided;
        `modes.verdict` says why, and `modes.margin` by how much [1/s].
        """
        return modes_of(self.motion)


def in_steps(found: Linearized, step: float) -> Linearized:
    """Return the same with A and B of x(t + step) = A x(t) + B u, where u is constant from one step to the next.

    By the exponential of ((A, B), (0, 0)) step, in powers of it halved until it is small (Taylor's series of order 18,
    squared again): both matrices at once, A singular or not. Van Loan 1978.

    Raises:
        InputError: the step is no positive finite number, or a mode grows beyond all numbers within it, or rounding
            leaves nothing: an angle is off by as many roundings as it has radians.
    """
    if isinstance(step, str) or not 0.0 < step < inf:
        raise InputError(f"the step is {step!r}, no positive finite number of seconds")
    size, inputs = found.B.shape
    whole = np.zeros((size + inputs, size + inputs))
    whole[:size, :size], whole[:size, size:] = found.A * step, found.B * step
    with np.errstate(all="ignore"):
        lost = not (np.isfinite(whole).all() and np.abs(found.A).max() * step < _LOST)
        E = whole if lost else _exponential(whole)
    if lost or not np.isfinite(E).all():
        raise InputError(f"the motion overflows within a step of {step:g} s", remedy="give shorter steps")
    return replace(found, A=E[:size, :size], B=E[:size, size:], step=step)


def _exponential(X: Floats) -> Floats:
    """Return exp(X), by exp(X) - 1, squared as (1 + F)^2 - 1 = 2 F + F F: beside 1 what is slow would be lost."""
    halvings = max(0, int(np.ceil(np.log2(max(float(np.abs(X).sum(axis=1).max()), 2.0**-60)))) + 1)
    small = X / 2.0**halvings
    term, out = np.eye(len(X)), np.zeros_like(X)
    for k in range(1, 19):
        term = product(term, small) / k
        out = out + term
    for _ in range(halvings):
        out = 2.0 * out + product(out, out)
    return np.asarray(np.eye(len(X)) + out)
