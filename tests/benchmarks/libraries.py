"""Libraries of rigid-body dynamics behind one interface, each in a process of its own, as `benchmarks.compare` asks.

`python -m benchmarks.libraries NAME` answers each line of JSON that it reads with one: it reads a robot and its states
and computes some of them, or it runs an algorithm again and again for a while and tells how long a state took.
"""

from __future__ import annotations

import importlib.metadata
import json
import os
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from time import process_time
from typing import Any, NamedTuple

import numpy as np
from benchmarks.limit import limit

import robodyn
from robodyn.dynamics.function import KINDS
from robodyn.dynamics.plan import plan
from robodyn.programs.program import Program
from robodyn.programs.run.compiled_blocks import lanes_of
from robodyn.scene.scene import DEFAULT
from robodyn.support.floats import Floats


class Algorithm(NamedTuple):
    """What it computes, the name of robodyn's function, its arguments of q, v, a and torques t, axes of its result."""

    meaning: str
    function: str
    sources: str
    axes: int


ALGORITHMS = {
    "RNEA": Algorithm("torques of a motion", "inverse_dynamics", "qva", 1),
    "CRBA": Algorithm("mass matrix", "mass_matrix", "q", 2),
    "ABA": Algorithm("accelerations that torques make", "forward_dynamics", "qvt", 1),
    "dRNEA": Algorithm("derivatives of torques by q and qd", "inverse_dynamics_derivatives", "qva", 2),
    "dABA": Algorithm("derivatives of accelerations by q and qd", "forward_dynamics_derivatives", "qvt", 2),
}
CHECKED = {"RNEA": 24, "CRBA": 24, "ABA": 24, "dRNEA": 4, "dABA": 4}
"""States whose results are compared with those in 50 digits, which take long: the first."""
CALLS, BLOCK = 50, 1000
"""States that are computed one a call, and in a block."""
OURS, NUMBERS = 100_000, 500_000
"""States of a block of robodyn, and numbers among its results at most, which stay in the caches."""
TURN = 0.02
"""Seconds of a turn at least."""
CONSTANT = Path(__file__).parents[2] / "robots" / "pendulum.urdf"
"""A robot whose mass matrix is a number."""


class Robot(NamedTuple):
    """A description of links and joints alone, the root of its links, names of joints, states (samples, joints)."""

    file: str
    root: str
    names: list[str]
    states: dict[str, Floats]


class Library:
    """What a library does for one state and for a block of them, by algorithm, with joints in its own order."""

    package = ""

    def __init__(self, robot: Robot, order: Sequence[int], block: int = BLOCK) -> None:
        """`order`: where the library has each joint."""
        own = np.argsort(order)
        self.n, self.order = len(own), np.array(order)
        self.given = {name: np.ascontiguousarray(values[:block, own]) for name, values in robot.states.items()}
        self.calls: dict[str, dict[str, Callable[..., Any]]] = {"one": {}}
        self.block: dict[str, Callable[[], Any]] = {}
        self.samples = dict.fromkeys(ALGORITHMS, block)
        self.empty: Callable[[], object] = lambda: None
        self.told: dict[str, dict[str, float]] = {}

    def states(self, algorithm: str) -> list[tuple[Floats, ...]]:
        return list(zip(*(self.given[name][:CALLS] for name in ALGORITHMS[algorithm].sources), strict=True))

    def read(self, algorithm: str, found: Any) -> Floats:
        """Return a result, or those of a block, with joints in the order of robodyn."""
        values = np.array(found, dtype=float)
        for axis in range(-ALGORITHMS[algorithm].axes, 0):
            values = values.take(self.order, axis)
        return values


class Robodyn(Library):
    """`robodyn.function` for one state, and the functions of arrays for one and for many, compiled, on one thread."""

    package = "robodyn"

    def __init__(self, robot: Robot) -> None:
        super().__init__(robot, range(len(robot.names)), OURS)
        model, n = robodyn.load(robot.file), self.n
        for name, algorithm in ALGORITHMS.items():
            shape = (3, n, n) if name.startswith("d") else (n,) * algorithm.axes
            samples = self.samples[name] = min(len(robot.states["q"]), NUMBERS // int(np.prod(shape)))
            arrays = [np.asfortranarray(self.given[source][:samples]) for source in algorithm.sources]
            function = partial(getattr(robodyn, algorithm.function), model, executor="compiled", threads=1)
            written = {} if name == "CRBA" else {"out": np.moveaxis(np.empty((*shape, samples)), -1, 0)}
            self.calls["one"][name] = robodyn.function(model, algorithm.function)
            if name == "RNEA":
                self.calls["arrays"] = {name: function}
            self.block[name] = partial(self._into, function, *arrays, **written)
            self.told[name] = told(KINDS[algorithm.function].program(plan(model, DEFAULT)))
        self.empty = partial(robodyn.function(robodyn.load(CONSTANT), "mass_matrix"), np.zeros(1))

    def _into(self, function: Callable[..., Any], *arrays: Floats, **written: Floats) -> Floats:
        found = function(*arrays, **written)
        return written.get("out", found)[: max(CHECKED.values())]

    def read(self, algorithm: str, found: Any) -> Floats:
        return np.array(found[..., :2, :, :] if algorithm.startswith("d") else found)


def told(program: Program) -> dict[str, float]:
    """Operations of a state, and the seconds that their arithmetic takes at least."""
    return {"operations": program.size, "limit": limit(program, lanes_of("double"))}


class Pinocchio(Library):
    """Functions of C++ for one state; for a block those that exist, with a pool of one thread."""

    package = "pin"

    def __init__(self, robot: Robot) -> None:
        import pinocchio as pin

        model = pin.buildModelFromUrdf(robot.file)
        joints, data = [model.joints[model.getJointId(name)] for name in robot.names], model.createData()
        super().__init__(robot, [joint.idx_v for joint in joints])
        q = np.tile(pin.neutral(model), (BLOCK, 1))
        for joint, angle in zip(joints, robot.states["q"][:BLOCK].T, strict=True):
            values = [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
            q[:, joint.idx_q : joint.idx_q + joint.nq] = np.transpose(values)
        self.given["q"] = q
        functions = pin.rnea, pin.crba, pin.aba, pin.computeRNEADerivatives, pin.computeABADerivatives
        self.calls["one"] = {
            name: partial(function, model, data) for name, function in zip(ALGORITHMS, functions, strict=True)
        }
        q, v, a, t = (np.asfortranarray(values.T) for values in self.given.values())
        for name, function, last in (("RNEA", pin.rneaInParallel, a), ("ABA", pin.abaInParallel, t)):
            self.block[name] = partial(self._into, function, pin.ModelPool(model, 1), q, v, last, np.empty_like(v))
        self.empty = partial(model.existJointName, "")

    def _into(self, function: Callable[..., Any], pool: Any, *arrays: Floats) -> Floats:
        function(1, pool, *arrays)
        return arrays[-1].T

    def read(self, algorithm: str, found: Any) -> Floats:
        if algorithm == "CRBA":  # the upper triangle is what is promised
            found = np.triu(found) + np.triu(found, 1).T
        return super().read(algorithm, found[:2] if algorithm.startswith("d") else found)


class MuJoCo(Library):
    """`mj_inverse`, `mj_forward` without constraints, composite bodies; derivatives by differences; a batch."""

    package = "mujoco"

    def __init__(self, robot: Robot) -> None:
        import mujoco

        model = mujoco.MjModel.from_xml_path(robot.file)
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        super().__init__(robot, [int(model.joint(name).dofadr[0]) for name in robot.names])
        data, M, by_q, by_v = mujoco.MjData(model), *np.empty((3, self.n, self.n))
        qpos, qvel, qacc, applied, inverse = data.qpos, data.qvel, data.qacc, data.qfrc_applied, data.qfrc_inverse

        def rnea(q: Floats, v: Floats, a: Floats) -> Floats:
            qpos[:], qvel[:], qacc[:] = q, v, a
            mujoco.mj_inverse(model, data)
            return inverse

        def crba(q: Floats) -> Floats:
            qpos[:] = q
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_crb(model, data)
            mujoco.mj_fullM(model, data, M)
            return M

        def aba(q: Floats, v: Floats, t: Floats) -> Floats:
            qpos[:], qvel[:], applied[:] = q, v, t
            mujoco.mj_forward(model, data)
            return qacc

        def derivatives(q: Floats, v: Floats, a: Floats) -> tuple[Floats, Floats]:
            qpos[:], qvel[:], qacc[:] = q, v, a
            mujoco.mjd_inverseFD(model, data, 1e-6, False, by_q, by_v, None, None, None, None, None)
            return by_q.T, by_v.T

        self.calls["one"] = {"RNEA": rnea, "CRBA": crba, "ABA": aba, "dRNEA": derivatives}
        self.empty = mujoco.mj_version
        try:
            from mujoco.batch import Batch
        except ImportError:
            return  # before 4.0
        batch = Batch(model, nsim=BLOCK, nthread=1)
        for field, name in (("qpos", "q"), ("qvel", "v"), ("qfrc_applied", "t")):
            batch.bind(field)[:] = self.given[name]
        self.block["ABA"] = partial(self._forward, batch, batch.bind("qacc"))

    def _forward(self, batch: Any, accelerations: Floats) -> Floats:
        batch.forward()
        return accelerations


class Drake(Library):
    """A MultibodyPlant in continuous time; derivatives by its automatic differentiation."""

    package = "drake"

    def __init__(self, robot: Robot) -> None:
        from pydrake.autodiffutils import AutoDiffXd, ExtractGradient, InitializeAutoDiff
        from pydrake.multibody.parsing import Parser
        from pydrake.multibody.plant import MultibodyPlant
        from pydrake.multibody.tree import MultibodyForces_

        plant = MultibodyPlant(0.0)
        Parser(plant).AddModels(robot.file)
        if robot.root != "world":
            plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(robot.root))
        plant.Finalize()
        super().__init__(robot, [plant.GetJointByName(name).velocity_start() for name in robot.names])

        def inverse(plant: Any, kind: type) -> Callable[..., Any]:
            context, forces = plant.CreateDefaultContext(), MultibodyForces_[kind](plant)

            def rnea(state: Floats, a: Floats) -> Any:
                plant.SetPositionsAndVelocities(context, state)
                plant.CalcForceElementsContribution(context, forces)
                return plant.CalcInverseDynamics(context, a, forces)

            return rnea

        def forward(plant: Any) -> Callable[..., Any]:
            context, applied = plant.CreateDefaultContext(), plant.get_applied_generalized_force_input_port()
            found = plant.get_generalized_acceleration_output_port()

            def aba(state: Floats, t: Floats) -> Any:
                plant.SetPositionsAndVelocities(context, state)
                applied.FixValue(context, t)
                return found.Eval(context)

            return aba

        context = plant.CreateDefaultContext()

        def crba(q: Floats) -> Any:
            plant.SetPositions(context, q)
            return plant.CalcMassMatrix(context)

        def plain(function: Callable[..., Any]) -> Callable[..., Any]:
            return lambda q, v, x: function(np.concatenate((q, v)), x)

        def gradient(function: Callable[..., Any]) -> Callable[..., Any]:
            def derivatives(q: Floats, v: Floats, x: Floats) -> Floats:
                found = ExtractGradient(function(InitializeAutoDiff(np.concatenate((q, v)))[:, 0], x))
                return found.reshape(self.n, 2, self.n).swapaxes(0, 1)

            return derivatives

        ad = plant.ToAutoDiffXd()
        self.calls["one"] = {
            "RNEA": plain(inverse(plant, float)),
            "CRBA": crba,
            "ABA": plain(forward(plant)),
            "dRNEA": gradient(inverse(ad, AutoDiffXd)),
            "dABA": gradient(forward(ad)),
        }
        self.empty = plant.num_positions


class IDynTree(Library):
    """KinDynComputations with a base at rest; its forward dynamics has a free base, and is left out."""

    package = "idyntree"

    def __init__(self, robot: Robot) -> None:
        from idyntree import swig

        loader, computations = swig.ModelLoader(), swig.KinDynComputations()
        if not loader.loadReducedModelFromFile(robot.file, robot.names):
            raise ValueError("it does not load the description")
        computations.loadRobotModel(loader.model())
        super().__init__(robot, range(len(robot.names)))
        n, model = self.n, computations.model()
        place, still, gravity = np.eye(4), np.zeros(6), np.array([0.0, 0.0, -9.81])
        wrenches, torques = swig.LinkWrenches(model), swig.FreeFloatingGeneralizedTorques(model)
        masses, rest = swig.MatrixDynSize(n + 6, n + 6), np.zeros(n)
        wrenches.zero()

        def rnea(q: Floats, v: Floats, a: Floats) -> Floats:
            computations.setRobotState(place, q, still, v, gravity)
            computations.inverseDynamics(still, a, wrenches, torques)
            return torques.jointTorques().toNumPy()

        def crba(q: Floats) -> Floats:
            computations.setRobotState(place, q, still, rest, gravity)
            computations.getFreeFloatingMassMatrix(masses)
            return masses.toNumPy()[6:, 6:]

        self.calls["one"] = {"RNEA": rnea, "CRBA": crba}
        self.empty = computations.getNrOfDegreesOfFreedom


class Frax(Library):
    """Dynamics in JAX, in doubles, compiled by XLA for one state and for a block; derivatives would take minutes."""

    package = "frax"

    def __init__(self, robot: Robot) -> None:
        import jax
        from frax.core.robot import Robot as Model

        model, gravity = Model(robot.file, joint_ordering=robot.names), np.array([0.0, 0.0, 9.81, 0.0, 0.0, 0.0])
        super().__init__(robot, range(len(robot.names)))
        functions = {
            "RNEA": lambda q, v, a: model.rnea(q, v, a, gravity, None),
            "CRBA": model.crba,
            "ABA": lambda q, v, t: model.forward_dynamics(q, v, t, None),
        }
        for name, function in functions.items():
            sources = (self.given[source] for source in ALGORITHMS[name].sources)
            self.calls["one"][name] = partial(self._done, jax, jax.jit(function))
            self.block[name] = partial(self._done, jax, jax.jit(jax.vmap(function)), *sources)
        self.empty = partial(self._done, jax, jax.jit(lambda q: q), self.given["q"][0])

    def _done(self, jax: Any, function: Callable[..., Any], *arrays: Floats) -> Any:
        return jax.block_until_ready(function(*arrays))


LIBRARIES: dict[str, type[Library]] = {
    "robodyn": Robodyn,
    "Pinocchio": Pinocchio,
    "MuJoCo": MuJoCo,
    "Drake": Drake,
    "iDynTree": IDynTree,
    "frax": Frax,
}
"""By name."""


class Server:
    """Answers questions to one library about one robot after the other."""

    def __init__(self, kind: type[Library]) -> None:
        self.kind = kind
        self.acts: dict[str, tuple[Callable[[], object], int]] = {}

    def robot(self, robot: str, states: str, results: str, algorithms: list[str]) -> dict[str, Any]:
        """Take a robot and its states, store results of the first states, and tell what there is to time."""
        with np.load(states) as arrays:
            given = Robot(**json.loads(robot), states=dict(arrays))
        library = self.kind(given)
        self.acts, found = {"empty": (partial(each, library.empty, [()] * CALLS), CALLS)}, {}
        for way, functions in library.calls.items():
            for name in filter(functions.__contains__, algorithms):
                rows, function = library.states(name), functions[name]
                found[f"{name} {way}"] = np.array([library.read(name, function(*row)) for row in rows[: CHECKED[name]]])
                self.acts[f"{name} {way}"] = partial(each, function, rows), len(rows)
        for name in filter(library.block.__contains__, algorithms):
            act = library.block[name]
            found[f"{name} block"] = library.read(name, act())[: CHECKED[name]]
            self.acts[f"{name} block"] = act, library.samples[name]
        np.savez(results, **found)
        told = {name: library.told.get(name, {}) for name in algorithms}
        samples = {name: count for name, (_, count) in self.acts.items()}
        return {"samples": samples, "told": told, "version": importlib.metadata.version(self.kind.package)}

    def turn(self, act: str) -> float:
        """Run one again and again for a while; seconds of the process per state."""
        run, samples = self.acts[act]
        begin, count, spent = process_time(), 0, 0.0
        while spent < TURN:
            run()
            count, spent = count + 1, process_time() - begin
        return spent / count / samples


def each(function: Callable[..., Any], states: list[tuple[Floats, ...]]) -> None:
    """Call a function with each state."""
    for state in states:
        function(*state)


def main() -> None:
    """Answer; what libraries print goes nowhere."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    server = Server(LIBRARIES[sys.argv[1]])
    for line in sys.stdin:
        asked = json.loads(line)
        try:
            answer = getattr(server, asked.pop("do"))(**asked)
        except ModuleNotFoundError as error:
            answer = {"problem": f"{error.name} is not installed"}
        except Exception as error:
            answer = {"problem": f"{type(error).__name__}: {error}".partition("\n")[0][:200]}
        print(json.dumps(answer), file=answers, flush=True)


if __name__ == "__main__":
    main()
