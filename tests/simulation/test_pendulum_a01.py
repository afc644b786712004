"""IFToMM's benchmark A01, a pendulum let go from the horizontal: within 1 mm of the exact place over 2000 s."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.oracles import ROBOTS, robot

import robodyn

REFERENCE = Path(__file__).parents[1] / "data" / "reference" / "analytic.json"
BAR = 1e-3


def exact(last):
    """Rows of t, x, z at whole multiples of 10 s."""
    rows = np.array(json.loads(REFERENCE.read_text())["A01_pendulum_exact"]["rows"], dtype=float)
    return [row[:3] for row in rows if row[0] > 0 and row[0] % 10 == 0 and row[0] <= last]


@pytest.mark.parametrize(
    ("method", "step", "last"),
    [("rk4", 1e-2, 100), ("rk4", 1 / 120, 2000), ("gauss6", 0.1, 2000), ("verlet", 0.0125, 2000)],
)
def test_within_a_millimetre(method, step, last):
    scene = robodyn.load_scene(ROBOTS / "pendulum_a01.toml")
    result = robodyn.simulate(robot("pendulum"), scene, float(last), step=step, method=method)
    rows = exact(last)
    assert len(rows) == {100: 2, 2000: 4}[last]
    for t, *place in rows:
        k = np.argmin(np.abs(result.time - t))
        assert result.time[k] == pytest.approx(t, rel=1e-12)
        q = result.q[k, 0]
        assert np.hypot(np.cos(q) - place[0], np.sin(q) - place[1]) <= BAR
