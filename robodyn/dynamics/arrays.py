"""Samples as arrays: what callers give, as matrices of samples by columns."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from math import prod
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from robodyn.dynamics.effects.effect import ZeroColumns
from robodyn.errors import InputError
from robodyn.programs.run.runner import Runner
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats


def zero_columns(sources: Mapping[str, Floats]) -> ZeroColumns:
    """Return the (source, column) pairs that are zero in every sample."""
    out = []
    for source, rows in _rows(sources):
        for column, first in enumerate(rows[0].tolist() if len(rows) else ()):
            if first == 0.0 and not rows[:, column].any():
                out.append((source, column))
    return frozenset(out)


def zero_sources(sources: Mapping[str, Floats]) -> ZeroColumns:
    """Return the pairs of those sources that are zero altogether: of a robot at rest, or left to itself.

    There are few such patterns, so that calls with zeros in ever other columns share their programs.
    """
    zero = [(source, rows.shape[1]) for source, rows in _rows(sources) if len(rows) and not rows.any()]
    return frozenset((source, column) for source, count in zero for column in range(count))


def _rows(sources: Mapping[str, Floats]) -> Iterator[tuple[str, Floats]]:
    """Yield what may be zero of each source; one row where all are the same."""
    for source, values in sources.items():
        if source != "columns":
            yield source, values[:1] if values.strides[0] == 0 else values


def arrays_of(
    model: Model,
    given: Mapping[str, ArrayLike],
    scene: Scene = DEFAULT,
    columns: Mapping[str, ArrayLike] = MappingProxyType({}),
    dtype: DTypeLike = np.float64,
) -> tuple[dict[str, Floats], tuple[int, ...]]:
    """Return the arrays as (samples, columns) matrices, and the shape of the samples.

    Args:
        given: q, and what else there is by coordinate.
    """
    if np.dtype(dtype).type not in (np.float64, np.float32):
        raise InputError(f"dtype {np.dtype(dtype).name} is not offered", remedy="float64 or float32")
    names = {name: model.coordinates if name == "q" else model.rates for name in given}
    arrays = {name: _trailing(np.asarray(x, dtype), name, names[name]) for name, x in given.items()}
    missing = [name for name in scene.columns if name not in columns]
    if missing:
        raise InputError(f"the scene needs columns {', '.join(missing)}", remedy="pass them as columns={name: values}")
    extra = [np.asarray(columns[name], dtype) for name in scene.columns]
    shape = _common_shape(arrays, extra)
    sources = {name: _matrix(array, shape) for name, array in arrays.items()}
    for joint in model.independent:
        if joint.kind == "floating" and _has_zero(sources["q"][:, joint.coordinate + 3 : joint.coordinate + 7]):
            raise InputError(f"the quaternion of {joint.name} is zero", remedy="no turn is qx qy qz qw = 0 0 0 1")
    sources["columns"] = (
        _matrix(np.stack([np.broadcast_to(x, shape) for x in extra], -1), shape) if extra else np.empty((0, 0))
    )
    return sources, shape


def target(out: Floats | None, shape: tuple[int, ...], dtype: DTypeLike) -> Floats:
    """Return the array to write to, which is `out` if given.

    Raises:
        InputError: it does not fit.
    """
    if out is None:
        return np.empty(shape, dtype, order="F" if len(shape) == 2 else "C")
    if out.shape != shape or out.dtype != dtype or not out.flags.writeable:
        found = f"shape {out.shape}, type {out.dtype}" + ("" if out.flags.writeable else ", read-only")
        raise InputError(f"out has {found}, not {shape} and {np.dtype(dtype).name}")
    return out


def fill(
    out: Floats, runner: Runner, sources: Mapping[str, Floats], executor: str = "auto", threads: int | None = None
) -> None:
    """Runs over all samples and writes to `out`, whose dtype is that of the arithmetic."""
    samples = prod(out.shape[:-1])
    flat = out.reshape(samples, out.shape[-1])
    runner(sources, samples, flat, executor=executor, threads=threads, dtype=out.dtype)
    if not np.shares_memory(flat, out):
        out[...] = flat.reshape(out.shape)


def tensors(
    runner: Runner,
    sources: Mapping[str, Floats],
    shape: tuple[int, ...],
    each: tuple[int, ...],
    out: Floats | None = None,
    executor: str = "auto",
    threads: int | None = None,
    dtype: DTypeLike = np.float64,
) -> Floats:
    """Return a program's outputs as one tensor of a shape `each` per sample: (*shape, *each), which is `out` if given.

    Where it is not, each entry has its samples beside each other.
    """
    if out is None:
        inner = tuple(range(len(each)))
        out = np.moveaxis(np.empty((*each, *shape), dtype), inner, tuple(k - len(each) for k in inner))
    out = target(out, (*shape, *each), dtype)
    flat = out.reshape(*shape, prod(each))
    fill(flat, runner, sources, executor, threads)
    if not np.shares_memory(flat, out):
        out[...] = flat.reshape(out.shape)
    return out


def _common_shape(given: Mapping[str, Floats], extra: Iterable[Floats]) -> tuple[int, ...]:
    """Return the shape of the samples."""
    shapes = {*(array.shape[:-1] for array in given.values()), *(array.shape for array in extra)}
    try:
        return shapes.pop() if len(shapes) == 1 else np.broadcast_shapes(*shapes)
    except ValueError:
        found = ", ".join(f"{name} {array.shape}" for name, array in given.items())
        raise InputError(f"the shapes do not go together: {found}") from None


def _has_zero(quaternions: Floats) -> bool:
    """Return whether all four numbers of some row are zero."""
    zero = quaternions[:, 3] == 0.0
    return bool(zero.any()) and not quaternions[zero].any(axis=1).all()


def _trailing(values: Floats, name: str, names: tuple[str, ...]) -> Floats:
    if values.ndim == 0:
        values = np.broadcast_to(values, (len(names),))
    if values.shape[-1] != len(names):
        what = f"{name} has {values.shape[-1]} columns, the robot has {len(names)}"
        raise InputError(what, remedy=f"in this order: {', '.join(names)}")
    return values


def _matrix(array: Floats, shape: tuple[int, ...]) -> Floats:
    columns = array.shape[-1]
    whole = array if array.shape[:-1] == shape else np.broadcast_to(array, (*shape, columns))
    return whole if len(shape) == 1 else whole.reshape(prod(shape), columns)
