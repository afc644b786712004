"""Inverse dynamics, mass matrix and bias for arrays of samples: the Python interface to the recursion."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from robodyn.dynamics.arrays import arrays_of, results, zero_sources
from robodyn.dynamics.effects import payload
from robodyn.dynamics.effects.effect import ZeroColumns
from robodyn.dynamics.effects.rotor_inertia import reflected
from robodyn.dynamics.plan import Plan, applied, plan
from robodyn.dynamics.recursions.newton_euler import mass_matrix as mass_matrix_of
from robodyn.programs.program import Program, trace
from robodyn.programs.run.runner import Runner
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats


def inverse_dynamics(
    model: Model,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    *,
    scene: Scene = DEFAULT,
    columns: Mapping[str, ArrayLike] | None = None,
    out: Floats | None = None,
    executor: str = "auto",
    threads: int | None = None,
    dtype: DTypeLike = np.float64,
) -> Floats:
    """tau = M(q) qdd + c(q, qd) + g(q) + friction + armature qdd + springs - J^T w.

    The recursive Newton-Euler algorithm (RNEA), traced once per model and scene, and once more without
    speeds or accelerations, then run over all samples.

    Args:
        model: of `robodyn.load`.
        q: (..., nq) rad or m; a floating base comes first, as x y z qx qy qz qw.
        qd, qdd: (..., n) per s and per s^2; of a floating base wx wy wz (body axes) and vx vy vz (ground's axes).
            Broadcast against q; `0` is a robot at rest.
        scene: gravity, friction and so on; by default gravity (0, 0, -9.81) and the friction of the description.
        columns: (...) values of the columns that the scene's wrenches name.
        out: (..., n) of `dtype`, written to and returned if given.
        executor: "numpy" starts at once; "compiled" turns the recursion into machine code, tens of times faster per
            sample, and needs llvmlite; "auto" weighs the work. Their results differ by rounding.
        threads: of the compiled executor; None is all cores. Results do not depend on it.
        dtype: float64 or float32, of arrays and arithmetic.

    Returns:
        (..., n) N m or N, in the order of `model.rates`. The columns of a matrix are contiguous, which is fastest.

    Raises:
        InputError: a shape, or a joint or link that the scene names, does not fit the model; no such executor.

    Accuracy: 1e-14 of the largest torque for chains of up to 100 bodies. The executors agree within 4 ulp of it for
    real robots on a fixed base, 8 on a free one. Bit-identical wherever a fixed base stands and with every effect whose
    coefficient is zero. In float32, 1e-6 of the largest torque.
    """
    sources, shape = arrays_of(model, {"q": q, "qd": qd, "qdd": qdd}, scene, columns or {}, dtype)
    runner = torque_runner(model, scene, zero_sources(sources))
    return results(runner, sources, shape, (model.n,), out, executor, threads, dtype)


def bias_forces(
    model: Model,
    q: ArrayLike,
    qd: ArrayLike,
    *,
    scene: Scene = DEFAULT,
    columns: Mapping[str, ArrayLike] | None = None,
    executor: str = "auto",
    threads: int | None = None,
) -> Floats:
    """b(q, qd) = c(q, qd) + g(q) + friction + springs - J^T w: the torque of a motion without acceleration.

    Args, returns and accuracy: as for `inverse_dynamics` with qdd = 0.
    """
    return inverse_dynamics(model, q, qd, 0.0, scene=scene, columns=columns, executor=executor, threads=threads)


def mass_matrix(
    model: Model, q: ArrayLike, *, scene: Scene = DEFAULT, executor: str = "auto", threads: int | None = None
) -> Floats:
    """M(q), with payloads and rotor inertias of the scene.

    Args:
        q: (..., nq) rad or m.
        executor, threads: as for `inverse_dynamics`.

    Returns:
        (..., n, n) kg m^2, kg m or kg; exactly symmetric.

    Raises:
        InputError: a shape that does not fit the model.

    Accuracy: 1e-14 of the largest entry.
    """
    refuse_others(model, scene)
    sources, shape = arrays_of(model, {"q": q})
    return results(mass_runner(model, scene), sources, shape, (model.n, model.n), None, executor, threads)


@lru_cache(maxsize=16)
def torque_runner(model: Model, scene: Scene, zero_columns: ZeroColumns = frozenset()) -> Runner:
    """Return tau of their plan, ready to run."""
    a_plan = plan(model, scene, zero_columns)
    return runner_of(a_plan.torques(), a_plan)


@lru_cache(maxsize=16)
def mass_runner(model: Model, scene: Scene) -> Runner:
    """Return the entries of M(q) row by row, ready to run."""
    a_plan = plan(model, scene)
    armature = reflected(model, scene)

    def outputs(tape: Any) -> Any:
        sample = a_plan.sample(tape)
        inertias = applied([payload.EFFECT], sample, scene).inertias
        return mass_matrix_of(model, sample.q, inertias, armature).ravel()

    return runner_of(trace(outputs), a_plan)


def runner_of(program: Program, a_plan: Plan, more: Mapping[str, int] = MappingProxyType({})) -> Runner:
    """Return a program of this plan, ready to run; `more` are widths of sources that are its own."""
    model = a_plan.model
    widths = {"q": model.nq, "qd": model.n, "qdd": model.n, "tau": model.n, "columns": len(a_plan.scene.columns)}
    return Runner(program, {**widths, **more})
