"""Drives, wrenches and initial states that follow the columns of a table."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.oracles import robot
from helpers.simulated_robots import pendulum, slide

import robodyn
from robodyn.errors import InputError, RobodynError
from robodyn.scene.scene import Drive, ExternalWrench, Scene
from robodyn.simulation.methods import method_named

TIME = np.linspace(0.0, 2.0, 101)
WEIGHTLESS = Scene(gravity=(0, 0, 0), joint_limits="ignore")
PUSHED = replace(WEIGHTLESS, drive={"j1": Drive(torque="push")})


def end(found):
    return np.array([found.q[-1, 0], found.qd[-1, 0], found.work[-1]])


def exact_push(m, time, force):
    """q, qd and work at the end of a push that is straight between rows: both are integrals of polynomials."""
    q = qd = work = 0.0
    for h, f, g in zip(np.diff(time), force[:-1], force[1:], strict=True):
        slope = (g - f) / h
        after = qd + (f * h + slope * h * h / 2) / m
        q += qd * h + (f * h * h / 2 + slope * h**3 / 6) / m
        work += m * (after**2 - qd**2) / 2
        qd = after
    return np.array([q, qd, work])


@pytest.mark.parametrize(
    ("name", "executor"), [("midpoint", "numpy"), ("verlet", "compiled"), ("rk4", "numpy"), ("gauss4", "compiled")]
)
def test_a_torque_straight_between_rows(name, executor):
    time = np.array([0.0, 0.1, 0.3, 0.35, 0.6, 1.0])
    force = np.array([1.0, -2.0, 4.0, 4.0, 0.0, 3.0])
    found = robodyn.simulate(
        slide(2.0), PUSHED, table={"time": time, "push": force}, step=0.05, method=name, executor=executor
    )
    expected = exact_push(2.0, time, force)
    assert found.time[-1] == 1.0
    if name in ("rk4", "gauss4", "gauss6"):  # exact for cubics, and every row is the end of a step
        assert np.abs(end(found) - expected).max() <= 1e-14 * np.abs(expected).max()
    else:
        assert abs(found.qd[-1, 0] - expected[1]) <= 1e-14
        assert np.abs(end(found) - expected).max() <= 2e-3


def test_a_torque_that_is_held():
    time, force = np.array([0.0, 0.1, 0.3, 0.6, 1.0]), np.array([1.0, -2.0, 4.0, 0.5, 99.0])
    held = replace(PUSHED, between_rows="hold")
    for how in ({"step": 0.05}, {"step": 0.1, "method": "verlet"}, {"rtol": 1e-11}):
        found = robodyn.simulate(slide(2.0), held, table={"time": time, "push": force}, **how)
        assert abs(found.qd[-1, 0] - force[:-1] @ np.diff(time) / 2.0) <= 1e-7, how


@pytest.mark.parametrize("name", ["symplectic-euler", "rk4", "dop853"])
def test_references_are_followed_with_their_slopes(name):
    """With the torque of the motion fed forward, an arm on its reference stays on it."""
    model, method = robot("two_link_planar"), method_named(name)
    q = np.column_stack([0.3 * np.sin(3 * TIME) - 0.2, 0.5 * np.cos(2 * TIME)])
    qd = np.column_stack([0.9 * np.cos(3 * TIME), -1.0 * np.sin(2 * TIME)])
    qdd = np.column_stack([-2.7 * np.sin(3 * TIME), -2.0 * np.cos(2 * TIME)])
    tau = robodyn.inverse_dynamics(model, q, qd, qdd)
    joints = ("shoulder", "elbow")
    scene = Scene(
        initial_q={joint: f"q_{joint}" for joint in joints},
        initial_qd={"shoulder": "v1"},
        drive={joint: Drive(f"tau_{joint}", 400.0, 40.0, f"q_{joint}") for joint in joints},
        joint_limits="ignore",
    )
    table = {"time": TIME + 5.0, "v1": qd[:, 0]}
    table |= {f"{kind}_{joint}": x[:, i] for kind, x in (("q", q), ("tau", tau)) for i, joint in enumerate(joints)}
    how = {"rtol": 1e-8} if method.adaptive else {"step": 2e-3}
    found = robodyn.simulate(model, scene, 0.5, table=table, method=name, **how)
    expected = np.column_stack([0.3 * np.sin(3 * found.time) - 0.2, 0.5 * np.cos(2 * found.time)])
    assert np.abs(found.q - expected).max() <= (2e-3 if method.order == 1 else 1e-4)
    assert found.q[0].tolist() == q[0].tolist()
    assert found.energy_drift <= {1: 2.0, 2: 1e-3}.get(method.order, 1e-5)
    note = next(note for note in found.notes if note.startswith("table of arrays: 101 rows over 2 s"))
    assert "its first row, 5 s, is time 0" in note
    assert "references are cubic splines, with their slopes for speeds" in note


def test_a_speed_of_its_own():
    scene = replace(WEIGHTLESS, drive={"j1": Drive(kd=50.0, speed="v")})
    found = robodyn.simulate(slide(2.0), scene, table={"time": TIME, "v": 0.5 * TIME})
    assert abs(found.qd[-1, 0] - (1.0 - 0.5 * 2.0 / 50)) <= 1e-9
    steady = replace(WEIGHTLESS, drive={"j1": Drive(kd=50.0, speed=0.3)})
    assert abs(robodyn.simulate(slide(2.0), steady, 2.0).qd[-1, 0] - 0.3) <= 1e-9


def test_a_reference_that_was_wrapped():
    """A continuous joint's encoder jumps by 2 pi; its drive does not."""
    turn = 3.0 * TIME
    wrapped = np.mod(turn + np.pi, 2 * np.pi) - np.pi
    scene = replace(WEIGHTLESS, drive={"j1": Drive(kp=100.0, kd=20.0, reference="angle")})
    scene = replace(scene, initial_qd={"j1": 3.0})
    found = robodyn.simulate(pendulum(), scene, table={"time": TIME, "angle": wrapped})
    assert np.abs(found.q[:, 0] - 3.0 * found.time).max() <= 1e-9


def test_a_wrench_of_columns():
    wrench = ExternalWrench("l1", ("push", 0.0, 0.0), frame="world")
    found = robodyn.simulate(slide(2.0), replace(WEIGHTLESS, wrenches=(wrench,)), table={"t": TIME, "push": TIME})
    assert abs(found.qd[-1, 0] - 1.0) <= 1e-13
    assert abs(found.work[-1] - 1.0) <= 1e-13


def test_chunks_and_thinned_records_are_given_the_same_rows(monkeypatch):
    table = {"time": TIME, "push": np.sin(20 * TIME)}
    full = robodyn.simulate(slide(), PUSHED, table=table, step=1e-2, executor="compiled")
    monkeypatch.setattr("robodyn.simulation.integrate.CHUNK", 7)
    assert (robodyn.simulate(slide(), PUSHED, table=table, step=1e-2, executor="compiled").q == full.q).all()
    monkeypatch.setattr("robodyn.simulation.integrate.MOST_RECORDS", 50)
    thin = robodyn.simulate(slide(), PUSHED, table=table, step=1e-2, executor="compiled")
    assert np.abs(thin.q - full.q[::2]).max() <= 1e-14  # rows, at every other step, are recorded


def test_a_limit_is_found_under_a_changing_push():
    table = {"time": 10 * TIME, "push": 6.0 * TIME}
    found = robodyn.simulate(slide(2.0), replace(PUSHED, joint_limits="stop"), table=table, step=0.013)
    assert abs(found.time[-1] - (9.0 * 2.0 * 6.0 / 0.6) ** (1 / 3)) <= 1e-12
    assert abs(found.q[-1, 0] - 9.0) <= 1e-12


WRONG = [
    (WEIGHTLESS, {}, "the scene names no column of the table"),
    (PUSHED, {"duration": 3.0}, "the table lasts 2 s, the simulation 3 s"),
    (PUSHED, {"table": None}, "the scene names 'push', columns of a table"),
    (PUSHED, {"table": {"time": [0.0], "push": [1.0]}}, "the table has one row"),
    (PUSHED, {"table": {"time": TIME, "pusch": TIME}}, "no column 'push', which the scene names"),
    (PUSHED, {"table": {"time": TIME[::-1], "push": TIME}}, "time"),
    (PUSHED, {"table": {"time": TIME, "push": TIME[1:]}}, "'time' has 101 rows, 'push' has 100"),
    (PUSHED, {"table": {"time": TIME, "push": np.where(TIME > 1, np.nan, 0)}}, "column 'push' is empty or NaN"),
]


@pytest.mark.parametrize(("scene", "how", "what"), WRONG)
def test_what_does_not_fit(scene, how, what):
    with pytest.raises(RobodynError, match=what):
        robodyn.simulate(slide(), scene, **{"table": {"time": TIME, "push": TIME}} | how)


@pytest.mark.parametrize("executor", ["numpy", "compiled"])
def test_rollouts_follow_a_table_together(executor):
    table = {"time": TIME, "push": np.sin(20 * TIME)}
    q = np.linspace(0.0, 1.0, 11)[:, None]
    found = robodyn.rollouts(slide(), q, 0 * q, 1600, 1e-3, every=4, scene=PUSHED, table=table, executor=executor)
    alone = robodyn.simulate(slide(), PUSHED, 1.6, table=table, step=1e-3)
    assert np.abs(found.q[:, :, 0] - q[:, 0] - alone.q[::4]).max() <= 1e-13


def test_rollouts_without_their_table():
    with pytest.raises(RobodynError, match="the scene names 'push', columns of a table"):
        robodyn.rollouts(slide(), [[0.0]], [[0.0]], 10, 1e-3, scene=PUSHED)
    table = {"time": TIME, "push": TIME}
    with pytest.raises(InputError, match="the table lasts 2 s, the simulation 3 s"):
        robodyn.rollouts(slide(), [[0.0]], [[0.0]], 3000, 1e-3, scene=PUSHED, table=table)
