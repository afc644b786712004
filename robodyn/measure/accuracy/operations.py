"""Floating-point operations, counted as they are done."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from robodyn.programs.vectors import Array
from robodyn.solids.mesh.kernel import volume_kernel
from robodyn.solids.mesh.triangles import CHUNK, Step, workspace

_RECENTRING = 9
"""Subtractions that take the three corners of a triangle to the point of reference."""


def counted(act: Callable[[Array], object], numbers: Array) -> int:
    """Element operations of NumPy's functions that an act does on an array and on what comes of it.

    A matrix product counts its multiplications and additions; sorting, indexing and running sums count nothing.
    """
    total = 0

    class Counted(np.ndarray):  # type: ignore[type-arg,unused-ignore]
        __array_priority__ = 1.0

        def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
            nonlocal total
            plain = [_plain(value) for value in inputs]
            if "out" in options:
                options["out"] = tuple(_plain(value) for value in options["out"])
            result = getattr(ufunc, method)(*plain, **options)
            if ufunc is np.matmul:
                total += 2 * np.size(result) * plain[0].shape[-1]
            else:
                total += max(np.size(value) for value in (*plain, *_several(result)))
            several = _several(result)
            wrapped = tuple(each.view(Counted) if isinstance(each, np.ndarray) else each for each in several)
            return wrapped if isinstance(result, tuple) else wrapped[0]

    act(numbers.view(Counted))
    return total


def integral_operations(triangles: int) -> int:
    """Of the exact integral over so many triangles, in floats of any width."""
    kernel = volume_kernel(workspace(12, CHUNK).reshape(4, 3, CHUNK))
    return triangles * (_RECENTRING + round(_of_steps(kernel.steps) / CHUNK))


def _of_steps(steps: Iterable[Step]) -> int:
    """Element operations of steps that write to workspaces."""
    total = 0
    for function, arguments in steps:
        if function is np.matmul:
            total += 2 * arguments[0].size
        elif function == np.add.reduce:
            total += arguments[0].size
        elif function is not np.copyto:
            total += arguments[-1].size
    return total


def _plain(value: Any) -> Any:
    return np.asarray(value) if isinstance(value, np.ndarray) else value


def _several(result: Any) -> tuple[Any, ...]:
    return result if isinstance(result, tuple) else (result,)
