"""Moments of volume and of surface of a block of triangles.

A tetrahedron from the point of reference to a triangle a, b, c has six times the volume D = a . ((b - a) x (c - a)).
Over it, and over the triangle, a quadratic is the mean of its values at the middles of the three edges, times a
constant (Hammer, Marlowe, Stroud 1956). With the edge sums u = a + b, b + c, c + a:

    6 V = sum D,    24 first = sum D (a + b + c),    120 S = sum D u u^T,

and for the surface, with twice the area of a triangle |(b - a) x (c - a)| for D, 2 A, 6 first and 24 S.

Operations on rows that follow each other are the fast ones. Each triangle is added to the one half a block further on,
and the sums of NumPy's pairwise summation over these pairs are the results: the same to the bit on every processor and
in `compiled_kernel`, as dot products by BLAS would not be. Those are left to what is a bound (dots
of more than 10 000 numbers are not made, because OpenBLAS would start threads for them) and to integers.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from robodyn.programs.vectors import Array
from robodyn.solids.mesh.triangles import ROWS, Step, workspace

if TYPE_CHECKING:
    from robodyn.programs.program import Program
    from robodyn.programs.run.compiled_blocks import CompiledBlocks


PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
"""The entries of a symmetric matrix in the order of its sums."""
SUMS = 11
"""Sums that are the same to the bit everywhere, of `volume_kernel`."""


class Kernel(NamedTuple):
    """Steps to be taken for every block, and the arrays that then have its sums and twice the area of each triangle."""

    steps: list[Step]
    result: Array
    sizes: Array


def volume_kernel(space: Array) -> Kernel:
    """6 V, 24 first (3), 120 S (6: xx, yy, zz, xy, yz, xz), twice the area, and about the sums of the squares of the
    coordinates of b - a (3) and c - a (3), for bounds.

    Args:
        space: (4, 3, n) of `block_space`, with corners from the point of reference; they are lost.
    """
    X, result, n = space[:3], np.empty(17, space.dtype), space.shape[-1]
    early, normal, weight = (workspace(rows, n, space.dtype) for rows in (18, 3, 1))
    sums = workspace(SUMS, n // 2, space.dtype)
    edges, terms = early[:6], early[6:9]
    steps: list[Step] = [
        *cross_steps(X, early[:12], normal),
        (np.matmul, (edges[:, None, :], edges[..., None], result[SUMS:, None, None])),
        (np.multiply, (normal, X[0], terms)),
        *_row_sum(terms, weight[0]),
        *_lengths(normal),
        _halves(normal[0], sums[10]),
        *_moments(space, weight, early, sums),
        total(sums, result[:SUMS]),
    ]
    return Kernel(steps, result, normal[0])


def surface_kernel(space: Array) -> Kernel:
    """2 A, 6 first (3), 24 S (6), for the same space."""
    result, n = np.empty(10, space.dtype), space.shape[-1]
    early, normal, weight = (workspace(rows, n, space.dtype) for rows in (18, 3, 1))
    sums = workspace(10, n // 2, space.dtype)
    steps: list[Step] = [
        *cross_steps(space[:3], early[:12], normal),
        *_lengths(normal),
        (np.copyto, (weight[0], normal[0])),
        *_moments(space, weight, early, sums),
        total(sums, result),
    ]
    return Kernel(steps, result, normal[0])


def total(sums: Array, result: Array) -> Step:
    """Return the step that adds up each row."""
    return np.add.reduce, (sums, 1, None, result)


def symmetric(entries: Array) -> Array:
    """(3, 3) from the entries xx, xy, xz, yy, yz, zz."""
    matrix = np.empty((3, 3), entries.dtype)
    for (i, j), entry in zip(PAIRS, entries, strict=True):
        matrix[i, j] = matrix[j, i] = entry
    return matrix


def cross_steps(X: Array, space: Array, normal: Array) -> list[Step]:
    """(b - a) x (c - a), and its products in the last six of twelve rows of space."""
    edges, (plus, minus) = space.reshape(2, 2, 3, -1)
    (ex, ey, ez), (fx, fy, fz) = edges
    return [
        (np.subtract, (X[1], X[0], edges[0])),
        (np.subtract, (X[2], X[0], edges[1])),
        (np.multiply, (ey, fz, plus[0])),
        (np.multiply, (ez, fx, plus[1])),
        (np.multiply, (ex, fy, plus[2])),
        (np.multiply, (ez, fy, minus[0])),
        (np.multiply, (ex, fz, minus[1])),
        (np.multiply, (ey, fx, minus[2])),
        (np.subtract, (plus, minus, normal)),
    ]


def _row_sum(rows: Array, out: Array) -> list[Step]:
    return [(np.add, (rows[0], rows[1], out)), (np.add, (out, rows[2], out))]


def _lengths(normal: Array) -> list[Step]:
    """The length of each vector in its first component; the vectors are lost."""
    first = normal[0]
    return [(np.multiply, (normal, normal, normal)), *_row_sum(normal, first), (np.sqrt, (first, first))]


def _halves(rows: Array, out: Array) -> Step:
    """Add each triangle to the one half a block further on."""
    half = rows.shape[-1] // 2
    return np.add, (rows[..., :half], rows[..., half:], out)


def _moments(space: Array, weight: Array, early: Array, sums: Array) -> list[Step]:
    """Weight, weight (a + b + c) and weight u u^T for a row of weights, in the first ten rows of sums."""
    (a, b, c, third), edges = space, space[1:]
    weighted, terms = early.reshape(2, 3, 3, -1)
    whole = terms[0]
    steps: list[Step] = [
        _halves(weight[0], sums[0]),
        (np.add, (a, b, third)),
        (np.add, (third, c, whole)),
        (np.multiply, (whole, weight, whole)),
        _halves(whole, sums[1:4]),
        (np.add, (b, c, b)),
        (np.add, (c, a, c)),
        (np.multiply, (edges, weight, weighted)),
    ]
    first = 4
    for apart in range(3):  # the entries i, i + apart, for which PAIRS is in this order
        some = terms[:, : 3 - apart]
        steps += [
            (np.multiply, (weighted[:, : 3 - apart], edges[:, apart:], some)),
            *_row_sum(some, some[0]),
            _halves(some[0], sums[first : first + 3 - apart]),
        ]
        first += 3 - apart
    return steps


LEAST = 200_000
"""Triangles of the smallest mesh for which machine code is looked up."""
BY_NUMPY = 20e-9
"""Seconds that `volume_kernel` takes for a triangle, on a typical machine."""
TOGETHER = 2
"""Triangles of a sample, whose sums are added in registers; a single one writes more, and four were no quicker."""
_SOURCE = "corners"
_WIDTHS = {_SOURCE: 9 * TOGETHER}
_ALL_SUMS = 17


def kernel_for(count: int) -> Callable[[Array], Kernel]:
    """Return what is quickest for a mesh of so many triangles: `volume_kernel`, or the same in machine code.

    Machine code needs the compiler and is made, or loaded, once: the more such meshes this process has had, the sooner
    it is worth it. Moments of the two are the same to the bit.
    """
    if count < LEAST:
        return volume_kernel
    _seen.triangles += count
    if _worth_its_start(_seen.triangles):
        from robodyn.programs.run.llvm.machine import compiler_problem

        if not compiler_problem():
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
    out, result = workspace(_ALL_SUMS + TOGETHER, samples), np.empty(_ALL_SUMS)
    sums, sizes = out[:_ALL_SUMS], out[_ALL_SUMS:].reshape(-1)
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
