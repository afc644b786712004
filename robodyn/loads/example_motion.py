"""A motion for a robot that has none yet: every joint swings within its limits of position, speed and effort."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi

import numpy as np

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.robot.limits import binding, coordinate_ranges
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats, first_largest

DURATION, RATE = 10.0, 200.0  # seconds, and samples per second
_SWING = {"revolute": 0.5, "prismatic": 0.1}  # largest distance from the middle of a swing [rad, m]
_SHARE = 0.4  # of the range and of the largest speed that a swing takes
_CLEAR = 1.1  # half-widths from the middle to a limit, so that a swing does not touch it
_PERIODS = (1, 2, 3)  # in the duration, joint by joint in turn, so that they do not move in step
_MOST, _RESTING = 0.95, 0.8
"""Of the limits of effort that the motion may take, and that standing in the middle of it may, if any pose allows."""
_SMALLER, _LEAST = 0.7, 0.01
"""Times the swings, until efforts are within limits; and the smallest swings that are tried, of the first."""
_POSITIONS, _CHANGES = 9, 40
"""Of a joint that are tried to make the robot lighter, and how often one of its joints is moved for that."""


@dataclass(frozen=True, eq=False)
class _Swings:
    """`q = c - h cos(w t)`: middle, half-width and angular frequency of each coordinate (nq,)."""

    model: Model
    c: Floats
    h: Floats
    w: Floats

    def at(self, time: Floats) -> tuple[Floats, Floats, Floats]:
        phase, h, w = np.outer(time, self.w), self.h, self.w
        moving = [joint for joint in self.model.independent if joint.kind != "floating"]
        places, rates = [joint.coordinate for joint in moving], [joint.rate for joint in moving]
        qd, qdd = np.zeros((2, len(time), self.model.n))
        qd[:, rates] = (h * w * np.sin(phase))[:, places]
        qdd[:, rates] = (h * w * w * np.cos(phase))[:, places]
        return self.c - h * np.cos(phase), qd, qdd


def example_motion(model: Model, scene: Scene = DEFAULT) -> tuple[tuple[str, ...], Floats, Floats]:
    """Return an example for `torques`: `q = c - h cos(w t)`, at rest at both ends, with exact speeds and accelerations.

    The middle c is zero, or as near to it as the swing stays within the limits; a base that floats stands still. Where
    standing there takes more than 80 % of a joint's limit of effort, joints are moved one by one to where it takes
    less; where the motion takes more than 95 %, all swings are made smaller, and joints whose friction alone takes more
    stand still.

    Args:
        scene: what the torques are computed in; columns that its wrenches name are zero.

    Returns:
        Names of columns, time (N,) and columns (N, k): `q_`, `qd_`, `qdd_` of every coordinate and rate, and the
        scene's.
    """
    time = np.arange(int(DURATION * RATE) + 1) / RATE
    q, qd, qdd = _within_effort(_first(model), scene, time[:: len(_PERIODS) + 1]).at(time)
    names = [f"q_{name}" for name in model.coordinates]
    names += [f"{kind}_{name}" for kind in ("qd", "qdd") for name in model.rates]
    return (*names, *scene.columns), time, np.hstack((q, qd, qdd, np.zeros((len(time), len(scene.columns)))))


def overloaded(model: Model, scene: Scene, columns: Floats) -> list[str]:
    """Return a line for each joint that the columns of an example overload, or leave where it is."""
    q, qd, qdd, _ = np.split(columns, np.cumsum((model.nq, model.n, model.n)), axis=1)
    efforts, (least, largest), lines = _efforts(model, scene, q, qd, qdd), _ranges(model), []
    for joint in model.independent:
        limit, unit = f"{joint.effort or 0.0:g}", "N" if joint.kind == "prismatic" else "N m"
        if efforts[joint.rate] > 1.0:
            takes = f"{efforts[joint.rate] * (joint.effort or 0.0):.4g} of {limit} {unit}"
            lines.append(f'the example exceeds the effort limit of "{joint.name}", {takes}: so does standing still')
        elif joint.kind != "floating" and not qd[:, joint.rate].any():
            room = least[joint.coordinate] < largest[joint.coordinate]
            why = f"moving takes more than its limit of {limit} {unit}" if room else "its limits leave no room"
            lines.append(f'"{joint.name}" stands still in the example: {why}')
    return lines


def _first(model: Model) -> _Swings:
    least, largest = _ranges(model)
    c, h, w = np.zeros(model.nq), np.zeros(model.nq), np.zeros(model.nq)
    speed = np.full(model.nq, np.inf)
    for body in model.bodies:
        limit = binding(body.joint.velocity)
        if limit is not None and body.joint.kind in ("revolute", "prismatic") and body.joint.multiplier:
            at = body.joint.coordinate
            speed[at] = min(speed[at], limit / abs(body.joint.multiplier))
    for k, joint in enumerate(model.independent):
        at = joint.coordinate
        if joint.kind == "floating":
            c[at + 6] = 1.0
            continue
        w[at] = 2.0 * pi * _PERIODS[k % len(_PERIODS)] / DURATION
        h[at] = min(_SWING.get(joint.kind, 0.1), _SHARE * (largest[at] - least[at]), _SHARE * speed[at] / w[at])
        c[at] = min(max(0.0, least[at] + _CLEAR * h[at]), largest[at] - _CLEAR * h[at])
    return _Swings(model, c, h, w)


def _ranges(model: Model) -> tuple[Floats, Floats]:
    """Return the least and largest positions; those that exclude each other are no limits."""
    least, largest = coordinate_ranges(model)
    wrong = least > largest
    return np.where(wrong, -pi, least), np.where(wrong, pi, largest)


def _within_effort(swings: _Swings, scene: Scene, time: Floats) -> _Swings:
    """Return the swings about a pose that efforts allow, as large as they allow."""
    model = swings.model
    if _efforts(model, scene, *swings.at(time)).max(initial=0.0) <= _MOST:
        return swings
    lighter = replace(swings, c=_lighter(swings, scene), h=swings.h.copy())
    able = _efforts(model, scene, lighter.c[None], 0.0, 0.0) <= _MOST
    creeping = _efforts(model, scene, *replace(lighter, h=_LEAST * lighter.h).at(time))
    stuck = [joint.coordinate for joint in model.independent if able[joint.rate] and creeping[joint.rate] > _MOST]
    lighter.h[stuck] = 0.0
    size = 1.0
    while True:
        smaller = replace(lighter, h=size * lighter.h)
        if size < _LEAST or _efforts(model, scene, *smaller.at(time))[able].max(initial=0.0) <= _MOST:
            return smaller
        size *= _SMALLER


def _lighter(swings: _Swings, scene: Scene) -> Floats:
    """Return the middle with joints moved, one by one, to where standing takes less of the limits of effort."""
    model, c = swings.model, swings.c
    least, largest = _ranges(model)
    low, high = np.maximum(least + _CLEAR * swings.h, -pi), np.minimum(largest - _CLEAR * swings.h, pi)
    places = np.flatnonzero(swings.h)
    for _ in range(_CHANGES):
        poses = np.repeat(c[None], 1 + len(places) * _POSITIONS, axis=0)  # the first is as it is
        for k, at in enumerate(places):
            poses[1 + k * _POSITIONS : 1 + (k + 1) * _POSITIONS, at] = np.linspace(low[at], high[at], _POSITIONS)
        excess = np.maximum(_efforts(model, scene, poses, 0.0, 0.0, each=True) - _RESTING, 0.0)
        tried = (excess**2).sum(axis=1)
        best = 1 + first_largest(-tried[1:]) if len(places) else 0
        if tried[0] == 0.0 or not tried[best] < tried[0] * (1.0 - 1e-6):
            break
        c = poses[best]
    return c


def _efforts(
    model: Model, scene: Scene, q: Floats, qd: Floats | float, qdd: Floats | float, each: bool = False
) -> Floats:
    """Return (n,) the largest torque of each joint over its limit, 0 where there is none; of each sample if asked."""
    limits = np.full(model.n, np.inf)
    for joint in model.independent:
        if joint.kind != "floating":
            limits[joint.rate] = binding(joint.effort) or np.inf
    zero = dict.fromkeys(scene.columns, np.zeros(len(q)))
    tau = inverse_dynamics(model, q, qd, qdd, scene=scene, columns=zero, executor="numpy")
    found: Floats = np.abs(tau) / limits
    return found if each else found.max(axis=0, initial=0.0)
