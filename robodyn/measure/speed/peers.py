"""Other libraries beside robodyn in one run: torques of gravity, inertia and Coriolis forces.

The libraries are given links and joints alone, without shapes, friction, transmissions and mimicry: what mimics is a
joint of its own to them, is moved as it must, and its torque is reflected onto its master here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from robodyn.dynamics.plan import torque_runner
from robodyn.errors import InputError
from robodyn.measure.speed.libraries import LIBRARIES, Gravity, States, Task
from robodyn.measure.speed.result import PeerBench, PeersBench, Timing
from robodyn.measure.timing import largest_difference, taking_turns
from robodyn.programs.run.llvm.machine import compiler
from robodyn.programs.vectors import product
from robodyn.robot.model import Joint, Model
from robodyn.scene.parts import Friction, Rotor
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats

KEPT = {"link": {"inertial"}, "joint": {"origin", "parent", "child", "axis", "limit"}}
"""What other libraries are given of a description."""


def compared(
    model: Model, gravity: Gravity, sources: Mapping[str, Floats], samples: int, watch: Callable[[str], None]
) -> PeersBench:
    """Return what other libraries take for the same torques.

    Args:
        sources: q, qd and qdd (samples, n), columns being contiguous.
        watch: told which library is next.
    """
    tasks: list[Task] = []
    missing: list[PeerBench] = []
    for name in LIBRARIES:
        watch(name)
        try:
            tasks += library_tasks(name, model, gravity, sources)
        except Exception as error:  # whatever another library raises is its answer
            missing.append(PeerBench(name, problem=_problem(name, error)))
    runner = torque_runner(model, bare_scene(model, gravity))
    executor = "numpy" if compiler().problem else "compiled"
    tau = np.empty((samples, model.n), order="F")
    watch("libraries in turn")
    ours = partial(runner, sources, samples, tau, executor=executor, threads=1)
    mine, *others = taking_turns(dict(enumerate([ours, *(task.run for task in tasks)]))).values()
    S, _ = following(model)
    found = [_bench(task, time, product(task.torques(), S), tau) for task, time in zip(tasks, others, strict=True)]
    return PeersBench(runner.program.size, executor, mine.per(samples), (*found, *missing))


def _bench(task: Task, time: Timing, torques: Floats, expected: Floats) -> PeerBench:
    difference = largest_difference(torques, expected[: task.samples])
    if not np.isfinite(difference):
        return PeerBench(task.name, problem="does not take part: its torques are not finite")
    return PeerBench(task.name, task.samples, time.per(task.samples), difference)


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


def _problem(name: str, error: Exception) -> str:
    if isinstance(error, ImportError):
        return f"is not installed (pip install {LIBRARIES[name][0]})"
    text = " ".join(str(error).split()) or type(error).__name__
    return f"does not take part: {text if len(text) <= 160 else text[:160] + '...'}"
