"""Exciting motions: limits kept at all times, exact slopes, predicted errors, and the same from the same call."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import pi
from pathlib import Path

import numpy as np
import pytest
from helpers.example_robots import path_of
from helpers.oracles import ROBOTS, robot, worst

import robodyn
from robodyn.dynamics.plan import plan
from robodyn.errors import InputError
from robodyn.identification.excitation.excite import excite
from robodyn.identification.excitation.landscape import Landscape, programs_of
from robodyn.identification.excitation.motion import Fourier, bounds_of
from robodyn.identification.parameters.base import structural_base
from robodyn.robot.load import load
from robodyn.scene.scene import DEFAULT, ExternalWrench, Friction, Scene

DATA = Path(__file__).parents[1] / "data"
QUICK = {"harmonics": 3, "rate": 20.0}


@cache
def quick(path):
    """A robot, and a motion of few harmonics for it."""
    model = load(path)
    return model, excite(model, **QUICK)


def planar():
    return quick(ROBOTS / "two_link_planar.urdf")


def check(found, model, scene=DEFAULT):
    """At 20 000 times: within limits of the description, at rest at both ends, and what the result says is reached."""
    time = np.linspace(0.0, found.series.period, 20_001)
    joints = found.joints
    c, sine, cosine = (np.array([getattr(each, name) for each in joints]) for name in ("centre", "sine", "cosine"))
    k = np.arange(1, sine.shape[1] + 1) * (2.0 * pi / found.series.period)
    s, co = np.sin(np.outer(time, k)), np.cos(np.outer(time, k))
    q = c + s @ sine.T + co @ cosine.T
    qd, qdd = (co * k) @ sine.T - (s * k) @ cosine.T, -(s * k * k) @ sine.T - (co * k * k) @ cosine.T
    tau = robodyn.inverse_dynamics(model, q, qd, qdd, scene=scene)
    for i, each in enumerate(joints):
        reached = (q[:, i].min(), q[:, i].max(), *(np.abs(x[:, i]).max() for x in (qd, qdd, tau)))
        assert each.least - 1e-9 <= reached[0] <= reached[1] <= each.largest + 1e-9
        assert (np.array(reached[2:]) <= 1e-9 + np.array([each.speed, each.acceleration, each.effort])).all()
        described = model.independent[i]
        assert reached[2] <= min(each.speed_limit, described.velocity or np.inf) + 1e-9
        assert reached[3] <= each.acceleration_limit
        assert reached[4] <= (described.effort or np.inf)
        if each.moves:
            room = each.largest - each.least
            assert room > 0.01
            if described.lower is not None and described.upper is not None and not described.continuous:
                margin = 0.05 * (described.upper - described.lower) - 1e-9
                assert described.lower + margin <= reached[0]
                assert reached[1] <= described.upper - margin
    assert np.abs(found.motion[1:, [0, -1]]).max() < 1e-10
    assert worst(found.motion[0, -1], found.motion[0, 0], 1.0) < 1e-12
    return q, qd, qdd


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(ROBOTS / "pendulum.urdf", id="one joint", marks=pytest.mark.slow),
        pytest.param(ROBOTS / "cylindrical.urdf", id="slides", marks=pytest.mark.slow),
        pytest.param(ROBOTS / "gripper.urdf", id="mimic and continuous joints"),
        pytest.param(ROBOTS / "puma.urdf", id="an arm", marks=pytest.mark.slow),
        pytest.param(path_of("double_pendulum_continuous"), id="no limits at all"),
        pytest.param(path_of("ur5_robot"), id="UR5", marks=pytest.mark.slow),
        pytest.param(DATA / "lwr4.urdf", id="LWR4+", marks=pytest.mark.slow),
    ],
)
def test_limits_are_kept_at_all_times(path):
    model, found = quick(path)
    check(found, model)
    assert found.information.rank == found.base.rank
    assert found.information.log_determinant > found.plain.log_determinant
    assert found.gain > 1.0
    fitted = structural_base(model)
    assert found.base.independent == fitted.independent, "all joints move, so that all shows"


def test_the_limits_of_a_mimic_joint_count():
    model, found = quick(ROBOTS / "gripper.urdf")
    q, qd, _ = check(found, model)
    for body in model.bodies:
        if body.joint.mimics:
            k = body.joint.rate
            moved = body.joint.multiplier * q[:, k] + body.joint.offset
            assert (moved >= body.joint.lower).all()
            assert (moved <= body.joint.upper).all()
            if body.joint.velocity:
                assert np.abs(body.joint.multiplier * qd[:, k]).max() <= body.joint.velocity + 1e-12


def test_slopes_are_those_of_the_value():
    model = robot("puma")
    scene = Scene(friction={"waist": Friction(0.5, 2.0, -2.0)}, slip_speed=0.1)
    bounds, base = bounds_of(model, scene), structural_base(model, scene)
    programs = programs_of(plan(model, scene), base.independent, len(base.names))
    landscape = Landscape(programs, bounds, Fourier(8.0, 3), np.array([1.0, 2.0, 0.5]), 96, 0.9)
    rng = np.random.default_rng(1)
    y = landscape.position(bounds.middle, 0.05 * rng.normal(size=(3, 5)))
    for pressure in (0.0, 5.0):
        slope, way = landscape.height(y, pressure)[1], rng.normal(size=y.shape)
        step = 1e-6 * way
        change = landscape.height(y + step, pressure)[0] - landscape.height(y - step, pressure)[0]
        assert change / 2e-6 == pytest.approx(float((slope * way).sum()), rel=1e-6)
    strong = Landscape(programs, replace(bounds, effort=bounds.effort * np.inf), Fourier(8.0, 3), np.ones(3), 96, 1.0)
    bend = (strong.height(y + step, 1e12)[1] - strong.height(y - step, 1e12)[1]) / 2e-6
    assert worst(np.einsum("nab,nb->na", strong.stiffness(y, 1e12), way), bend) <= 1e-6


def test_series_are_at_rest_at_both_ends_and_between_samples_below_their_bound():
    series, rng = Fourier(7.0, 5), np.random.default_rng(2)
    assert np.abs(series.shapes(np.array([0.0, 7.0]))[1:]).max() <= 1e-12
    x = rng.normal(size=(4, series.size))
    c, a, b = series.coefficients(x)
    time = rng.uniform(0, 7, 50)
    phase = np.outer(time, np.arange(1, 6)) * 2 * pi / 7
    assert worst(series.shapes(time)[0] @ x.T, c + np.sin(phase) @ a.T + np.cos(phase) @ b.T) <= 1e-13
    x[:, 0] = 0.0
    for samples in (11, 20, 64):
        even = np.abs(series.shapes(series.even(samples)) @ x.T).max(axis=1)
        fine = np.abs(series.shapes(series.even(20_000)) @ x.T).max(axis=1)
        assert (fine <= series.between(samples) * even * (1 + 1e-12)).all()
    midway = np.cos(5 * 2 * pi * (np.arange(20) + 0.5) / 20)
    assert np.abs(midway).max() * series.between(20) == pytest.approx(1.0), "which is reached"


def test_the_same_call_finds_the_same():
    model, one = planar()
    assert one.motion.tolist() == excite(model, **QUICK).motion.tolist()


@pytest.mark.slow
def test_another_seed_finds_as_much():
    model, one = planar()
    other = excite(model, seed=1, **QUICK)
    assert one.motion.tolist() != other.motion.tolist()
    assert other.information.log_determinant == pytest.approx(one.information.log_determinant, abs=2.0)


def test_joints_that_do_not_move_are_held_and_their_links_weigh_on_others():
    model = robot("puma")
    found = excite(model, joints=["shoulder"], **QUICK)
    q, qd, _ = check(found, model)
    assert not qd[:, [0, 2]].any()
    assert not q[:, [0, 2]].any()
    hidden = {found.base.names[k] for k in found.base.invisible}
    assert {"waist.viscous", "elbow.rotor", "forearm.m"} & hidden == {"waist.viscous", "elbow.rotor"}
    assert found.base.rank < structural_base(model).rank


def test_assumptions_are_said():
    notes = quick(path_of("double_pendulum_continuous"))[1].notes
    for what in ("no position limits: 3.142 rad", "no speed limit: 3.142 rad/s assumed", "no effort limit"):
        assert any(what in note for note in notes)
    assert not planar()[1].notes


@pytest.mark.slow
def test_without_gravity_and_with_a_payload():
    model, bare = planar()
    weightless = Scene(gravity=(0.0, 0.0, 0.0))
    found = excite(model, weightless, **QUICK)
    check(found, model, weightless)
    assert found.base.rank < bare.base.rank
    heavy = DEFAULT.changed(payloads=[robodyn.Payload(model.bodies[-1].name, 3.0, (0.5, 0.0, 0.0))])
    noise = np.array([0.5, 0.1])
    loaded = excite(model, heavy, noise=noise.tolist(), **QUICK)
    check(loaded, model, heavy)
    assert loaded.values[0] > bare.values[0]
    rows = robodyn.regressor(model, *loaded.motion[:, :-1], scene=heavy).Y[..., loaded.base.independent]
    solve = np.linalg.pinv((rows / noise[:, None]).reshape(-1, loaded.base.rank))
    spread = (solve @ np.random.default_rng(3).normal(size=(solve.shape[1], 3000))).std(axis=1)
    assert np.abs(spread / loaded.information.standard_errors - 1.0).max() < 0.06, "errors of many fits"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: excite(robot("puma", moving_base=True)), "floats: nothing drives it"),
        (lambda: excite(robot("puma"), joints=["elbw"]), "there is no joint 'elbw' to move (did you mean 'elbow'?)"),
        (lambda: excite(robot("puma"), harmonics=1), "1 harmonics: one cannot begin and end at rest"),
        (lambda: excite(robot("puma"), harmonics=21), "more than 20 are not offered"),
        (lambda: excite(robot("puma"), period=-1.0), "a period of -1 s at 200 /s is none"),
        (lambda: excite(robot("puma"), period=0.01), "a period of 0.01 s at 200 /s has 2 rows"),
        (lambda: excite(robot("puma"), noise=[1.0, 2.0]), "noise has 2 numbers, the robot 3 joints"),
        (lambda: excite(robot("puma"), noise=[-1.0]), "noise is -1 (it is positive"),
        (lambda: excite(robot("puma"), noise={"toe": 1.0}), "noise is given for 'toe', which is no joint"),
        (
            lambda: excite(robot("puma"), Scene(wrenches=(ExternalWrench("forearm", ("fx", 0.0, 0.0)),))),
            "the scene takes 'fx' from a motion that is still to be found",
        ),
        (
            lambda: excite(
                robot("puma"), Scene(friction={n: Friction(0, 500, -500) for n in ("waist", "shoulder", "elbow")})
            ),
            "no joint can move (3 joints (waist, shoulder, elbow): held: friction alone takes its effort limit)",
        ),
        (
            lambda: excite(replace_effort(robot("pendulum"), 0.01)),
            "none of 200 postures can be held and moved about within the effort limits",
        ),
    ],
)
def test_is_refused(call, message):
    with pytest.raises(InputError) as caught:
        call()
    assert message in str(caught.value)


def replace_effort(model, effort):
    """The model with another effort limit at every joint."""
    bodies = tuple(
        replace(body, joint=replace(body.joint, effort=effort, lower=0.5, upper=1.0)) for body in model.bodies
    )
    return replace(model, bodies=bodies)
