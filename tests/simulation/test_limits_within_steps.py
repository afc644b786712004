"""Joint limits are found inside steps, touches among them, by every method at the same moment."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from helpers.random_scenes import braked_slide, hanging, swung
from helpers.sampled import sampled
from helpers.simulated_robots import slide
from helpers.small_robots import built, joint, link
from scipy.integrate import solve_ivp

import robodyn
from robodyn.errors import InputError
from robodyn.measure.accuracy import simulate_within as effort
from robodyn.measure.accuracy.simulate_within import graze, simulate_within
from robodyn.scene.scene import Drive, Scene

WAYS = [{}, {"rtol": 1e-6}, {"method": "midpoint"}, {"rtol": 1e-9}, {"method": "radau"}]
WAYS += [{"method": name} for name in ("verlet", "gauss6")]


@cache
def moment_of(start: float, limit: float) -> float:
    """When a pendulum of 1 m that is let go reaches an angle, by SciPy's DOP853 at its finest [s]."""

    def room(_: float, y: np.ndarray) -> float:
        return limit - y[0]

    room.terminal = True
    how = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15, "events": room, "max_step": 0.02}
    found = solve_ivp(lambda _, y: (y[1], -9.81 * np.sin(y[0])), (0.0, 10.0), (start, 0.0), **how)
    return float(found.t_events[0][0])


@pytest.mark.parametrize("how", sampled(WAYS, 3), ids=str)
def test_a_pendulum_reaches_a_limit_just_before_it_turns(how):
    """From -0.5 rad it swings to 0.5; its limit is at 0.49, where it is for a short while of each swing."""
    found = robodyn.simulate(hanging(-1.0, 0.49), Scene(initial_q={"j1": -0.5}), 20.0, **how)
    expected = moment_of(-0.5, 0.49)
    order = found.method.order
    assert abs(found.time[-1] - expected) <= {2: 1e-4}.get(order, 1e-4 if how.get("rtol") == 1e-6 else 1e-8)
    assert abs(found.q[-1, 0] - 0.49) <= 1e-12
    assert f'"j1" reaches its upper limit of 0.49 rad at {found.time[-1]:.6g} s' == found.ended


@pytest.mark.parametrize("how", sampled([*WAYS, {"method": "euler"}, {"method": "symplectic-euler"}], 3), ids=str)
@pytest.mark.parametrize("depth", [1e-3, 1e-7])
def test_a_limit_that_is_touched_within_one_step(how, depth):
    """A slide braked by a constant force turns `depth` beyond its limit, for much less than a step or for some."""
    model, scene, turn, over = braked_slide(depth)
    found = robodyn.simulate(model, scene, 2.0, **how, **({} if "rtol" in how or "method" in how else {"step": 0.05}))
    if "euler" in how.get("method", ""):  # their own motion turns half a step's gain elsewhere
        assert not found.ended or abs(found.time[-1] - turn) <= 0.1
        return
    assert found.ended
    assert abs(found.time[-1] - (turn - over)) <= 1e-6 * over + 1e-9


def test_a_limit_that_is_missed_by_little_is_not_reached():
    for how in ({}, {"step": 0.05}, {"rtol": 1e-10}, {"method": "gauss6"}):
        model, scene, _, _ = braked_slide(-1e-7)
        assert not robodyn.simulate(model, scene, 2.0, **how).ended, how


def test_a_short_passing_between_records(monkeypatch):
    """With records every 40 steps, which the joint passes its limit between."""
    monkeypatch.setattr("robodyn.simulation.integrate.MOST_RECORDS", 50)
    model, scene, turn, over = braked_slide(1e-4)
    found = robodyn.simulate(model, scene, 2.0)
    assert abs(found.time[-1] - (turn - over)) <= 1e-9
    assert found.steps == int(np.ceil(found.time[-1] / 1e-3))


@pytest.mark.parametrize("how", [{"step": 1.0}, {"rtol": 1e-3}, {"method": "radau"}])
def test_the_first_of_two_limits_in_one_step(how):
    """Two slides on each other reach their limits in the same step, the second of them first."""
    parts = [link("l0"), link("l1", 1.0), link("l2", 1.0)]
    parts += [joint("j1", "l0", "l1", "prismatic", (1, 0, 0)), joint("j2", "l1", "l2", "prismatic", (0, 1, 0))]
    scene = Scene(gravity=(0, 0, 0), initial_q={"j1": 8.5, "j2": 8.9}, initial_qd={"j1": 1.0, "j2": 1.0})
    found = robodyn.simulate(built(*parts), scene, 3.0, **how)
    assert abs(found.time[-1] - 0.1) <= 1e-14
    assert found.ended.startswith('"j2" reaches its upper limit of 9 m')


@pytest.mark.parametrize("how", [{"step": 0.05}, {"rtol": 1e-6}])
def test_the_limit_of_a_joint_that_mimics_another(how):
    """The follower moves minus twice as far as its master, which turns back just beyond where the follower may go."""
    parts = [link("l0"), link("l1", 1.0), link("l2", 1e-9)]
    mimic = '<mimic joint="j1" multiplier="-2"/>'
    parts += [joint("j1", "l0", "l1", "prismatic", (1, 0, 0)), joint("j2", "l0", "l2", "prismatic", more=mimic)]
    scene = Scene(gravity=(0, 0, 0), drive={"j1": Drive(torque=-1.0)}, initial_qd={"j1": 3.0001})
    found = robodyn.simulate(built(*parts), scene, 4.0, **how)
    assert found.ended.startswith('"j2" reaches its lower limit of -9 m')
    assert abs(found.q[-1, 0] - 4.5) <= 1e-12


@pytest.mark.parametrize("how", [{}, {"method": "gauss4"}, {"rtol": 1e-9}])
def test_a_motion_that_begins_at_a_limit(how):
    """Away from it, it goes on; into it, at speed or by a force, it is over at once."""
    at = Scene(gravity=(0, 0, 0), initial_q={"j1": 9.0})
    away = robodyn.simulate(slide(), replace(at, initial_qd={"j1": -1.0}), 1.0, **how)
    assert (away.ended, away.time[-1]) == ("", 1.0)
    pulled = robodyn.simulate(slide(), replace(at, drive={"j1": Drive(torque=-1.0)}), 1.0, **how)
    assert (pulled.ended, pulled.time[-1]) == ("", 1.0)
    for into in ({"initial_qd": {"j1": 1.0}}, {"drive": {"j1": Drive(torque=1.0)}}):
        found = robodyn.simulate(slide(), replace(at, **into), 1.0, **how)
        assert found.ended
        assert found.time[-1] <= 1e-6


def test_numbers_beyond_a_limit_do_not_matter():
    """A force that blows up after the limit is reached ends no motion that had ended before."""
    scene = Scene(gravity=(0, 0, 0), drive={"j1": Drive(torque="push")}, between_rows="hold")
    table = {"time": [0.0, 2.0, 2.001, 3.0], "push": [40.0, 1e300, 1e308, 0.0]}
    found = robodyn.simulate(slide(2.0), replace(scene, initial_qd={"j1": 1.0}), table=table)
    assert abs(found.q[-1, 0] - 9.0) <= 1e-12


@pytest.mark.parametrize("seed", sampled([17, 30], 2))
def test_what_halved_steps_say_covers_the_moment_of_an_early_limit(seed):
    """A limit that is reached within the first whole step, by steps that halving that one does not change."""
    found = swung(np.random.default_rng(seed))
    motion = simulate_within(found.model, found.scene, None, 1e-3, table=found.table)
    assert found.moment is not None
    assert abs(motion.time[-1] - found.moment) <= motion.expected_error * found.moment + 1e-15


@pytest.mark.parametrize("depth", sampled([1e-6, -1e-11], 2))
def test_an_accuracy_tells_a_limit_that_is_just_reached_from_one_that_is_just_missed(depth):
    """A pendulum let go at -0.5 rad turns at 0.5: errors have to be below what is left there."""
    model = hanging(-1.0, 0.5 - depth)
    found = simulate_within(model, Scene(initial_q={"j1": -0.5}), 2.0, 1e-2)
    assert bool(found.ended) == (depth > 0)
    assert found.expected_error <= abs(depth)


@pytest.mark.slow
def test_a_limit_that_no_digits_can_tell_is_refused(monkeypatch):
    """Let go at its lower limit, a pendulum comes back to just there."""
    monkeypatch.setattr(effort, "ALLOWED", 2.0)
    with pytest.raises(InputError, match=r'"j1" (misses|passes) its lower limit of -0.5 rad by .*e-1\d rad, at 2.0'):
        simulate_within(hanging(-0.5, 1.0), Scene(initial_q={"j1": -0.5}), 3.0, 1e-2)


def test_how_far_a_joint_would_go_on_beyond_its_limit():
    """Thrown up to 9.1 m below a limit of 9 m, a slide would rise by 0.1 m more."""
    found = robodyn.simulate(slide(axis=(0, 0, 1)), Scene(initial_qd={"j1": np.sqrt(2 * 9.81 * 9.1)}), 2.0)
    near = graze(found)
    assert (near.stop.value, near.time) == (9.0, found.time[-1])
    assert near.depth == pytest.approx(0.1, rel=1e-9)
