"""`torques --accuracy`: the arithmetic for an accuracy, by the first samples of the motion."""

from __future__ import annotations

from robodyn.cli.files import STANDARD_INPUT
from robodyn.cli.reading_options import reading
from robodyn.errors import InputError
from robodyn.measure.accuracy.torques_within import Arithmetic, arithmetic_within
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.trajectory.robot_motion import read_motion


def arithmetic_for(target: float, trajectory: str, model: Model, scene: Scene) -> Arithmetic:
    """By the first block of the trajectory, which is read once more for the torques.

    Raises:
        InputError: the trajectory is standard input or has no samples, or the accuracy is beyond doubles.
    """
    if trajectory == STANDARD_INPUT:
        raise InputError("--accuracy reads the trajectory twice", remedy="name a file", file="<stdin>")
    with read_motion(trajectory, model, scene, **reading()) as reader:
        for block in reader.blocks():
            if len(block):
                return arithmetic_within(model, block, scene, target)
    raise InputError("the trajectory has no samples", file=trajectory)
