"""How measured torques depend on faults: residuals and their derivatives, joint by joint."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

OWN = ("gain", "offset", "viscous", "coulomb", "rotor", "delay")
"""The parameters of each joint, in order: `gain` is relative, less one."""
GAIN, OFFSET, VISCOUS, COULOMB, ROTOR, DELAY = range(len(OWN))
LOST = 0.01
"""A gain below this tells nothing of the robot."""
MOST_DELAY = 0.25
"""s: delays are looked for within this, and within a tenth of the log."""


@dataclass(frozen=True)
class Evidence:
    """Torques and what may explain their difference, all through the same filter, on an even grid.

    Attributes:
        step: s, of the grid.
        measured, computed: (k, n) N m.
        own: (k, n, 3) torque of each joint per unit of its viscous friction, Coulomb friction and rotor inertia.
        load: (k, n, m) torques per unit of the parameters of a payload.
    """

    step: float
    measured: Floats
    computed: Floats
    own: Floats
    load: Floats

    @property
    def joints(self) -> int:
        return int(self.measured.shape[1])

    @property
    def parameters(self) -> int:
        """Of the joints, `OWN` of each, and then of the payload."""
        return int(len(OWN) * self.joints + self.load.shape[2])

    @property
    def margin(self) -> int:
        """Samples at either end that delays may move beyond the log."""
        k = len(self.measured)
        return int(min(MOST_DELAY / self.step, 0.1 * k)) + 1

    @property
    def inside(self) -> slice:
        return slice(self.margin, len(self.measured) - self.margin)

    @cached_property
    def splines(self) -> list[Any]:
        """The measured torques at any time, in samples."""
        from scipy.interpolate import make_interp_spline

        at = np.arange(len(self.measured), dtype=float)
        return [make_interp_spline(at, column, k=5) for column in self.measured.T]

    def shifted(self, joint: int, delay: float) -> Floats:
        """Return the measured torque a delay [s] later, inside."""
        at = np.arange(len(self.measured), dtype=float)[self.inside] + delay / self.step
        return np.asarray(self.splines[joint](at))

    def places(self, joint: int) -> list[int]:
        """Return the places of the parameters that a joint feels."""
        own = len(OWN) * self.joints
        return [*range(len(OWN) * joint, len(OWN) * (joint + 1)), *range(own, own + self.load.shape[2])]


def rms(values: Floats) -> Floats:
    """Return the root mean square of each column."""
    return np.asarray(np.sqrt(einsum("ki,ki->i", values, values) / len(values)))


def columns(evidence: Evidence, theta: Floats) -> tuple[list[Floats], Floats]:
    """Return derivatives of the model, for each joint (N, 6 + m), and what the model leaves of the torques (N, n).

    `measured(t + delay) = (1 + gain) (computed + load)(t) + own(t) + offset`; the derivative for the delay is
    `-d(measured)/dt`, by the model.
    """
    from scipy.interpolate import make_interp_spline

    found, left, inside = [], [], evidence.inside
    at = np.arange(len(evidence.measured), dtype=float)
    for j in range(evidence.joints):
        mine = theta[evidence.places(j)]
        gain, own, load = 1.0 + mine[GAIN], mine[VISCOUS : ROTOR + 1], mine[len(OWN) :]
        inner = evidence.computed[:, j] + einsum("ki,i->k", evidence.load[:, j], load)
        whole = gain * inner + einsum("ki,i->k", evidence.own[:, j], own)
        rate = make_interp_spline(at, whole, k=5).derivative()(at) / evidence.step
        per = [inner, np.ones(len(at)), *evidence.own[:, j].T, -rate, *(gain * evidence.load[:, j]).T]
        found.append(np.stack(per, axis=1)[inside])
        left.append(evidence.shifted(j, mine[DELAY]) - whole[inside] - mine[OFFSET])
    return found, np.stack(left, axis=1)


def additive(evidence: Evidence, theta: Floats) -> tuple[list[Floats], Floats]:
    """Return columns of which `theta` makes exactly what is explained of measured less computed, and that difference.

    As `columns`, with the secant of the delay in place of its derivative, and the gain's column with all that it
    scales.
    """
    found, _ = columns(evidence, theta)
    inside = evidence.inside
    for j, each in enumerate(found):
        mine = theta[evidence.places(j)]
        delay = mine[DELAY]
        each[:, len(OWN) :] = evidence.load[inside, j]
        if delay:
            each[:, DELAY] = (evidence.measured[inside, j] - evidence.shifted(j, delay)) / delay
    return found, (evidence.measured - evidence.computed)[inside]


def of_robot(theta: Floats, covariance: Floats, gains: Collection[int]) -> tuple[Floats, Floats]:
    """Return parameters and their covariance with friction and rotors of the robot, before the gain of its sensor.

    Args:
        gains: the joints whose gain was told; that of the others is taken for 1, as is a gain of next to nothing.
    """
    rate, found = np.eye(len(theta)), theta.copy()
    for j in gains:
        gain = len(OWN) * j + GAIN
        if abs(1.0 + theta[gain]) < LOST:
            continue
        own = [len(OWN) * j + kind for kind in (VISCOUS, COULOMB, ROTOR)]
        found[own] /= 1.0 + theta[gain]
        rate[own, own] = 1.0 / (1.0 + theta[gain])
        rate[own, gain] = -found[own] / (1.0 + theta[gain])
    return found, einsum("ia,ab,jb->ij", rate, covariance, rate, optimize=True)


def first_delays(evidence: Evidence) -> Floats:
    """Return the delay of each joint [s] at which all other effects leave least, to a sample; 0 unless it is clear.

    It is clear if it leaves `_CLEAR` less than no delay does.
    """
    zero, left = columns(evidence, np.zeros(evidence.parameters))
    found = np.zeros(evidence.joints)
    margin = evidence.margin
    shifts = np.arange(1 - margin, margin)
    for j, each in enumerate(zero):
        own = np.delete(each, DELAY, axis=1)
        size = np.sqrt(einsum("ki,ki->i", own, own))
        basis = np.linalg.svd(own[:, size > 0] / size[size > 0], full_matrices=False)
        Q = basis[0][:, basis[1] > 1e-6 * basis[1][0]]
        windows = np.lib.stride_tricks.sliding_window_view(evidence.measured[:, j], len(left))[1:-1]
        whole = einsum("sk,sk->s", windows, windows)
        rest = whole - (np.square(einsum("sk,kq->sq", windows, Q))).sum(axis=1)
        best = int(np.argmin(rest))
        if rest[best] < (1.0 - _CLEAR) * rest[margin - 1]:
            found[j] = shifts[best] * evidence.step
    return found


_CLEAR = 0.05
