"""The quadruped's motions by Pinocchio: its states, its feet, and what carries its base."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from helpers.peers import pin
from helpers.robot_files import stacked

LEGS = ("lf", "rf", "lh", "rh")
FEET = (0.19, 0.11)
"""Place of the front left foot that stands [m]."""
Table = dict[str, np.ndarray]


def states(robot: pin.Model, table: Table) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Pinocchio's q, v and a: the velocity of the base in its own axes, whose rate is `R' a - w x R' v`."""
    names = [name for name in robot.names if name not in ("universe", "root_joint")]
    q, qd, qdd = (stacked(table, [f"{level}_{name}" for name in names]) for level in ("q", "qd", "qdd"))
    place, w, wd, v, a = (
        stacked(table, [f"base_{name}" for name in group.split()])
        for group in ("x y z qx qy qz qw", "wx wy wz", "wdx wdy wdz", "vx vy vz", "ax ay az")
    )
    for k in range(len(q)):
        R = pin.Quaternion(place[k, 3:]).toRotationMatrix()
        speed = R.T @ v[k]
        rate = R.T @ a[k] - np.cross(w[k], speed)
        yield np.r_[place[k], q[k]], np.r_[speed, w[k], qd[k]], np.r_[rate, wd[k], qdd[k]]


def standing(table: Table) -> np.ndarray:
    """(samples, 4) whether each foot stands."""
    return np.column_stack([table.get(f"on_{leg}", np.ones(len(table["time"]))) for leg in LEGS]).astype(bool)


def feet_places(robot: pin.Model, table: Table) -> Iterator[np.ndarray]:
    """Yield (4, 3) where the feet are."""
    data = robot.createData()
    for q, _, _ in states(robot, table):
        pin.framesForwardKinematics(robot, data, q)
        yield np.array([data.oMf[robot.getFrameId(f"{leg}_foot")].translation for leg in LEGS])


def base_wrenches(robot: pin.Model, table: Table) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Yield the place of the trunk's middle, and force and moment on the robot about it, all in the ground's axes."""
    data = robot.createData()
    for q, v, a in states(robot, table):
        wrench = pin.rnea(robot, data, q, v, a)[:6]
        R = pin.Quaternion(q[3:7]).toRotationMatrix()
        yield q[:3], R @ wrench[:3], R @ wrench[3:]
