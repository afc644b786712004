"""Friction that grows with load: closed forms, round trips, differences, power, and what refuses it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.oracles import EPS, frictionless, random_state, worst
from helpers.small_robots import built, chain, joint, link, random_tree

import robodyn
from robodyn.dynamics.derivatives import forward_dynamics_derivatives
from robodyn.dynamics.momenta import energy, laws, losses
from robodyn.dynamics.plan import plan, runner_of
from robodyn.equations.free_body.bodies import free_bodies
from robodyn.errors import InputError, SceneError
from robodyn.scene.read import parse_scene
from robodyn.scene.scene import CoupledMotor, Friction, Scene
from robodyn.scene.template import scene_toml
from robodyn.trajectory.read import motion

SAMPLES = 10
LOADS = {"j1": 0.03, "j2": 0.2, "slide": 0.5, "j4": 0.1}


def loaded(model, scene, loads):
    """The scene with these loads, other friction being as it was."""
    described = {body.joint.name: body.joint for body in model.bodies}
    plain = {
        name: Friction(described[name].damping, described[name].friction, -described[name].friction) for name in loads
    }
    friction = {name: replace(scene.friction.get(name, plain[name]), load=load) for name, load in loads.items()}
    return replace(scene, friction={**scene.friction, **friction})


def busy(free, **scene):
    model, rng = busy_robot(free), np.random.default_rng(5)
    surroundings = loaded(model, replace(BUSY_SCENE, **scene), LOADS)
    columns = {name: rng.normal(size=SAMPLES) for name in surroundings.columns}
    return model, surroundings, random_state(model, rng, SAMPLES), columns


def pendulum():
    return built(link("l0"), link("l1", 2.0, (0.5, 0, 0)), joint("j", "l0", "l1", axis=(0, -1, 0)))


@pytest.mark.parametrize("qd", [0.7, -0.7, 0.0])
@pytest.mark.parametrize("qdd", [4.0, -40.0])
def test_one_joint(qd, qdd):
    """tau = p + 0.1 |p| sign(qd) + friction + A qdd, p = m c^2 qdd + m g c cos q + k q: none of it at rest."""
    friction, rotor = Friction(0.3, 0.5, -0.4, load=0.1), robodyn.Rotor(1e-3, 20.0)
    scene = Scene(friction={"j": friction}, rotor={"j": rotor}, spring={"j": robodyn.Spring(3.0)})
    passed = 0.5 * qdd + 9.81 * np.cos(0.4) + 3.0 * 0.4
    own = 0.3 * qd + {1.0: 0.5, -1.0: -0.4, 0.0: 0.0}[np.sign(qd)] + 0.4 * qdd
    tau = robodyn.inverse_dynamics(pendulum(), [0.4], [qd], [qdd], scene=scene)
    assert worst(tau, [passed + 0.1 * abs(passed) * np.sign(qd) + own]) <= 8 * EPS
    assert worst(robodyn.forward_dynamics(pendulum(), [0.4], [qd], tau, scene=scene), [qdd]) <= 32 * EPS


@pytest.mark.parametrize(("free", "slip_speed"), [(False, 0.0), (True, 0.4)], ids=["sign", "smooth"])
def test_round_trip_with_every_effect(free, slip_speed):
    model, scene, (q, qd, qdd), columns = busy(free, slip_speed=slip_speed)
    tau = robodyn.inverse_dynamics(model, q, qd, qdd, scene=scene, columns=columns)
    without = robodyn.inverse_dynamics(
        model, q, qd, qdd, scene=loaded(model, scene, dict.fromkeys(LOADS, 0.0)), columns=columns
    )
    assert worst(tau, without) > 0.01
    found = robodyn.forward_dynamics(model, q, qd, tau, scene=scene, columns=columns)
    assert worst(found, qdd) <= 1e-11


def test_round_trip_of_a_random_tree_without_rotors():
    """High loads are explicit there: up to 95 %, motors driving and being driven."""
    model, rng = random_tree(0), np.random.default_rng(0)
    names = [joint.name for joint in model.independent]
    scene = loaded(model, Scene(), dict(zip(names, rng.uniform(0, 0.95, len(names)).tolist(), strict=True)))
    q, qd, qdd = random_state(model, rng, SAMPLES)
    tau = robodyn.inverse_dynamics(model, q, qd, qdd, scene=scene)
    assert worst(robodyn.forward_dynamics(model, q, qd, tau, scene=scene), qdd) <= 1e-10


def test_large_rotors_and_loads():
    """Rotors of ten times the links' inertia at the largest load that forward dynamics takes."""
    model = chain(3, skew=True)
    scene = loaded(model, frictionless(model), dict.fromkeys(model.joint_names, 0.5))
    scene = replace(scene, rotor={name: robodyn.Rotor(1e-2, 50.0) for name in model.joint_names})
    q, qd, qdd = random_state(model, np.random.default_rng(3), 100)
    tau = robodyn.inverse_dynamics(model, q, qd, qdd, scene=scene)
    assert worst(robodyn.forward_dynamics(model, q, qd, tau, scene=scene), qdd) <= 1e-11
    high = loaded(model, scene, {"j2": 0.6})
    with pytest.raises(InputError, match=r"'j2': load 0\.6 at a joint with a rotor is too large"):
        robodyn.forward_dynamics(model, q, qd, tau, scene=high)


def test_derivatives_of_inverse_dynamics():
    model, scene, state, columns = busy(False, slip_speed=0.4)
    given, h = {"scene": scene, "columns": columns}, 1e-5
    found = robodyn.inverse_dynamics_derivatives(model, *state, **given)
    assert np.abs(found.dqdd - found.dqdd.swapaxes(1, 2)).max() > 1e-2
    for k, matrix in enumerate(found):
        for j, unit in enumerate(h * np.eye(model.n)):
            up, down = (
                robodyn.inverse_dynamics(model, *state[:k], state[k] + sign * unit, *state[k + 1 :], **given)
                for sign in (1.0, -1.0)
            )
            assert worst(matrix[:, :, j], (up - down) / (2.0 * h), np.abs(matrix).max()) <= 1e-7


def test_power_balance_and_shares():
    """tau qd = dE/dt + losses; the shares of all effects add up to tau."""
    model, scene, (q, qd, qdd), columns = busy(True)
    a_plan = plan(model, scene)
    sources = {"q": q, "qd": qd, "qdd": qdd, "columns": np.column_stack(list(columns.values()))}
    tau = robodyn.inverse_dynamics(model, q, qd, qdd, scene=scene, columns=columns)
    lost = runner_of(losses(a_plan), a_plan)(sources, SAMPLES)[:, 0]
    assert worst(runner_of(energy(a_plan), a_plan)(sources, SAMPLES)[:, 1], lost) <= 8 * EPS
    stored = runner_of(laws(a_plan), a_plan)(sources, SAMPLES)[:, 6]
    power = np.einsum("ki,ki->k", tau, qd)
    assert worst(stored + lost, power, np.abs(tau * qd).max()) <= 1e-12
    shares = sum(runner_of(program, a_plan)(sources, SAMPLES) for program in map(a_plan.share, a_plan.effects))
    assert worst(shares, tau) <= 1e-12


def test_a_simulation_keeps_its_power_balance():
    """What drives give is kinetic and potential energy and the work of friction, which is there."""
    model = chain(2, skew=True)
    drive = {"j1": robodyn.Drive(torque=3.0), "j2": robodyn.Drive(kp=20.0, reference=1.0)}
    rotor = {"j1": robodyn.Rotor(1e-3, 20.0)}
    scene = frictionless(model, gravity=(0.0, -9.81, 0.0), rotor=rotor, drive=drive, slip_speed=0.5)
    free, rubbed = (
        robodyn.simulate(model, loaded(model, scene, {"j1": load, "j2": load}), duration=0.2, step=1e-3)
        for load in (0.0, 0.2)
    )
    assert rubbed.energy_drift <= 1e-8 * rubbed.figures.kinetic.max()
    assert rubbed.figures.kinetic[-1] < 0.98 * free.figures.kinetic[-1]
    said = "friction that grows with load is regularised"
    assert said in " ".join(rubbed.notes)
    assert said not in " ".join(free.notes)


def test_it_holds_a_weight():
    """At rest any torque within the share of the weight holds the joint: here 10 % of m g c cos 0.4."""
    model, still = pendulum(), np.zeros((2, 1))
    scene = Scene(friction={"j": Friction(forward=0.2, backward=-0.2, load=0.1)})
    found = robodyn.torques(model, motion(model, np.array([0.0, 1.0]), still + 0.4, still, still), scene).joints[0]
    assert worst(found.hold, 0.2 + 0.981 * np.cos(0.4)) <= 8 * EPS


def test_what_rests_on_a_mass_matrix_refuses_it():
    model = chain(2)
    scene = loaded(model, Scene(), {"j1": 0.03})
    state = np.zeros((3, 1, 2))
    for refused in (
        lambda: robodyn.bias_forces(model, *state[:2], scene=scene),
        lambda: forward_dynamics_derivatives(model, *state, scene=scene),
        lambda: robodyn.inverse_dynamics_second_derivatives(model, *state, scene=scene),
        lambda: robodyn.inverse_dynamics_derivative_entries(model, *state, scene=scene),
        lambda: robodyn.function(model, "bias_forces", scene=scene),
        lambda: robodyn.export(model, to="c", what="torques,bias", scene=scene),
        lambda: robodyn.linearize(model, scene),
        lambda: free_bodies(model, *state[:, 0], scene=scene),
    ):
        with pytest.raises(SceneError, match="friction of 'j1' grows with load, and this knows only torques M qdd"):
            refused()


def test_scenes_that_refuse_it():
    model = busy_robot()
    for name, scene, wrong in (
        ("j1", Scene(passive=("j2",)), "is not known with loops, contacts or joints that do not drive"),
        ("j1", Scene(coupled=(CoupledMotor("m", {"j1": 1.0}),)), "a coupled motor turns"),
        ("finger", Scene(), "is followed"),
        ("follower", Scene(), "follows another"),
    ):
        with pytest.raises(SceneError, match=f"'{name}': \"load\" .*{wrong}"):
            plan(model, loaded(model, scene, {name: 0.1}))
    for load in (-0.1, 1.0, float("nan")):
        with pytest.raises(SceneError, match=r'"load" is .*0 or more, less than 1'):
            plan(model, loaded(model, Scene(), {"j1": load}))


def test_exported_files_say_that_torques_are_not_linear():
    model = chain(2)
    text = robodyn.export(model, to="c", what="torques,derivatives,forward", scene=loaded(model, Scene(), {"j1": 0.03}))
    assert "riction of 'j1' grows with load, so that tau = M qdd + b does not hold" in text
    assert "tau = M(q) qdd" not in text
    assert "load 0.03" in text
    assert "does not hold" not in robodyn.export(model, to="c", what="torques")


def test_reading():
    assert parse_scene(b"[friction.j1]\nload = 0.03\n").friction["j1"] == Friction(load=0.03)
    with pytest.raises(SceneError, match="load"):
        parse_scene(b'[[coupled]]\nname = "m"\njoints = { j1 = 1.0 }\nload = 0.03\n')
    assert "load" in scene_toml(chain(2))
