"""The compact form of derivatives: the same numbers, and what it leaves out."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.example_robots import real
from helpers.oracles import random_state, robot

import robodyn
from robodyn.scene.scene import Scene

ROBOTS = {
    "busy": (busy_robot(False), BUSY_SCENE),
    "busy, free": (busy_robot(True), BUSY_SCENE),
    "puma": (robot("puma560"), Scene()),
}


@pytest.mark.parametrize(
    ("name", "executor"),
    [
        *((name, "numpy") for name in ROBOTS),
        *((name, "compiled") for name in ("busy", "puma")),
        pytest.param("busy, free", "compiled", marks=pytest.mark.slow),
    ],
)
def test_dense_form(name, executor):
    """Every entry to the last bit; those left out are zero, or are given on the other side of the diagonal of M."""
    model, scene = ROBOTS[name]
    rng = np.random.default_rng(3)
    state, columns = random_state(model, rng, 40), {each: rng.uniform(-1, 1, 40) for each in scene.columns}
    found = robodyn.inverse_dynamics_derivative_entries(model, *state, scene=scene, columns=columns, executor=executor)
    expected = robodyn.inverse_dynamics_derivatives(model, *state, scene=scene, columns=columns, executor=executor)
    for matrix, other in zip(found.dense(), expected, strict=True):
        np.testing.assert_array_equal(matrix, other)
    assert found.values.shape == (40, len(found.row))
    assert (found.row <= found.column)[found.matrix == 2].all()
    assert len(set(zip(found.matrix, found.row, found.column, strict=True))) == len(found.row)
    assert found.values.any(axis=0).mean() > 0.9


def test_branches_do_not_meet():
    """Legs of a body that stands still: no entry joins two of them."""
    model = real("solo12")
    entries = robodyn.inverse_dynamics_derivative_entries(model, np.zeros(model.nq), 0.0, 0.0)
    leg = np.array([name[:2] for name in model.joint_names])
    assert (leg[entries.row] == leg[entries.column]).all()
    assert len(entries.row) == 4 * (9 + 9 + 6)
