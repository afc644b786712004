"""The regressor, Y theta and the rest being the torques, and loads of varied parameters, by edited descriptions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.busy_robot import EVERY_EFFECT, busy_robot
from helpers.drawn_motions import varied_runner
from helpers.example_robots import kinds
from helpers.oracles import random_state, robot, run, worst
from helpers.small_robots import body_numbers, built, joint, link

import robodyn
from robodyn.dynamics.plan import plan
from robodyn.dynamics.regressor import INERTIAL, derivative_runner, regressor, variations
from robodyn.errors import SceneError
from robodyn.robot.load import load
from robodyn.scene.scene import Friction, Loop, Payload, Rotor, Scene
from robodyn.scene.uncertainty import Covariance, Deviation, LinkUncertainty, Uncertainty

SAMPLES = 3
bases = pytest.mark.parametrize("moving_base", [False, True], ids=["fixed", "free"])
COMPILED = pytest.param(False, 0.2, "compiled", marks=pytest.mark.slow)


def error(found, tau):
    """Of Y theta + rest, as a part of the largest term."""
    terms = np.abs(found.Y * found.theta).max(initial=0)
    return worst((found.Y @ found.theta) + found.rest, tau, max(terms, np.abs(tau).max(initial=0)))


@pytest.mark.parametrize(
    ("moving_base", "slip_speed", "executor"), [(False, 0.0, "numpy"), (True, 0.2, "numpy"), COMPILED]
)
def test_every_effect(moving_base, slip_speed, executor):
    model, rng = busy_robot(moving_base), np.random.default_rng(4)
    scene = replace(EVERY_EFFECT, slip_speed=slip_speed)
    state = random_state(model, rng, SAMPLES)
    columns = {name: rng.uniform(-1, 1, SAMPLES) for name in scene.columns}
    expected = robodyn.inverse_dynamics(model, *state, scene=scene, columns=columns)
    found = regressor(model, *state, scene=scene, columns=columns, executor=executor)
    assert found.Y.shape == (SAMPLES, model.n, len(found.names)) == (SAMPLES, model.n, len(found.theta))
    assert error(found, expected) <= 1e-14
    alone = replace(scene, friction={}, rotor={}, payloads=(), gravity=(0.0, 0.0, 0.0))
    assert np.abs(found.rest).max() > 0.1, alone


@bases
@pytest.mark.parametrize("path", kinds())
def test_published_robots(path, moving_base):
    model = load(path, moving_base=moving_base)
    state = random_state(model, np.random.default_rng(len(path.name)), 2)
    found = regressor(model, *state)
    assert not found.rest.any()
    assert error(found, robodyn.inverse_dynamics(model, *state)) <= 1e-13


def test_what_is_linear_stays_so():
    """Another mass, payload, friction and rotor: the same Y, and it makes the new torques too."""
    model, state = robot("puma560"), random_state(robot("puma560"), np.random.default_rng(2), SAMPLES)
    names = model.joint_names
    one = Scene(
        friction=dict.fromkeys(names, Friction(0.1, 0.2, -0.3, 0.5)), rotor=dict.fromkeys(names, Rotor(1e-4, 50.0))
    )
    two = replace(
        one,
        friction=dict.fromkeys(names, Friction(0.7, 0.1, -0.6, 0.9)),
        rotor=dict.fromkeys(names, Rotor(3e-4, 20.0)),
        payloads=(Payload(model.bodies[-1].name, 2.5, (0.1, 0.2, 0.3), (0.1, 0.0, 0.0, 0.2, 0.01, 0.3)),),
    )
    first, second = (regressor(model, *state, scene=scene) for scene in (one, two))
    assert (first.Y == second.Y).all()
    assert first.names == second.names
    assert worst(first.Y @ second.theta, robodyn.inverse_dynamics(model, *state, scene=two)) <= 1e-13
    assert (first.theta != second.theta).sum() == 10 + 5 * len(names)


def test_names():
    found = regressor(robot("pendulum"), [0.3], [0.1], [0.2])
    body, joint = robot("pendulum").bodies[-1].name, robot("pendulum").joint_names[0]
    expected = [f"{body}.{name}" for name in INERTIAL]
    expected += [f"{joint}.{name}" for name in ("viscous", "forward", "backward", "rotor")]
    assert list(found.names[-14:]) == expected
    assert found.theta[found.names.index(f"{body}.m")] == robot("pendulum").bodies[-1].inertia.m


def test_refusals():
    model = busy_robot()
    with pytest.raises(SceneError, match="loop"):
        regressor(model, 0.0, 0.0, 0.0, scene=Scene(loops=(Loop("l", "tool"),)))


def sources(model, state, columns=()):
    return dict(zip(("q", "qd", "qdd"), state, strict=True)) | {
        "columns": np.array(columns).T.reshape(len(state[0]), -1)
    }


def every(model):
    """Each load alone: tau, base wrench, and those of the joints."""
    return [[(k, 1.0)] for k in range(model.n + 6 * len(model.bodies))]


def derivatives(model, scene, given):
    found = variations(model, scene)
    runner, count = derivative_runner(plan(model, scene), found, every(model)), len(given["q"])
    return runner({**given, "x": np.zeros((count, len(found.each)))}, count).reshape(count, -1, len(found.each))


def varied(model, scene, given, x):
    found, count = variations(model, scene), len(given["q"])
    runner = varied_runner(plan(model, scene), found, every(model))
    return runner({**given, "x": np.tile(x, (count, 1))}, count)


@pytest.mark.parametrize("moving_base", [False, True], ids=["fixed", "free"])
def test_derivatives_by_the_regressors_parameters_are_its_columns(moving_base):
    model, rng = busy_robot(moving_base), np.random.default_rng(5)
    scene = replace(EVERY_EFFECT, slip_speed=0.2)
    state = random_state(model, rng, SAMPLES)
    columns = {name: rng.uniform(-1, 1, SAMPLES) for name in scene.columns}
    Y, theta, names, _ = robodyn.regressor(model, *state, scene=scene, columns=columns)
    sizes = rng.uniform(0.1, 2.0, len(names))
    known = Covariance(names, theta, np.diag(sizes**2))
    found = derivatives(
        model, replace(scene, uncertainty=Uncertainty(covariance=known)), sources(model, state, list(columns.values()))
    )
    assert worst(found[:, : model.n], Y * sizes) <= 1e-14


def arm(numbers):
    """Two arms with parts fixed to them, the frames of all of which are askew."""
    askew = {"xyz": (0.3, -0.2, 0.1), "rpy": (0.4, -0.7, 1.1)}
    return built(
        link("base"),
        *(link(name, *numbers[name], rpy=(0.0, 0.0, 0.0) if name == "a" else (0.3, 0.2, -0.5)) for name in numbers),
        joint("j1", "base", "a", axis=(0, 0.6, 0.8), **askew),
        joint("f", "a", "b", "fixed", **askew),
        joint("j2", "b", "c", "prismatic", axis=(0.6, 0, 0.8), **askew),
        joint("g", "c", "d", "fixed", **askew),
    )


def test_derivatives_are_those_of_an_edited_description():
    """Mass with the radii of gyration kept, the centre of mass with the inertia about it kept, the inertia scaled.

    Loads, at joints too, are of second degree in each parameter alone, so that central differences are exact.
    """
    rng = np.random.default_rng(8)
    numbers = {name: body_numbers(rng) for name in "abcd"}
    absolute = LinkUncertainty(Deviation(0.2, relative=False), Deviation(0.1), Deviation(0.01, relative=False))
    given = Uncertainty(Deviation(0.1), Deviation(0.02, relative=False), Deviation(0.2), link={"a": absolute})
    scene, model = Scene(uncertainty=given), arm(numbers)
    names = tuple(each.name for each in variations(model, scene).each)
    assert names == tuple(
        f"{n}.{q}" for n in "abcd" for q in ("mass", *["com"] * 3, *["inertia"] * (3 if n == "a" else 1))
    )

    def edited(x):
        """Loads of the arm with parameters that are off by x."""
        changed, at = {}, 0
        for name, (m, c, I) in numbers.items():
            if name == "a":
                mass, far = m + 0.2 * x[0], 0.1 * np.sqrt(np.square(c).sum())
                inertia = I * mass / m + 0.01 * np.array([x[4], 0, 0, x[5], 0, x[6]])
                changed[name], at = (mass, c + far * x[1:4], inertia), 7
            else:
                mass = m * (1 + 0.1 * x[at])
                changed[name] = (mass, c + 0.02 * x[at + 1 : at + 4], I * mass / m * (1 + 0.2 * x[at + 4]))
                at += 5
        plain = plan(arm(changed), Scene())
        return run(plain.wrenches(joints=True), plain, *state)

    state = random_state(model, rng, SAMPLES)
    found = derivatives(model, scene, sources(model, state))
    for k, x in enumerate(np.eye(len(names))):
        assert worst(found[..., k], 0.5 * (edited(x) - edited(-x)), np.abs(found).max()) <= 1e-13


def test_friction_by_a_factor_and_by_a_torque():
    model, rng = robot("scara"), np.random.default_rng(3)
    friction = {"shoulder": Friction(0.4, 0.8, -0.5, 1.7, 0.9), "elbow": Friction(0.1, 0.3, -0.3)}
    given = Uncertainty(
        friction=Deviation(0.2), joint={"elbow": Deviation(0.6, relative=False), "quill": Deviation(0.0)}
    )
    scene = Scene(friction=friction, slip_speed=0.1, uncertainty=given)
    names = tuple(each.name for each in variations(model, scene).each)
    x = rng.normal(size=len(names))
    of = dict(zip(names, x, strict=True))
    share, more = 1 + 0.2 * of["shoulder.friction"], 0.6 * of["elbow.friction"]
    edited = {
        "shoulder": Friction(0.4 * share, 0.8 * share, -0.5 * share, 1.7 * share, 0.9),
        "elbow": Friction(0.1, 0.3 + more, -0.3 - more),
    }
    assert "quill.friction" not in names
    state = random_state(model, rng, SAMPLES)
    expected = robodyn.inverse_dynamics(model, *state, scene=Scene(friction=edited, slip_speed=0.1))
    assert worst(varied(model, scene, sources(model, state), x)[:, : model.n], expected) <= 1e-14
