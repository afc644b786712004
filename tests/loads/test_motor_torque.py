"""Motors at their shafts: the gear's loss either way, the rotor once, closed forms, the gear maker's example."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.command_line import ROBOTS
from helpers.oracles import EPS, reference
from helpers.small_robots import built, joint, link
from scipy.integrate import trapezoid

import robodyn
from robodyn.errors import SceneError
from robodyn.loads.sizing import allowed
from robodyn.loads.torques import torques
from robodyn.scene.parts import Motor, Rotor
from robodyn.scene.scene import Scene
from robodyn.support.floats import first_largest
from robodyn.trajectory.read import motion

SIZING = reference("sizing")
LIMITS = '<limit lower="-9" upper="9" effort="1000" velocity="100"/>'


def wheel(kind="revolute", limits=LIMITS, J=2.0):
    hinge = joint("j", "base", "wheel", kind).replace(LIMITS, limits)
    return built(link("base"), link("wheel", J, inertia=(J, 0, 0, J, 0, J)), hinge)


def swing(model, n=4001):
    """q = 0.5 sin(2 pi t) over one cycle."""
    t = np.linspace(0, 1, n)[:, None]
    w = 2 * np.pi
    return motion(model, t[:, 0], 0.5 * np.sin(w * t), 0.5 * w * np.cos(w * t), -0.5 * w * w * np.sin(w * t))


def floating_in_space(motor=None, rotor=None):
    return Scene(
        gravity=(0.0, 0.0, 0.0), motor={"j": motor} if motor else {}, rotor={"j": rotor} if rotor is not None else {}
    )


def of_swing(motor, rotor=None, kind="revolute"):
    model = wheel(kind)
    return torques(model, swing(model), floating_in_space(motor, rotor)).sizing.joints[0]


def test_a_motor_without_gear_does_what_the_joint_does():
    """J = 2: peak 39.4784, RMS 27.9155, power 62.0126 W, work 19.7392 J per cycle."""
    expected, found = SIZING["closed_form_test"], of_swing(Motor())
    motor = found.motor
    assert abs(abs(motor.peak) / expected["tau_peak"] - 1) <= 4 * EPS
    assert abs(motor.rms / expected["tau_rms"] - 1) <= 2e-9
    assert abs(motor.peak_power / expected["power_peak"] - 1) <= 1e-6
    assert abs(motor.least_power / -expected["power_peak"] - 1) <= 1e-6
    assert abs(motor.work_positive / expected["positive_work_per_cycle"] - 1) <= 3e-6
    assert abs(motor.work_positive + motor.work_negative) <= 1e-12 * motor.work_positive
    assert (motor.peak_time, motor.peak_row) == (0.25, 1001)
    assert (motor.max_speed, motor.max_speed_time, motor.max_speed_row) == (np.pi, 0.0, 1)
    assert abs(motor.mean_speed - 2.0) <= 1e-6
    assert abs(found.mean_speed - 2.0) <= 1e-6
    assert (motor.inertia_ratio, motor.unit, motor.speed_unit) == (None, "N m", "rad/s")
    assert (found.static_peak, found.static_rms, found.static_share) == (0, 0, 0)


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


def test_the_rotor_counts_once_and_before_the_gear():
    """T = G J qdd + (tau - G^2 J qdd) / (G e^s), and tau itself holds G^2 J qdd."""
    e, G, J_rotor, J = 0.8, 10.0, 0.01, 2.0
    model, scene = wheel(), floating_in_space(Motor(efficiency=e), Rotor(0.01, 10.0))
    taken = swing(model)
    result = torques(model, taken, scene)
    qd, qdd = taken.qd[:, 0], taken.qdd[:, 0]
    assert abs(result.joints[0].peak / (-(J + G * G * J_rotor) * 2 * np.pi**2) - 1) <= 4 * EPS
    shaft = G * J_rotor * qdd + J * qdd / G * np.where(qdd * qd > 0, 1 / e, np.where(qdd * qd < 0, e, 1))
    motor = result.sizing.joints[0].motor
    assert abs(abs(motor.peak) - np.abs(shaft).max()) <= 8 * EPS * np.abs(shaft).max()
    assert motor.rms == pytest.approx(np.sqrt(trapezoid(shaft**2, taken.time)), rel=1e-13)
    assert motor.inertia_ratio == pytest.approx(J / (G * G * J_rotor), rel=1e-13)


def test_a_lossless_gear_keeps_power_and_work():
    found = of_swing(Motor(), Rotor(0.01, -37.0))
    load = torques(wheel(), swing(wheel()), floating_in_space(Motor(), Rotor(0.01, -37.0))).joints[0]
    for name in ("peak_power", "least_power", "work_positive", "work_negative"):
        assert getattr(found.motor, name) == pytest.approx(getattr(load, name), rel=1e-13)


def worked_example():
    """150, 82, 130, 0 N m for 0.2, 3, 0.3, 0.2 s at 10, 20, 10, 0 rpm, as a motion of a flywheel."""
    example = SIZING["harmonic_drive"]["worked_example"]
    rows = [(T, n * np.pi / 30, t) for T, n, t in zip(*(example[key] for key in ("T", "n", "t")), strict=True)]
    ends = np.cumsum([0, *(t for *_, t in rows)])
    time = np.column_stack((ends[:-1] + 1e-9, ends[1:])).ravel()
    speed, push = (np.repeat([row[k] for row in rows], 2)[:, None] for k in (1, 0))
    return motion(wheel(), time, 0 * speed, speed, push / 2.0)


def test_harmonic_drives_example_against_the_gears_limits():
    """Cubic mean 89.3868 N m, duty cycle 3.5 of 3.7 s, mean speed 17.5676 rpm."""
    example = SIZING["harmonic_drive"]["worked_example"]

    def sized(**gear):
        return torques(wheel(), worked_example(), floating_in_space(Motor(**gear))).sizing.joints[0]

    joint = sized(gear_average=89.0, gear_peak=140.0)
    peak, mean = joint.exceeded
    assert joint.level == "over peak"
    assert (mean.quantity, mean.level, mean.limit) == ("mean gear torque", "over continuous", 89.0)
    assert abs(mean.value / 89.3868 - 1) <= 1e-6
    assert (mean.time, mean.row, mean.seconds) == (None, None, None)
    assert (peak.quantity, peak.value, peak.limit, peak.row) == ("gear torque", 150.0, 140.0, 1)
    assert peak.seconds == pytest.approx(0.2, abs=1e-6)
    assert joint.duty_cycle == pytest.approx(3.5 / 3.7, abs=1e-6)
    assert joint.mean_speed * 30 / np.pi == pytest.approx(example["n_out_av_rpm"], abs=1e-5)
    assert sized(gear_average=89.4, gear_peak=150.0).level == "OK"
    assert sized(gear_average=89.0).level == "over continuous"


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
    joint = torques(model, swing(model), floating_in_space(), sizing=True).sizing.joints[0]
    assert [(x.quantity, x.limit) for x in joint.exceeded] == [("effort", 30.0), ("velocity", 3.0)]
    assert (joint.exceeded[0].time, joint.exceeded[0].row) == (0.25, 1001)
    assert (joint.exceeded[1].time, joint.exceeded[1].row) == (0.0, 1)
    endless = wheel("continuous")
    assert torques(endless, swing(endless), floating_in_space(), sizing=True).sizing.joints[0].level == "no limits"


def test_units_of_slides():
    """A slide without a gear has a linear motor, with one a turning motor."""
    assert of_swing(Motor(), kind="prismatic").motor.unit == "N"
    screw = of_swing(Motor(), Rotor(1e-4, 2 * np.pi / 0.01), kind="prismatic").motor
    assert (screw.unit, screw.speed_unit) == ("N m", "rad/s")
    assert screw.max_speed == pytest.approx(2 * np.pi / 0.01 * np.pi)


def test_a_motor_needs_a_gear_that_turns():
    with pytest.raises(SceneError, match=r"\[motor\] j: the gear ratio is 0"):
        of_swing(Motor(), Rotor(1e-4, 0.0))


def test_curves():
    curve = ((1.0, 4.0), (3.0, 2.0))
    assert allowed(curve, np.array([0.0, 1.0, 2.0, 3.0, np.nextafter(3, 4)])).tolist() == [4, 4, 3, 2, 0]
    assert allowed(5.0, np.array([0.0, 1e9])).tolist() == [5, 5]


def test_one_sample():
    model = wheel()
    at = motion(model, [1.0], [[0.0]], [[0.5]], [[3.0]])
    joint = torques(model, at, floating_in_space(Motor(continuous=5.0, peak=7.0))).sizing.joints[0]
    assert (joint.motor.rms, joint.motor.mean_speed, joint.mean_speed, joint.duty_cycle) == (6, 0.5, 0.5, 1)
    assert [x.quantity for x in joint.exceeded] == ["RMS motor torque"]


def test_without_motors_nothing_is_sized():
    model = wheel()
    taken = swing(model, 11)
    bare, sized = (torques(model, taken, floating_in_space(), sizing=sizing) for sizing in (None, True))
    assert bare.sizing is None
    assert bare.operations == sized.operations
    assert replace(sized, sizing=None) == bare
    assert torques(model, taken, floating_in_space(Motor()), sizing=False).sizing is None


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
