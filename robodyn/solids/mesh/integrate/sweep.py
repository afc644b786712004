"""One pass over the triangles of a mesh: sums, box and boundary; and the integrals over a surface."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import fsum

import numpy as np
from numpy.typing import DTypeLike

from robodyn.errors import MeshError
from robodyn.programs.vectors import Array
from robodyn.solids.inertia.exact import exact
from robodyn.solids.mesh.blocks import block_space, fill, reference_in
from robodyn.solids.mesh.closed.fingerprint import EdgeSums, Fingerprint
from robodyn.solids.mesh.integrate.kernel import Kernel, surface_kernel, symmetric
from robodyn.solids.mesh.triangles import Triangles
from robodyn.support.floats import LARGEST, Floats

_SAFE = 2.0**-170, 2.0**180
"""Sizes of boxes whose fifth powers, and those of the triangles in them, stay clear of the ends of a float's range."""


@dataclass(frozen=True, eq=False)
class Sweep:
    """What one pass found.

    Attributes:
        sums: (blocks, k) the sums of each block, in the floats of the pass.
        reference: (3,) the point about which they are.
        lows, highs: (blocks, 3) corners of the box of each block.
        least: twice the area of the smallest triangle.
        edges: fingerprint of the boundary, where it was asked for.
    """

    sums: Array
    reference: Floats
    lows: Floats
    highs: Floats
    least: float
    edges: Fingerprint | None = None

    @property
    def lo(self) -> Floats:
        """(3,) the least coordinates."""
        lo: Floats = self.lows.min(axis=0)
        return lo

    @property
    def hi(self) -> Floats:
        """(3,) the largest coordinates."""
        hi: Floats = self.highs.max(axis=0)
        return hi

    @property
    def reach(self) -> Floats:
        """(3,) how far the box reaches from the reference."""
        return self._reach(self.lo, self.hi)

    def _reach(self, lo: Floats, hi: Floats) -> Floats:
        with np.errstate(over="ignore"):
            return np.maximum(hi - self.reference, self.reference - lo)

    def perm(self, squares: Array) -> float:
        """At least the sum over the triangles of a . |(b - a) x (c - a)| with all its products taken as positive.

        In each block by its reach and Schwarz's inequality, sum |x y|^2 <= sum x^2 sum y^2.

        Args:
            squares: (blocks, 6) sums of the squares of the coordinates of b - a and c - a.
        """
        e, f = np.sqrt(squares.astype(np.float64)).reshape(-1, 2, 3).swapaxes(0, 1)
        products = [e[:, i - 2] * f[:, i - 1] + e[:, i - 1] * f[:, i - 2] for i in range(3)]
        return float((self._reach(self.lows, self.highs) * np.stack(products, axis=1)).sum())

    @property
    def safe(self) -> bool:
        """Whether nothing can have come near the ends of the range of a float."""
        reach = self.reach
        return bool((reach < _SAFE[1]).all() and (reach[reach > 0] > _SAFE[0]).all())

    def totals(self, columns: slice = slice(None)) -> Array:
        """(k,) these sums over all blocks, as fractions.

        Accuracy: of float64, the correctly rounded sum; of wider floats, the exact one.
        """
        if self.sums.dtype == np.float64:
            return exact([fsum(column) for column in self.sums[:, columns].T.tolist()])
        total: Array = exact(self.sums[:, columns]).sum(axis=0)
        return total

    def check_size(self, triangles: Triangles) -> None:
        """Raise if products of the moments, which symmetry and tessellation are judged by, would leave floats."""
        with np.errstate(over="ignore"):
            size = np.array((1.0, triangles.scale))
            far = np.maximum(np.abs(self.lo), np.abs(self.hi)).max() * size
            width = (self.hi - self.lo).max() * size
        if not far.max() <= LARGEST:
            raise self.beyond(triangles, "large")
        if 0 < width.min() < 1 / LARGEST:
            raise self.beyond(triangles, "small")

    def beyond(self, triangles: Triangles, how: str) -> MeshError:
        """Return the error of a mesh that is too large or too small for floats."""
        with np.errstate(over="ignore"):
            width = (self.hi - self.lo).max()
        return MeshError(
            f"is too {how}, {width:.3g} wide: its moments are beyond the range of a float",
            remedy=f"scale it to a size between {1 / LARGEST:g} and {LARGEST:g}",
            file=triangles.name,
        )


def swept(
    triangles: Triangles,
    kernel: Callable[[Array], Kernel],
    *,
    dtype: DTypeLike = np.float64,
    reference: Floats | None = None,
    edges: bool = False,
) -> Sweep:
    """Pass over the triangles once.

    Args:
        kernel: `volume_kernel` or `surface_kernel`.
        dtype: of the arithmetic.
        reference: (3,) by default a point in the middle of the first block.
        edges: take the fingerprint of the boundary, too; the arithmetic is in float64 then.

    Raises:
        MeshError: there are no triangles.
    """
    space = block_space(triangles, dtype)
    ready, boundary = kernel(space), EdgeSums(space) if edges else None
    sums, lows, highs, least = [], [], [], [np.inf]
    left = triangles.count
    with np.errstate(all="ignore"):
        for X in fill(space, triangles, checked=False):
            if boundary is not None:
                boundary.add()
            if reference is None:
                reference = reference_in(X)
            lows.append(np.minimum.reduce(X, 2))
            highs.append(np.maximum.reduce(X, 2))
            np.subtract(X, reference[:, None], X)
            for function, arguments in ready.steps:
                function(*arguments)
            sums.append(ready.result.copy())
            least.append(np.minimum.reduce(ready.sizes[:left]))
            left -= len(ready.sizes)
    if reference is None:
        raise MeshError("has no triangles", remedy="give a mesh with at least one", file=triangles.name)
    ends = np.min(lows, axis=1).astype(np.float64), np.max(highs, axis=1).astype(np.float64)
    if not np.isfinite(ends).all():
        for _ in triangles.blocks():  # which names the first corner that is not finite
            pass
    found = None if boundary is None else boundary.total()
    return Sweep(np.array(sums), reference, *ends, float(min(least)), found)


@dataclass(frozen=True, eq=False)
class SurfaceIntegrals:
    """Integrals over a surface, in units of the file. They do not depend on the winding.

    Attributes:
        area: A, of 1.
        first: (3,) of x - reference.
        S: (3, 3) of (x - reference)(x - reference)^T.
        reference: (3,) a point inside the box.
    """

    area: float
    first: Floats
    S: Floats
    reference: Floats


def surface(triangles: Triangles) -> SurfaceIntegrals:
    """Return A = integral of 1, first = integral of x - r and S = integral of (x - r)(x - r)^T over the surface.

    Sums over triangles about a reference r inside the box; see `robodyn.solids.mesh.integrate.kernel`.

    Raises:
        MeshError: there are no triangles, or moments are beyond the range of a float.

    Accuracy: S within 1e-15 of its largest entry wherever the origin is, if no triangle is longer than ten times its
        height; the error grows with that ratio.
    """
    sweep = swept(triangles, surface_kernel)
    if not sweep.safe:
        raise sweep.beyond(triangles, "large" if sweep.reach.max() > 1 else "small")
    sums = sweep.totals().astype(np.float64)
    return SurfaceIntegrals(float(sums[0] / 2), sums[1:4] / 6, symmetric(sums[4:10] / 24), sweep.reference)
