"""[motor] of a scene: data sheets as they are written, each wrong value in one line."""

from __future__ import annotations

import re

import numpy as np
import pytest
from helpers.oracles import robot

from robodyn.errors import SceneError
from robodyn.scene.fit import check_scene
from robodyn.scene.parts import Motor, Rotor
from robodyn.scene.read import parse_scene
from robodyn.scene.scene import Scene

RPM = np.pi / 30


def motor(text):
    return parse_scene(f"[motor]\nj = {{ {text} }}".encode())


def test_every_key():
    scene = motor(
        'gear = -50, efficiency = 0.8, inertia = 2e-4, speed_unit = "rpm", continuous = [[0, 0.5], [3000, 0.4]], '
        "peak = 1.5, max_speed = 5000, gear_average = 40, gear_peak = 60"
    )
    curve = ((0.0, 0.5), (3000 * RPM, 0.4))
    assert scene.motor == {"j": Motor(0.8, curve, 1.5, 5000 * RPM, 40.0, 60.0)}
    assert scene.rotor == {"j": Rotor(2e-4, -50.0)}


def test_what_is_left_out():
    scene = motor("")
    assert (scene.motor, scene.rotor) == ({"j": Motor()}, {})
    assert motor("gear = 3").rotor == {"j": Rotor(None, 3.0)}
    assert motor("peak = [[300, 2]]").motor["j"].peak == ((300.0, 2.0),)


def test_a_rotor_may_stand_in_its_own_table():
    scene = parse_scene(b"[rotor]\nj = { inertia = 1, gear = 2 }\n[motor]\nj = { peak = 3 }")
    assert (scene.motor, scene.rotor) == ({"j": Motor(peak=3.0)}, {"j": Rotor(1.0, 2.0)})


def test_a_gear_alone_leaves_the_inertia_of_the_description():
    from dataclasses import replace

    from robodyn.dynamics.effects.motors import rotor_of

    joint = replace(robot("puma560").independent[0], rotor_inertia=5e-4, reduction=30.0)
    assert rotor_of(joint, motor("gear = 3")) == (5e-4, 30.0)
    named = replace(joint, name="j")
    assert rotor_of(named, motor("gear = 3")) == (5e-4, 3.0)
    assert rotor_of(named, motor("inertia = 1e-3")) == (1e-3, 30.0)


WRONG = {
    "efficiency = 85": '"efficiency" is 85 (a share above 0 and up to 1: 85 % is 0.85)',
    "efficiency = 0": '"efficiency" is 0 (a share above 0 and up to 1: such as 0.85)',
    "gear = 0": '"gear" is 0 (turns of the motor per turn of the joint)',
    "inertia = -1": '"inertia" is -1 (it is positive or zero)',
    "peak = 0": '"peak" is 0 (it is positive; leave it out if it is not known)',
    "max_speed = -1": '"max_speed" is -1 (it is positive',
    "peak = [1, 2]": '"peak" is [1, 2], neither a torque nor a curve (points are [speed, torque]',
    "peak = []": '"peak" is [], neither a torque nor a curve',
    "peak = [[0, 1], [0, 2]]": 'the speeds of "peak" do not increase from 0 on: 0, 0',
    "peak = [[1.5, 0], [1.2, 300]]": 'the speeds of "peak" do not increase from 0 on: 1.5, 1.2 (points are [speed',
    "peak = [[0, -1], [9, 2]]": 'the torques of "peak" are not positive: -1, 2',
    "peak = [[0, nan]]": '"peak" is nan, not a finite number',
    "continuous = [[0, 1], [9, 2]], peak = [[0, 3], [9, 1]]": '"continuous" allows 2 at 9 rad/s and "peak" 1 (are they',
    'speed_unit = "rpms"': '"speed_unit" is "rpms" (one of: rad/s, rpm)',
    "spead = 1": 'unknown key "spead" (valid keys: ',
}


@pytest.mark.parametrize("text", WRONG)
def test_wrong_values(text):
    with pytest.raises(SceneError, match=re.escape(f"<scene>: [motor] j: {WRONG[text]}")):
        motor(text)


@pytest.mark.parametrize("key", ["gear = 3", "inertia = 3"])
def test_what_is_said_twice(key):
    name = key.split()[0]
    with pytest.raises(SceneError, match=rf'"{name}" and \[rotor\] j say the same \(leave \[rotor\] out\)'):
        parse_scene(f"[rotor]\nj = {{ inertia = 1 }}\n[motor]\nj = {{ {key} }}".encode())


def test_motors_are_of_joints_of_their_own():
    with pytest.raises(SceneError, match=re.escape("[motor]: the robot has no joint 'waste' that moves")):
        check_scene(Scene(motor={"waste": Motor()}), robot("puma560"))
    gripper = robot("gripper")
    follower = next(body.joint for body in gripper.bodies if body.joint.mimics)
    what = f"[motor]: the joint '{follower.name}' mimics another (its torque is part of that of '{follower.mimics}'"
    with pytest.raises(SceneError, match=re.escape(what)):
        check_scene(Scene(motor={follower.name: Motor()}), gripper)
