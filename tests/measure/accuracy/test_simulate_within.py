"""Simulations that are as accurate as asked, and refusals of those that cannot be."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from helpers.simulated_robots import pendulum, slide, turntable

import robodyn
from robodyn.errors import InputError
from robodyn.measure.accuracy import simulate_within as effort
from robodyn.measure.accuracy.simulate_within import simulate_within
from robodyn.measure.accuracy.simulation import apart, motion_reference, state_errors
from robodyn.scene.scene import Scene

SWING = Scene(initial_q={"j1": 2.5})


@pytest.mark.parametrize(
    "target", [pytest.param(1e-3, marks=pytest.mark.slow), 1e-7, pytest.param(1e-12, marks=pytest.mark.slow)]
)
def test_the_error_is_within_the_expected_one(target):
    model = pendulum(masses=2)
    found = simulate_within(model, SWING, 0.3, target)
    known = motion_reference(model, 0.3, partial(robodyn.simulate, model, found.scene))
    assert state_errors(found, known)[1] <= found.expected_error + 2 * known.bound
    assert found.expected_error <= target == found.target
    assert found.notes[-1].startswith(f"accuracy: {target:g} asked, {found.method.name} with ")


def test_a_lower_target_takes_no_more_steps():
    """Steps are counted where the method is the same, which does not depend on the machine."""
    found = [simulate_within(pendulum(), SWING, 0.5, target) for target in (1e-2, 1e-6, 1e-10)]
    for a, b in pairwise(found):
        assert b.expected_error < a.expected_error
        if a.method == b.method:
            assert a.steps <= b.steps


@pytest.mark.parametrize(
    ("duration", "target", "what"),
    [
        (0.2, 1e-16, "cannot be promised: .* going to steps of"),  # what rounding forbids
        (60.0, 1e-6, "an accuracy of 1e-06 cannot be promised: reached .* after [0-9]+ steps in"),  # chaos
    ],
)
def test_what_cannot_be_is_refused_with_what_was_reached(duration, target, what, monkeypatch):
    monkeypatch.setattr(effort, "ALLOWED", 0.15)
    with pytest.raises(InputError, match=what):
        simulate_within(pendulum(masses=2), SWING, duration, target)


@pytest.mark.parametrize("case", [(pendulum(masses=2), SWING, 60.0), (*turntable(), 1.0)], ids=["chaotic", "stiff"])
def test_work_is_counted_and_bounded(case, monkeypatch):
    """So many seconds of counted work: no run begins beyond it, and all evaluations together stay within it."""
    allowed = 0.2
    monkeypatch.setattr(effort, "ALLOWED", allowed)
    monkeypatch.setattr(effort, "FIRST", 1e3)
    done = []

    def counted(*args, most, **how):
        done.append((how.get("method", "usual"), most))
        motion = robodyn.simulate(*args, most=most, **how)
        assert motion.evaluations <= most
        return motion

    monkeypatch.setattr(effort, "simulate", counted)
    with pytest.raises(InputError, match="more work than is allowed"):
        simulate_within(*case, 1e-9)
    methods = [name for name, _ in done]
    assert {"usual", "rk4", "gauss6", "radau"} <= set(methods)
    assert all(0 <= most <= allowed / effort.CALLED for _, most in done)
    assert all(most <= allowed / effort.SCIPY for name, most in done if name in ("dop853", "radau", "bdf"))
    assert len(done) <= 60


@pytest.mark.slow
def test_friction_that_becomes_stiff_on_the_way():
    """It did not end in seven minutes, and rk4 ends 0.35 rad away; it creeps at the slip speed times 0.8 / 0.6."""
    found = simulate_within(*turntable(), 0.6, 1e-2)
    assert found.method.name in ("radau", "bdf")
    assert abs(found.q[-1, 0] - 0.6e-3 * 0.8 / 0.6) <= 1e-5
    assert found.expected_error <= 1e-2


def test_the_time_at_a_limit_is_a_result():
    near, far = (robodyn.simulate(slide(axis=(0, 0, 1)), Scene(), 5.0, step=step) for step in (1e-3, 1e-2))
    late = replace(far, time=np.array([*far.time[:-1], far.time[-1] * 1.01]))
    assert apart(far, near) <= 1e-9
    assert 0.009 <= apart(late, near) <= 0.011
    assert apart(replace(far, ended="another limit at 1 s"), near) == np.inf
    assert apart(replace(far, ended=""), near) == np.inf
