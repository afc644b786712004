"""Torques of closed chains against virtual work, simulations that they undo and bases that loops hold."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS, run
from helpers.driven_chains import MIDDLE, SCENES, Chain, moving, still, swinging
from helpers.robot_files import read_table
from helpers.virtual_work import shared

import robodyn

SOME = [pytest.param(name, marks=[pytest.mark.slow] * (name not in ("crank_slider", "four_bar"))) for name in MIDDLE]
PARTS = ("fx", "fy", "fz", "mx", "my", "mz")
GAINS = {"crank_slider": 2.0, "four_bar": 40.0, "five_bar": 15.0, "delta": 15.0, "planar_3rrr": 15.0}
"""N m/rad of the drives that pull the chains of a simulation along."""


def motors_alone(chain: Chain, times: np.ndarray, path: Path) -> Path:
    """Write the motion of the driven joints."""
    columns = {"time": times}
    for level, values in zip(("q", "qd", "qdd"), chain.state, strict=True):
        columns |= {f"{level}_{name}": values[:, chain.model.joint_names.index(name)] for name in chain.place.motors}
    rows = np.column_stack([*columns.values()])
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.17g")
    return path


@pytest.mark.parametrize("name", MIDDLE)
def test_friction_springs_and_rotors_act_in_passive_joints_too(name):
    chain, rng = moving(name), np.random.default_rng(1)
    friction, spring, rotor, taken = {}, {}, {}, {}
    for joint, q, qd, qdd in zip(chain.model.joint_names, *(part.T for part in chain.state), strict=True):
        c, f, k, rest, J = rng.uniform(0.05, 0.5, 5)
        friction[joint] = robodyn.Friction(c, f, -f)
        spring[joint] = robodyn.Spring(k, rest)
        rotor[joint] = robodyn.Rotor(J / 100, 3.0)
        taken[joint] = c * qd + f * np.sign(qd) + k * (q - rest) + 9.0 * J / 100 * qdd
    scene = replace(chain.scene, friction=friction, spring=spring, rotor=rotor)
    tau = robodyn.inverse_dynamics(chain.model, *chain.state, scene=scene)
    expected = chain.torques_with(taken)
    assert np.abs(expected - chain.torques).max() >= 0.1 * np.abs(expected).max()
    np.testing.assert_allclose(tau, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


@pytest.mark.parametrize("name", MIDDLE)
def test_drives_of_all_joints_share_by_their_weights(name):
    chain = moving(name)
    names = chain.model.joint_names
    weights = dict(zip(names, np.random.default_rng(2).uniform(0.3, 3.0, len(names)).tolist(), strict=True))
    for given, scene in (
        (dict.fromkeys(names, 1.0), replace(chain.scene, actuated=None)),
        (weights, replace(chain.scene, actuated=None, share="weighted", weights=weights)),
    ):
        found = robodyn.inverse_dynamics(chain.model, *chain.state, scene=scene)
        expected = np.column_stack([*shared(chain.mechanism, chain.u, given).values()])
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


@pytest.mark.parametrize("name", SOME)
def test_a_motion_of_the_motors_alone_is_enough(name, tmp_path):
    times = np.linspace(0, 2, 41)
    chain = swinging(name, times)
    motion, out = motors_alone(chain, times, tmp_path / "motors.csv"), tmp_path / "tau.csv"
    (tmp_path / "scene.toml").write_text(without_friction(name))
    scene = str(tmp_path / "scene.toml")
    outcome = run("torques", str(ROBOTS / f"{name}.urdf"), str(motion), "--scene", scene, "--out", str(out))
    assert (outcome.status, outcome.err) == (0, "")
    found = read_table(out)
    bound = 1e-13 * np.abs(chain.torques).max()
    for motor in chain.place.motors:
        expected = chain.torques[:, chain.model.joint_names.index(motor)]
        np.testing.assert_allclose(found[f"tau_{motor}"], expected, rtol=0, atol=bound)
    passive = {f"tau_{joint}" for joint in chain.model.joint_names} - {f"tau_{motor}" for motor in chain.place.motors}
    assert not passive & set(found)


def without_friction(name: str) -> str:
    """The scene of robots/, whose oracle has no friction."""
    text = (ROBOTS / f"{SCENES[name]}.toml").read_text()
    return text.replace("rail = { viscous = 60.0 }", "rail = { viscous = 0.0 }")


def pulled(name: str, motors: tuple[str, ...]) -> str:
    """The scene of robots/ with its friction, and drives that pull every motor to a place of its own."""
    k, lines = GAINS[name], ["", "[drive]"]
    for i, motor in enumerate(motors):
        lines.append(
            f"{motor} = {{ torque = {0.3 + 0.1 * i}, kp = {k}, kd = {0.05 * k}, reference = {0.3 - 0.2 * i} }}"
        )
    return (ROBOTS / f"{SCENES[name]}.toml").read_text() + "\n".join(lines) + "\n"


@pytest.mark.parametrize("name", SOME)
def test_drives_and_loop_forces_of_a_simulation_come_back(name, tmp_path):
    chain = still(name, 1)
    urdf, scene = str(ROBOTS / f"{name}.urdf"), str(tmp_path / "scene.toml")
    moved, out = tmp_path / "moved.csv", tmp_path / "back.csv"
    (tmp_path / "scene.toml").write_text(pulled(name, chain.place.motors))
    outcome = run("simulate", urdf, "--scene", scene, "--duration", "0.1", "--step", "0.005", "--out", str(moved))
    assert (outcome.status, outcome.err) == (0, "")
    outcome = run("torques", urdf, str(moved), "--scene", scene, "--out", str(out))
    assert (outcome.status, outcome.err) == (0, "")
    expected, found = read_table(moved), read_table(out)
    loops = [loop.name for loop in chain.scene.loops]
    for names in (
        [f"tau_{motor}" for motor in chain.place.motors],
        *([f"{part}_{loop}" for loop in loops for part in group] for group in (PARTS[:3], PARTS[3:])),
    ):
        bound = 1e-13 * max(np.abs(expected[column]).max() for column in names)
        assert all(np.abs(found[column] - expected[column]).max() <= bound for column in names)
    assert max(np.abs(expected[f"tau_{motor}"]).max() for motor in chain.place.motors) >= 0.3


def test_no_samples_and_samples_that_are_none():
    chain = moving("four_bar")
    q, qd, qdd = chain.state
    assert robodyn.inverse_dynamics(chain.model, q[:0], qd[:0], qdd[:0], scene=chain.scene).shape == (0, 3)
    found = robodyn.constraint_forces(chain.model, q[:0], qd[:0], qdd[:0], scene=chain.scene)
    assert [wrench.shape for wrench in found.wrenches.values()] == [(0, 6)]
    bad = qd.copy()
    bad[2, 0] = np.nan
    with pytest.raises(robodyn.RobodynError, match="qd of sample 2 is not finite"):
        robodyn.inverse_dynamics(chain.model, q, bad, qdd, scene=chain.scene)


def test_loops_of_small_robots_are_open_by_their_size():
    """A tenth of a millimetre is much to a four-bar of a millimetre."""
    chain = moving("four_bar")
    text = (ROBOTS / "four_bar.urdf").read_text()
    small = robodyn.load(
        text.replace('xyz="0.5 0 0"', 'xyz="5e-4 0 0"').replace('xyz="0 0 0.3"', 'xyz="0 0 3e-4"').encode()
    )
    (loop,) = chain.scene.loops
    scene = replace(chain.scene, loops=(replace(loop, point=(5e-4, 0.0, 0.0), to_point=(0.0, 0.0, 3e-4)),))
    q = {"left": 0.3, "right": 0.3, "top": -0.3}
    closed = [q[name] for name in small.rates]
    assert np.isfinite(robodyn.inverse_dynamics(small, closed, 0.0, 0.0, scene=scene)).all()
    q["right"] += 0.3
    with pytest.raises(robodyn.RobodynError, match=r"loop 'right_pin' is open by 8\.87e-05 m"):
        robodyn.inverse_dynamics(small, [q[name] for name in small.rates], 0.0, 0.0, scene=scene)


TIME = np.linspace(0.0, 2.0, 41)
ARRAYS = np.stack([np.sin(TIME) ** 2, TIME**3 / 9.0], axis=1)


def on_base(joints: np.ndarray, base: np.ndarray | None = None):
    """q of a base that stays at its place, or turns as base has it, and of joints."""
    still = np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], (len(joints), 1)) if base is None else base
    return np.hstack((still, joints))


def test_bolts_bear_the_wrench_of_a_fixed_base():
    bolt = robodyn.Loop("bolt", "bus", kind="weld")
    scene, fixed = robodyn.Scene(moving_base=True, loops=(bolt,)), robodyn.Scene()
    tables: list[np.ndarray] = []
    model = robodyn.load(ROBOTS / "satellite.urdf", moving_base=True)
    sinks = [lambda time, rows: tables.append(rows)]
    result = robodyn.torques(model, robodyn.motion(model, TIME, on_base(ARRAYS), scene=scene), scene, sinks=sinks)
    model = robodyn.load(ROBOTS / "satellite.urdf")
    robodyn.torques(model, robodyn.motion(model, TIME, ARRAYS), fixed, sinks=sinks, reactions=True)
    bolted, base = tables
    scale = np.abs(base).max()
    np.testing.assert_allclose(bolted[:, :8], base[:, :8], rtol=0, atol=1e-12 * scale)
    assert scale > 900.0
    found = result.constraints
    assert found is not None
    assert (found.rank, found.freedoms, found.unbalanced) == (6, 2, ())
    assert found.loops[0].determined
    assert not any("ground holds the base" in said for said in result.warnings)
    assert max(result.checks.first_law, result.checks.second_law) < 1e-12


def test_what_a_ball_does_not_hold_is_told_of_the_base():
    """A plate on a ball beside its middle would fall: m g of the middle's arm is missing."""
    ball = robodyn.Loop("ball", "plate", point=(0.1, 0.0, 0.0), to_point=(0.1, 0.0, 0.0))
    scene = robodyn.Scene(moving_base=True, loops=(ball,))
    model = robodyn.load(ROBOTS / "rigid_body.urdf", moving_base=True)
    result = robodyn.torques(model, robodyn.motion(model, TIME, on_base(np.zeros((41, 0))), scene=scene), scene)
    found = result.constraints
    assert found is not None
    assert found.freedoms == 3
    assert {each.name for each in found.unbalanced} == {"base_wy", "base_vz"}
    assert result.within_limits is None
    assert not any("ground holds the base" in said for said in result.warnings)
    lever = 8.0 * 0.1  # the remainder is least with moments in units of 1/8 N m, as equilibration by powers of 2 has it
    assert found.loops[0].force.value == pytest.approx(model.total_mass * 9.81 / (1.0 + lever**2), rel=1e-12)
