"""Periodic motions within limits: what they reach, and how they are made smaller until they keep them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.errors import InputError
from robodyn.identification.excitation.bounds import Bounds
from robodyn.identification.excitation.fourier import Fourier
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

PERIOD_SAMPLES = 64
"""Per harmonic: where a motion is held against its limits."""
_SMALLER, _LEAST = 0.99, 1e-3
"""By steps of which a motion is made smaller, and to which part of it at most."""


class Peaks(NamedTuple):
    """The most that a motion reaches at any time, each (n,); with what may lie between the samples."""

    least: Floats
    largest: Floats
    speed: Floats
    acceleration: Floats
    effort: Floats


@dataclass(frozen=True, eq=False)
class Motion:
    """q(t) of a robot: combinations x (m, size) of the shapes of a series; joints that do not move stand at home."""

    model: Model
    scene: Scene
    bounds: Bounds
    series: Fourier
    x: Floats

    @property
    def centre(self) -> Floats:
        """The mean position of each joint that moves (m,)."""
        return self.x[:, 0]

    def at(self, time: Floats) -> Floats:
        """Return q, qd and qdd (3, N, n)."""
        motion = np.zeros((3, len(time), self.model.n))
        motion[0] = self.bounds.home
        motion[:, :, list(self.bounds.moving)] = einsum("kti,ni->ktn", self.shapes(time), self.x)
        return motion

    def shapes(self, time: Floats) -> Floats:
        """Return q, qd and qdd of every shape: (3, N, size)."""
        return self.series.shapes(time)

    def peaks(self) -> Peaks:
        """Return what it reaches at even samples, times what Ehlich and Zeller's bound adds.

        Of torques, an eighth of the largest second difference is added: what a parabola reaches between samples.
        """
        samples = PERIOD_SAMPLES * self.series.harmonics
        q, qd, qdd = self.at(self.series.even(samples))
        tau = inverse_dynamics(self.model, q, qd, qdd, scene=self.scene, executor="numpy")
        bends = np.abs(tau - 0.5 * (np.roll(tau, 1, axis=0) + np.roll(tau, -1, axis=0))).max(axis=0) / 4.0
        more = self.series.between(samples)
        centre = self.bounds.home.copy()
        centre[list(self.bounds.moving)] = self.centre
        return Peaks(
            centre + more * (q - centre).min(axis=0),
            centre + more * (q - centre).max(axis=0),
            more * np.abs(qd).max(axis=0),
            more * np.abs(qdd).max(axis=0),
            np.abs(tau).max(axis=0) + bends,
        )

    def keeps_limits(self) -> bool:
        """Return whether it is within all bounds at all times; joints that stand need be within their efforts only."""
        peaks, bounds, k = self.peaks(), self.bounds, list(self.bounds.moving)
        low, high = (bounds.middle - bounds.half)[k], (bounds.middle + bounds.half)[k]
        ranged = (peaks.least[k] >= low).all() and (peaks.largest[k] <= high).all()
        quick = (peaks.speed <= bounds.speed).all() and (peaks.acceleration <= bounds.acceleration).all()
        return bool(ranged and quick and (peaks.effort <= bounds.effort).all())


def within_limits(motion: Motion) -> Motion:
    """Return the motion, swinging as much less about its centre as keeps all limits.

    Raises:
        InputError: however little it swings, it exceeds one.
    """
    size = 1.0
    while size > _LEAST:
        x = motion.x * size
        x[:, 0] = motion.centre
        smaller = replace(motion, x=x)
        if smaller.keeps_limits():
            return smaller
        size *= _SMALLER
    raise InputError("efforts leave no room for a motion", remedy="check limits and masses, or move fewer joints")


class Sine(Motion):
    """Each joint is a plain wave: x has its centre, and amplitudes of 1 - cos(k w t) with k = 1..harmonics."""

    def shapes(self, time: Floats) -> Floats:
        k = np.arange(1, self.series.harmonics + 1) * (2.0 * np.pi / self.series.period)
        phase = np.outer(time, k)
        waves = np.array([-np.cos(phase), k * np.sin(phase), k * k * np.cos(phase)])
        still = np.zeros((3, len(time), 1))
        still[0] = 1.0
        return np.concatenate((still, waves), axis=-1)


def sine(model: Model, scene: Scene, bounds: Bounds, series: Fourier, centre: Floats) -> Motion:
    """Return a plain motion to compare with: c - h cos(k w t) with the harmonics 1, 2, ... joint by joint in turn.

    Each is as large as its limits of position, speed and acceleration allow, all as much smaller as efforts need.
    """
    moving = list(bounds.moving)
    x = np.zeros((len(moving), series.harmonics + 1))
    x[:, 0] = centre
    for i, k in enumerate(moving):
        turn = i % series.harmonics
        w = (turn + 1) * 2.0 * np.pi / series.period
        room = bounds.half[k] - abs(centre[i] - bounds.middle[k])
        x[i, turn + 1] = min(room, bounds.speed[k] / w, bounds.acceleration[k] / (w * w)) / series.between(
            PERIOD_SAMPLES * series.harmonics
        )
    return within_limits(Sine(model, scene, bounds, series, x))
