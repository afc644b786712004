"""The quadruped's motions by Pinocchio: its states, its feet, and what carries its base."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from helpers.peers import pin
from helpers.robot_files import stacked

LEGS = ("lf", "rf", "lh", "rh")
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
