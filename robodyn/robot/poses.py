"""Where the bodies are and how fast they move, for any scalar: the outward recursions without accelerations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from robodyn.programs.vectors import IDENTITY, ZERO, Array, cross
from robodyn.robot.motion_types import Motion


class Pose(NamedTuple):
    """Where a body stands: rotation R of its axes and position p of its origin, in the ground's axes."""

    R: Array
    p: Array


def poses(parents: Sequence[int], motions: Sequence[Motion]) -> list[Pose]:
    """The pose of every body in the ground's axes: `R_i = R_j R`, `p_i = p_j + R_j p`."""
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
    """The velocity of every body: `w_i = R^T w_j + w_J`, `v_i = R^T (v_j + w_j x p) + v_J`."""
    out: list[Velocity] = []
    for j, joint in zip(parents, motions, strict=True):
        w_j, v_j = out[j] if j >= 0 else (ZERO, ZERO)
        out.append(Velocity(joint.R.T @ w_j + joint.w, joint.R.T @ (v_j + cross(w_j, joint.p)) + joint.v))
    return out


class Acceleration(NamedTuple):
    """Angular acceleration wd and acceleration a of the origin of a body, in the body's axes."""

    wd: Array
    a: Array


def accelerations(parents: Sequence[int], motions: Sequence[Motion]) -> list[Acceleration]:
    """The acceleration of every body relative to the ground.

    `wd_i = R^T wd_j + R^T w_j x w_J + wd_J`, `a_i = R^T (a_j + wd_j x p + w_j x (w_j x p)) + 2 R^T w_j x v_J + a_J`.
    """
    out: list[Acceleration] = []
    moving = velocities(parents, motions)
    for j, joint in zip(parents, motions, strict=True):
        w_j = moving[j].w if j >= 0 else ZERO
        wd_j, a_j = out[j] if j >= 0 else (ZERO, ZERO)
        w_in = joint.R.T @ w_j
        wd = joint.R.T @ wd_j + cross(w_in, joint.w) + joint.wd
        a = a_j + cross(wd_j, joint.p) + cross(w_j, cross(w_j, joint.p))
        out.append(Acceleration(wd, joint.R.T @ a + 2.0 * cross(w_in, joint.v) + joint.a))
    return out
