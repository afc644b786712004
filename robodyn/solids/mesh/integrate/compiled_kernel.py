"""`volume_kernel` as machine code, which takes a third of the time, for meshes that are worth its start."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from robodyn.programs.vectors import Array
from robodyn.solids.mesh.blocks import ROWS, Step, workspace
from robodyn.solids.mesh.integrate.kernel import PAIRS, Kernel, total, volume_kernel

if TYPE_CHECKING:
    from robodyn.programs.program import Program
    from robodyn.programs.run.compiled_blocks import CompiledBlocks

LEAST = 200_000
"""Triangles of the smallest mesh for which machine code is looked up."""
BY_NUMPY = 20e-9
"""Seconds that `volume_kernel` takes for a triangle, on a typical machine."""
TOGETHER = 2
"""Triangles of a sample, whose sums are added in registers; a single one writes more, and four were no quicker."""
_SOURCE = "corners"
_WIDTHS = {_SOURCE: 9 * TOGETHER}
_SUMS = 17


def kernel_for(count: int) -> Callable[[Array], Kernel]:
    """Return what is quickest for a mesh of so many triangles: `volume_kernel`, or the same in machine code.

    Machine code needs the compiler and is made, or loaded, once: the more such meshes this process has had, the sooner
    it is worth it. Moments of the two are the same to the bit.
    """
    if count < LEAST:
        return volume_kernel
    _seen.triangles += count
    if _worth_its_start(_seen.triangles):
        from robodyn.programs.run.llvm.machine import compiler

        if not compiler().problem:
            with suppress(OSError, RuntimeError):
                return partial(compiled_kernel, _machine_code())
    return volume_kernel


@dataclass
class _Seen:
    """Triangles of large meshes that this process has had."""

    triangles: int = 0


_seen = _Seen()


def compiled_kernel(code: CompiledBlocks, space: Array) -> Kernel:
    """Return the sums of `volume_kernel`, of float64; the corners stay.

    Args:
        code: of `triangle_program`.
        space: (4, 3, n) of `block_space`, with corners from the point of reference.

    Accuracy: to the bit as `volume_kernel`, but for the squares of edges: no product is rounded together with a sum.
    """
    samples = space.shape[-1] // TOGETHER
    corners = space[:3].reshape(9 * TOGETHER, samples).T
    out, result = workspace(_SUMS + TOGETHER, samples), np.empty(_SUMS)
    sums, sizes = out[:_SUMS], out[_SUMS:].reshape(-1)
    run = code.bound({_SOURCE: corners}, samples, out.T)
    steps: list[Step] = [(run, ()), total(sums, result)]
    return Kernel(steps, result, sizes)


def triangle_program() -> Program:
    """Return the sums of `volume_kernel` over TOGETHER triangles, and twice the area of each.

    The coordinate i of corner c of triangle k is in column (3 c + i) TOGETHER + k.
    """
    from robodyn.programs.program import trace

    def outputs(tape: Any) -> list[Any]:
        each = []
        for k in range(TOGETHER):
            corners = [[tape.input(_SOURCE, (3 * c + i) * TOGETHER + k) for i in range(3)] for c in range(3)]
            each.append(_terms(*corners))
        sums = [one + other for one, other in zip(*each, strict=True)]
        return [*sums, *(terms[10] for terms in each)]

    return trace(outputs)


def _terms(a: list[Any], b: list[Any], c: list[Any]) -> list[Any]:
    """Return what one triangle adds to each sum."""
    e, f = _minus(b, a), _minus(c, a)
    normal = [e[i - 2] * f[i - 1] - e[i - 1] * f[i - 2] for i in range(3)]
    D = _dot(a, normal)
    u, v, w = _plus(a, b), _plus(b, c), _plus(c, a)
    first = [D * x for x in _plus(u, c)]
    weighted = [[D * x for x in edge] for edge in (v, w, u)]
    second = [_dot([x[i] for x in weighted], [x[j] for x in (v, w, u)]) for i, j in PAIRS]
    return [D, *first, *second, _dot(normal, normal).sqrt(), *(x * x for x in (*e, *f))]


def _plus(a: list[Any], b: list[Any]) -> list[Any]:
    return [x + y for x, y in zip(a, b, strict=True)]


def _minus(a: list[Any], b: list[Any]) -> list[Any]:
    return [x - y for x, y in zip(a, b, strict=True)]


def _dot(a: list[Any], b: list[Any]) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _worth_its_start(count: int) -> bool:
    from robodyn.programs.run.choice import Work, times

    if _machine_code.cache_info().currsize:
        return True
    blocks = -(-count // ROWS)
    return times(Work(_program().size, count // TOGETHER, blocks, blocks))[1] < count * BY_NUMPY


@cache
def _program() -> Program:
    return triangle_program()


@cache
def _machine_code() -> CompiledBlocks:
    from robodyn.programs.run.compiled_blocks import CompiledBlocks

    return CompiledBlocks(_program(), _WIDTHS, fused=False)
