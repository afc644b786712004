"""The result of `excite`: the motion, what each joint does, and what the torques will tell."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import exp
from typing import NamedTuple

import numpy as np

from robodyn.identification.excitation.fourier import Fourier
from robodyn.identification.parameters.base import Base
from robodyn.robot.model import Model
from robodyn.support.floats import Floats


class Information(NamedTuple):
    """What the torques of a motion tell of the base parameters.

    Attributes:
        rank: how many of them it shows.
        condition: of the base columns at unit length, rows weighted by 1 / noise.
        log_determinant: of sum Y^T W Y over the rows, in SI units; -inf where some are not shown.
        standard_errors: (r,) of each by least squares, with noise that is independent from row to row.
    """

    rank: int
    condition: float
    log_determinant: float
    standard_errors: Floats


@dataclass(frozen=True)
class JointSwing:
    """What a joint does: `centre + sum sine_k sin(k w t) + cosine_k cos(k w t)`.

    Attributes:
        unit: of torques.
        least, largest, speed, acceleration, effort: reached at any time.
        bounds: between which it stays: limits of position, less a margin; None if it has no room.
        effort_limit: None where there is none.
        noise: standard deviation of its torque.
    """

    name: str
    unit: str
    moves: bool
    centre: float
    sine: tuple[float, ...]
    cosine: tuple[float, ...]
    least: float
    largest: float
    bounds: tuple[float, float] | None
    speed: float
    speed_limit: float
    acceleration: float
    acceleration_limit: float
    effort: float
    effort_limit: float | None
    noise: float


@dataclass(frozen=True, eq=False)
class Excitation:
    """A motion that shows parameters.

    Attributes:
        rate: rows per second of `motion`.
        base: the base parameters that motions of these joints can show; values: theirs in the description.
        information, plain: of this motion, and of plain waves of the same period within the same limits.
        notes: what was assumed.
        motion, torques: q, qd and qdd (3, N, n), a period with both its ends; and what they take (N, n).
    """

    model: Model
    series: Fourier
    rate: float
    joints: tuple[JointSwing, ...]
    base: Base
    values: Floats
    information: Information
    plain: Information
    notes: tuple[str, ...]
    motion: Floats
    torques: Floats

    @property
    def gain(self) -> float:
        """How many times smaller standard errors are than those of plain waves, in the geometric mean."""
        gained = self.information.log_determinant - self.plain.log_determinant
        return exp(gained / (2 * self.base.rank)) if gained < float("inf") else gained

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The columns of `columns`."""
        return tuple(f"{kind}_{name}" for kind in ("q", "qd", "qdd") for name in self.model.joint_names)

    @property
    def time(self) -> Floats:
        """(N,) [s]."""
        return np.asarray(np.arange(self.motion.shape[1]) / self.rate)

    @property
    def columns(self) -> Floats:
        """(N, 3 n)."""
        return self.motion.transpose(1, 0, 2).reshape(self.motion.shape[1], -1)
