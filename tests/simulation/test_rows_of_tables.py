"""Steps end at the rows of tables: no pulse between two steps is lost, counted twice or smeared."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.random_scenes import momentum_of, pushed_slide
from helpers.sampled import sampled
from helpers.simulated_robots import pendulum, slide

import robodyn
from robodyn.errors import RobodynError
from robodyn.measure.accuracy.simulate_within import simulate_within
from robodyn.scene.scene import Drive, Scene
from robodyn.simulation.methods import METHODS

PUSHED = Scene(gravity=(0, 0, 0), joint_limits="ignore", drive={"j1": Drive(torque="push")})
PULSE = {"time": [0.0, 0.1001, 0.1004, 0.1007, 1.0], "push": [0.0, 0.0, 5000.0, 0.0, 0.0]}
TENTHS = {"time": np.arange(10001) / 1e4, "push": np.where(np.arange(10001) % 10, 0.0, 10.0)}
CASES = [("linear", PULSE, 1.5), ("hold", PULSE, 1.5), ("linear", TENTHS, 0.999 + 0.001), ("hold", TENTHS, 1.0)]
FIXED = [method.name for method in METHODS if not (method.adaptive or method.keeps_momenta)]
QUICK = [{}, {"rtol": 1e-9}, {"method": "radau"}, {"method": "euler"}, {"method": "gauss4"}]
SLOW = [{"method": name} for name in FIXED if name not in ("euler", "gauss4")]
WAYS = [*QUICK, *(pytest.param(how, marks=pytest.mark.slow) for how in SLOW)]


@pytest.mark.parametrize("how", WAYS, ids=str)
@pytest.mark.parametrize(("between", "table", "impulse"), CASES)
def test_no_pulse_is_passed_over(between, table, impulse, how):
    """Pulses shorter than a step, and one that is longer than any other step of a quick method."""
    slow = "radau" in how.values() or "rtol" in how
    part = 0.02 if slow and len(table["time"]) > 5 else 1.0  # they take their time for each row
    found = robodyn.simulate(slide(1.0), replace(PUSHED, between_rows=between), part, table=table, **how)
    first = how.get("method") in ("euler", "symplectic-euler") and between == "linear"  # they take a step's first force
    assert abs(found.qd[-1, 0] - part * impulse) <= (1.5 if first else 1e-8)
    said = "torques and wrenches between rows are held until the next"
    assert any(said in note for note in found.notes) == (between == "hold")


@pytest.mark.slow
def test_an_accuracy_for_more_rows_than_a_method_of_scipy_can_do_with():
    """Noise of 10 000 rows drives a pendulum: rk4 and gauss6 confirm each other."""
    rng = np.random.default_rng(3)
    table = {"time": np.arange(10001) / 1e4, "push": rng.normal(size=10001)}
    scene = replace(PUSHED, gravity=(0, 0, -9.81), initial_q={"j1": 1.0})
    found = simulate_within(pendulum(), scene, None, 1e-6, table=table)
    fine = robodyn.simulate(pendulum(), scene, table=table, step=1e-5, method="gauss4")
    assert np.abs(found.qd[-1] - fine.qd[-1]).max() <= found.expected_error * np.abs(fine.qd).max() + 1e-13
    assert {"rk4", "gauss6"} <= set(found.notes[-1].replace(",", "").split())


@pytest.mark.parametrize("seed", [*range(3), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(3, 9))])
def test_random_tables_give_their_impulse(seed):
    """Rows finer and coarser than steps, at commensurate times and others, shorter and longer than the motion."""
    rng = np.random.default_rng(seed)
    pushed = pushed_slide(rng)
    how = [{"step": pushed.step}, {"step": pushed.step, "method": "gauss4"}, {"rtol": 1e-10}][seed % 3]
    found = robodyn.simulate(pushed.model, pushed.scene, pushed.duration, table=pushed.table, **how)
    expected, largest = momentum_of(pushed)
    assert abs(found.qd[-1, 0] - expected) <= (1e-7 if "rtol" in how else 1e-12) * largest


@pytest.mark.parametrize("name", sampled(["verlet", "midpoint", "gauss2", "rk4", "gauss4"], 3))
def test_order_is_kept_across_rows(name):
    """Half the step leaves 2^-order of the error, though rows lie inside steps and forces jump there."""
    time = np.array([0.0, 0.0913, 0.31, 0.3137, 0.7, 1.0])
    table = {"time": time, "push": np.array([1.0, -9.0, 4.0, 40.0, -3.0, 0.0])}
    method = next(method for method in METHODS if method.name == name)
    scene = replace(PUSHED, between_rows="hold", gravity=(0, 0, -9.81), initial_q={"j1": 0.5})
    ends = [robodyn.simulate(pendulum(), scene, table=table, step=h, method=name) for h in (0.02, 0.01, 1e-4)]
    coarse, fine = (abs(found.q[-1, 0] - ends[-1].q[-1, 0]) for found in ends[:2])
    assert fine <= 1.5 * 2.0**-method.order * coarse + 1e-13


def test_rows_that_are_steps_but_for_rounding_make_no_steps():
    time = np.cumsum(np.full(1000, 1e-3))
    table = {"time": np.round(np.concatenate(([0.0], time)), 12), "push": np.sin(np.arange(1001.0))}
    found = robodyn.simulate(slide(), PUSHED, table=table)
    assert found.steps == 1000
    assert not any("steps end at rows" in note for note in found.notes)


def test_how_many_steps_rows_make_is_told(monkeypatch):
    found = robodyn.simulate(slide(1.0), PUSHED, table=TENTHS)
    assert found.steps in (3000, 10000)
    assert f"steps end at rows of the table too: {found.steps} steps instead of 1000" in found.notes
    assert len(found.time) == found.steps + 1
    quick = robodyn.simulate(slide(1.0), PUSHED, table=PULSE, rtol=1e-6)
    assert "steps end at 3 rows of the table too" in " ".join(quick.notes)
    monkeypatch.setattr("robodyn.simulation.integrate.MOST_ROWS", 2998)
    with pytest.raises(RobodynError, match="have to end at 2999 rows of the table, more than 2998"):
        robodyn.simulate(slide(1.0), PUSHED, table=TENTHS, rtol=1e-6)


@pytest.mark.parametrize(("between", "how"), [("linear", {}), ("hold", {"step": 0.05}), ("linear", {"rtol": 1e-3})])
def test_a_peak_between_steps_is_held_against_the_limit_of_effort(between, how):
    """5000 N for less than a step, of a drive that may have 1000 N."""
    found = robodyn.simulate(slide(1.0), replace(PUSHED, between_rows=between), table=PULSE, **how)
    (use,) = found.joints
    assert use.peak == 5000.0
    assert use.peak_time == 0.1004
    assert [excess.limit for excess in found.exceeded] == [1000.0]


def test_peaks_at_rows_are_recorded_where_few_steps_are(monkeypatch):
    """Records every 20 steps, a pulse from the 333rd to the 334th, and rows between that change nothing."""
    monkeypatch.setattr("robodyn.simulation.integrate.MOST_RECORDS", 50)
    time = np.arange(1001) / 1000
    table = {"time": time, "push": np.where(np.arange(1001) == 333, 5000.0, 0.0)}
    found = robodyn.simulate(slide(1.0), replace(PUSHED, between_rows="hold"), table=table)
    assert (found.joints[0].peak, found.joints[0].peak_time) == (5000.0, 0.333)
    assert len(found.time) == 51 + 2
    assert found.steps == 1000


@pytest.mark.parametrize("between", ["linear", "hold"])
def test_rows_at_which_nothing_changes_make_no_steps(between):
    table = {"time": np.linspace(0.0, 1.0, 8001), "push": np.zeros(8001)}
    assert robodyn.simulate(slide(), replace(PUSHED, between_rows=between), table=table).steps == 1000


@pytest.mark.parametrize("between", ["linear", "hold"])
def test_tables_of_microseconds(between):
    time = 1e-6 * np.array([0.0, 0.1, 0.10001, 0.5, 1.0])
    force = np.array([0.0, 2.0, -7.0, 3.0, 0.0])
    table = {"time": time, "push": force}
    expected = np.diff(time) @ (force[:-1] if between == "hold" else 0.5 * (force[1:] + force[:-1]))
    for how in ({}, {"step": 3e-7}, {"rtol": 1e-9}):
        found = robodyn.simulate(slide(1.0), replace(PUSHED, between_rows=between), table=table, **how)
        assert found.time[-1] == 1e-6
        assert abs(found.qd[-1, 0] - expected) <= 1e-12 * 7e-6, how


def test_a_reference_quicker_than_steps_is_followed():
    """A reference with a bump of ten rows inside one step: a drive's torque over it is that of fine steps."""
    time = np.linspace(0.0, 0.1, 10001)
    bump = 1e-3 * np.exp(-(((time - 0.05037) / 4e-5) ** 2))
    scene = replace(PUSHED, drive={"j1": Drive(kp=1e6, reference="q")})
    table = {"time": time, "q": bump}
    ends = [robodyn.simulate(slide(1.0), scene, table=table, step=step).qd[-1, 0] for step in (1e-3, 1e-5)]
    assert abs(ends[0] - ends[1]) <= 1e-6 * abs(ends[1])


@pytest.mark.parametrize("executor", ["numpy", "compiled"])
def test_rollouts_end_steps_at_rows(executor):
    q = np.zeros((3, 1))
    scene = replace(PUSHED, between_rows="hold")
    found = robodyn.rollouts(slide(1.0), q, q, 100, 1e-2, every=10, scene=scene, table=PULSE, executor=executor)
    assert len(found.time) == 11
    assert np.abs(found.qd[-1] - 1.5).max() <= 1e-12
