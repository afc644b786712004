"""Closed chains of two and three samples: whatever stood in memory before, torques are those of virtual work."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.dirty_memory import soil
from helpers.driven_chains import MIDDLE, moving

import robodyn


@pytest.mark.parametrize("samples", [2, 3])
@pytest.mark.parametrize("name", MIDDLE)
def test_what_stood_in_memory_is_in_no_torque(name, samples, monkeypatch):
    soil(monkeypatch)
    for seed in range(2):
        chain = moving(name, samples, seed)
        tau = robodyn.inverse_dynamics(chain.model, *chain.state, scene=chain.scene)
        np.testing.assert_allclose(tau, chain.torques, rtol=0, atol=1e-13 * np.abs(chain.torques).max())
