"""Examples that makers of gears and motors printed, screws and pinions, one pose, and scenes that are wrong."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.command_line import ROBOTS, document, run, shown
from helpers.small_robots import built, link

import robodyn
from robodyn.errors import InputError, SceneError
from robodyn.identification.result import calibrated
from robodyn.scene.fit import check_scene
from robodyn.scene.read import parse_scene
from robodyn.scene.scene import ExternalWrench, Friction, GearLife, Motor, Rotor, Scene
from robodyn.trajectory.read import motion, pose

LIMITS = '<limit lower="-1e6" upper="1e6" effort="1e6" velocity="1e6"/>'
RPM = np.pi / 30
THERMAL = """[motor.j.thermal]
resistance = 0.5
torque_constant = 0.05
winding_housing = 1.2
winding_capacity = 20
winding_limit = 155
"""


def mover(kind="revolute", J=2.0):
    joint = f'<joint name="j" type="{kind}"><parent link="base"/><child link="it"/><axis xyz="0 0 1"/>{LIMITS}</joint>'
    return built(link("base"), link("it", J, inertia=(J, 0, 0, J, 0, J)), joint)


def driven(phases, *, J=2.0, motor=None, rotor=None, kind="revolute", **scene):
    """The motor's figures over phases (torque of inertia, speed in rpm from and to, seconds) in space."""
    ends, time, speed, push = 0.0, [], [], []
    for torque, begin, end, seconds in phases:
        time += [ends + 1e-9, ends + seconds]
        speed += [begin * RPM, end * RPM]
        push += [torque / J] * 2
        ends += seconds
    model, qd = mover(kind, J), np.array(speed)[:, None]
    given = Scene(gravity=(0.0, 0.0, 0.0), motor={"j": motor or Motor()}, rotor={"j": rotor} if rotor else {}, **scene)
    found = robodyn.torques(model, motion(model, time, 0 * qd, qd, np.array(push)[:, None]), given)
    return found.joints[0], found.sizing.joints[0]


def test_harmonic_drives_selection_of_a_csf_40_120():
    """Harmonic Drive, CSF-2A catalogue, example: 400, 320, 200 N m at 7, 14, 7 rpm for 0.3, 3, 0.4 s, 0.2 s of pause;
    printed: average torque 319 N m, 12 rpm, 1440 rpm in, and 7610 h of 7000 h at 294 N m and 2000 rpm."""
    life, rotor = {"j": GearLife(7000.0, 294.0, 2000 * RPM)}, Rotor(0.0, gear=120.0)
    load, joint = driven(
        [(400, 7, 7, 0.3), (320, 14, 14, 3), (200, 7, 7, 0.4), (0, 0, 0, 0.2)], rotor=rotor, gear_life=life
    )
    motor = joint.motor
    assert int(motor.gear_mean) == int(load.cubic_mean) == 319
    assert round(motor.mean_speed / RPM / 120) == 12
    exact = (400**3 * 2.1 + 320**3 * 42 + 200**3 * 2.8) / 46.9
    assert motor.gear_mean == pytest.approx(exact ** (1 / 3), rel=1e-7)
    assert motor.gear_life == pytest.approx(7000 * 294**3 / exact * 2000 / (120 * 46.9 / 3.9), rel=1e-6)
    _, joint = driven([(319, 12, 12, 1)], rotor=rotor, gear_life=life)  # the maker goes on with what it printed
    assert int(joint.motor.gear_life) == 7610


def test_a_gear_that_stands_still_lives_for_ever():
    _, still = driven([(90, 0, 0, 1)], rotor=Rotor(0.0, gear=50.0), gear_life={"j": GearLife(6000.0, 100.0, 150.0)})
    assert still.motor.gear_life is None


def test_maxons_selection_of_a_drive():
    """maxon catalogue, example of selecting a drive: 140 000 g cm^2 to 60 rpm in 0.5 s, friction 300 mNm, 2 s of this,
    0.5 s to rest, 0.7 s of standstill. Printed: 476, 300, 124 mNm, RMS 285 mNm, 3 W; with a gear 84:1 of 59 %:
    5040 rpm, RMS 5.75 mNm, largest 9.6 mNm."""
    alpha = 0.014 * 60 * RPM / 0.5
    phases = [(alpha, 0, 60, 0.5), (0, 60, 60, 2), (-alpha, 60, 0, 0.5), (0, 0, 0, 0.7)]
    phases[0], phases[2] = (alpha, 1e-9, 60, 0.5), (-alpha, 60, 1e-9, 0.5)
    friction = {"j": Friction(0.0, 0.3, -0.3)}
    planetary = {"motor": Motor(efficiency=0.59), "rotor": Rotor(0.0, gear=84.0)}
    load, joint = driven(phases, J=0.014, friction=friction, **planetary)
    motor = joint.motor
    assert round(1e3 * alpha) == 176
    assert round(1e3 * load.peak) == 476
    assert round(1e3 * load.rms) == 285
    assert round(load.peak_power) == 3
    assert round(motor.max_speed / RPM) == 5040
    assert round(1e3 * motor.rms, 2) == 5.75
    assert round(1e3 * motor.peak, 1) == 9.6


def test_screws_and_pinions_are_gears_in_turns_per_metre():
    rng = np.random.default_rng(0)
    for key, ratio in (("lead", 2 * np.pi / 0.01), ("pitch_radius", 1 / 0.01)):
        for gear in (None, 3.0, -5.0):
            text = f"[motor.j]\ninertia = 1e-5\n{key} = 0.01\n" + (f"gear = {gear}\n" if gear else "")
            scene, turned = parse_scene(text.encode()), ratio * (gear or 1.0)
            assert scene.rotor["j"].ratio == pytest.approx(turned, rel=1e-15)
            model, t = mover("prismatic"), np.linspace(0, 1, 20)[:, None]
            moved = motion(model, t[:, 0], 0 * t, rng.normal(size=t.shape), rng.normal(size=t.shape))
            plain = parse_scene(f"[motor.j]\ninertia = 1e-5\ngear = {turned!r}\n".encode())
            one, other = (robodyn.torques(model, moved, each) for each in (scene, plain))
            assert one.joints[0].peak == pytest.approx(other.joints[0].peak, rel=1e-14)
            assert one.sizing.joints[0].motor.unit == "N m"
            assert one.sizing.joints[0].motor.max_speed == pytest.approx(
                other.sizing.joints[0].motor.max_speed, rel=1e-14
            )
    rotor = parse_scene(b"[rotor.j]\ninertia = 1e-5\nlead = 0.02\n").rotor["j"]
    assert rotor == Rotor(1e-5, lead=0.02)
    with pytest.raises(SceneError, match="a lead or pitch_radius is for joints that slide") as error:
        check_scene(Scene(rotor={"j": rotor}), mover())
    assert "give gear" in str(error.value)


WRONG = [
    ("[motor.j]\nlead = 0.01\npitch_radius = 0.1", 2, '"lead" and "pitch_radius" are both given'),
    ("[motor.j]\nlead = -0.01", 2, '"lead" is -0.01'),
    ("[motor.j]\nlead = 0.01\ngear = 0", 3, '"gear" is 0'),
    ("[rotor.j]\ninertia = 1\n[motor.j]\nlead = 0.01", 4, r'"lead" and \[rotor\] j say the same'),
    ("[motor.j]\n" + THERMAL.replace("0.5", "0"), 3, '"resistance" is 0'),
    ("[motor.j]\n" + THERMAL.replace("resistance = 0.5\n", ""), 2, '"resistance" is missing'),
    ("[motor.j]\n" + THERMAL + "ambient = 160", 8, '"ambient" is 160'),
    ("[motor.j]\n" + THERMAL + "housing_limit = 0", 8, '"housing_limit" is 0'),
    ("[motor.j]\n" + THERMAL + "housing_ambient = 2", 2, "go together"),
    ("[motor.j]\n" + THERMAL + "housing_capacity = 2", 2, "go together"),
    ("[motor.j]\n" + THERMAL + "torque_coefficient = 0.001", 8, '"torque_coefficient" is 0.001'),
    ("[motor.j]\n" + THERMAL + "start = 900", 8, '"start" is 900'),
    ("[motor.j]\n" + THERMAL + "start = nan", 8, "not a finite number"),
    ("[motor.j]\n" + THERMAL + "drive_efficiency = 1.1", 8, '"drive_efficiency" is 1.1'),
    ("[motor.j]\n" + THERMAL + "ambiant = 20", 8, 'unknown key "ambiant"'),
    ("[motor.j]\n" + THERMAL.replace("= 0.05", "= 1e-200"), 4, '"torque_constant" is 1e-200'),
    ("[motor.j]\nthermal = 3", 2, "is 3, not a table"),
    ("[motor.j]\n[gear.j]\nratio = 3", 2, '"life" is missing'),
    ("[motor.j]\n[gear.j.life]\nrated_life = 1\nrated_torque = 1", 2, '"rated_speed" is missing'),
    ("[motor.j]\n[gear.j.life]\nrated_life = 0\nrated_torque = 1\nrated_speed = 1", 3, '"rated_life" is 0'),
]


@pytest.mark.parametrize(("text", "line", "said"), WRONG)
def test_wrong_scenes_name_the_line(text, line, said):
    with pytest.raises(SceneError, match=said) as error:
        parse_scene(text.encode(), "s.toml")
    assert str(error.value).startswith(f"s.toml:{line}:")


def test_life_needs_a_ratio():
    scene = parse_scene(b"[gear.j.life]\nrated_life = 1\nrated_torque = 1\nrated_speed = 1")
    model, zero = mover(), np.zeros((2, 1))
    with pytest.raises(SceneError, match="its ratio is not said"):
        robodyn.torques(model, motion(model, [0.0, 1.0], zero, zero, zero), scene)


def test_life_needs_no_motor():
    model, zero = mover(), np.zeros((2, 1))
    scene = Scene(gear_life={"j": GearLife(7000.0, 60.0, 200.0)}, rotor={"j": Rotor(1e-4, gear=100.0)})
    (joint,) = robodyn.torques(model, motion(model, [0.0, 1.0], zero, zero + 1.0, zero + 1.0), scene).sizing.joints
    assert joint.motor.gear_life > 0.0


def test_pose_is_a_motion_of_one_row(tmp_path):
    robot, scene = f"{ROBOTS}/puma560.urdf", f"{ROBOTS}/puma560_sizing.toml"
    at = "0.1,-0.5,0.3,0.2,0.4,-0.2"
    given = ("--at", at, "--qd", "elbow=0.5", "--qdd", "waist=1")
    found = document("torques", robot, *given, "--scene", scene)
    names = [joint["name"] for joint in found["joints"]]
    table = tmp_path / "one.csv"
    qd, qdd = ("0,0,0.5,0,0,0", "1,0,0,0,0,0")
    head = ",".join(["time", *(f"{kind}_{name}" for kind in ("q", "qd", "qdd") for name in names)])
    table.write_text(f"{head}\n0,{at},{qd},{qdd}\n")
    expected = document("torques", robot, str(table), "--scene", scene)
    for key in ("joints", "base_wrench", "sizing"):
        assert found[key] == expected[key]
    model = robodyn.load(robot)
    assert found["samples"] == 1
    written = tmp_path / "tau.csv"
    text = shown("torques", robot, "--at", at, "--reactions", "--explain", "--out", str(written))
    assert "RMS" not in text
    assert len(written.read_text().splitlines()) == 2
    tau = robodyn.inverse_dynamics(model, [float(x) for x in at.split(",")], np.zeros(6), np.zeros(6))
    assert f"{tau[1]:.2f}" in text


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["motion.csv", "--at", "0,0"], "--at is of one pose, in place of motion.csv"),
        (["--qd", "1"], "--qd goes with --at"),
        ([], "missing argument 'TRAJECTORY...', or --at for one pose"),
        (["--at", "1", "--hold", "rest"], "--hold is for trajectories"),
        (["--at", "1", "--accuracy", "1e-3"], "--accuracy is for trajectories"),
        (["--at", "1", "--jobs", "2"], "--jobs goes with many trajectories"),
        (["--at", "1", "--measured"], "--measured is for trajectories"),
        (["--at", "1,2", "--example"], "--example is for trajectories"),
        (["--at", "1,2"], "2 values for 6 coordinates"),
        (["--at", "elbo=1"], "no joint 'elbo' to set"),
    ],
)
def test_poses_that_make_no_sense(options, said):
    done = run("torques", f"{ROBOTS}/puma560.urdf", *options)
    assert (done.status, done.out) == (2, "")
    assert said in done.err
    assert len(done.err.splitlines()) == 1


def test_pose_of_a_scene_with_columns_is_refused():
    scene = Scene(wrenches=(ExternalWrench("it", ("push", 0.0, 0.0)),))
    with pytest.raises(InputError, match=r"push.*, which a pose has not"):
        pose(mover(), {"j": 0.1}, scene=scene)


def test_loops_tell_the_other_joints_of_a_pose():
    text = shown("torques", f"{ROBOTS}/four_bar.urdf", "--at", "left=0.3", "--scene", f"{ROBOTS}/four_bar_lift.toml")
    assert "Follow from the loops" in text
    assert "one row is no motion" not in text
    assert "RMS" not in text


def test_limits_fail_a_pose():
    done = run("torques", f"{ROBOTS}/puma560.urdf", "--at", "shoulder=-3", "--fail-on-limits")
    assert done.status == 1
    assert "shoulder goes to -3 rad, below its lower limit" in done.out


def test_what_is_identified_behind_a_screw_keeps_its_ratio():
    model, scene = mover("prismatic"), Scene(rotor={"j": Rotor(1e-5, lead=0.01)})
    ratio = 2 * np.pi / 0.01
    found = calibrated(model, ["j.rotor"], np.array([2e-5 * ratio**2]), scene).rotor["j"]
    assert found.ratio == pytest.approx(ratio, rel=1e-15)
    assert found.inertia == pytest.approx(2e-5, rel=1e-14)
