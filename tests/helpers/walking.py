"""Real robots that shift their weight and walk: base and feet are placed at some times, between which joints move by
minimum jerk.

The base stays level and may turn about the vertical; soles are level and do not turn where they are placed. Between
steps the base moves until the mass centre is about above the feet that stand.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BPoly

import robodyn
from helpers.example_robots import path_of, real
from helpers.peers import pin
from helpers.pinocchio_robots import PinocchioRobot
from robodyn.robot.kinematics import configuration
from robodyn.robot.model import Model
from robodyn.scene.scene import Contact, Scene
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.read import motion


@dataclass(frozen=True)
class Walker:
    """A robot and how it stands.

    Attributes:
        stem: of its description.
        feet: links by name, in the order of the steps.
        posture: of its joints whose names have these patterns [rad], the others being 0.
        stride, lift: of a step [m].
        sole: the points of each foot, in its link's frame [m].
    """

    stem: str
    feet: Mapping[str, str]
    posture: Mapping[str, float]
    stride: float
    lift: float
    sole: tuple[tuple[float, float, float], ...] = ((0.0, 0.0, 0.0),)

    @property
    def model(self) -> Model:
        return real(self.stem, moving_base=True)

    @cached_property
    def peer(self) -> PinocchioRobot:
        return PinocchioRobot(path_of(self.stem), free=True)

    def scene(self, **more: float) -> Scene:
        """Each foot stands where its column `on_<foot>` says so; more: of each Contact."""
        contacts = (Contact(name, link, self.sole, on=f"on_{name}", **more) for name, link in self.feet.items())
        return Scene(moving_base=True, contacts=tuple(contacts))

    def foot(self, q: np.ndarray, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the Jacobian (6, n), place (3,) and turn (3, 3) of the middle of a foot."""
        middle = np.mean(self.sole, axis=0)
        J, R = self.peer.point_jacobian(self.model, q, self.feet[name], middle)
        return J, self.peer.data.oMf[self.peer.model.getFrameId(self.feet[name])].act(middle), R

    def standing(self) -> np.ndarray:
        """Return q (nq,) of the posture, its feet at height 0."""
        angles = {
            name: angle
            for name in self.model.joint_names
            for pattern, angle in self.posture.items()
            if re.search(pattern, name)
        }
        q = np.array(configuration(self.model, angles))
        q[2] -= self.foot(q, next(iter(self.feet)))[1][2]
        return q

    def placed(self, q: np.ndarray, places: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return q whose feet are at these places (3,), by Newton's method; soles are level."""
        q, parts = q.copy(), 3 if len(self.sole) == 1 else 6
        for _ in range(8):
            for name, place in places.items():
                J, at, R = self.foot(q, name)
                leg = 6 + np.flatnonzero(J[:, 6:].any(axis=0))
                off = np.hstack((place - at, pin.log3(R.T)))[:parts]
                q[leg + 1] += np.linalg.pinv(J[:parts, leg], rcond=1e-8) @ off
        return q


@dataclass(frozen=True)
class Walk:
    """A motion: q (N, nq), qd and qdd (N, n), and the columns `on_<foot>` (N,)."""

    walker: Walker
    time: np.ndarray
    q: np.ndarray
    qd: np.ndarray
    qdd: np.ndarray
    columns: Mapping[str, np.ndarray]

    def trajectory(self, scene: Scene, more: Mapping[str, np.ndarray] | None = None) -> Trajectory:
        columns = {**self.columns, **(more or {})}
        known = {name: columns[name] for name in scene.motion_columns}
        return motion(self.walker.model, self.time, self.q, self.qd, self.qdd, scene=scene, columns=known)


SQUARE = ((-0.1, -0.06, 0.0), (0.1, -0.06, 0.0), (0.1, 0.06, 0.0), (-0.1, 0.06, 0.0))
WALKERS = {
    "Go2": Walker(
        "go2",
        {"rl": "RL_foot", "fl": "FL_foot", "rr": "RR_foot", "fr": "FR_foot"},
        {"thigh": 0.9, "calf": -1.8},
        stride=0.08,
        lift=0.05,
    ),
    "TALOS": Walker(
        "talos_full_v2",
        {"left": "left_sole_link", "right": "right_sole_link"},
        {"leg_.*_3": -0.45, "leg_.*_4": 0.9, "leg_.*_5": -0.45, "arm_left_2": 0.3, "arm_right_2": -0.3},
        stride=0.2,
        lift=0.06,
        sole=SQUARE,
    ),
}


def walk(walker: Walker, count: int, steps: int, turn: float) -> Walk:
    """Return `steps` steps, then a shift back, at `count` times; turn: of the base to and fro [rad]."""
    legs = len(walker.feet)
    shift, swing, over = (1.0, 0.8, 0.8) if legs == 4 else (2.0, 1.6, 1.0)
    q = walker.standing()
    at, begin = {name: walker.foot(q, name)[1] for name in walker.feet}, robodyn.momenta(walker.model, q).com
    frames, clock, lifts = {0.0: (begin, dict(at)), 0.2: (begin, dict(at))}, 0.2, []
    for step in range(steps):
        name = list(walker.feet)[step % legs]
        middle = np.mean([*at.values()], axis=0)
        over_others = middle + over * (np.mean([place for foot, place in at.items() if foot != name], axis=0) - middle)
        stride = np.array((walker.stride * (0.5 if step == 0 and legs == 2 else 1.0), 0.0, 0.0))
        lifts.append((name, clock + shift, clock + shift + swing))
        frames[clock + shift] = over_others, dict(at)
        frames[clock + shift + 0.5 * swing] = (
            over_others,
            {**at, name: at[name] + 0.5 * stride + (0.0, 0.0, walker.lift)},
        )
        at[name] = at[name] + stride
        clock += shift + swing
        frames[clock] = over_others, dict(at)
    frames[clock + shift] = frames[clock + shift + 0.2] = np.mean([*at.values()], axis=0), at
    return followed(walker, q, frames, lifts, count, turn)


def sway(walker: Walker, count: int, by: float, turn: float) -> Walk:
    """Return a shift of the weight by (by / 2, by) m and back; it begins and ends at rest, and feet stay."""
    q = walker.standing()
    at, begin = {name: walker.foot(q, name)[1] for name in walker.feet}, robodyn.momenta(walker.model, q).com
    there = begin + np.array((0.5 * by, by, 0.0))
    frames = {time: (there if time == 1.2 else begin, at) for time in (0.0, 1.2, 2.4)}
    return followed(walker, q, frames, [], count, turn)


def followed(walker, q, frames, lifts, count, turn) -> Walk:
    """Return the motion at `count` times through frames: by time the mass centre and the feet."""
    begin, moved, times = robodyn.momenta(walker.model, q).com, [], list(frames)
    for time, (centre, places) in frames.items():
        yaw = turn * np.sin(np.pi * time / times[-1])
        base = [*(q[:2] + (centre - begin)[:2]), q[2], 0.0, 0.0, np.sin(0.5 * yaw), np.cos(0.5 * yaw)]
        moved.append([*base[:3], yaw, *walker.placed(np.hstack((base, q[7:])), places)[7:]])
    levels = np.stack((moved, 0.0 * np.array(moved), 0.0 * np.array(moved)), axis=1)
    path, time = BPoly.from_derivatives(times, levels), np.linspace(0.0, times[-1], count)
    x, v, a = (path(time, order) for order in range(3))
    zero, half = np.zeros((count, 2)), 0.5 * x[:, 3:4]
    rates = (np.hstack((zero, rate[:, 3:4], rate[:, :3], rate[:, 4:])) for rate in (v, a))
    columns = {f"on_{name}": np.ones(count) for name in walker.feet}
    for name, start, end in lifts:
        columns[f"on_{name}"][(time > start) & (time < end)] = 0.0
    return Walk(walker, time, np.hstack((x[:, :3], zero, np.sin(half), np.cos(half), x[:, 4:])), *rates, columns)
