"""Figures of joints, motors, gears and bearings against closed forms, plain NumPy and the gear maker's example."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.command_line import ROBOTS
from helpers.oracles import EPS, random_state, reference, worst
from helpers.small_robots import built, joint, link, random_tree
from scipy.integrate import trapezoid

import robodyn
from robodyn.errors import SceneError
from robodyn.loads.accumulate import quadrature_errors
from robodyn.loads.statistics import Integrals
from robodyn.loads.torques import torques
from robodyn.scene.scene import Friction, Motor, Rotor, Scene
from robodyn.support.floats import first_largest
from robodyn.trajectory.read import motion

SIZING = reference("sizing")


LIMITS = '<limit lower="-9" upper="9" effort="1000" velocity="100"/>'


def wheel(kind="revolute", limits=LIMITS, J=2.0):
    hinge = joint("j", "base", "wheel", kind).replace(LIMITS, limits)
    return built(link("base"), link("wheel", J, inertia=(J, 0, 0, J, 0, J)), hinge)


def swing(model, n=4001):
    """q = 0.5 sin(2 pi t) over one cycle, sampled so that all extremes are met."""
    t = np.linspace(0, 1, n)[:, None]
    w = 2 * np.pi
    return motion(model, t[:, 0], 0.5 * np.sin(w * t), 0.5 * w * np.cos(w * t), -0.5 * w * w * np.sin(w * t))


def in_space(motor=None, rotor=None, **more):
    """A scene without weight, with a motor or a rotor at the joint."""
    return Scene(
        gravity=(0.0, 0.0, 0.0),
        motor={"j": motor} if motor else {},
        rotor={"j": rotor} if rotor is not None else {},
        **more,
    )


EXAMPLE = SIZING["harmonic_drive"]["worked_example"]
"""Of the gear's maker: 150, 82, 130, 0 N m for 0.2, 3, 0.3, 0.2 s at 10, 20, 10, 0 rpm."""


def worked_example():
    """Its motion of the flywheel, pushed so that its torque is what the example asks for."""
    rows = [(T, n * np.pi / 30, t) for T, n, t in zip(*(EXAMPLE[key] for key in ("T", "n", "t")), strict=True)]
    ends = np.cumsum([0, *(t for *_, t in rows)])
    time = np.column_stack((ends[:-1] + 1e-9, ends[1:])).ravel()
    speed, push = (np.repeat([row[k] for row in rows], 2)[:, None] for k in (1, 0))
    return motion(wheel(), time, 0 * speed, speed, push / 2.0)


def of_swing(motor, rotor=None, kind="revolute"):
    model = wheel(kind)
    return torques(model, swing(model), in_space(motor, rotor)).sizing.joints[0]


def test_closed_form_of_a_swinging_wheel():
    """J = 2: peak 39.4784, RMS 27.9155, power 62.0126 W, work 19.7392 J per cycle; a motor without a gear does it."""
    expected, result = SIZING["closed_form_test"], torques(wheel(), swing(wheel()), in_space(Motor()))
    (load,), (sized,) = result.joints, result.sizing.joints
    for found in (load, sized.motor):
        assert abs(abs(found.peak) / expected["tau_peak"] - 1) <= 4 * EPS
        assert abs(found.rms / expected["tau_rms"] - 1) <= 2e-9
        assert abs(found.max_speed / expected["qd_peak"] - 1) <= 4 * EPS
        assert abs(found.peak_power / expected["power_peak"] - 1) <= 1e-9
        assert abs(found.least_power / -expected["power_peak"] - 1) <= 1e-9
        assert abs(found.work_positive / expected["positive_work_per_cycle"] - 1) <= 3e-6
        assert abs(found.work_positive + found.work_negative) <= 1e-12 * found.work_positive
        assert abs(found.torque_at_max_speed) <= 1e-12
        assert (found.peak_time, found.peak_row) == (0.25, 1001)
        assert (found.max_speed, found.max_speed_time, found.max_speed_row) == (np.pi, 0.0, 1)
        assert found.peak < 0
        assert abs(found.peak_speed) <= 1e-12
    assert abs(load.mean) <= 1e-12 * load.rms
    assert abs(sized.motor.mean_speed - 2.0) <= 1e-6
    assert abs(sized.mean_speed - 2.0) <= 1e-6
    assert (sized.motor.inertia_ratio, sized.motor.unit, sized.motor.speed_unit) == (None, "N m", "rad/s")
    assert (sized.static_peak, sized.static_rms, sized.static_share) == (0, 0, 0)


def test_harmonic_drives_example_against_the_gears_limits():
    """Cubic mean 89.3868 N m, dwell not in it; duty cycle 3.5 of 3.7 s, mean speed 17.5676 rpm."""

    def sized(**gear):
        return torques(wheel(), worked_example(), in_space(Motor(**gear)))

    result = sized(gear_average=89.0, gear_peak=140.0)
    (load,), (joint,) = result.joints, result.sizing.joints
    squares = sum(T * T * t for T, t in zip(EXAMPLE["T"], EXAMPLE["t"], strict=True))
    assert load.rms == pytest.approx(np.sqrt(squares / 3.7), rel=1e-6)
    assert load.cubic_mean == pytest.approx(EXAMPLE["T_av"], abs=0.005)
    peak, mean = joint.exceeded
    assert joint.level == "over peak"
    assert (mean.quantity, mean.level, mean.limit) == ("mean gear torque", "over continuous", 89.0)
    assert abs(mean.value / 89.3868 - 1) <= 1e-6
    assert (mean.time, mean.row, mean.seconds) == (None, None, None)
    assert (peak.quantity, peak.value, peak.limit, peak.row) == ("gear torque", 150.0, 140.0, 1)
    assert peak.seconds == pytest.approx(0.2, abs=1e-6)
    assert joint.duty_cycle == pytest.approx(3.5 / 3.7, abs=1e-6)
    assert joint.mean_speed * 30 / np.pi == pytest.approx(EXAMPLE["n_out_av_rpm"], abs=1e-5)
    assert sized(gear_average=89.4, gear_peak=150.0).sizing.joints[0].level == "OK"
    assert sized(gear_average=89.0).sizing.joints[0].level == "over continuous"


def test_limits_exceeded_are_told_apart():
    model = wheel(limits='<limit lower="-0.4" upper="0.6" effort="30" velocity="2"/>')
    result = torques(model, swing(model), in_space())
    load = result.joints[0]
    assert (load.effort_limit, load.velocity_limit, load.lower, load.upper) == (30, 2, -0.4, 0.6)
    assert worst(load.effort_margin, 30 - 8 * np.pi**2 / 2) <= 1e-12
    assert worst(load.velocity_margin, 2 - np.pi) <= 1e-12
    assert load.seconds_over_effort == pytest.approx(1 - 4 * np.arcsin(30 / (4 * np.pi**2)) / (2 * np.pi), abs=2e-3)
    assert load.seconds_over_velocity == pytest.approx(1 - 4 * np.arcsin(2 / np.pi) / (2 * np.pi), abs=2e-3)
    found = [(excess.joint, excess.quantity, excess.limit, excess.unit) for excess in result.exceeded]
    assert found == [("j", "effort", 30, "N m"), ("j", "velocity", 2, "rad/s"), ("j", "position", -0.4, "rad")]
    assert [round(excess.value, 6) for excess in result.exceeded] == [39.478418, 3.141593, -0.5]


def test_hold_band_is_the_coulomb_friction():
    model = wheel()
    scene = Scene(friction={"j": Friction(1.0, 0.4, -0.35)})
    assert abs(torques(model, swing(model, 21), scene).joints[0].hold - 0.375) <= EPS


def test_quadrature_error_of_a_parabola():
    """Trapezoids and Richardson: for x^2 on an even grid the estimate is exact."""
    x = np.linspace(0, 2, 9)
    error = trapezoid(x**2, x) - 8 / 3
    assert error > 0.01
    assert abs(abs(quadrature_errors(np.diff(x), x**2).sum()) - error) <= 1e-15
    assert not quadrature_errors(np.diff(x), 3 * x + 1).any()
    assert len(quadrature_errors(np.empty(0), np.ones(1))) == 0


def test_integrals_over_uneven_steps():
    rng = np.random.default_rng(5)
    time, values = np.sort(rng.uniform(0, 9, 50)), rng.normal(size=(3, 50))
    integrals = Integrals()
    for start, stop in ((0, 1), (1, 20), (20, 21), (21, 50)):
        integrals.update(time[start:stop], {"x": values[:, start:stop]})
    assert worst(integrals.totals["x"], trapezoid(values, time, axis=1)) <= 8 * EPS


@pytest.mark.parametrize("G", [20.0, -20.0])
def test_gear_and_efficiency(G):
    """Driving, the motor gives the load's power over e; driven, it takes e of it; at rest e does not count."""
    e, J = 0.7, 2.0
    found = of_swing(Motor(efficiency=e), Rotor(0.0, G)).motor
    power, work = SIZING["closed_form_test"]["power_peak"], SIZING["closed_form_test"]["positive_work_per_cycle"]
    assert found.peak_power == pytest.approx(power / e, rel=1e-6)
    assert found.least_power == pytest.approx(-power * e, rel=1e-6)
    assert found.work_positive == pytest.approx(work / e, rel=3e-6)
    assert found.work_negative == pytest.approx(-work * e, rel=3e-6)
    tau = SIZING["closed_form_test"]["tau_rms"]
    assert found.rms == pytest.approx(tau / abs(G) * np.sqrt((e**2 + e**-2) / 2), rel=5e-4)  # T jumps where qd turns
    assert found.max_speed == G * np.pi
    assert abs(found.peak) == pytest.approx(J * 2 * np.pi**2 / abs(G) / e, rel=1e-5)


def test_the_inertia_of_the_load_beside_that_of_the_rotor():
    assert of_swing(Motor(), Rotor(0.01, 10.0)).motor.inertia_ratio == pytest.approx(2.0 / (10.0**2 * 0.01), rel=1e-13)


def test_continuous_torque_at_the_mean_speed():
    """RMS 27.9155 at a mean of 2 rad/s."""
    curve = ((0.0, 40.0), (1.0, 30.0), (3.0, 24.0))
    joint = of_swing(Motor(continuous=curve))
    assert joint.motor.continuous_limit == pytest.approx(27.0, abs=1e-5)
    (found,), motor = joint.exceeded, joint.motor
    assert (joint.level, found.quantity) == ("over continuous", "RMS motor torque")
    assert (found.value, found.limit, found.speed) == (motor.rms, motor.continuous_limit, motor.mean_speed)
    assert joint.motor.continuous_margin == found.limit - found.value < 0
    assert of_swing(Motor(continuous=28.0)).level == "OK"
    assert of_swing(Motor(continuous=((1.9, 28.0),))).motor.continuous_limit == 0
    above = of_swing(Motor(continuous=20.0)).motor.seconds_above_continuous
    assert above == pytest.approx(1 - 4 * np.arcsin(20 / (4 * np.pi**2)) / (2 * np.pi), abs=1e-3)


def test_peak_curve_and_speed():
    """Beyond the curve where |T| / limit is largest, found by plain NumPy."""
    curve = ((0.0, 39.0), (1.0, 36.0), (2.5, 12.0), (3.0, 8.0), (3.1, 7.0))
    joint = of_swing(Motor(peak=curve))
    taken = swing(wheel())
    T, v = np.abs(2 * taken.qdd[:, 0]), np.abs(taken.qd[:, 0])
    limit = np.where(v > 3.1, 1e-9 * 39.0, np.interp(v, *zip(*curve, strict=True)))
    at = first_largest(T / limit)  # the motion is its mirror image in time
    limit = np.where(v > 3.1, 0.0, limit)
    torque, speed = joint.exceeded if joint.exceeded[0].quantity == "motor torque" else joint.exceeded[::-1]
    assert (torque.quantity, speed.quantity, joint.level) == ("motor torque", "motor speed", "over peak")
    assert (torque.row, torque.time) == (at + 1, taken.time[at])
    assert abs(torque.value - T[at]) <= 4 * EPS * T.max()
    assert abs(torque.limit - limit[at]) <= 4 * EPS * T.max()
    assert torque.speed == v[at]
    assert torque.seconds == pytest.approx(trapezoid((limit < T).astype(float), taken.time), rel=1e-12)
    assert (speed.value, speed.limit, speed.row) == (np.pi, 3.1, 1)
    assert joint.motor.peak_margin == torque.limit - torque.value
    assert of_swing(Motor(peak=curve, max_speed=3.2)).motor.speed_limit == 3.2
    assert of_swing(Motor(peak=40.0)).level == "OK"
    assert [x.quantity for x in of_swing(Motor(peak=40.0, max_speed=3.0)).exceeded] == ["motor speed"]


def test_limits_of_the_description_are_part_of_the_verdict():
    model = wheel(limits='<limit lower="-9" upper="9" effort="30" velocity="3"/>')
    joint = torques(model, swing(model), in_space(), sizing=True).sizing.joints[0]
    assert [(x.quantity, x.limit) for x in joint.exceeded] == [("effort", 30.0), ("velocity", 3.0)]
    assert (joint.exceeded[0].time, joint.exceeded[0].row) == (0.25, 1001)
    assert (joint.exceeded[1].time, joint.exceeded[1].row) == (0.0, 1)
    endless = wheel("continuous")
    assert torques(endless, swing(endless), in_space(), sizing=True).sizing.joints[0].level == "no limits"


def test_units_of_slides():
    """A slide without a gear has a linear motor, with one a turning motor."""
    assert of_swing(Motor(), kind="prismatic").motor.unit == "N"
    screw = of_swing(Motor(), Rotor(1e-4, 2 * np.pi / 0.01), kind="prismatic").motor
    assert (screw.unit, screw.speed_unit) == ("N m", "rad/s")
    assert screw.max_speed == pytest.approx(2 * np.pi / 0.01 * np.pi)


def test_a_motor_needs_a_gear_that_turns():
    with pytest.raises(SceneError, match=r"\[motor\] j: the gear ratio is 0"):
        of_swing(Motor(), Rotor(1e-4, 0.0))


def test_one_sample():
    model = wheel()
    at = motion(model, [1.0], [[0.0]], [[0.5]], [[3.0]])
    joint = torques(model, at, in_space(Motor(continuous=5.0, peak=7.0))).sizing.joints[0]
    assert (joint.motor.rms, joint.motor.mean_speed, joint.mean_speed, joint.duty_cycle) == (6, 0.5, 0.5, 1)
    assert [x.quantity for x in joint.exceeded] == ["RMS motor torque"]


def test_without_motors_nothing_is_sized():
    model = wheel()
    taken = swing(model, 11)
    bare, sized = (torques(model, taken, in_space(), sizing=sizing) for sizing in (None, True))
    assert bare.sizing is None
    assert bare.operations == sized.operations
    assert replace(sized, sizing=None) == bare
    assert torques(model, taken, in_space(Motor()), sizing=False).sizing is None


def test_motors_at_joints_that_nothing_drives():
    """Their rotors are turned along, so that their speed alone is judged; they accelerate no load."""
    model, scene = robodyn.load(ROBOTS / "crank_slider.urdf"), robodyn.load_scene(ROBOTS / "crank_slider_turn.toml")
    motor = Motor(continuous=1.0, peak=1.0, max_speed=10.0)
    rotors = {name: Rotor(1e-4, 10.0) for name in ("main", "pin")}
    scene = replace(scene, motor={"main": motor, "pin": motor}, rotor=rotors)
    result = torques(model, ROBOTS / "crank_slider_turn.csv", scene)
    assert result.sizing is not None
    found = {joint.name: joint.motor for joint in result.sizing.joints}
    assert found["pin"].inertia_ratio is None
    assert found["main"].inertia_ratio > 1.0
    assert found["pin"].seconds_over_speed > 1.0
    assert "nothing drives 'pin', so that its [motor] is judged by its speed alone" in result.warnings


@pytest.mark.parametrize("seed", range(2))
def test_bearings_of_skew_joints(seed):
    """One sample at a time: rotated back with the drive, they are the wrench that --reactions writes."""
    model = random_tree(seed, kinds=("revolute", "prismatic"))
    at = [x[:1] for x in random_state(model, np.random.default_rng(seed), 1)]
    wrenches = []
    keep = lambda time, columns: wrenches.append(columns[0, model.n + 6 :].reshape(-1, 6))  # noqa: E731
    result = torques(model, motion(model, [0.0], *at), sizing=True, reactions=True, sinks=[keep])
    largest = np.abs(wrenches[0]).max()
    for body, bearing, wrench in zip(model.bodies[1:], result.sizing.bearings, wrenches[0], strict=True):
        parts = {part.name: part.peak for part in bearing.components}
        assert len(parts) == 5
        missing = ({"fu", "fv", "fa", "mu", "mv", "ma"} - parts.keys()).pop()
        assert missing == {"revolute": "ma", "prismatic": "fa"}[body.joint.kind]
        vector = wrench[:3] if missing == "fa" else wrench[3:]
        parts[missing] = vector @ body.joint.axis
        turn = np.array(bearing.directions)
        for kind, expected in (("f", wrench[:3]), ("m", wrench[3:])):
            back = turn.T @ [parts[f"{kind}{axis}"] for axis in "uva"]
            assert np.abs(back - expected).max() <= 16 * EPS * largest
        assert bearing.radial.peak == pytest.approx(np.hypot(parts["fu"], parts["fv"]), rel=1e-14)
        assert bearing.tilting.peak == pytest.approx(np.hypot(parts["mu"], parts["mv"]), rel=1e-14)
