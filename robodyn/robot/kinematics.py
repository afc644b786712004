"""Kinematics for any scalar: the motion of each joint from its coordinates, the outward recursions from it; and what a
configuration is: values of coordinates by name, limits that it exceeds, where the links then are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from robodyn.errors import InputError
from robodyn.programs.vectors import (
    IDENTITY,
    ZERO,
    Array,
    Scalar,
    cross,
    narrowed,
    rotation_about,
    rotation_from_quaternion,
    vector,
)
from robodyn.robot.model import Joint, Model
from robodyn.support.floats import Floats
from robodyn.support.wording import alternatives, count, listed, shown

Values = Sequence[float] | Mapping[str, float]

_UNITS = {"revolute": "rad", "prismatic": "m"}


class Motion(NamedTuple):
    """How a body moves relative to its parent; see `joint_motion`.

    Attributes:
        R: rotation that takes components in the body's axes to the parent's.
        p: the body's origin from the parent's, in the parent's axes [m].
        w, v: relative angular and linear velocity, in the body's axes [rad/s, m/s].
        wd, a: their rates as seen from the parent, in the body's axes [rad/s^2, m/s^2].
    """

    R: Array
    p: Array
    w: Array
    v: Array
    wd: Array
    a: Array


REST = Motion(IDENTITY, ZERO, ZERO, ZERO, ZERO, ZERO)


def joint_motion(joint: Joint, q: Sequence[Scalar], qd: Sequence[Scalar], qdd: Sequence[Scalar]) -> Motion:
    """Return how the joint moves its body relative to the parent body.

    Revolute: `R = R_0 rot(axis, q)`, `w = axis qd`, `wd = axis qdd`. Prismatic: `p = p_0 + R_0 axis q`, `v = axis qd`,
    `a = axis qdd`. Floating: q is x y z qx qy qz qw in the parent's axes; qd wx wy wz vx vy vz, the angular velocity in
    the body's axes and the rate of the position in the parent's. Fixed: the placement, at rest. R and p are arrays of
    objects even where these are floats, so that NumPy multiplies them in order, without BLAS.
    """
    R, p = joint.R.astype(object), joint.p.astype(object)
    if joint.kind == "fixed":
        return REST._replace(R=R, p=p)
    if joint.kind == "floating":
        turn = rotation_from_quaternion(*q[3:]).astype(object)
        return Motion(
            R @ turn,
            p + R @ vector(*q[:3]),
            vector(*qd[:3]),
            turn.T @ vector(*qd[3:]),
            vector(*qdd[:3]),
            turn.T @ vector(*qdd[3:]),
        )
    axis = joint.axis
    if joint.kind == "revolute":
        return Motion(R @ rotation_about(axis, q[0]), p, axis * qd[0], ZERO, axis * qdd[0], ZERO)
    return Motion(R, p + (R @ axis) * q[0], ZERO, axis * qd[0], ZERO, axis * qdd[0])


def motions(model: Model, q: Sequence[Scalar], qd: Sequence[Scalar], qdd: Sequence[Scalar]) -> list[Motion]:
    """Return the motion of every joint of the model from q (nq scalars), qd and qdd (n); mimic joints move by
    `multiplier q + offset` of their leader."""
    out = []
    for body in model.bodies:
        joint = body.joint
        if joint.kind == "floating":
            i, k = joint.coordinate, joint.rate
            out.append(joint_motion(joint, q[i : i + 7], qd[k : k + 6], qdd[k : k + 6]))
        elif joint.kind == "fixed":
            out.append(joint_motion(joint, (), (), ()))
        else:
            ratio, own, k = joint.multiplier, joint.coordinate, joint.rate
            out.append(joint_motion(joint, [ratio * q[own] + joint.offset], [ratio * qd[k]], [ratio * qdd[k]]))
    return out


class Pose(NamedTuple):
    """Where a frame stands in an outer one, as a body on the ground: rotation R of its axes, origin p [m]."""

    R: Array
    p: Array

    def after(self, inner: Pose) -> Pose:
        """Return the pose, in the outer frame, of what stands at `inner` in this one."""
        return Pose(self.R @ inner.R, self.R @ inner.p + self.p)

    @property
    def inverse(self) -> Pose:
        return Pose(self.R.T, -self.R.T @ self.p)


def poses(parents: Sequence[int], motions: Sequence[Motion]) -> list[Pose]:
    """Return the pose of every body in the ground's axes: `R_i = R_j R`, `p_i = p_j + R_j p`."""
    out: list[Pose] = []
    for j, joint in zip(parents, motions, strict=True):
        R_j, p_j = out[j] if j >= 0 else (IDENTITY, ZERO)
        out.append(Pose(R_j @ joint.R, p_j + R_j @ joint.p))
    return out


class Velocity(NamedTuple):
    """Angular velocity w and velocity v of the origin of a body, in the body's axes."""

    w: Array
    v: Array


def velocities(parents: Sequence[int], motions: Sequence[Motion]) -> list[Velocity]:
    """Return the velocity of every body: `w_i = R^T w_j + w_J`, `v_i = R^T (v_j + w_j x p) + v_J`."""
    out: list[Velocity] = []
    for j, joint in zip(parents, motions, strict=True):
        w_j, v_j = out[j] if j >= 0 else (ZERO, ZERO)
        out.append(Velocity(joint.R.T @ w_j + joint.w, joint.R.T @ (v_j + cross(w_j, joint.p)) + joint.v))
    return out


def acceleration_of_point(a_p: Array, r: Array, w: Array, wd: Array) -> Array:
    """Return the acceleration of the body's point at r from p, whose acceleration is a_p: `a = a_p + wd x r + w x (w x
    r)`.

    Accuracy: 8 eps (|a_p| + |wd| |r| + |w|^2 |r|).
    """
    a: Array = a_p + cross(wd, r) + cross(w, cross(w, r))
    return a


class Acceleration(NamedTuple):
    """Angular acceleration wd and acceleration a of the origin of a body, in the body's axes."""

    wd: Array
    a: Array


def accelerations(parents: Sequence[int], motions: Sequence[Motion]) -> list[Acceleration]:
    """Return the acceleration of every body relative to the ground.

    `wd_i = R^T wd_j + R^T w_j x w_J + wd_J`, `a_i = R^T (a_j + wd_j x p + w_j x (w_j x p)) + 2 R^T w_j x v_J + a_J`.
    """
    out: list[Acceleration] = []
    moving = velocities(parents, motions)
    for j, joint in zip(parents, motions, strict=True):
        w_j = moving[j].w if j >= 0 else ZERO
        wd_j, a_j = out[j] if j >= 0 else (ZERO, ZERO)
        w_in = joint.R.T @ w_j
        wd = joint.R.T @ wd_j + cross(w_in, joint.w) + joint.wd
        a = acceleration_of_point(a_j, joint.p, w_j, wd_j)
        out.append(Acceleration(wd, joint.R.T @ a + 2.0 * cross(w_in, joint.v) + joint.a))
    return out


class Wrench(NamedTuple):
    """A force [N] and a moment [N m] about the body's origin, both in the body's axes."""

    f: Array
    n: Array


def coordinates(model: Model) -> tuple[str, ...]:
    """Return the coordinates that place the links in the base's frame: all but those of a base that moves."""
    return model.coordinates[7 if model.floating else 0 :]


def configuration(model: Model, values: Values = ()) -> Floats:
    """Return the q of a configuration; coordinates that are not given are zero, a floating joint at its place.

    Args:
        values: of all `coordinates` in their order, or of some by name [rad or m].

    Raises:
        InputError: there are more or fewer values than coordinates, a name is none, or a quaternion is zero.
    """
    q = np.zeros(model.nq)
    for _, k in model.quaternions:
        q[k : k + 4] = (0.0, 0.0, 0.0, 1.0)
    place = {name: k for k, name in enumerate(model.coordinates)}
    for name, value in named(model, values, coordinates(model)).items():
        q[place[name]] = value
    for joint, k in model.quaternions:
        if not q[k : k + 4].any():
            raise InputError(f"the quaternion of joint {shown(joint)} is zero", remedy="give four numbers, w last")
    return q


def nearest_to_zero(model: Model) -> dict[str, float]:
    """Return each joint that has one coordinate at zero, or at its limit nearest to zero [rad or m]."""
    at = {}
    for joint in (joint for joint in model.independent if joint.kind != "floating"):
        lower, upper = -inf if joint.lower is None else joint.lower, inf if joint.upper is None else joint.upper
        at[joint.name] = min(max(0.0, lower), upper) if lower <= upper else 0.0
    return at


def unit_rows(model: Model, states: Floats) -> Floats:
    """Return rows of q and more (N, width), which change, with quaternions of unit length."""
    for _, k in model.quaternions:
        states[:, k : k + 4] /= np.linalg.norm(states[:, k : k + 4], axis=1)[:, None]
    return states


def rates(model: Model, values: Values = ()) -> Floats:
    """Return the velocities or accelerations of the joints, of all in the order of `model.rates` or of some by name
    [rad or m, per s or s^2]; what is not given, and a base that moves, is zero."""
    given = named(model, values, model.rates[6 if model.floating else 0 :])
    return np.array([given.get(name, 0.0) for name in model.rates])


def named(model: Model, values: Values, names: tuple[str, ...]) -> Mapping[str, float]:
    """Return values by name, given in the order of these names, or some by name already; InputError of others."""
    if not isinstance(values, Mapping):
        if len(values) not in (0, len(names)):
            what = f"{count(len(values), 'value')} for {len(names)} coordinates"
            remedy = f"in the order: {listed(names)}" if names else "no joint moves"
            raise InputError(what, remedy=remedy, file=model.file)
        return dict(zip(names, values, strict=False))
    for name in values:
        if name not in names:
            leaders = (body.joint.mimics for body in model.bodies if body.joint.name == name and body.joint.mimics)
            remedy = next((f"it follows {shown(leader)}" for leader in leaders), alternatives(name, names, "joints"))
            raise InputError(f"no joint {shown(name)} to set", remedy=remedy, file=model.file)
    return values


def named_links(model: Model, names: Sequence[str]) -> tuple[str, ...]:
    """Return the names of links, each once; InputError of one that is none."""
    for name in names:
        if name not in model.links:
            remedy = alternatives(name, list(model.links), "links")
            raise InputError(f"there is no link {shown(name)}", remedy=remedy, file=model.file)
    return tuple(dict.fromkeys(names))


def beyond_limits(model: Model, q: Floats) -> tuple[str, ...]:
    """Return what is outside its limits, mimic joints included, in words."""
    found = []
    for joint in (body.joint for body in model.bodies if body.joint.kind in ("revolute", "prismatic")):
        value, unit = joint.multiplier * float(q[joint.coordinate]) + joint.offset, _UNITS[joint.kind]
        for name, limit, side in (("lower", joint.lower, "below"), ("upper", joint.upper, "above")):
            if limit is not None and (value < limit if side == "below" else value > limit):
                found.append(f"joint {shown(joint.name)} at {value:.6g} {unit} is {side} its {name} limit {limit:.6g}")
    return tuple(found)


def link_poses(model: Model, q: Floats) -> dict[str, Pose]:
    """Return rotation and origin of every link's frame in the frame of the base, wherever the base is.

    Accuracy: 4 eps for each joint between, of rotations and of the robot's size.
    """
    bodies = body_poses(model, q)
    placed = {}
    for name, frame in model.links.items():
        R, p = bodies[frame.body]
        placed[name] = Pose(narrowed(R @ frame.R), narrowed(p + R @ frame.p))
    return placed


def body_poses(model: Model, q: Floats) -> list[Pose]:
    """Return rotation and origin of every body's frame in the frame of the base; see `link_poses`."""
    still = [0.0] * model.n
    return poses(model.parents, [REST, *motions(model, q.tolist(), still, still)[1:]])
