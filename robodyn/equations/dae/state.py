"""Where every body is and how fast it moves, each on its own (maximal coordinates), for any scalar."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from robodyn.programs.vectors import IDENTITY, ZERO, Array, Scalar, cross
from robodyn.robot.kinematics import Acceleration, acceleration_of_point, accelerations, motions, poses, velocities
from robodyn.robot.model import Model


class Place(NamedTuple):
    """Rotation R of a body's axes in the ground's, and position c of its mass centre in these, from the base's origin.

    From there, because then a robot that is far away from the ground's origin loses no digits.
    """

    R: Array
    c: Array


class Speed(NamedTuple):
    """Angular velocity w in the body's axes, and velocity v of its mass centre in the ground's."""

    w: Array
    v: Array


STILL = Speed(ZERO, ZERO)


class State(NamedTuple):
    """Places and speeds of the N bodies, and behind them the ground's, so that body -1 is the ground.

    The ground stands at minus the position of the base.
    """

    places: tuple[Place, ...]
    speeds: tuple[Speed, ...]


def state_of(model: Model, centres: Sequence[Array], q: Sequence[Scalar], qd: Sequence[Scalar]) -> State:
    """The bodies in a motion of the joints: `c = p - p_base + R r`, `v = R (v_o + w x r)`, r being the mass centre.

    Args:
        centres: (3,) of each body, in its frame [m].
        q: nq scalars; qd: n scalars.
    """
    base, *others = joints = motions(model, q, qd, (0.0,) * model.n)
    there = poses(model.parents, [base._replace(p=ZERO), *others])
    places, speeds = [], []
    for pose, moving, r in zip(there, velocities(model.parents, joints), centres, strict=True):
        places.append(Place(pose.R, pose.p + pose.R @ r))
        speeds.append(Speed(moving.w, pose.R @ (moving.v + cross(moving.w, r))))
    return State((*places, Place(IDENTITY, -base.p)), (*speeds, STILL))


def accelerations_of(
    model: Model, centres: Sequence[Array], q: Sequence[Scalar], qd: Sequence[Scalar], qdd: Sequence[Scalar]
) -> list[Acceleration]:
    """wd (body's axes) and acceleration of the mass centre (ground's axes) of each body in a motion of the joints."""
    joints = motions(model, q, qd, qdd)
    moving, speeding = velocities(model.parents, joints), accelerations(model.parents, joints)
    out = []
    for pose, (w, _), (wd, a), r in zip(poses(model.parents, joints), moving, speeding, centres, strict=True):
        out.append(Acceleration(wd, pose.R @ (acceleration_of_point(a, r, w, wd))))
    return out
