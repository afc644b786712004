"""Coupled motors: closed forms, MuJoCo, other forms of the equations, energy, and every interface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.effect_identities import (
    composite_bodies_give_the_mass_matrix,
    derivatives_are_differences,
    forward_is_the_inverse_of_inverse,
    kinetic_energy_is_that_of_the_mass_matrix,
)
from helpers.oracles import EPS, frictionless, random_state, robot, worst
from helpers.peers import mujoco
from helpers.small_robots import built, chain, joint, link

import robodyn
from robodyn.dynamics.effects import motors
from robodyn.dynamics.plan import Plan, runner_of
from robodyn.equations.dae.dae import dae_at
from robodyn.errors import SceneError
from robodyn.scene.parts import CoupledMotor, Friction
from robodyn.scene.read import parse_scene
from robodyn.scene.scene import Scene

SAMPLES = 20
WRIST = CoupledMotor("wrist motor", {"j2": 1.0, "slide": -0.7}, 2e-3, -30.0, Friction(0.3, 0.5, -0.4, 0.9, 0.3))
CROSSED = CoupledMotor("crossed", {"j4": 0.5, "follower": 0.7, "finger": -0.2}, 1e-3, 20.0, Friction(0.1, 0.2, -0.2))
CHAINED = CoupledMotor("chained", {"slide": 1.0, "j4": 2.0}, 3e-4, 10.0)
MOTORS = (WRIST, CROSSED, CHAINED)
both = pytest.mark.parametrize("free", [False, True], ids=["fixed", "free"])


def busy(free=False, **scene):
    model, rng = busy_robot(free), np.random.default_rng(5)
    surroundings = replace(BUSY_SCENE, coupled=MOTORS, **scene)
    columns = {name: rng.normal(size=SAMPLES) for name in surroundings.columns}
    return model, surroundings, random_state(model, rng, SAMPLES), columns


def massless_wrist():
    parts = [link("base"), link("a"), link("b"), joint("j5", "base", "a"), joint("j6", "a", "b")]
    return built(*parts)


@pytest.mark.parametrize(("qd", "friction"), [((0.3, 0.2), 0.7), ((0.3, -0.5), -0.6), ((0.3, -0.3), 0.0)])
def test_closed_form(qd, friction):
    """c_j (G^2 J sdd + d s + f(s)) on links without mass; what turns against each other feels no friction."""
    motor = CoupledMotor("m", {"j5": 1.0, "j6": 1.0}, 2e-4, 50.0, Friction(0.4, 0.5, -0.52))
    tau = robodyn.inverse_dynamics(massless_wrist(), [0.1, 0.2], qd, [2.0, 3.0], scene=Scene(coupled=(motor,)))
    assert worst(tau, np.full(2, 0.5 * 5.0 + friction)) <= 8 * EPS
    M = robodyn.mass_matrix(massless_wrist(), [0.1, 0.2], scene=Scene(coupled=(motor,)))
    np.testing.assert_array_equal(M, np.full((2, 2), 0.5))


def test_a_rotor_adds_c_c_transposed():
    """c c^T G^2 J on a skew chain whose other torques are known, and forward dynamics with it."""
    model = chain(4, skew=True)
    names, G, J = model.joint_names, 12.0, 3e-3
    c = dict(zip(names, (0.0, 1.0, 0.0, -0.6), strict=True))
    scene = frictionless(model, coupled=(CoupledMotor("m", {k: v for k, v in c.items() if v}, J, G),))
    q, qd, qdd = random_state(model, np.random.default_rng(1), SAMPLES)
    share = np.array([*c.values()])
    expected = robodyn.inverse_dynamics(model, q, qd, qdd, scene=frictionless(model))
    expected = expected + np.outer(qdd @ share, share) * G * G * J
    tau = robodyn.inverse_dynamics(model, q, qd, qdd, scene=scene)
    assert worst(tau, expected) <= 1e-14
    assert worst(robodyn.forward_dynamics(model, q, qd, tau, scene=scene), qdd) <= 1e-11


def test_of_one_joint_it_is_its_rotor_and_friction():
    model = robot("puma560")
    state = random_state(model, np.random.default_rng(2), SAMPLES)
    friction = Friction(0.4, 0.5, -0.3)
    plain = Scene(friction={"elbow": friction}, rotor={"elbow": robodyn.Rotor(1e-4, 50.0)})
    alone = Scene(friction={"elbow": Friction()}, coupled=(CoupledMotor("m", {"elbow": 1.0}, 1e-4, 50.0, friction),))
    expected = robodyn.inverse_dynamics(model, *state, scene=plain)
    assert worst(robodyn.inverse_dynamics(model, *state, scene=alone), expected) <= 1e-15


@both
def test_forward_is_the_inverse_of_inverse(free):
    forward_is_the_inverse_of_inverse(*busy(free))


@both
def test_derivatives(free):
    derivatives_are_differences(*busy(free, slip_speed=0.2))


@both
@pytest.mark.parametrize("slip_speed", [0.0, 0.2])
def test_regressor(free, slip_speed):
    model, scene, state, columns = busy(free, slip_speed=slip_speed)
    found = robodyn.regressor(model, *state, scene=scene, columns=columns)
    expected = [f"{WRIST.name}.{part}" for part in ("viscous", "forward", "backward", "stribeck", "rotor")]
    assert list(found.names[-13:-8]) == expected
    assert found.theta[-13:-8].tolist() == [0.3, 0.5, -0.4, 0.9, 900.0 * 2e-3]
    tau = robodyn.inverse_dynamics(model, *state, scene=scene, columns=columns)
    assert worst(found.Y @ found.theta + found.rest, tau) <= 1e-13
    without = robodyn.regressor(model, *state, scene=replace(scene, coupled=()), columns=columns)
    np.testing.assert_array_equal(found.Y[..., :-13], without.Y)
    assert worst(found.rest, without.rest) <= 4 * EPS


def test_its_share_is_what_it_adds():
    model, scene, state, columns = busy()
    tau = robodyn.inverse_dynamics(model, *state, scene=scene, columns=columns)
    without = robodyn.inverse_dynamics(model, *state, scene=replace(scene, coupled=()), columns=columns)
    bare = replace(scene, wrenches=())
    rows = np.hstack(state)
    sources = {"q": rows[:, : model.nq], "qd": state[1], "qdd": state[2], "columns": np.empty((SAMPLES, 0))}
    a_plan = Plan(model, bare)
    share = runner_of(a_plan.share(motors.COUPLED), a_plan).run(sources, SAMPLES).values
    assert worst(share, tau - without, np.abs(tau).max()) <= 1e-14


def test_kinetic_energy_is_that_of_the_mass_matrix():
    model, scene, (q, qd, _), _ = busy()
    kinetic_energy_is_that_of_the_mass_matrix(model, scene, q, qd)


@pytest.mark.parametrize("friction", [Friction(), Friction(0.1, 0.2, -0.2)], ids=["none", "some"])
def test_simulation_balances_energy(friction):
    model = chain(3, skew=True)
    one, two, three = model.joint_names
    motors = (
        CoupledMotor("a", {two: 1.0, three: 1.0}, 0.02, 5.0, friction),
        CoupledMotor("b", {one: 1.0, three: 0.5}, 0.1),
    )
    scene = frictionless(model, coupled=motors, joint_limits="ignore", initial_qd={two: 1.0})
    result = robodyn.simulate(model, scene, duration=0.5, step=1e-3)
    assert result.energy_drift <= 1e-9 * result.figures.energy.max()


def test_scene_file():
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


def test_names_must_fit():
    model = robot("puma560")
    for coupled, says in (
        ((CoupledMotor("m", {"elbo": 1.0}),), "[[coupled]]: the robot has no joint 'elbo' that moves"),
        ((CoupledMotor("elbow", {"elbow": 1.0}),), "'elbow': a joint or another coupled motor has this name"),
        ((CoupledMotor("m", {"elbow": 1.0}), CoupledMotor("m", {"waist": 1.0})), "has this name"),
    ):
        with pytest.raises(SceneError) as caught:
            robodyn.inverse_dynamics(model, 0.0, 0.0, 0.0, scene=Scene(coupled=coupled))
        assert says in str(caught.value)


def test_absent_or_idle_it_costs_nothing():
    model = robot("puma560")
    idle = Scene(coupled=(CoupledMotor("m", {"elbow": 1.0, "waist": 0.5}),))
    assert Plan(model, idle).torques() == Plan(model, Scene()).torques()


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


def test_composite_bodies():
    model, scene, state, _ = busy()
    reflected = motors.reflected(model, scene)
    composite_bodies_give_the_mass_matrix(model, scene, state[0][:3], lambda _: reflected)


def test_dae_form():
    """All bodies on their own: the same accelerations."""
    model = chain(3, skew=True)
    one, two, three = model.joint_names
    motors = (CoupledMotor("a", {two: 1.0, three: -0.5}, 0.02, 5.0, Friction(0.3)), CoupledMotor("b", {one: 1.0}, 0.1))
    scene = frictionless(model, coupled=motors)
    q, qd, tau = np.random.default_rng(3).normal(size=(3, 3))
    found = dae_at(model, scene, q, qd, tau)
    assert max(found.comparison.accelerations, found.comparison.forces, found.comparison.moments) <= 1e-12
    assert worst(found.qdd, robodyn.forward_dynamics(model, q, qd, tau, scene=scene)) <= 1e-11
