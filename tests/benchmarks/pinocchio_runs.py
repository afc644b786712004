"""Robots of benchmarks, random samples for them, and Pinocchio beside robodyn: gravity, inertia, Coriolis forces.

Pinocchio is given links and joints alone, without shapes, friction, transmissions and mimicry: what mimics is a joint
of its own there, is moved as it must, and its torque is reflected onto its leader here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path

import numpy as np
from helpers.example_robots import path_of
from helpers.oracles import ROBOTS as FOLDER

import robodyn
from robodyn.robot.kinematics import unit_rows
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import DEFAULT, Friction, Rotor, Scene
from robodyn.support.floats import Floats

OURS = {"Two links": "two_link_planar", "SCARA": "scara"}
"""Robots of robots/; the others are of example-robot-data."""
ROBOTS = OURS | {
    "UR5": "ur5_robot",
    "Kinova": "kinova",
    "xArm7": "xarm7",
    "Panda": "panda",
    "Solo12": "solo12",
    "ANYmal": "anymal",
    "Allegro hand": "allegro_right_hand",
    "Baxter": "baxter",
    "ANYmal with arm": "anymal-kinova",
    "iCub": "icub",
    "TALOS": "talos_full_v2",
    "Romeo": "romeo",
    "Centauro": "centauro",
    "G1 with hands": "g1_29dof_with_hand_rev_1_0",
    "Tiago": "tiago",
}
KEPT = {"link": {"inertial"}, "joint": {"origin", "parent", "child", "axis", "limit"}}
"""What Pinocchio is given of a description."""


@cache
def described(name: str) -> tuple[Model, Scene]:
    path: Path = FOLDER / f"{OURS[name]}.urdf" if name in OURS else path_of(ROBOTS.get(name, name))
    model = robodyn.load(path)
    return model, bare_scene(model)


def joints(name: str) -> str:
    """Degrees of freedom here and, where they differ, in Pinocchio."""
    moving, n = following(described(name)[0])[0].shape
    return str(n) if moving == n else f"{n} ({moving})"


def random_sources(model: Model, scene: Scene, samples: int) -> dict[str, Floats]:
    """Arrays for the programs of this robot, with columns contiguous: q up to 2, rates and further columns up to 3.

    All numbers are those of single precision, so that every executor works on the same; quaternions are of unit length
    within that.
    """
    columns = {"q": model.nq, "qd": model.n, "qdd": model.n, "columns": len(scene.columns)}
    rng = np.random.default_rng(0)
    sources = {
        name: rng.uniform(-3.0, 3.0, (count, samples)).astype(np.float32).astype(np.float64).T
        for name, count in columns.items()
    }
    sources["q"] *= 2.0 / 3.0
    unit_rows(model, sources["q"])
    sources["q"] = np.asfortranarray(sources["q"].astype(np.float32), np.float64)
    return sources


def in_parallel(model: Model, name: str, state: Sequence[Floats]) -> tuple[Callable[[], object], Callable[[], Floats]]:
    """Pinocchio's `rneaInParallel` or `abaInParallel` with one thread, a state being a column as it wants them.

    Returns:
        What computes q, qd and qdd (or torques) anew, and what returns (N, n) its last results in the order of ours.
    """
    import pinocchio as pin

    q, qd, last = state
    other = pin.buildModelFromXML(bare_description(model))
    S, offset = following(model)
    places = [other.joints[other.getJointId(joint.name)] for joint in _moving(model)]
    rows = [joint.idx_v for joint in places]
    Q = np.asfortranarray(np.tile(pin.neutral(other)[:, None], len(q)))
    V, A, out = (np.zeros((other.nv, len(q)), order="F") for _ in range(3))
    for joint, angle in zip(places, (q @ S.T + offset).T, strict=True):
        Q[joint.idx_q : joint.idx_q + joint.nq] = angle if joint.nq == 1 else (np.cos(angle), np.sin(angle))
    forwards = name.startswith("aba")
    V[rows], A[rows] = (qd @ S.T).T, (last @ np.linalg.pinv(S) if forwards else last @ S.T).T
    run = partial(getattr(pin, name), 1, pin.ModelPool(other, 1), Q, V, A, out)
    back = np.linalg.pinv(S).T if forwards else S
    return run, lambda: out[rows].T @ back


def following(model: Model) -> tuple[Floats, Floats]:
    """S (joints, n) and offsets: every joint moves as S q + offset, and torques at the joints make S^T times them."""
    moving = _moving(model)
    S = np.zeros((len(moving), model.n))
    S[range(len(moving)), [joint.rate for joint in moving]] = [joint.multiplier for joint in moving]
    return S, np.array([joint.offset for joint in moving])


def bare_scene(model: Model) -> Scene:
    """Gravity alone: friction and rotors that the description declares are off."""
    names = [joint.name for joint in _moving(model) if joint.kind != "floating"]
    return Scene(DEFAULT.gravity, dict.fromkeys(names, Friction()), dict.fromkeys(names, Rotor(0.0)))


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


def nanoseconds(seconds: float) -> str:
    value = 1e9 * seconds
    return f"{value:.0f} ns" if value >= 100 else f"{value:.1f} ns"
