"""Inverse dynamics, mass matrix and bias for arrays of samples: the Python interface to the recursion."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from math import prod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from robodyn.dynamics.system_matrices import mass_matrix as mass_matrix_of
from robodyn.effects import payload
from robodyn.effects.effect import Still
from robodyn.effects.rotor_inertia import armatures
from robodyn.errors import InputError
from robodyn.execute.runner import Runner
from robodyn.model import Model
from robodyn.plan import Plan, applied, plan
from robodyn.scene import DEFAULT, Scene
from robodyn.trace.program import Program, trace

Floats = NDArray[np.float64]


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

    The recursion of `robodyn.dynamics.newton_euler`, traced once per model, scene and pattern of zero columns, then
    run over all samples.

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
    if np.dtype(dtype).type not in (np.float64, np.float32):
        raise InputError(f"dtype {np.dtype(dtype).name} is not offered", remedy="float64 or float32")
    sources, shape = _sources(model, q, qd, qdd, scene, columns or {}, dtype)
    samples = prod(shape)
    runner = torque_runner(plan(model, scene, still(sources)))
    if out is None:
        out = np.empty((*shape, model.n), dtype, order="F" if len(shape) == 1 else "C")
    if out.shape != (*shape, model.n) or out.dtype != dtype or not out.flags.writeable:
        found = f"shape {out.shape}, type {out.dtype}" + ("" if out.flags.writeable else ", read-only")
        raise InputError(f"out has {found}, not {(*shape, model.n)} and {np.dtype(dtype).name}")
    flat = out.reshape(samples, model.n)
    runner(sources, samples, flat, executor=executor, threads=threads, dtype=dtype)
    if not np.may_share_memory(flat, out):
        out[...] = flat.reshape(out.shape)
    return out


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
    sources, shape = _sources(model, q, 0.0, 0.0, DEFAULT, {})
    samples, n = prod(shape), model.n
    entries = mass_runner(model, scene)(sources, samples, executor=executor, threads=threads)
    return entries.reshape(*shape, n, n)


@lru_cache(maxsize=16)
def torque_runner(a_plan: Plan) -> Runner:
    """The plan's tau, ready to run."""
    return runner_of(a_plan.torques(), a_plan)


@lru_cache(maxsize=16)
def mass_runner(model: Model, scene: Scene) -> Runner:
    """The entries of M(q) row by row, ready to run."""
    a_plan = plan(model, scene)
    armature = [0.0] * model.n
    for _, joint, inertia in armatures(model, scene):
        armature[joint.rate] += joint.multiplier**2 * inertia

    def outputs(tape: Any) -> Any:
        sample = a_plan.sample(tape)
        inertias = applied([payload.EFFECT], sample, scene).inertias
        return mass_matrix_of(model, sample.q, inertias, armature).ravel()

    return runner_of(trace(outputs), a_plan)


def runner_of(program: Program, a_plan: Plan) -> Runner:
    """A program of this plan, ready to run."""
    model = a_plan.model
    widths = {"q": model.nq, "qd": model.n, "qdd": model.n, "columns": len(a_plan.scene.columns)}
    return Runner(program, widths)


def still(sources: Mapping[str, Floats]) -> Still:
    """The (source, column) pairs that are zero in every sample."""
    out = []
    for source in ("q", "qd", "qdd"):
        values = sources[source]
        rows = values[:1] if values.strides[0] == 0 else values
        for column, first in enumerate(rows[0].tolist() if len(rows) else ()):
            if first == 0.0 and not rows[:, column].any():
                out.append((source, column))
    return frozenset(out)


def _sources(
    model: Model,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    scene: Scene,
    columns: Mapping[str, ArrayLike],
    dtype: DTypeLike = np.float64,
) -> tuple[dict[str, Floats], tuple[int, ...]]:
    """The arrays as (samples, columns) matrices, and the shape of the samples."""
    given = {
        "q": _trailing(np.asarray(q, dtype), "q", model.nq, model.coordinates),
        "qd": _trailing(np.asarray(qd, dtype), "qd", model.n, model.rates),
        "qdd": _trailing(np.asarray(qdd, dtype), "qdd", model.n, model.rates),
    }
    missing = [name for name in scene.columns if name not in columns]
    if missing:
        raise InputError(f"the scene needs columns {', '.join(missing)}", remedy="pass them as columns={name: values}")
    extra = [np.asarray(columns[name], dtype) for name in scene.columns]
    shape = _common_shape(given, extra)
    sources = {name: _matrix(array, shape) for name, array in given.items()}
    for joint in model.independent:
        if joint.kind == "floating" and _has_zero(sources["q"][:, joint.coordinate + 3 : joint.coordinate + 7]):
            raise InputError(f"the quaternion of {joint.name} is zero", remedy="no turn is qx qy qz qw = 0 0 0 1")
    sources["columns"] = (
        _matrix(np.stack([np.broadcast_to(x, shape) for x in extra], -1), shape) if extra else np.empty((0, 0))
    )
    return sources, shape


def _common_shape(given: Mapping[str, Floats], extra: Iterable[Floats]) -> tuple[int, ...]:
    """The shape of the samples."""
    shapes = {*(array.shape[:-1] for array in given.values()), *(array.shape for array in extra)}
    try:
        return shapes.pop() if len(shapes) == 1 else np.broadcast_shapes(*shapes)
    except ValueError:
        found = ", ".join(f"{name} {array.shape}" for name, array in given.items())
        raise InputError(f"the shapes do not go together: {found}") from None


def _has_zero(quaternions: Floats) -> bool:
    """Whether all four numbers of some row are zero."""
    zero = quaternions[:, 3] == 0.0
    return bool(zero.any()) and not quaternions[zero].any(axis=1).all()


def _trailing(values: Floats, name: str, count: int, names: tuple[str, ...]) -> Floats:
    if values.ndim == 0:
        values = np.broadcast_to(values, (count,))
    if values.shape[-1] != count:
        raise InputError(
            f"{name} has {values.shape[-1]} columns, the robot has {count}", remedy=f"in this order: {', '.join(names)}"
        )
    return values


def _matrix(array: Floats, shape: tuple[int, ...]) -> Floats:
    columns = array.shape[-1]
    whole = array if array.shape[:-1] == shape else np.broadcast_to(array, (*shape, columns))
    return whole if len(shape) == 1 else whole.reshape(prod(shape), columns)
