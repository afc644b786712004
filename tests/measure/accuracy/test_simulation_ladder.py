"""Errors of simulated motions against closed forms, and what else their ladder tells."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import partial

import numpy as np
import pytest
from helpers import series_reference as reference_module
from helpers.closed_chains import four_bars
from helpers.oracles import reference
from helpers.series_reference import BITS, Taylor, fixed, motion_reference, step_of, summed
from helpers.simulated_robots import pendulum, slide, tumbling

from robodyn.dynamics.plan import plan
from robodyn.errors import InputError
from robodyn.measure.accuracy import simulation as simulation_ladder
from robodyn.measure.accuracy.ladder import front
from robodyn.measure.accuracy.simulation import MotionError, simulation_accuracy, state_errors
from robodyn.programs.program import trace
from robodyn.scene.scene import Drive, Scene
from robodyn.simulation.equations import STATE, Equations
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
    assert front(ladder.front) == ladder.front
    assert "gauss6 and dop853, which agree to" in ladder.reference


@pytest.mark.parametrize("step", [0.05, 0.01, 0.001])
def test_errors_are_the_true_ones(step):
    """After a quarter of its period the pendulum hangs at zero and moves at a known speed."""
    a_plan = plan(pendulum(), SWING)
    known = motion_reference(a_plan, QUARTER)
    motion = simulate(pendulum(), SWING, QUARTER, method="rk4", step=step)
    speed = -np.sqrt(2 * 9.81)
    true = max(abs(motion.q[-1, 0]) / (np.pi / 2), abs(motion.qd[-1, 0] / speed - 1))
    end, way = state_errors(motion, known)
    assert true <= end * (1 + 1e-6) + 4e-16
    assert end <= true * (1 + 1e-6) + 2 * known.bound
    assert end <= way


def test_references_agree(monkeypatch):
    """Series and doubles are independent, and each is within its bound."""
    model, scene = tumbling()
    a_plan = plan(model, replace(scene, friction={}))
    times = np.linspace(0.0, 0.1, 40)
    series = motion_reference(a_plan, 0.1)
    monkeypatch.setattr(reference_module, "PATIENCE", 0.0)
    doubles = motion_reference(a_plan, 0.1)
    assert "gauss6 and dop853" in doubles.how
    assert series.bound < 1e-15 < doubles.bound < 1e-10
    off = series.error(doubles.at(times), series.at(times))
    assert off.max() <= 2 * doubles.bound


def test_a_motion_that_ends_at_a_limit():
    found = simulation_accuracy(slide(axis=(0, 0, 1)), Scene(), 5.0)
    assert found.notes[0].startswith("compared up to 1.34")
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
    """A table of a constant torque makes the motion that is known of that torque; its duration is the usual one."""
    table = {"time": [0.0, 0.1, 0.25], "push": [2.0, 2.0, 2.0]}
    model, times = pendulum(), np.linspace(0.0, 0.25, 40)
    known = motion_reference(plan(model, replace(SWING, drive={"j1": Drive(torque=2.0)})), 0.25)
    found = motion_reference(plan(model, PUSHED), 0.25, partial(simulate, model, PUSHED, table=table))
    assert "gauss6 and dop853" in found.how
    assert found.error(found.at(times), known.at(times)).max() <= found.bound + known.bound
    whole = simulation_accuracy(model, PUSHED, table=table)
    assert whole.name.endswith(", 0.25 s")
    rungs = {rung.name: rung for rung in whole.ladders[0].rungs}
    assert rungs["rk4, 4 ms"].errors[0] <= 1e-9 < rungs["euler, 4 ms"].errors[0]


def test_an_initial_state_of_a_table_is_that_of_the_reference():
    """A series from q = 0, where the motion does not begin, made every method wrong by as much."""
    model, scene = pendulum(), replace(SWING, initial_q={"j1": "begin"}, initial_qd={})
    found = simulation_accuracy(model, scene, 0.2, {"time": [0.0, 1.0], "begin": [0.7, 0.0]})
    assert min(rung.error for rung in found.ladders[0].rungs) <= 1e-12


def test_closed_chains():
    model, scene = four_bars(1)
    found = simulation_accuracy(model, scene, 0.4)
    assert found.ladders[0].reference.startswith("gauss6 and dop853, which agree to ")
    rungs = {rung.name: rung for rung in found.ladders[0].rungs}
    assert 100 <= rungs["rk4, 16 ms"].error / rungs["rk4, 4 ms"].error <= 700
    assert rungs["gauss6, 4 ms"].error <= 1e-11


mpmath = pytest.importorskip("mpmath")

ONE = 1 << BITS
PRINTED = reference("double_pendulum")["data"]


def solved(program, state, duration, order=24, tolerance=1e-24):
    """The state after the duration, all in fixed point."""
    series_of = Taylor(program, "state", len(state), order)
    now = 0
    while now < duration:
        series = series_of(state)
        step = min(fixed(step_of(series, tolerance)), duration - now)
        state, now = summed(series, step), now + step
    return state


def of(model, scene, state, duration):
    equations = Equations(plan(model, scene))
    return solved(equations.derivatives(), [*state, 0, 0], duration)[: len(state)]


@pytest.mark.parametrize(("case", "eighths"), [("large(pi/2,0)", 4), ("chaotic(3pi/4,0)", 6)])
def test_double_pendulum(case, eighths):
    """Within the last digit of the reference; and orders agree far beyond it."""
    with mpmath.workdps(70):
        state = [int(mpmath.ldexp(eighths * mpmath.pi / 8, BITS)), 0, 0, 0]
    equations = Equations(plan(pendulum(masses=2), Scene()))
    ways = ((24, 1e-24), (16, 1e-20))
    found, other = (solved(equations.derivatives(), [*state, 0, 0], 2 * ONE, *way)[:4] for way in ways)
    for value, same, expected in zip(found, other, PRINTED[case]["2"], strict=True):
        last = Fraction(1, 10 ** len(expected.partition(".")[2]))
        assert abs(Fraction(value, ONE) - Fraction(expected)) <= last
        assert abs(Fraction(value - same, ONE)) <= 1e-17


def test_every_operation():
    """y' = exp(y) / (1 + sqrt(y)): its time as a function of y is an integral."""

    def outputs(tape):
        y = tape.input("state", 0)
        return [y.exp() / (1.0 + y.sqrt()) - 0.25 * (-y).exp() * y]

    found = solved(trace(outputs), [ONE], fixed(0.75), order=30)
    with mpmath.workdps(40):
        end = mpmath.ldexp(found[0], -BITS)

        def slowness(y):
            return 1 / (mpmath.exp(y) / (1 + mpmath.sqrt(y)) - y * mpmath.exp(-y) / 4)

        assert abs(mpmath.quad(slowness, mpmath.linspace(1, end, 9)) - 0.75) <= 1e-22


def test_jumps_and_tables_have_no_series():
    for outputs in (lambda tape: [tape.input("state", 0).sign()], lambda tape: [tape.input("time", 0)]):
        with pytest.raises(InputError, match="no power series"):
            Taylor(trace(outputs), STATE, 1, 8)
