"""The forces under the quadruped's feet against the balance of its base, and closed forms of who bears what."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS, run
from helpers.peers import pin
from helpers.robot_files import model, read_csv, read_table
from helpers.walked import FEET, LEGS, base_wrenches, feet_places, standing

MOTIONS = ("quadruped_stand", "quadruped_trot")
WEIGHT = 10 * 9.81
RADIUS = np.hypot(*FEET)


@pytest.fixture(scope="module")
def robot():
    return model("quadruped", pin.JointModelFreeFlyer())


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """By motion: the columns of `torques --out`."""
    folder = tmp_path_factory.mktemp("quadruped")
    return {name: computed(name, folder / f"{name}.csv") for name in MOTIONS}


def computed(name: str, out: Path) -> dict[str, np.ndarray]:
    scene = str(ROBOTS / f"{name}.toml")
    call = (str(ROBOTS / "quadruped.urdf"), str(ROBOTS / f"{name}.csv"), "--scene", scene, "--out", str(out))
    outcome = run("torques", *call)
    assert (outcome.status, outcome.err) == (0, "")
    return read_table(out)


def forces(found):
    """(samples, 4, 3) of the ground on the feet."""
    return np.stack([np.column_stack([found[f"f{axis}_{leg}"] for axis in "xyz"]) for leg in LEGS], axis=1)


def test_four_feet_under_the_middle_bear_a_quarter_each(results):
    quarter = np.broadcast_to([0, 0, WEIGHT / 4], (4, 3))
    np.testing.assert_allclose(forces(results["quadruped_stand"])[0], quarter, rtol=0, atol=1e-9 * WEIGHT)


def test_two_feet_bear_half_each_and_turn_the_robot_with_the_shortest_forces(robot, results):
    """F / 2 upwards, and m / (2 r) along the circle on which the feet stand."""
    motion = {key: values[::4] for key, values in read_csv("quadruped_trot").items()}
    found = forces(results["quadruped_trot"])[::4]
    rows = zip(feet_places(robot, motion), base_wrenches(robot, motion), standing(motion), found, strict=True)
    checked = 0
    for places, (_, force, moment), on, f in rows:
        if on.all():
            continue
        checked += 1
        out = places[on] * [1, 1, 0]
        expected = force / 2 + np.cross([0, 0, moment[2] / (2 * RADIUS)], out / RADIUS)
        np.testing.assert_allclose(f[on], expected, rtol=0, atol=1e-9 * WEIGHT)
    assert checked >= 25
