"""A scene that names what the robot does not have is refused, with the closest name that it has."""

from __future__ import annotations

import re

import pytest
from helpers.oracles import robot

from robodyn.dynamics.inverse import bias_forces, inverse_dynamics, mass_matrix
from robodyn.errors import SceneError
from robodyn.loads.torques import torques
from robodyn.scene.fit import check_scene
from robodyn.scene.parts import ExternalWrench, Friction, Immersed, Loop, Motor, Payload, Rotor, Spring
from robodyn.scene.scene import Scene
from robodyn.scene.uncertainty import Deviation, Uncertainty
from robodyn.trajectory.read import motion

PUMA = robot("puma560")
MISFITS = {
    "friction": (Scene(friction={"waste": Friction()}), "[friction]: the robot has no joint 'waste' that moves"),
    "rotor": (Scene(rotor={"waste": Rotor(1.0)}), "[rotor]: the robot has no joint 'waste' that moves"),
    "spring": (Scene(spring={"waste": Spring(1.0)}), "[spring]: the robot has no joint 'waste' that moves"),
    "payload": (Scene(payloads=(Payload("flang", 1.0),)), "[[payload]]: the robot has no link 'flang'"),
    "wrench": (Scene(wrenches=(ExternalWrench("flang"),)), "[[wrench]]: the robot has no link 'flang'"),
    "uncertain friction": (
        Scene(uncertainty=Uncertainty(joint={"waste": Deviation(0.1)})),
        "[uncertainty.joint]: the robot has no joint 'waste' that moves",
    ),
    "fluid": (Scene(immersed=(Immersed("flang"),)), "[[fluid.link]]: the robot has no link 'flang'"),
}


@pytest.mark.parametrize("where", MISFITS)
def test_unknown_names(where):
    scene, what = MISFITS[where]
    with pytest.raises(SceneError) as caught:
        check_scene(scene, PUMA, "my.toml")
    meant = "waist" if "waste" in what else "flange"
    assert str(caught.value) == f"my.toml: {what} (did you mean '{meant}'?)"


def test_names_far_from_any_list_what_there_is():
    with pytest.raises(SceneError, match=re.escape("joints: 'waist', 'shoulder', 'elbow'")):
        check_scene(Scene(friction={"qqq": Friction()}), PUMA)
    with pytest.raises(SceneError, match="links: 'base', 'trunk'"):
        check_scene(Scene(payloads=(Payload("qqq", 1.0),)), PUMA)


def test_a_moving_base_needs_a_model_that_has_one():
    with pytest.raises(SceneError, match="the base moves in the scene and is fixed in the model"):
        check_scene(Scene(moving_base=True), PUMA)
    check_scene(Scene(moving_base=True), robot("puma560", True))


def test_the_functions_of_dynamics_ask():
    scene = MISFITS["rotor"][0]
    still = motion(PUMA, [0.0, 1.0], [[0.0] * 6] * 2, [[0.0] * 6] * 2, [[0.0] * 6] * 2)
    for call in (
        lambda: torques(PUMA, still, scene),
        lambda: inverse_dynamics(PUMA, [0.1] * 6, 0, 0, scene=scene),
        lambda: bias_forces(PUMA, [0.1] * 6, 0, scene=scene),
        lambda: mass_matrix(PUMA, [0.1] * 6, scene=scene),
    ):
        with pytest.raises(SceneError, match="no joint 'waste'"):
            call()


LOOPS = {
    "no such link": (Loop("a", "flang"), "[[loop]] 'a': the robot has no link 'flang' (did you mean 'flange'?)"),
    "no such other link": (
        Loop("a", "flange", to="groud"),
        "[[loop]] 'a': the robot has no link 'groud' (did you mean 'ground'?)",
    ),
    "the base to the ground": (
        Loop("a", "base"),
        "[[loop]] 'a': no joint moves 'base' against 'ground' (a loop connects links that move against each other)",
    ),
}


@pytest.mark.parametrize("where", LOOPS)
def test_loops_that_do_not_fit_the_robot(where):
    loop, what = LOOPS[where]
    with pytest.raises(SceneError, match=f"^my.toml: {re.escape(what)}$"):
        check_scene(Scene(loops=(loop,)), robot("puma560"), "my.toml")


def test_motors_are_of_joints_of_their_own():
    with pytest.raises(SceneError, match=re.escape("[motor]: the robot has no joint 'waste' that moves")):
        check_scene(Scene(motor={"waste": Motor()}), robot("puma560"))
    gripper = robot("gripper")
    follower = next(body.joint for body in gripper.bodies if body.joint.mimics)
    what = f"[motor]: the joint '{follower.name}' mimics another (its torque is part of that of '{follower.mimics}'"
    with pytest.raises(SceneError, match=re.escape(what)):
        check_scene(Scene(motor={follower.name: Motor()}), gripper)
