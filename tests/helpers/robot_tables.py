"""Columns of the example trajectories: times, joints with their rates, and a base that moves."""

from __future__ import annotations

from collections.abc import Mapping

from mpmath import mpf

from helpers.free_motions import BaseState
from helpers.robot_motions import Motion

Table = dict[str, list[mpf]]


def times(count: int, rate: int) -> list[mpf]:
    return [mpf(k) / rate for k in range(count)]


def joints(clock: list[mpf], motions: Mapping[str, Motion]) -> Table:
    """time, then q_, qd_ and qdd_ of every joint."""
    table = {"time": clock}
    for level, name in enumerate(("q", "qd", "qdd")):
        for joint, motion in motions.items():
            table[f"{name}_{joint}"] = [motion(t)[level] for t in clock]
    return table


def base(states: list[BaseState]) -> Table:
    """The base_ columns: position, quaternion, velocity (linear, angular), acceleration (linear, angular)."""
    groups = {
        "x y z": [state.p for state in states],
        "qx qy qz qw": [state.attitude for state in states],
        "vx vy vz": [state.v for state in states],
        "wx wy wz": [state.w for state in states],
        "ax ay az": [state.a for state in states],
        "wdx wdy wdz": [state.wd for state in states],
    }
    return {
        f"base_{name}": [row[i] for row in rows]
        for names, rows in groups.items()
        for i, name in enumerate(names.split())
    }
