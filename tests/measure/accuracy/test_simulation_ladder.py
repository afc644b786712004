"""Errors of simulated motions against closed forms, and what else their ladder tells."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from helpers.closed_chains import four_bars
from helpers.oracles import reference
from helpers.simulated_robots import pendulum, slide, tumbling

from robodyn.errors import InputError
from robodyn.measure.accuracy import simulation as simulation_ladder
from robodyn.measure.accuracy.simulation import MotionError, motion_reference, simulation_accuracy, state_errors
from robodyn.scene.scene import Drive, Scene
from robodyn.simulation.simulate import simulate

QUARTER = float(reference("analytic")["pendulum_L1_g9.81"]["T_by_amplitude_deg"]["90"]) / 4
SWING = Scene(initial_q={"j1": np.pi / 2})
PUSHED = replace(SWING, drive={"j1": Drive(torque="push")})


@pytest.fixture(autouse=True)
def _short_ladders(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulation_ladder, "STEPS", (1.6e-2, 4e-3))
    monkeypatch.setattr(simulation_ladder, "TOLERANCES", (1e-4, 1e-8))


def test_pendulum():
    found = simulation_accuracy(pendulum(), SWING, QUARTER)
    (ladder,) = found.ladders
    rungs = {rung.name: rung for rung in ladder.rungs}
    assert {name.partition(",")[0] for name in rungs} >= {"euler", "verlet", "rk4", "gauss6", "dop853", "radau"}
    for name, order in (("rk4", 4), ("gauss2", 2), ("verlet", 2)):
        steps = [rungs[f"{name}, {step} ms"] for step in (16, 4)]
        assert 0.6 * 4**order <= steps[0].error / steps[1].error <= 1.7 * 4**order
    assert rungs["rk4, 4 ms"].evaluations == 4 * np.ceil(QUARTER / 4e-3)
    assert all(rung.operations > rung.evaluations > 0 for rung in ladder.rungs)
    assert rungs["gauss6, 4 ms"].drift <= 1e-12 < rungs["euler, 4 ms"].drift
    assert all(rung.errors[0] <= rung.errors[1] for rung in ladder.rungs)
    assert [rung.error for rung in ladder.front] == sorted((rung.error for rung in ladder.front), reverse=True)
    assert replace(ladder, rungs=ladder.front).front == ladder.front
    assert "gauss6 and dop853, which agree to" in ladder.reference


@pytest.mark.parametrize("step", [0.05, 0.01, 0.001])
def test_errors_are_the_true_ones(step):
    """After a quarter of its period the pendulum hangs at zero and moves at a known speed."""
    known = motion_reference(pendulum(), QUARTER, partial(simulate, pendulum(), SWING))
    motion = simulate(pendulum(), SWING, QUARTER, method="rk4", step=step)
    speed = -np.sqrt(2 * 9.81)
    true = max(abs(motion.q[-1, 0]) / (np.pi / 2), abs(motion.qd[-1, 0] / speed - 1))
    end, way = state_errors(motion, known)
    assert true <= end * (1 + 1e-6) + 4e-16
    assert end <= true * (1 + 1e-6) + 2 * known.bound
    assert end <= way


def test_references_are_within_their_bounds():
    """Of the double pendulum, whose state after 2 s is known to fifteen digits."""
    model, start = pendulum(masses=2), Scene(initial_q={"j1": 0.75 * np.pi})
    expected = np.array(reference("double_pendulum")["data"]["chaotic(3pi/4,0)"]["2"], dtype=float)
    known = motion_reference(model, 2.0, partial(simulate, model, start))
    assert "gauss6 and dop853" in known.how
    assert known.bound < 1e-11
    assert known.error(known.at(np.array([2.0])), expected[None])[0] <= known.bound + 1e-14


def test_a_motion_that_ends_at_a_limit():
    found = simulation_accuracy(slide(axis=(0, 0, 1)), Scene(gravity=(0, 0, -98.1)), 5.0)
    assert found.notes[0].startswith("compared up to 0.424")
    assert "reaches its lower limit of -9 m" in found.notes[0]
    assert all(rung.error <= 1e-11 for rung in found.ladders[0].rungs if rung.name.startswith("rk4"))


def test_kinds_are_compared_with_their_own():
    model, _ = tumbling()
    states = np.ones((3, model.nq + model.n))
    states[:, 0], states[:, 3:7] = 50.0, 0.25
    measure = MotionError.over(model, states)
    off = states.copy()
    off[1, 1] += 0.5
    off[2, 3] += 0.5
    assert measure(off, states).tolist() == [0.0, 0.01, 0.5]


def test_a_table_is_asked_for():
    with pytest.raises(InputError, match=r"the scene names 'push', columns of a table \(give the table: --traj FILE\)"):
        simulation_accuracy(pendulum(), PUSHED, 1.0)


def test_tables_are_followed():
    """A table of a constant torque makes the motion that is known of that torque."""
    table = {"time": [0.0, 0.1, 0.25], "push": [2.0, 2.0, 2.0]}
    model, times = pendulum(), np.linspace(0.0, 0.25, 40)
    constant = replace(SWING, drive={"j1": Drive(torque=2.0)})
    known = motion_reference(model, 0.25, partial(simulate, model, constant))
    found = motion_reference(model, 0.25, partial(simulate, model, PUSHED, table=table))
    assert "gauss6 and dop853" in found.how
    assert found.error(found.at(times), known.at(times)).max() <= found.bound + known.bound


def test_an_initial_state_of_a_table_is_that_of_the_reference():
    """A series from q = 0, where the motion does not begin, made every method wrong by as much."""
    scene = replace(SWING, initial_q={"j1": "begin"}, initial_qd={})
    found = simulation_accuracy(pendulum(), scene, table={"time": [0.0, 0.2], "begin": [0.7, 0.0]})
    assert found.name.endswith(", 0.2 s")
    assert min(rung.error for rung in found.ladders[0].rungs) <= 1e-12


def test_closed_chains():
    model, scene = four_bars(1)
    found = simulation_accuracy(model, scene, 0.032)
    assert found.ladders[0].reference.startswith("gauss6 and dop853, which agree to ")
    rungs = {rung.name: rung for rung in found.ladders[0].rungs}
    assert 100 <= rungs["rk4, 16 ms"].error / rungs["rk4, 4 ms"].error <= 700
    assert rungs["gauss6, 4 ms"].error <= 1e-11
