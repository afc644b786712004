"""The files of robots/ for tests: their places, their tables as arrays, their descriptions through Pinocchio."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from helpers.peers import pin

FOLDER = Path(__file__).parents[2] / "robots"
REFERENCE = Path(__file__).parents[1] / "data" / "reference"
NAMES = sorted(path.stem for path in FOLDER.glob("*.urdf"))
FULL = {
    "scara_pick_and_place": "scara",
    "puma_reach": "puma",
    "puma_polish": "puma",
    "puma560_sweep": "puma560",
    "cylindrical_transfer": "cylindrical",
    "two_link_planar_swing": "two_link_planar",
    "two_link_spatial_slew": "two_link_spatial",
    "gripper_pick": "gripper",
    "satellite_slew": "satellite",
}
"""Motions of all joints, and their robots."""
MOTORS_ONLY = {
    "crank_slider_turn": "crank_slider",
    "four_bar_lift": "four_bar",
    "five_bar_reach": "five_bar",
    "delta_pick": "delta",
    "planar_3rrr_circle": "planar_3rrr",
}
"""Motions of the driven joints of closed chains."""


def read_csv(name: str) -> dict[str, np.ndarray]:
    return read_table(FOLDER / f"{name}.csv")


def read_table(path: Path) -> dict[str, np.ndarray]:
    """Return the columns of a CSV file."""
    header, *lines = path.read_text().splitlines()
    rows = np.array([[float(cell) for cell in line.split(",")] for line in lines])
    return dict(zip(header.split(","), rows.T, strict=True))


def model(name: str, root: pin.JointModel | None = None) -> pin.Model:
    path = str(FOLDER / f"{name}.urdf")
    return pin.buildModelFromUrdf(path) if root is None else pin.buildModelFromUrdf(path, root)


def stacked(table: dict[str, np.ndarray], names: list[str]) -> np.ndarray:
    return np.column_stack([table[name] for name in names])
