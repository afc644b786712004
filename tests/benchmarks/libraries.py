"""Inverse dynamics of a fixed base by other libraries: Pinocchio, MuJoCo and Drake, imported when they are called."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from robodyn.errors import InputError
from robodyn.support.floats import Floats
from robodyn.support.libraries import library_messages

Gravity = tuple[float, float, float]

FEW = 1000
"""Samples for what goes one by one through a loop in Python."""


class States(NamedTuple):
    """Samples (N, joints) of every joint that moves, by its name, whether it mimics another or not, on a fixed link."""

    base: str
    names: tuple[str, ...]
    q: Floats
    qd: Floats
    qdd: Floats

    def first(self, count: int) -> States:
        return States(self.base, self.names, self.q[:count], self.qd[:count], self.qdd[:count])


class Task(NamedTuple):
    """Torques of the first `samples` states.

    Attributes:
        run: computes them anew.
        torques: (samples, joints) of the last run, in the order of the states' names.
    """

    name: str
    samples: int
    run: Callable[[], object]
    torques: Callable[[], Floats]


def pinocchio(urdf: str, gravity: Gravity, states: States) -> Iterator[Task]:
    """`rneaInParallel` with one thread, a state being a column as it wants them; then `rnea` in a loop."""
    pin: Any = import_module("pinocchio")
    model = pin.buildModelFromXML(urdf)
    model.gravity.linear = np.array(gravity)
    joints = [model.joints[model.getJointId(_known(name, model.existJointName))] for name in states.names]
    samples = len(states.q)
    Q = np.asfortranarray(np.tile(pin.neutral(model)[:, None], samples))
    V, A, out = (np.zeros((model.nv, samples), order="F") for _ in range(3))
    for joint, q in zip(joints, states.q.T, strict=True):
        Q[joint.idx_q : joint.idx_q + joint.nq] = q if joint.nq == 1 else (np.cos(q), np.sin(q))
    places = [joint.idx_v for joint in joints]
    V[places], A[places] = states.qd.T, states.qdd.T
    name = f"Pinocchio {pin.__version__}"
    if hasattr(pin, "rneaInParallel"):
        pool = pin.ModelPool(model, 1)
        run = partial(pin.rneaInParallel, 1, pool, Q, V, A, out)
        yield Task(f"{name}, rneaInParallel", samples, run, lambda: out[places].T)
    data = model.createData()
    few = min(samples, FEW)
    found = np.empty((few, model.nv))

    def loop() -> None:
        for k in range(few):
            found[k] = pin.rnea(model, data, Q[:, k], V[:, k], A[:, k])

    yield Task(f"{name}, rnea in a loop", few, loop, lambda: found[:, places])


def mujoco(urdf: str, gravity: Gravity, states: States) -> Iterator[Task]:
    """`mj_inverse` in a loop, without constraints."""
    mj: Any = import_module("mujoco")
    model = mj.MjSpec.from_string(urdf).compile()
    model.opt.gravity = gravity
    model.opt.disableflags |= mj.mjtDisableBit.mjDSBL_CONSTRAINT
    data = mj.MjData(model)
    joints = [model.joint(name) for name in states.names]
    places, rates = [int(joint.qposadr[0]) for joint in joints], [int(joint.dofadr[0]) for joint in joints]
    few = states.first(FEW)
    Q, V, A = np.tile(data.qpos, (len(few.q), 1)), *np.zeros((2, len(few.q), model.nv))
    Q[:, places], V[:, rates], A[:, rates] = few.q, few.qd, few.qdd
    found = np.empty_like(V)

    def loop() -> None:
        for k in range(len(Q)):
            data.qpos, data.qvel, data.qacc = Q[k], V[k], A[k]
            mj.mj_inverse(model, data)
            found[k] = data.qfrc_inverse

    yield Task(f"MuJoCo {mj.__version__}, mj_inverse in a loop", len(Q), loop, lambda: found[:, rates])


def drake(urdf: str, gravity: Gravity, states: States) -> Iterator[Task]:
    """`MultibodyPlant.CalcInverseDynamics` in a loop."""
    parsing: Any = import_module("pydrake.multibody.parsing")
    multibody: Any = import_module("pydrake.multibody.plant")
    tree: Any = import_module("pydrake.multibody.tree")
    plant = multibody.MultibodyPlant(0.0)
    with library_messages("drake"):
        (instance,) = parsing.Parser(plant).AddModelsFromString(urdf, "urdf")
    if plant.HasBodyNamed(states.base, instance):  # a link named world is the world
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(states.base, instance))
    plant.mutable_gravity_field().set_gravity_vector(gravity)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    places = [plant.GetJointByName(name).velocity_start() for name in states.names]
    few = states.first(FEW)
    Q, V, A, found = np.zeros((4, len(few.q), plant.num_velocities()))
    Q[:, places], V[:, places], A[:, places] = few.q, few.qd, few.qdd
    forces = tree.MultibodyForces(plant)

    def loop() -> None:
        for k in range(len(Q)):
            plant.SetPositions(context, Q[k])
            plant.SetVelocities(context, V[k])
            plant.CalcForceElementsContribution(context, forces)
            found[k] = plant.CalcInverseDynamics(context, A[k], forces)

    yield Task("Drake, CalcInverseDynamics in a loop", len(Q), loop, lambda: found[:, places])


def _known(name: str, known: Callable[[str], bool]) -> str:
    if not known(name):
        raise InputError(f"it does not know the joint {name}")
    return name


LIBRARIES: Mapping[str, tuple[str, Callable[[str, Gravity, States], Iterator[Task]]]] = {
    "Pinocchio": ("pin", pinocchio),
    "MuJoCo": ("mujoco", mujoco),
    "Drake": ("drake", drake),
}
"""For each the name of its package and what makes its tasks."""
