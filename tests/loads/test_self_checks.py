"""Self-checks hold on right results and fail on wrong ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.motions import waves
from helpers.oracles import ROBOTS, random_state, robot, run

import robodyn.dynamics.plan
from robodyn.dynamics.inverse import mass_matrix
from robodyn.dynamics.momenta import LawResiduals, laws, losses
from robodyn.dynamics.plan import Plan
from robodyn.dynamics.recursions.newton_euler import newton_euler
from robodyn.loads.accumulate import EnergyLedger
from robodyn.loads.result import EnergyBalance
from robodyn.loads.torques import torques
from robodyn.scene.read import load_scene
from robodyn.scene.scene import Scene
from robodyn.trajectory.read import motion, read_motion

EXAMPLES = {
    "scara_pick_and_place": ("scara", None),
    "satellite_slew": ("satellite", "satellite"),
    "puma560_sweep": ("puma560", "puma560_motors"),
    "gripper_pick": ("gripper", "gripper"),
    "rigid_body_flip": ("rigid_body", "rigid_body"),
}


@pytest.mark.parametrize("name", EXAMPLES)
def test_hold_on_every_example(name):
    """Tables of robots/ carry rounded columns: energy agrees within its sampling, the laws to rounding."""
    urdf, toml = EXAMPLES[name]
    scene = load_scene(ROBOTS / f"{toml}.toml") if toml else Scene()
    model = robot(urdf, scene.moving_base)
    with read_motion(ROBOTS / f"{name}.csv", model, scene) as reader:
        result = torques(model, reader, scene)
    assert result.checks.energy_balance.consistent
    assert max(result.checks.first_law, result.checks.second_law, result.checks.power) <= 1e-12
    assert not [warning for warning in result.warnings if "energy" in warning]
    largest = max((abs(load.peak) for load in result.joints), default=0.0)
    for load in result.joints:
        assert abs(sum(load.shares.values()) - load.peak) <= 1e-12 * largest


def test_hold_with_every_effect():
    model = busy_robot(True)
    rng = np.random.default_rng(1)
    state = random_state(model, rng, 200)
    columns = {name: rng.normal(size=200) for name in BUSY_SCENE.columns}
    trajectory = motion(model, np.arange(200) * 1.0, *state, columns=columns)
    checks = torques(model, trajectory, BUSY_SCENE).checks
    assert max(checks.first_law, checks.second_law, checks.power) <= 1e-13
    assert checks.samples == 64


@pytest.mark.parametrize("still", [{"q"}, {"qd"}, {"q", "qd"}])
def test_hold_where_a_state_is_zero_throughout(still):
    """What is zero in every sample is folded away; its rate is not."""
    model = robot("puma")
    state = dict(zip(("q", "qd", "qdd"), random_state(model, np.random.default_rng(3), 20), strict=True))
    checks = torques(
        model, motion(model, np.arange(20.0), *(x * (name not in still) for name, x in state.items()))
    ).checks
    assert max(checks.first_law, checks.second_law, checks.power) <= 1e-13


MUTATIONS = {
    "a wrong force": lambda wrench: wrench._replace(f=wrench.f * 1.001),
    "a wrong moment": lambda wrench: wrench._replace(n=wrench.n + np.array([0, 0, 0.001])),
    "a flipped axis": lambda wrench: wrench._replace(n=wrench.n * np.array([1, -1, 1])),
}


@pytest.mark.parametrize("mutation", MUTATIONS)
def test_a_wrong_wrench_shows_up(mutation, monkeypatch):
    """The momentum recursion does not share what the force recursion got wrong."""

    def wrong(*args):
        return [MUTATIONS[mutation](wrench) for wrench in newton_euler(*args)]

    monkeypatch.setattr(robodyn.dynamics.plan, "newton_euler", wrong)
    model = busy_robot.__wrapped__()  # one of its own, whose programs nobody else finds
    plain = replace(BUSY_SCENE, wrenches=(), immersed=())
    trajectory = waves(model, np.linspace(0, 2, 100))
    checks = torques(model, trajectory, plain).checks
    assert max(checks.first_law, checks.second_law) >= 1e-6
    assert checks.power >= 1e-6


def test_a_wrong_joint_torque_shows_up_in_the_power():
    model = busy_robot()
    plan = Plan(model, Scene())
    state = random_state(model, np.random.default_rng(2), 30)
    out = run(plan.wrenches(), plan, *state)
    tau, base = out[:, : model.n].copy(), out[:, model.n :]
    expected, lost = run(laws(plan), plan, *state), run(losses(plan), plan, *state)[:, 0]
    for nudge, bound in ((0.0, 1e-14), (1e-6, np.inf)):
        residuals = LawResiduals()
        gross = tau * state[1]
        gross[:, 2] *= 1 + nudge
        residuals.update(expected, base, gross.sum(1) - lost, gross)
        assert residuals.relative[2] <= bound
        assert nudge == 0 or residuals.relative[2] > 1e-9


def test_a_velocity_that_is_not_the_rate_of_the_position_is_told():
    model = robot("puma")
    t = np.linspace(0, 2, 1001)[:, None]
    span = np.array([1.0, -1.2, 0.7])
    good = motion(model, t[:, 0], *(span * x for x in (np.sin(t / 2), np.cos(t / 2) / 2, -np.sin(t / 2) / 4)))
    assert set(torques(model, good).warnings) == set(model.notes)
    for wrong in (replace(good, qd=0.9 * good.qd), replace(good, q=0.9 * good.q), replace(good, qdd=-good.qdd)):
        result = torques(model, wrong)
        assert not result.checks.energy_balance.consistent
        (warning,) = set(result.warnings) - set(model.notes)
        assert warning.startswith("energy balance is off by")
        assert warning.endswith("velocities or accelerations are not the rates of the positions")
        assert [caveat.text for caveat in result.caveats] == [warning]
        assert max(result.checks.first_law, result.checks.second_law) <= 1e-12


@pytest.mark.parametrize(
    ("numbers", "consistent"),
    [
        ((10.0, 10.0, 0.0, 10.0, 0.0099, 0.0, 0.0, 0.0), True),  # less than a thousandth of the turnover
        ((10.0, 10.0, 0.0, 10.0, -0.02, 0.0, 0.0, 0.0), False),
        ((10.0, 10.0, 0.0, 10.0, -0.02, 0.01, 0.004, 0.0), True),  # what sampling explains
        ((10.0, 10.0, 0.0, 10.0, -0.04, 0.01, 0.004, 0.0), False),
        ((10.0, 10.0, 0.0, 10.0, -0.4, 2.0, 0.0, 0.0), True),
        ((10.0, 10.0, 0.0, 10.0, -0.6, 2.0, 0.0, 0.0), False),  # more than a twentieth
        ((0.0, 0.0, 0.0, 0.0, 1e-16, 0.0, 0.0, 1.0), True),
    ],
)
def test_which_residuals_are_inconsistent(numbers, consistent):
    assert EnergyBalance(*numbers).consistent is consistent


def test_wrong_accelerations_show_up_although_the_ends_agree():
    """What a wrong acceleration gives to the motion it takes back before the end; the balance is judged on the way."""
    model = robot("puma560")
    given = waves(model, np.linspace(0, 3, 1001))
    right, wrong = (torques(model, replace(given, qdd=scale * given.qdd)) for scale in (1.0, 1.2))
    assert right.checks.energy_balance.consistent
    assert not wrong.checks.energy_balance.consistent
    assert abs(wrong.checks.energy_balance.residual) < 1e-3 * wrong.checks.energy_balance.turnover
    assert any("energy" in warning for warning in wrong.warnings)


@pytest.mark.parametrize("size", [1, 300])
def test_ledger_does_not_depend_on_blocks(size):
    rng = np.random.default_rng(9)
    time = np.sort(rng.uniform(0, 3, 300))
    power, energy = rng.normal(size=300), rng.normal(size=300)
    ledger = EnergyLedger()
    for start in range(0, 300, size):
        part = slice(start, start + size)
        ledger.update(time[part], power[part], np.arange(len(time[part])), energy[part])
    work = np.append(0.0, np.cumsum(np.diff(time) * (power[1:] + power[:-1]) / 2))
    residual = work - (energy - energy[0])
    assert abs(ledger.balance.work - work[-1]) <= 1e-14
    assert abs(ledger.balance.worst - residual[np.argmax(np.abs(residual))]) <= 1e-14
    assert abs(ledger.balance.residual - residual[-1]) <= 1e-14


def test_uncertainty_of_noisy_positions():
    """sqrt(sum (M_kj s_j)^2) at each joint's peak; none where accelerations are given."""
    model = robot("puma")
    clean = waves(model, np.linspace(0, 4, 2001), amplitude=0.3)
    assert {load.uncertainty for load in torques(model, clean).joints} == {0.0}
    noise = np.random.default_rng(6).normal(scale=1e-4, size=clean.q.shape)
    derived = motion(model, clean.time, clean.q + noise, derivatives="savgol")
    for k, load in enumerate(torques(model, derived).joints):
        row = load.peak_row - 1
        std = derived.sampling.noise[row]
        assert (std > 0).all()
        M = mass_matrix(model, derived.q[row])
        assert load.uncertainty == pytest.approx(np.linalg.norm(M[k] * std), rel=1e-12)
