"""Coupled motors and gyroscopic moments: explicit rotors on mimic joints, closed forms, MuJoCo, conservation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, SPINNING, busy_parts, busy_robot
from helpers.oracles import EPS, frictionless, random_state, worst
from helpers.peers import mujoco
from helpers.small_robots import built, chain, joint, link

import robodyn
from robodyn.dynamics.effects import motors
from robodyn.equations.dae.dae import dae_at
from robodyn.errors import SceneError
from robodyn.identification.result import calibrated, friction_toml
from robodyn.loads.torques import torques
from robodyn.scene.read import parse_scene
from robodyn.scene.scene import CoupledMotor, Friction, Loop, Motor, Rotor, Scene
from robodyn.trajectory.read import motion

SAMPLES = 5
both = pytest.mark.parametrize("free", [False, True], ids=["fixed", "free"])


def busy(free=False, **scene):
    model, rng = busy_robot(free), np.random.default_rng(5)
    surroundings = replace(BUSY_SCENE, rotor=SPINNING, **scene)
    columns = {name: rng.normal(size=SAMPLES) for name in surroundings.columns}
    return model, surroundings, random_state(model, rng, SAMPLES), columns


def explicit(free=False):
    """The busy robot with a body for each rotor, and payloads that take each one's inertia from its carrier."""
    model, parts, taken = busy_robot(free), busy_parts(), []
    for spin in motors.spins(model, Scene(rotor=SPINNING)):
        R = model.links[spin.link].R
        a = R.T @ spin.axis
        I = spin.share / spin.gear * np.outer(a, a)
        name, moments = f"rotor {spin.joint.name}", I[np.triu_indices(3)]
        ratio = spin.gear * spin.joint.multiplier
        leader = spin.joint.mimics or spin.joint.name
        mimic = f'<mimic joint="{leader}" multiplier="{ratio!r}"/>'
        parts += [link(name, 0.0, inertia=moments), joint(f"spin {name}", spin.link, name, "continuous", a, more=mimic)]
        taken.append(robodyn.Payload(spin.link, 0.0, inertia=tuple(-moments)))
    scene = replace(BUSY_SCENE, rotor={}, payloads=(*BUSY_SCENE.payloads, *taken))
    still = {name: Rotor(0.0, 1.0) for name in SPINNING}
    return built(*parts, moving_base=free), replace(scene, rotor=still)


@pytest.mark.parametrize("free", [pytest.param(False, marks=pytest.mark.slow), True])
def test_an_explicit_rotor_on_a_mimic_joint(free):
    model, scene, (q, qd, qdd), columns = busy(free)
    other, bare = explicit(free)
    tau = robodyn.inverse_dynamics(model, q, qd, qdd, scene=scene, columns=columns)
    assert worst(robodyn.inverse_dynamics(other, q, qd, qdd, scene=bare, columns=columns), tau) <= 1e-12
    M = robodyn.mass_matrix(model, q, scene=scene)
    assert worst(robodyn.mass_matrix(other, q, scene=bare), M) <= 1e-12
    found = robodyn.forward_dynamics(model, q, qd, tau, scene=scene, columns=columns)
    assert worst(robodyn.forward_dynamics(other, q, qd, tau, scene=bare, columns=columns), found) <= 1e-11
    C = robodyn.coriolis_matrix(model, q, qd, scene=scene)
    assert worst(robodyn.coriolis_matrix(other, q, qd, scene=bare), C) <= 1e-12
    one, two = robodyn.momenta(model, q, qd, scene=scene), robodyn.momenta(other, q, qd, scene=bare)
    for part in ("linear", "angular", "kinetic", "potential"):
        assert worst(getattr(two, part), getattr(one, part)) <= 1e-12


def test_another_inertia_of_a_rotor_is_its_column_alone():
    model, scene, state, columns = busy()
    found = robodyn.regressor(model, *state, scene=scene, columns=columns)
    without = robodyn.regressor(model, *state, scene=replace(scene, rotor={}), columns=columns)
    assert worst(found.rest, without.rest) <= 4 * EPS
    theta = found.theta.copy()
    theta[found.names.index("j4.rotor")] *= 1.7
    heavier = {**SPINNING, "j4": replace(SPINNING["j4"], inertia=1.7 * SPINNING["j4"].inertia)}
    tau = robodyn.inverse_dynamics(model, *state, scene=replace(scene, rotor=heavier), columns=columns)
    assert worst(found.Y @ theta + found.rest, tau) <= 1e-13


def test_a_calibrated_scene_keeps_axis_and_carrier():
    model, scene, state, columns = busy()
    found = robodyn.regressor(model, *state, scene=scene, columns=columns)
    written = parse_scene(friction_toml(model, calibrated(model, found.names, found.theta, scene)).encode())
    for name, rotor in SPINNING.items():
        assert (written.rotor[name].axis, written.rotor[name].on) == (rotor.axis, rotor.on)
        assert abs(written.rotor[name].inertia - rotor.inertia) <= 4 * EPS * rotor.inertia


@both
def test_free_bodies_and_laws_balance(free):
    model, scene, state, columns = busy(free)
    found = robodyn.free_bodies(
        model, *(each[0] for each in state), scene=scene, columns={name: x[0] for name, x in columns.items()}
    )
    assert max(found.residual_force, found.residual_moment) <= 1e-13
    assert {action.kind for body in found.bodies for action in body.actions} >= {"gyroscopic moment"}
    checks = torques(model, motion(model, np.arange(SAMPLES) * 1.0, *state, columns=columns), scene).checks
    assert max(checks.first_law, checks.second_law, checks.power) <= 1e-13


def test_a_closed_chain_balances_energy():
    model = chain(3)
    ends = Loop("closure", "l3", (1.0, 0.0, 0.0), to_point=(1.2, 0.9, 0.0), directions=((1, 0, 0), (0, 1, 0)))
    rotors = {"j3": Rotor(2e-3, 30.0, on="l3"), "j2": Rotor(1e-3, -20.0, (1.0, 0.0, 1.0), "l2")}
    initial = {"initial_q": {"j1": 0.3, "j2": 0.9, "j3": 0.9}, "initial_qd": {"j1": 1.0}}
    scene = frictionless(model, rotor=rotors, loops=(ends,), joint_limits="ignore", **initial)
    result = robodyn.simulate(model, scene, duration=0.3, step=1e-3)
    assert np.ptp(result.q[:, 0]) >= 0.1
    assert result.energy_drift <= 1e-9 * result.figures.energy.max()


def test_where_it_is_not_known_it_is_refused():
    model = chain(2, skew=True)
    scene = frictionless(model, rotor={"j2": Rotor(1e-3, 10.0, (1.0, 0.0, 0.0))}, motor={"j2": Motor(peak=1.0)})
    state, loaded = np.ones((9, 2)), {"j2": Friction(load=0.1)}
    for ask in (
        lambda: dae_at(model, replace(scene, motor={}), *state[:3]),
        lambda: torques(model, motion(model, np.arange(9) * 0.1, state, state, state), scene),
        lambda: robodyn.inverse_dynamics(model, *state[:3], scene=replace(scene, friction=loaded)),
    ):
        with pytest.raises(SceneError) as caught:
            ask()
        assert "j2" in str(caught.value)
        assert "axis" in str(caught.value)


def massless_wrist():
    parts = [link("base"), link("a"), link("b"), joint("j5", "base", "a"), joint("j6", "a", "b")]
    return built(*parts)


@pytest.mark.parametrize(("qd", "friction"), [((0.3, 0.2), 0.7), ((0.3, -0.5), -0.6), ((0.3, -0.3), 0.0)])
def test_closed_form_of_a_wrist(qd, friction):
    """c_j (G^2 J sdd + d s + f(s)) on links without mass; what turns against each other feels no friction."""
    motor = CoupledMotor("m", {"j5": 1.0, "j6": 1.0}, 2e-4, 50.0, Friction(0.4, 0.5, -0.52))
    tau = robodyn.inverse_dynamics(massless_wrist(), [0.1, 0.2], qd, [2.0, 3.0], scene=Scene(coupled=(motor,)))
    assert worst(tau, np.full(2, 0.5 * 5.0 + friction)) <= 8 * EPS
    M = robodyn.mass_matrix(massless_wrist(), [0.1, 0.2], scene=Scene(coupled=(motor,)))
    np.testing.assert_array_equal(M, np.full((2, 2), 0.5))


@pytest.mark.parametrize(
    ("scene", "says"),
    [
        (Scene(rotor={"j2": Rotor(1e-4, 1.0, (0.0, 0.0, 0.0))}), '[rotor] j2: "axis" is [0.0, 0.0, 0.0]'),
        (Scene(rotor={"j2": Rotor(1e-4, 1.0, on="l9")}), "[rotor] j2: the robot has no link 'l9'"),
        (Scene(rotor={"j2": Rotor(1e-4, 1.0, on="tool")}), "\"axis\" is missing, and the joint is not on 'tool'"),
        (Scene(coupled=(CoupledMotor("m", {"j9": 1.0}),)), "[[coupled]]: the robot has no joint 'j9' that moves"),
        (Scene(coupled=(CoupledMotor("j1", {"j1": 1.0}),)), "'j1': a joint or another coupled motor has this name"),
        (Scene(coupled=(CoupledMotor("m", {"j1": 1.0}), CoupledMotor("m", {"j2": 1.0}))), "has this name"),
    ],
)
def test_what_is_wrong_is_said(scene, says):
    with pytest.raises(SceneError) as caught:
        robodyn.inverse_dynamics(busy_robot(), 0.0, 0.0, 0.0, scene=scene)
    assert says in str(caught.value)


ARM = """<mujoco><option gravity="0 0 -9.81"/><compiler angle="radian"/><worldbody><body>
<joint name="j1" axis="0 1 0"/><inertial pos="0.1 0 0.2" mass="2" diaginertia="0.1 0.2 0.3"/>
<body pos="0 0 0.5"><joint name="j2" axis="1 0 0"/><inertial pos="0 0.1 0.3" mass="1" diaginertia="0.03 0.02 0.01"/>
</body></body></worldbody>
<tendon><fixed name="t" armature="0.5" damping="0.7"><joint joint="j1" coef="1"/><joint joint="j2" coef="-0.6"/></fixed>
</tendon></mujoco>"""


def test_mujoco():
    """A fixed tendon with armature and damping is a coupled motor without Coulomb friction."""
    other = mujoco.MjModel.from_xml_string(ARM)
    data = mujoco.MjData(other)
    parts = [link("base"), link("a", 2, (0.1, 0, 0.2), (0.1, 0, 0, 0.2, 0, 0.3))]
    parts += [link("b", 1, (0, 0.1, 0.3), (0.03, 0, 0, 0.02, 0, 0.01))]
    parts += [joint("j1", "base", "a", axis=(0, 1, 0)), joint("j2", "a", "b", axis=(1, 0, 0), xyz=(0, 0, 0.5))]
    scene = Scene(coupled=(CoupledMotor("m", {"j1": 1.0, "j2": -0.6}, 0.005, 10.0, Friction(0.7)),))
    model = built(*parts)
    for q, qd, tau in np.random.default_rng(0).normal(size=(10, 3, 2)):
        data.qpos, data.qvel, data.qfrc_applied = q, qd, tau
        mujoco.mj_forward(other, data)
        assert worst(robodyn.forward_dynamics(model, q, qd, tau, scene=scene), data.qacc) <= 1e-12


def test_scene_file_of_coupled_motors():
    text = b"""
    [[coupled]]
    name = "m"
    joints = { j5 = 1.0, j6 = -0.5 }
    inertia = 1e-4
    gear = 50
    viscous = 0.2
    coulomb = [0.4, -0.3]
    """
    motor = CoupledMotor("m", {"j5": 1.0, "j6": -0.5}, 1e-4, 50.0, Friction(0.2, 0.4, -0.3))
    assert parse_scene(text).coupled == (motor,)


@pytest.mark.parametrize(
    ("entry", "says"),
    [
        ("joints = { a = 1 }", '[[coupled]] number 1: "name" is missing'),
        ('name = "m"', '"joints" is missing'),
        ('name = "m"\njoints = { a = 0 }', '"joints" has no coefficient that is not 0'),
        ('name = "m"\njoints = { a = "x" }', "[[coupled]] number 1 joints: \"a\" is 'x', not a finite number"),
        ('name = "m"\njoints = { a = 1 }\ninertia = -1', '"inertia" is -1'),
        (
            'name = "m"\njoints = { a = 1 }\nviscous = -1',
            '"viscous" is -1 (positive or zero: else it drives the joint)',
        ),
        ('name = "m"\njoints = { a = 1 }\ngears = 2', 'unknown key "gears"'),
    ],
)
def test_what_is_wrong_in_a_scene_is_said(entry, says):
    with pytest.raises(SceneError) as caught:
        parse_scene(f"[[coupled]]\n{entry}\n".encode())
    assert says in str(caught.value)
