"""Samples as arrays: what callers give, as matrices of samples by columns."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from math import prod
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from robodyn.dynamics.effects.effect import ZeroColumns
from robodyn.errors import InputError
from robodyn.programs.run.runner import Runner
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats

DOUBLE = np.dtype(np.float64)
_NO_COLUMNS = np.empty((0, 0))
_OTHERS = {"c": "complex ones", "U": "text", "S": "text", "O": "other objects", "M": "dates", "m": "times"}
"""What arrays hold that are none of real numbers, by the kind of their dtype."""


def zero_columns(sources: Mapping[str, Floats]) -> ZeroColumns:
    """The (source, column) pairs that are zero in every sample."""
    out = []
    for source, values in sources.items():
        rows = _different(values)
        for column, first in enumerate(rows[0].tolist() if len(rows) and source != "columns" else ()):
            if first == 0.0 and not rows[:, column].any():
                out.append((source, column))
    return frozenset(out)


def zero_sources(sources: Mapping[str, Floats]) -> ZeroColumns:
    """Return the pairs of those sources that are zero altogether: of a robot at rest, or left to itself. There are few
    such patterns, so that calls with zeros in ever other columns share their programs."""
    zero = [source for source, rows in sources.items() if rows.size and rows.item(0) == 0.0 and source != "columns"]
    return _whole(tuple((s, sources[s].shape[1]) for s in zero if not np.count_nonzero(_different(sources[s]))))


@lru_cache
def _whole(sources: tuple[tuple[str, int], ...]) -> ZeroColumns:
    """All columns of sources with so many: the same object, for its hash is looked up at every call."""
    return frozenset((source, column) for source, count in sources for column in range(count))


def _different(rows: Floats) -> Floats:
    """Return the rows, but one where all are the same."""
    return rows[:1] if rows.strides[0] == 0 else rows


def arrays_of(
    model: Model,
    given: Mapping[str, ArrayLike],
    scene: Scene = DEFAULT,
    columns: Mapping[str, ArrayLike] = MappingProxyType({}),
    dtype: DTypeLike = np.float64,
) -> tuple[dict[str, Floats], tuple[int, ...]]:
    """Return arrays by coordinate as (samples, columns) matrices, and the shape of the samples."""
    refuse_others(model, scene)
    kind: np.dtype[Any] = DOUBLE
    if dtype is not np.float64:
        try:
            kind = np.dtype(dtype)
        except TypeError:
            raise InputError(f"dtype {dtype!r} is not offered", remedy="float64 or float32") from None
        if kind.type not in (np.float64, np.float32):
            raise InputError(f"dtype {kind.name} is not offered", remedy="float64 or float32")
    arrays = {}
    for name, values in given.items():
        array, names = numbers(name, values, kind), model.coordinates if name == "q" else model.rates
        arrays[name] = array if array.ndim else array.repeat(len(names))
        if arrays[name].shape[-1] != len(names):
            what = f"{name} has {array.shape[-1]} columns, the robot has {len(names)}"
            raise InputError(what, remedy=f"in this order: {', '.join(names)}")
    needed = scene.columns if scene.wrenches else ()
    if needed and not isinstance(columns, Mapping):
        raise InputError("columns is no mapping", remedy="pass columns={name: values}")
    if missing := [name for name in needed if name not in columns]:
        raise InputError(f"the scene needs columns {', '.join(missing)}", remedy="pass them as columns={name: values}")
    extra = {name: numbers(name, columns[name], kind) for name in needed}
    shapes = [array.shape[:-1] for array in arrays.values()]
    shapes += [array.shape for array in extra.values()] if extra else []
    shape = shapes[0] if shapes.count(shapes[0]) == len(shapes) else _common_shape(shapes, {**arrays, **extra})
    if shape:
        sources = {name: _matrix(array, shape) for name, array in arrays.items()}
    else:
        sources = {name: array[None] for name, array in arrays.items()}
    for name, first in model.quaternions:
        h = sources["q"][:, first : first + 4]
        still = h[:, 3] == 0.0
        if still.any() and not h[still].any(axis=1).all():
            raise InputError(f"the quaternion of {name} is zero", remedy="no turn is qx qy qz qw = 0 0 0 1")
    stacked = [np.broadcast_to(array, shape) for array in extra.values()]
    sources["columns"] = _matrix(np.stack(stacked, -1), shape) if stacked else _NO_COLUMNS
    return sources, shape


def numbers(name: str, values: ArrayLike, dtype: np.dtype[Any]) -> Floats:
    """An array of this dtype; InputError where these are no real numbers."""
    if type(values) is np.ndarray and values.dtype == dtype:
        return values
    try:
        array = np.asarray(values)
    except (TypeError, ValueError):
        raise InputError(f"{name} is no array of numbers: its rows have different lengths") from None
    if array.dtype.kind not in "fiub":
        found = "None" if values is None else _OTHERS.get(array.dtype.kind, str(array.dtype))
        raise InputError(f"{name} is no array of numbers: it holds {found}")
    return array.astype(dtype, copy=False)


def results(
    runner: Runner,
    sources: Mapping[str, Floats],
    shape: tuple[int, ...],
    outputs: tuple[int, ...],
    out: Floats | None = None,
    executor: str = "auto",
    threads: int | None = None,
    dtype: DTypeLike = np.float64,
) -> Floats:
    """Return what a program computes of all samples, (*shape, *outputs), written to `out` if given."""
    samples, whole = prod(shape), (*shape, *outputs)
    if out is None:
        values: Floats = runner.run(sources, samples, executor=executor, threads=threads, dtype=dtype).values
        return values.reshape(whole)
    check_out(out, whole, dtype)
    flat = out.reshape(samples, prod(outputs))
    runner.run(sources, samples, flat, executor=executor, threads=threads, dtype=dtype)
    if not np.may_share_memory(flat, out):  # a copy is apart from it
        out[...] = flat.reshape(whole)
    return out


def check_out(out: object, shape: tuple[int, ...], dtype: DTypeLike) -> None:
    """Raise InputError unless `out` is an array of this shape and dtype that can be written to."""
    if not isinstance(out, np.ndarray):
        raise InputError(f"out is no array but of type {type(out).__name__}")
    if out.shape != shape or out.dtype != dtype or not out.flags.writeable:
        found = f"shape {out.shape}, type {out.dtype}" + ("" if out.flags.writeable else ", read-only")
        raise InputError(f"out has {found}, not {shape} and {np.dtype(dtype).name}")


def _common_shape(shapes: list[tuple[int, ...]], given: Mapping[str, Floats]) -> tuple[int, ...]:
    try:
        return np.broadcast_shapes(*shapes)
    except ValueError:
        found = ", ".join(f"{name} {array.shape}" for name, array in given.items())
        raise InputError(f"the shapes do not go together: {found}") from None


def _matrix(array: Floats, shape: tuple[int, ...]) -> Floats:
    if array.shape[:-1] != shape:
        array = np.broadcast_to(array, (*shape, array.shape[-1]))
    return array if len(shape) == 1 else array.reshape(prod(shape), array.shape[-1])
