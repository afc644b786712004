"""Sizing block by block: the first of equal extremes, and memory that does not grow with the motion."""

from __future__ import annotations

import tracemalloc
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import write_arm

from robodyn.loads.statistics import Greatest
from robodyn.loads.torques import torques
from robodyn.robot.load import load
from robodyn.scene.parts import Motor, Rotor
from robodyn.scene.scene import Scene
from robodyn.trajectory.read import open_trajectory, signals
from robodyn.trajectory.reading import Reading


def test_of_equal_samples_the_first_counts():
    score = np.array([[1.0, 3.0, 2.0, 3.0, 0.0, 3.0], [-5.0, -4.0, -3.0, -3.0, -3.0, -9.0]])
    time, values = np.arange(6) / 10, np.arange(12.0).reshape(2, 6)
    for cuts in ([0, 6], [0, 1, 3, 6], range(7)):
        found = Greatest(2)
        for a, b in pairwise(cuts):
            found.update(time[a:b], a + 1, score[:, a:b], value=values[:, a:b])
        assert found.score.tolist() == [3, -3]
        assert (found.row.tolist(), found.time.tolist()) == ([2, 3], [0.1, 0.2])
        assert found.kept["value"].tolist() == [1, 8]


def peak_memory(folder: Path, rows: int) -> int:
    """Bytes at the most while the arm and its motors are sized in blocks of 256 samples."""
    write_arm(folder, rows)
    motor = Motor(0.8, continuous=1.0, peak=((0.0, 3.0), (9.0, 1.0)), gear_average=3.0, gear_peak=9.0)
    names = ("shoulder", "elbow")
    scene = Scene(rotor=dict.fromkeys(names, Rotor(1e-4, 50.0)), motor=dict.fromkeys(names, motor))
    tracemalloc.start()
    try:
        model = load(folder / "arm.urdf")
        with open_trajectory(
            folder / "arm.csv", signals(model), block_rows=256, reading=Reading(angle_unit="rad")
        ) as reader:
            torques(model, reader, scene, executor="numpy")
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.slow
def test_memory_does_not_grow_with_the_length(tmp_path: Path) -> None:
    """The loads of 192 blocks more would alone take 6 MB; a peak is some 1.4 MB, and differs by 0.3 between runs."""
    peak_memory(tmp_path, 16384)
    short, long = (peak_memory(tmp_path, rows) for rows in (16384, 65536))
    assert long - short <= 1_000_000
