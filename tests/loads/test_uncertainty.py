"""Error bars of loads where parameters are uncertain: closed forms, and Monte Carlo."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.drawn_motions import run_again
from helpers.example_robots import real
from helpers.motions import Pieces
from helpers.oracles import ROBOTS, robot
from helpers.small_robots import built, joint, link

import robodyn
from robodyn.errors import SceneError
from robodyn.loads.uncertain_report import normal
from robodyn.scene.scene import CoupledMotor, Friction, Motor, Rotor, Scene
from robodyn.scene.uncertainty import Covariance, Deviation, Uncertainty
from robodyn.trajectory.motion import join

KNOWN = Uncertainty(Deviation(0.05), Deviation(0.003, relative=False), Deviation(0.1), Deviation(0.2))
G = 9.81


def pendulum(limit=1000.0, mass=2.0, length=0.5):
    return built(
        link("base"),
        link("arm", mass, (length, 0, 0), (0.01, 0, 0, 0.02, 0, 0.02)),
        joint("hinge", "base", "arm", axis=(0, -1, 0)).replace('effort="1000"', f'effort="{limit!r}"'),
    )


def held(model, scene, q=0.0, rows=5, **options):
    time = np.linspace(0, 1, rows)
    still = np.zeros((rows, model.n))
    return robodyn.torques(model, robodyn.motion(model, time, still + q, still, still), scene, **options)


def test_a_held_pendulum():
    """tau = m g x, so that its variance is (g x s_m)^2 + (m g s_x)^2."""
    result = held(pendulum(), Scene(uncertainty=Uncertainty(Deviation(0.05), Deviation(0.003, relative=False))))
    (found,) = result.uncertainty.joints
    mass, com = 0.05 * 2 * G * 0.5, 2 * G * 0.003
    for bar in (found.load.peak, found.load.rms):
        assert bar.value == pytest.approx(G, rel=1e-14)
        assert bar.standard_error == pytest.approx(math.hypot(mass, com), rel=1e-12)
        assert bar.high - bar.value == pytest.approx(1.959964 * math.hypot(mass, com), rel=1e-6)
        assert bar.method == "linear"
    for shares in (found.load.shares, found.load.rms_shares):
        assert list(shares) == ["arm.mass", "arm.com"]
        assert shares["arm.mass"] == pytest.approx(mass**2 / (mass**2 + com**2), rel=1e-12)
    assert result.uncertainty.parameters == {"arm.mass": pytest.approx(0.1), "arm.com": 0.003}


@pytest.mark.parametrize("limit", [9.0, 9.81, 10.5, 11.0])
def test_the_probability_that_a_limit_is_kept(limit):
    result = held(pendulum(limit), Scene(uncertainty=Uncertainty(Deviation(0.05))))
    expected = normal((limit - G) / (0.05 * G))
    assert result.uncertainty.suffices == pytest.approx(expected, rel=1e-9)
    (effort, velocity) = result.uncertainty.joints[0].limits
    assert (effort.quantity, effort.limit, velocity.probability) == ("effort", limit, 1.0)
    caveats = [caveat.kind for caveat in result.caveats if "parameters" in caveat.kind]
    assert bool(caveats) == (limit >= G and expected < 0.95)
    assert result.within_limits is (False if limit < G else None if caveats else True)


def test_a_balanced_pendulum_is_no_linear_matter():
    """tau = m g s_x z: its magnitude is half-normal, and so is its RMS."""
    model = pendulum(length=0.0)
    result = held(model, Scene(uncertainty=Uncertainty(com=Deviation(0.003, relative=False))))
    (found,) = result.uncertainty.joints
    size = 2 * G * 0.003
    for bar in (found.load.peak, found.load.rms):
        assert (bar.value, bar.method) == (0.0, "draws")
        assert bar.standard_error == pytest.approx(size * math.sqrt(1 - 2 / math.pi), rel=0.03)
        assert abs(bar.high) == pytest.approx(size * 2.2414, rel=0.03)
    assert found.load.shares == {"arm.com": pytest.approx(1.0)}


def test_a_peak_that_may_be_at_another_sample():
    """Two poses, the torque of each by one coordinate of the centre of mass: the larger of two normal numbers."""
    time = np.linspace(0, 1, 2)
    model = built(link("base"), link("arm", 2.0, (0.5, 0, 0.5)), joint("hinge", "base", "arm", axis=(0, -1, 0)))
    q = np.array([[0.0], [-np.pi / 2]])
    scene = Scene(uncertainty=Uncertainty(com=Deviation(0.05, relative=False)))
    motion = robodyn.motion(model, time, q, 0 * q, 0 * q)
    result = robodyn.torques(model, motion, scene)
    again = run_again(model, motion, scene, 4000, bearings=False)["hinge", "tau", "peak"]
    peak, size = result.uncertainty.joints[0].load.peak, 2 * G * 0.05
    assert peak.method == "draws"
    expected = size * math.sqrt(1 - 1 / math.pi)
    assert peak.standard_error == pytest.approx(expected, rel=0.03)
    assert again.std() == pytest.approx(expected, rel=0.05)


def test_correlated_parameters():
    """m and m x that go together, against each other, or not at all."""
    model = pendulum()
    for r in (-1.0, 0.0, 1.0):
        rows = np.array(((0.01, 0.02 * r), (0.02 * r, 0.04)))
        known = Covariance(("arm.m", "arm.mx"), np.array((2.0, 1.0)), rows)
        found = held(model, Scene(uncertainty=Uncertainty(covariance=known)), q=0.0).uncertainty
        fx, load = found.base, found.joints[0].load
        assert load.peak.standard_error == pytest.approx(0.2 * G, rel=1e-12)
        assert load.shares == {"arm.mx": pytest.approx(1.0), "arm.m": pytest.approx(0.0, abs=1e-12)}
        assert fx[2].peak.standard_error == pytest.approx(0.1 * G, rel=1e-12)
        both = {each.name: each for each in found.base}["my"]
        assert both.peak.standard_error == pytest.approx(0.2 * G, rel=1e-12)


def test_parameters_that_are_hardly_told_apart():
    """tau = g (mx + mz) / sqrt(2), with mx + mz known 1e6 times better than either: its variance is 2 s^2 (1 - r)."""
    model, left = pendulum(), 2.0**-42
    rows = 1e10 * np.array(((1.0, left - 1.0), (left - 1.0, 1.0)))
    known = Covariance(("arm.mx", "arm.mz"), np.array((1.0, 0.0)), rows)
    found = held(model, Scene(uncertainty=Uncertainty(covariance=known)), q=-np.pi / 4).uncertainty
    expected = G / math.sqrt(2.0) * math.sqrt(2e10 * left)
    assert found.joints[0].load.peak.standard_error == pytest.approx(expected, rel=1e-3)


def test_friction_that_grows_with_load():
    """tau = (1 + load) g mx at qd > 0, with both uncertain and correlated."""
    known = Covariance(("arm.mx", "hinge.load"), np.array((1.0, 0.1)), np.array(((0.01, 0.0006), (0.0006, 0.0004))))
    scene = Scene(friction={"hinge": Friction(load=0.1)}, uncertainty=Uncertainty(covariance=known))
    model, time, one = pendulum(), np.linspace(0.0, 1.0, 5), np.ones((5, 1))
    found = robodyn.torques(model, robodyn.motion(model, time, 0 * one, 1e-3 * one, 0 * one), scene).uncertainty
    (x, load), bar = (1.1 * G, G), found.joints[0].load.peak
    assert bar.value == pytest.approx(1.1 * G, rel=1e-14)
    assert bar.standard_error == pytest.approx(math.sqrt(0.01 * x * x + 0.0004 * load**2 + 0.0012 * x * load), rel=1e-9)


def test_friction_of_a_coupled_motor():
    """tau = 0.4 on the one joint and -0.8 on the other, all by the friction of the motor that turns with both."""
    motor = CoupledMotor("both", {"wrist_pitch": 1.0, "flange_roll": -2.0}, friction=Friction(0.0, 0.4, -0.4))
    sure = ("waist", "shoulder", "elbow", "wrist_roll", "wrist_pitch", "flange_roll")
    scene = Scene(
        friction=dict.fromkeys(sure, Friction()),
        coupled=(motor,),
        uncertainty=Uncertainty(mass=Deviation(1e-9), joint={"both": Deviation(0.2)}),
    )
    model, time = robot("puma560"), np.linspace(0.0, 1.0, 5)
    rates = np.zeros((5, model.n))
    rates[:, 4] = 1e-3
    found = robodyn.torques(model, robodyn.motion(model, time, 0 * rates, rates, 0 * rates), scene).uncertainty
    for name, expected in (("wrist_pitch", 0.08), ("flange_roll", 0.16)):
        load = next(each.load for each in found.joints if each.load.name == name)
        assert load.peak.standard_error == pytest.approx(expected, rel=1e-6)
        assert load.shares["both.friction"] == pytest.approx(1.0)


@pytest.mark.parametrize(("load", "told"), [(0.1, False), (0.3, True)])
def test_much_friction_that_grows_with_load_is_told(load, told):
    scene = Scene(friction={"hinge": Friction(load=load)}, uncertainty=Uncertainty(mass=Deviation(0.05)))
    assert any("may be off by more than 5 %" in each for each in held(pendulum(), scene).warnings) == told


@pytest.mark.parametrize(("value", "told"), [(2.4, False), (2.6, True)])
def test_a_covariance_of_another_robot_is_told(value, told):
    known = Covariance(("arm.m",), np.array((value,)), np.array(((0.01,),)))
    warnings = held(pendulum(), Scene(uncertainty=Uncertainty(covariance=known))).warnings
    assert any("was found for other parameters: 'arm.m' 2.6, here 2, 6 standard" in each for each in warnings) == told


def test_what_bars_do_not_cover_is_refused():
    with pytest.raises(SceneError, match="error bars of open trees alone"):
        held(robot("puma560"), Scene(passive=("waist",), uncertainty=KNOWN))


def waves(model, samples=300, seed=1, size=1.0):
    """A motion of sines, to be had in every robot."""
    rng, time = np.random.default_rng(seed), np.linspace(0, 2, samples)
    rate, phase, far = rng.uniform(2, 5, model.n), rng.uniform(0, 6, model.n), rng.uniform(0.3, size, model.n)
    turn = np.multiply.outer(time, rate) + phase
    return robodyn.motion(model, time, far * np.sin(turn), far * rate * np.cos(turn), -far * rate**2 * np.sin(turn))


RUBBING = Friction(0.5, 1.0, -0.8)


def scene_of(model, friction=RUBBING, efficiency=0.8, **more):
    """All that may be uncertain, with motors and gears at every joint."""
    names = [joint.name for joint in model.independent if joint.kind != "floating"]
    motor = Motor(efficiency, continuous=1.0, peak=((0.0, 3.0), (900.0, 1.0)), gear_average=30.0, gear_peak=90.0)
    return Scene(
        friction=dict.fromkeys(names, friction),
        rotor=dict.fromkeys(names, Rotor(1e-4, 50.0)),
        motor=dict.fromkeys(names, motor),
        uncertainty=KNOWN,
        **more,
    )


OF_LIMITS = {
    "effort": ("tau", "peak"),
    "motor torque": ("use", "peak"),
    "RMS motor torque": ("motor", "rms"),
    "gear torque": ("gear", "peak"),
    "mean gear torque": ("gear", "cubic"),
}


def bars(found):
    """Every bar by joint, quantity and kind."""
    for each in found.joints:
        for load, name in ((each.load, "tau"), *([(each.motor, "motor")] if each.motor else [])):
            yield (each.load.name, name, "peak"), load.peak
            yield (each.load.name, name, "rms"), load.rms
        for limit in each.limits:
            if limit.quantity in OF_LIMITS:
                yield (each.load.name, *OF_LIMITS[limit.quantity]), limit.figure
    for owner, loads in (("", found.base), *found.bearings.items()):
        for load in loads:
            yield (owner, load.name, "peak"), load.peak
            yield (owner, load.name, "rms"), load.rms


def compare(result, again, share=0.05):
    """Assert that bars are those of motions that are run again: errors within a share, ends within it of the width."""
    found = list(bars(result.uncertainty))
    assert len(found) > 30
    for name, bar in found:
        signed = again[name] if bar.value >= 0.0 else -again[name]
        error, (low, high) = signed.std(ddof=1), np.quantile(signed, (0.025, 0.975))
        size, width = max(abs(bar.value), 1e-3), high - low
        assert abs(bar.standard_error - error) <= share * error + 1e-12 * size, name
        assert abs(bar.low - low) <= share * width + 1e-12 * size, name
        assert abs(bar.high - high) <= share * width + 1e-12 * size, name


LOSSY = {"friction": Friction(), "efficiency": 0.5}
"""Loads that are small beside their errors, so that gears lose now on the one way and now on the other."""


@pytest.mark.parametrize(
    ("name", "more", "samples", "count"),
    [
        ("scara", {}, 16, 5000),
        pytest.param("puma560", LOSSY, 16, 20_000, marks=pytest.mark.slow),
        pytest.param("cylindrical", {}, 16, 20_000, marks=pytest.mark.slow),
        pytest.param("gripper", {}, 16, 20_000, marks=pytest.mark.slow),
        pytest.param("ur5_robot", LOSSY, 16, 20_000, marks=pytest.mark.slow),
        pytest.param("scara", LOSSY, 900, 5000, marks=pytest.mark.slow, id="more samples than are kept"),
    ],
)
def test_bars_are_those_of_motions_that_are_run_again(name, more, samples, count):
    """Joints, motors, gears, bearings and the base: standard errors, and both ends of intervals of their width."""
    model = robot(name) if (ROBOTS / f"{name}.urdf").exists() else real(name)
    motion, scene = waves(model, samples), scene_of(model, **more)
    compare(robodyn.torques(model, motion, scene), run_again(model, motion, scene, count))


def test_blocks_threads_and_executors_agree():
    model = robot("two_link_planar")
    scene, trajectory = scene_of(model), waves(model, 120)

    whole = list(bars(robodyn.torques(model, trajectory, scene, executor="numpy").uncertainty))
    again = list(bars(robodyn.torques(model, trajectory, scene, executor="compiled", threads=2).uncertainty))
    parts = list(bars(robodyn.torques(model, Pieces(trajectory, [50, 1, 69]), scene).uncertainty))
    for (name, a), (_, b), (_, c) in zip(whole, again, parts, strict=True):
        assert a.standard_error == pytest.approx(b.standard_error, rel=1e-9, abs=1e-12), name
        assert a.low == pytest.approx(b.low, rel=1e-9, abs=1e-9), name
        assert a.standard_error == pytest.approx(c.standard_error, rel=1e-9, abs=1e-12), name
        assert a.method == b.method == c.method, name


def test_a_floating_base():
    model = robot("satellite", moving_base=True)
    scene = Scene(moving_base=True, gravity=(0.0, 0.0, 0.0), uncertainty=Uncertainty(Deviation(0.05)))
    with robodyn.read_motion(ROBOTS / "satellite_slew.csv", model, scene) as reader:
        whole = join(list(reader.blocks()))
    some = (part[::5] for part in (whole.time, whole.q, whole.qd, whole.qdd))
    motion = robodyn.motion(model, *some, scene=scene)
    compare(robodyn.torques(model, motion, scene, sizing=True), run_again(model, motion, scene, 3000))
