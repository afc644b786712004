"""Bearing loads: directions of any axis, and that five components and the drive are the whole wrench."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.oracles import EPS, random_state
from helpers.small_robots import random_tree

from robodyn.loads.sizing import frame
from robodyn.loads.torques import torques
from robodyn.trajectory.read import motion


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, -1), (0.6, 0, 0.8), (0.36, -0.48, 0.8)])
def test_directions_are_a_right_handed_frame(axis):
    turn = frame(np.array(axis, dtype=float))
    assert np.abs(turn @ turn.T - np.eye(3)).max() <= 4 * EPS
    assert abs(np.linalg.det(turn) - 1) <= 4 * EPS
    assert turn[2].tolist() == list(axis)
    if 0 in axis and 1 in np.abs(axis):
        assert set(np.abs(turn).ravel().tolist()) == {0.0, 1.0}


def test_of_z_the_directions_are_x_and_y():
    assert frame(np.array([0.0, 0.0, 1.0])).tolist() == [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    assert frame(np.array([1.0, 0.0, 0.0])).tolist() == [[0, 1, 0], [0, 0, 1], [1, 0, 0]]


@pytest.mark.parametrize("seed", range(4))
def test_components_of_skew_joints(seed):
    """One sample at a time: rotated back with the drive, they are the wrench that --reactions writes."""
    model = random_tree(seed, kinds=("revolute", "prismatic"))
    at = [x[:1] for x in random_state(model, np.random.default_rng(seed), 1)]
    wrenches = []
    keep = lambda time, columns: wrenches.append(columns[0, model.n + 6 :].reshape(-1, 6))  # noqa: E731
    result = torques(model, motion(model, [0.0], *at), sizing=True, reactions=True, sinks=[keep])
    largest = np.abs(wrenches[0]).max()
    for body, bearing, wrench in zip(model.bodies[1:], result.sizing.bearings, wrenches[0], strict=True):
        parts = {part.name: part.peak for part in bearing.components}
        assert len(parts) == 5
        missing = ({"fu", "fv", "fa", "mu", "mv", "ma"} - parts.keys()).pop()
        assert missing == {"revolute": "ma", "prismatic": "fa"}[body.joint.kind]
        vector = wrench[:3] if missing == "fa" else wrench[3:]
        parts[missing] = vector @ body.joint.axis
        turn = np.array(bearing.directions)
        for kind, expected in (("f", wrench[:3]), ("m", wrench[3:])):
            back = turn.T @ [parts[f"{kind}{axis}"] for axis in "uva"]
            assert np.abs(back - expected).max() <= 16 * EPS * largest
        assert bearing.radial.peak == pytest.approx(np.hypot(parts["fu"], parts["fv"]), rel=1e-14)
        assert bearing.tilting.peak == pytest.approx(np.hypot(parts["mu"], parts["mv"]), rel=1e-14)
