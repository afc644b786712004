"""Periodic motions within limits: what they must keep to, what they reach, and how they are made smaller to keep it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.effects.friction import friction_of
from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.errors import InputError
from robodyn.robot.limits import MOST_EFFORT, MOST_VELOCITY, binding, coordinate_ranges
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats, einsum
from robodyn.support.wording import alternatives, count

MARGIN = 0.05  # of a joint's range that the motion keeps from each limit of position
PERIOD_SAMPLES = 64  # per harmonic: where a motion is held against its limits
_SPEEDING = 0.25
"""In so many seconds a joint may reach its limit of speed, where no limit of acceleration is given [s]."""
_FAR, _NEAR = 1e4, 1e-6
"""Limits of position from which on they stand for "none", and room or speed that is none [rad, m, rad/s, m/s]."""
_RANGE, _SPEED = {"revolute": pi, "prismatic": 0.25}, {"revolute": pi, "prismatic": 0.5}
"""Where there is no limit: to each side of 0 [rad, m], and [rad/s, m/s]."""
_UNIT = {"revolute": "rad", "prismatic": "m"}
_SMALLER, _LEAST = 0.99, 1e-3  # by steps of which a motion is made smaller, and to which part of it at most


@dataclass(frozen=True, eq=False)
class Bounds:
    """Of each entry of q (n,), for a robot whose joints have one each: positions are within `middle +- half`, the
    margin taken off; speed, acceleration, effort: largest magnitudes, inf where there is none; moving: which joints
    move, the others are held at `home`; notes: what was assumed."""

    middle: Floats
    half: Floats
    speed: Floats
    acceleration: Floats
    effort: Floats
    moving: tuple[int, ...]
    home: Floats
    notes: tuple[str, ...]


def bounds_of(model: Model, scene: Scene, joints: tuple[str, ...] = (), acceleration: float | None = None) -> Bounds:
    """Return what motions of these joints, of all if none is named, must keep to; acceleration: largest, of every joint
    [rad/s^2, m/s^2], None: speed limit over `_SPEEDING`. Raise InputError if the base floats, there is no such joint,
    or none that can move."""
    if model.quaternions:
        what = f'"{model.quaternions[0][0]}" floats: nothing drives it along a motion'
        raise InputError(what, remedy="fix it", file=model.file)
    for name in joints:
        if name not in model.joint_names:
            remedy = alternatives(name, model.joint_names, "joints that have a coordinate")
            raise InputError(f"there is no joint {name!r} to move", remedy=remedy)
    notes: list[str] = []

    def say(these: NDArray[np.bool_], what: str) -> None:
        names = [joint.name for joint, each in zip(model.independent, these, strict=True) if each]
        if names:
            notes.append(f"{count(len(names), 'joint')} ({', '.join(names)}): {what}")

    are = {kind: np.array([joint.kind == kind for joint in model.independent], dtype=bool) for kind in _RANGE}
    least, largest = (np.where(np.abs(end) < _FAR, end, np.nan) for end in coordinate_ranges(model))
    endless = np.isnan(least) | np.isnan(largest)
    for kind, width in _RANGE.items():
        say(endless & are[kind], f"no position limits: {width:.4g} {_UNIT[kind]} to each side")
    most = np.array([_RANGE[joint.kind] for joint in model.independent])
    least = np.where(np.isfinite(least), least, np.where(np.isfinite(largest), largest - 2.0 * most, -most))
    largest = np.where(np.isfinite(largest), largest, least + 2.0 * most)
    half, speed = (0.5 - MARGIN) * (largest - least), np.full(model.n, np.inf)
    for joint in (body.joint for body in model.bodies):
        limit = binding(joint.velocity)
        if limit is not None and limit < MOST_VELOCITY and joint.kind != "fixed" and joint.multiplier:
            speed[joint.rate] = min(speed[joint.rate], limit / abs(joint.multiplier))
    for kind, assumed in _SPEED.items():
        these = np.isinf(speed) & are[kind]
        say(these, f"no speed limit: {assumed:.4g} {_UNIT[kind]}/s assumed")
        speed[these] = assumed
    effort = np.array([binding(joint.effort) or np.inf for joint in model.independent])
    effort[effort >= MOST_EFFORT] = np.inf
    say(effort == np.inf, "no effort limit: any torque is allowed")
    wanted = np.array([not joints or joint.name in joints for joint in model.independent], dtype=bool)
    narrow = wanted & (np.minimum(half, speed) < _NEAR)
    weak = wanted & (np.array([friction_of(joint, scene).dry for joint in model.independent]) >= effort)
    say(narrow, "held: its limits leave no room")
    say(weak, "held: friction alone takes its effort limit")
    moving = tuple(np.flatnonzero(wanted & ~narrow & ~weak).tolist())
    if not moving:
        raise InputError("no joint can move", remedy="; ".join(notes) or "none is described", file=model.file)
    middle = 0.5 * (least + largest)
    home = np.where((least <= 0.0) & (largest >= 0.0), 0.0, middle)
    fastest = speed / _SPEEDING if acceleration is None else np.full(model.n, acceleration)
    return Bounds(middle, half, speed, fastest, effort, moving, home, tuple(notes))


@dataclass(frozen=True)
class Fourier:
    """q(t) = c + sum a_k sin(k w t) + b_k cos(k w t) for k = 1..harmonics, with speed and acceleration zero at t = 0.

    That is so if sum k a_k = 0 and sum k^2 b_k = 0 (Swevers and others 1997), and it is so in the shapes that follow,
    by which motions are combined: 1, sin(k w t)/k - sin((k+1) w t)/(k+1), cos(k w t)/k^2 - cos((k+1) w t)/(k+1)^2.

    With w = 2 pi / period [s] and two harmonics or more.
    """

    period: float
    harmonics: int

    @property
    def size(self) -> int:
        """How many shapes there are."""
        return 2 * self.harmonics - 1

    def even(self, samples: int) -> Floats:
        """Return so many times of a period, evenly from 0 on [s]."""
        return np.asarray(np.arange(samples) * (self.period / samples))

    def _waves(self, time: Floats) -> Floats:
        """Return q, qd and qdd of sin(k w t) / k and cos(k w t) / k^2: (2, 3, N, harmonics)."""
        k = np.arange(1, self.harmonics + 1)
        w = k * (2.0 * pi / self.period)
        sine, cosine = np.sin(np.outer(time, w)), np.cos(np.outer(time, w))
        return np.array([[sine, w * cosine, -w * w * sine] / k, [cosine, -w * sine, -w * w * cosine] / (k * k)])

    def shapes(self, time: Floats) -> Floats:
        """Return q, qd and qdd of every shape: (3, N, size)."""
        waves = self._waves(time)
        return np.concatenate((_still(time), *(waves[..., :-1] - waves[..., 1:])), axis=-1)

    def coefficients(self, x: Floats) -> tuple[Floats, Floats, Floats]:
        """Return c (n,), a (n, harmonics) and b of combinations x (n, size) of the shapes."""
        k = np.arange(1, self.harmonics + 1)
        parts = np.split(x[:, 1:], 2, axis=1)
        of_sines, of_cosines = (np.diff(np.pad(part, ((0, 0), (1, 1))), axis=1) for part in parts)
        return x[:, 0], of_sines / k, of_cosines / (k * k)

    def between(self, samples: int) -> float:
        """Return how many times larger than at even samples of a period |q - c|, |qd| or |qdd| can be between them:
        1 / cos(pi n / N) for degree n at N > 2 n points (Ehlich and Zeller 1964)."""
        return 1.0 / cos(pi * self.harmonics / samples)


class PlainWaves(Fourier):
    """A plain wave for each joint: shapes are 1, and -cos(k w t) with k = 1..harmonics."""

    def shapes(self, time: Floats) -> Floats:
        k = np.arange(1, self.harmonics + 1)
        return np.concatenate((_still(time), -k * k * self._waves(time)[1]), axis=-1)


def _still(time: Floats) -> Floats:
    """Return q, qd and qdd of a joint that stands at 1: (3, N, 1)."""
    still = np.zeros((3, len(time), 1))
    still[0] = 1.0
    return still


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

    def at(self, time: Floats) -> Floats:
        """Return q, qd and qdd (3, N, n)."""
        motion = np.zeros((3, len(time), self.model.n))
        motion[0] = self.bounds.home
        motion[:, :, list(self.bounds.moving)] = einsum("kti,ni->ktn", self.series.shapes(time), self.x)
        return motion

    def peaks(self) -> Peaks:
        """Return what it reaches at even samples, times what Ehlich and Zeller's bound adds. Of torques, an eighth of
        the largest second difference is added: what a parabola reaches between samples."""
        samples = PERIOD_SAMPLES * self.series.harmonics
        q, qd, qdd = self.at(self.series.even(samples))
        tau = inverse_dynamics(self.model, q, qd, qdd, scene=self.scene, executor="numpy")
        bends = np.abs(tau - 0.5 * (np.roll(tau, 1, axis=0) + np.roll(tau, -1, axis=0))).max(axis=0) / 4.0
        more = self.series.between(samples)
        centre = self.bounds.home.copy()
        centre[list(self.bounds.moving)] = self.x[:, 0]
        return Peaks(
            centre + more * (q - centre).min(axis=0),
            centre + more * (q - centre).max(axis=0),
            more * np.abs(qd).max(axis=0),
            more * np.abs(qdd).max(axis=0),
            np.abs(tau).max(axis=0) + bends,
        )


def within_limits(motion: Motion) -> Motion:
    """Return the motion, swinging as much less about its centre as keeps all limits at all times (of joints that stand
    those of efforts); raise InputError if however little it swings, it exceeds one."""
    size, bounds, k = 1.0, motion.bounds, list(motion.bounds.moving)
    low, high = (bounds.middle - bounds.half)[k], (bounds.middle + bounds.half)[k]
    while size > _LEAST:
        x = motion.x * size
        x[:, 0] = motion.x[:, 0]
        smaller = replace(motion, x=x)
        peaks = smaller.peaks()
        ranged = (peaks.least[k] >= low).all() and (peaks.largest[k] <= high).all()
        quick = (peaks.speed <= bounds.speed).all() and (peaks.acceleration <= bounds.acceleration).all()
        if ranged and quick and (peaks.effort <= bounds.effort).all():
            return smaller
        size *= _SMALLER
    raise InputError("efforts leave no room for a motion", remedy="check limits and masses, or move fewer joints")


def plain_waves(found: Motion) -> Motion:
    """Return a plain motion to compare with: c - h cos(k w t) with the harmonics 1, 2, ... joint by joint in turn. Each
    is as large as its limits of position, speed and acceleration allow, all as much smaller as efforts need."""
    series, bounds, centre = found.series, found.bounds, found.x[:, 0]
    x = np.zeros((len(centre), series.harmonics + 1))
    x[:, 0] = centre
    for i, k in enumerate(bounds.moving):
        turn = i % series.harmonics
        w = (turn + 1) * 2.0 * np.pi / series.period
        room = bounds.half[k] - abs(centre[i] - bounds.middle[k])
        largest = min(room, bounds.speed[k] / w, bounds.acceleration[k] / (w * w))
        x[i, turn + 1] = largest / series.between(PERIOD_SAMPLES * series.harmonics)
    waves = PlainWaves(series.period, series.harmonics)
    return within_limits(replace(found, series=waves, x=x))
