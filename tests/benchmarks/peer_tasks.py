"""Other libraries beside robodyn in one run: torques of gravity, inertia and Coriolis forces.

The libraries are given links and joints alone, without shapes, friction, transmissions and mimicry: what mimics is a
joint of its own to them, is moved as it must, and its torque is reflected onto its leader here.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from benchmarks.libraries import LIBRARIES, Gravity, States, Task

from robodyn.errors import InputError
from robodyn.programs.vectors import product
from robodyn.robot.model import Joint, Model
from robodyn.scene.parts import Friction, Rotor
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats

KEPT = {"link": {"inertial"}, "joint": {"origin", "parent", "child", "axis", "limit"}}
"""What other libraries are given of a description."""


def library_tasks(name: str, model: Model, gravity: Gravity, sources: Mapping[str, Floats]) -> list[Task]:
    """Return the torques of these samples by a library of LIBRARIES, computed once.

    Raises:
        Exception: the library is not installed or refuses the robot, or a joint floats.
    """
    if any(joint.kind == "floating" for joint in _moving(model)):
        raise InputError("a joint floats, whose rates each library defines in its own way")
    S, offset = following(model)
    names = tuple(joint.name for joint in _moving(model))
    moving = product(sources["q"], S.T) + offset, product(sources["qd"], S.T), product(sources["qdd"], S.T)
    states = States(model.bodies[0].name, names, *moving)
    tasks = list(LIBRARIES[name][1](bare_description(model), gravity, states))
    for task in tasks:
        task.run()
    return tasks


def following(model: Model) -> tuple[Floats, Floats]:
    """S (joints, n) and offsets: every joint moves as S q + offset, and torques at the joints make S^T times them."""
    joints = _moving(model)
    S = np.zeros((len(joints), model.n))
    S[range(len(joints)), [joint.rate for joint in joints]] = [joint.multiplier for joint in joints]
    return S, np.array([joint.offset for joint in joints])


def bare_scene(model: Model, gravity: Gravity = DEFAULT.gravity) -> Scene:
    """Gravity alone: friction and rotors that the description declares are off."""
    names = [joint.name for joint in _moving(model) if joint.kind != "floating"]
    return Scene(gravity, dict.fromkeys(names, Friction()), dict.fromkeys(names, Rotor(0.0)))


def bare_description(model: Model) -> str:
    """Return the links of a robot's description with their inertias, and its joints, and nothing else."""
    from xml.etree import ElementTree

    assert model.description is not None, "it is not a model of bodies alone"
    root = ElementTree.fromstring(model.description.data)
    for part in list(root):
        if part.tag not in KEPT:
            root.remove(part)
        for detail in list(part):
            if detail.tag not in KEPT.get(part.tag, ()):
                part.remove(detail)
    return ElementTree.tostring(root, encoding="unicode")


def _moving(model: Model) -> list[Joint]:
    return [body.joint for body in model.bodies if body.joint.kind != "fixed"]
