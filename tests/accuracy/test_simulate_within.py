"""Simulations that are as accurate as asked, and refusals of those that cannot be."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from simulated_robots import pendulum, slide

from robodyn.accuracy.motion_reference import motion_reference
from robodyn.accuracy.simulate_within import simulate_within
from robodyn.accuracy.simulation_ladder import state_errors
from robodyn.errors import InputError
from robodyn.plan import plan
from robodyn.scene import Scene

SWING = Scene(initial_q={"j1": 2.5})


@pytest.mark.parametrize("target", [1e-3, 1e-7, 1e-12])
def test_the_error_is_within_the_expected_one(target):
    pytest.importorskip("mpmath")
    model = pendulum(masses=2)
    found = simulate_within(model, SWING, 0.7, target)
    _, error = state_errors(found, motion_reference(plan(model, found.scene), 0.7))
    assert error <= found.expected_error <= target == found.target
    assert found.notes[-1].startswith(f"accuracy: {target:g} asked, {found.method.name} with ")


def test_a_lower_target_takes_no_more_steps():
    """Steps are counted where the method is the same, which does not depend on the machine."""
    found = [simulate_within(pendulum(), SWING, 1.0, target) for target in (1e-2, 1e-5, 1e-8, 1e-11)]
    for a, b in pairwise(found):
        assert b.expected_error < a.expected_error
        if a.method == b.method:
            assert a.steps <= b.steps


def test_up_to_a_limit():
    found = simulate_within(slide(axis=(0, 0, 1)), Scene(), 5.0, 1e-9)
    assert abs(found.time[-1] - np.sqrt(18 / 9.81)) <= 1e-9
    assert found.ended


@pytest.mark.parametrize(("target", "why"), [(1e-17, "halving its step to"), (1e-14, "cannot be promised")])
def test_what_rounding_forbids_is_refused(target, why):
    with pytest.raises(InputError, match=why):
        simulate_within(pendulum(masses=2), SWING, 0.7, target)


def test_what_grows_too_fast_is_refused(monkeypatch: pytest.MonkeyPatch):
    """After a minute a chaotic motion has lost all that doubles hold."""
    monkeypatch.setattr("robodyn.accuracy.simulate_within.PATIENCE", 0.2)
    with pytest.raises(InputError, match="an accuracy of 1e-06 cannot be promised"):
        simulate_within(pendulum(masses=2), SWING, 60.0, 1e-6)
