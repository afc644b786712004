"""Volume, first and second moments of what a surface encloses, to the digits that are asked for, with bounds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, floor, fsum, inf, log10
from sys import float_info
from typing import NamedTuple

import numpy as np
from numpy.typing import DTypeLike

from robodyn.errors import MeshError
from robodyn.programs.vectors import Array, Scalar
from robodyn.solids.inertia.laws import exact
from robodyn.solids.mesh.closed import EdgeSums, Fingerprint
from robodyn.solids.mesh.kernel import PAIRS, Kernel, surface_kernel, symmetric, volume_kernel
from robodyn.solids.mesh.triangles import Triangles, block_space, fill, reference_in
from robodyn.support.floats import LARGEST, Floats
from robodyn.support.linear import eigen

_MANTISSA = 53
_SAFE = 2.0**-170, 2.0**180
"""Sizes of boxes whose fifth powers, and those of the triangles in them, stay clear of the ends of a float's range."""
ROUNDING = float_info.epsilon / 2
"""Relative error of the float nearest to a number."""


class Moments(NamedTuple):
    """Integrals over a volume of 1, x - r and (x - r)(x - r)^T about a point of reference r, as fractions."""

    volume: Scalar
    first: Array
    second: Array


@dataclass(frozen=True, eq=False)
class VolumeIntegrals:
    """Integrals over a volume of 1, x - reference (3,) and (x - reference)(x - reference)^T (3, 3), in its units."""

    volume: float
    first: Floats
    S: Floats
    reference: Floats

    @property
    def moments(self) -> Moments:
        """Volume, first and S with all that is known of their digits."""
        return Moments(self.volume, self.first, self.S)


def exact_moments(triangles: Triangles, reference: Array) -> Moments:
    """Return the moments of the volume within triangles whose coordinates are taken as exact. The sums of
    `volume_kernel` in Python's integers, as the coordinates of a block are multiples of a power of two."""
    from fractions import Fraction

    volume, first, second = Fraction(0), [Fraction(0)] * 3, [Fraction(0)] * 6
    for block in triangles.blocks():
        numbers = np.concatenate([np.broadcast_to(reference, (1, 3, 3)), block.astype(np.float64)])
        mantissas, exponents = np.frexp(numbers)
        lowest = int(exponents[mantissas != 0].min(initial=0))
        shifts = np.where(mantissas == 0, 0, exponents - lowest).astype(object)
        whole = np.ldexp(mantissas, _MANTISSA).astype(np.int64).astype(object) << shifts
        unit = Fraction(2) ** (lowest - _MANTISSA)
        a, b, c = (whole[1:] - whole[0]).transpose(1, 2, 0)
        e, f = b - a, c - a
        D = sum(a[i] * (e[i - 2] * f[i - 1] - e[i - 1] * f[i - 2]) for i in range(3))
        u, v, w = a + b, b + c, c + a
        volume += D.sum() * unit**3
        first = [total + (D * x).sum() * unit**4 for total, x in zip(first, u + c, strict=True)]
        squares = [u[i] * u[j] + v[i] * v[j] + w[i] * w[j] for i, j in PAIRS]
        second = [total + (D * xx).sum() * unit**5 for total, xx in zip(second, squares, strict=True)]
    return Moments(volume / 6, np.array(first) / 24, symmetric(np.array(second) / 120))


@dataclass(frozen=True, eq=False)
class Sweep:
    """What one pass found: sums (blocks, k), in its floats, about the reference (3,), and boxes (blocks, 3) of blocks.

    least: twice the area of the smallest triangle; edges: fingerprint of the boundary, where it was asked for.
    """

    sums: Array
    reference: Floats
    lows: Floats
    highs: Floats
    least: float
    edges: Fingerprint | None = None

    @property
    def lo(self) -> Floats:
        return np.asarray(self.lows.min(axis=0))

    @property
    def hi(self) -> Floats:
        return np.asarray(self.highs.max(axis=0))

    @property
    def reaches(self) -> Floats:
        """(blocks, 3) how far the box of each block reaches from the reference."""
        with np.errstate(over="ignore"):
            return np.maximum(self.highs - self.reference, self.reference - self.lows)

    @property
    def reach(self) -> Floats:
        return np.asarray(self.reaches.max(axis=0))

    @property
    def safe(self) -> bool:
        """Whether nothing came near the ends of the range of a float."""
        reach = self.reach
        return bool((reach < _SAFE[1]).all() and (reach[reach > 0] > _SAFE[0]).all())

    def totals(self, columns: slice = slice(None)) -> Array:
        """(k,) these sums over all blocks, as fractions: of float64 correctly rounded, of wider floats exact."""
        if self.sums.dtype == np.float64:
            return exact([fsum(column) for column in self.sums[:, columns].T.tolist()])
        total: Array = exact(self.sums[:, columns]).sum(axis=0)
        return total

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
    """Pass over the triangles once with `volume_kernel` or `surface_kernel`. The reference (3,) is a point in the
    middle of the first block by default; the fingerprint of edges needs float64."""
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


def surface(triangles: Triangles) -> tuple[float, Floats, Floats, Floats]:
    """Area, integrals over a surface of x - r and (x - r)(x - r)^T, and r, inside its box, whatever the winding.

    By sums over triangles, in the units of the file (see `robodyn.solids.mesh.kernel`). MeshError where there are none,
    or moments are beyond the range of a float.

    Accuracy: S within 1e-15 of its largest entry wherever the origin is, if no triangle is longer than ten times its
        height; the error grows with that ratio.
    """
    sweep = swept(triangles, surface_kernel)
    if not sweep.safe:
        raise sweep.beyond(triangles, "large" if sweep.reach.max() > 1 else "small")
    sums = sweep.totals().astype(np.float64)
    return float(sums[0] / 2), sums[1:4] / 6, symmetric(sums[4:10] / 24), sweep.reference


@dataclass(frozen=True, eq=False)
class Integrals(VolumeIntegrals):
    """Integrals over the volume inside a surface, in units of the file; negative where it is wound inwards.

    area: of the surface; lo, hi: (3,) corners of its box; count: triangles; bound: of the arithmetic error of the
    volume, relative to it, infinite where it is all there is; method: "float64", "long double" or "rational"; least:
    area of the smallest triangle; bound_second: as `bound`, of each principal second moment about the centre;
    unrounded: volume, first and S as fractions.
    """

    area: float
    lo: Floats
    hi: Floats
    count: int
    bound: float
    method: str
    least: float = 0.0
    bound_second: float = 0.0
    unrounded: Moments | None = None

    @property
    def moments(self) -> Moments:
        return self.unrounded or super().moments


def volume_bound(moments: Moments, perm: float, eps: float) -> float:
    """8 eps perm / |V| and the rounding to a float: of the relative error of V, on closed surfaces.

    perm is V with all its products taken as positive.
    """
    volume = abs(float(moments.volume))
    return _upwards(8 * eps * perm / volume + ROUNDING) if volume else inf


def second_bound(moments: Moments, perm: float, reach: Array, eps: float) -> float:
    """eps perm / s and the rounding to a float, of the relative error of principal second moments about the centre.

    s is the smallest eigenvalue of D^-1 S_c D^-1, D = diag(reach), by which the box reaches (3,) from the reference.
    The errors of S_c are eps perm D_i D_j or less, and scaling leaves relative bounds of eigenvalues as they are
    (Demmel, Veselic 1992): a thin body that lies along the axes is well conditioned, and the same one askew is not.
    """
    if not moments.volume or not reach.all():
        return inf
    S_c = moments.second - np.outer(moments.first, moments.first) / moments.volume
    with np.errstate(all="ignore"):
        scaled = S_c.astype(np.float64) / reach / reach[:, None]
    if not np.isfinite(scaled).all():
        return inf
    least = float(np.abs(eigen(scaled)[0]).min())
    return _upwards(eps * perm / least + ROUNDING) if least > float_info.epsilon * np.abs(scaled).max() else inf


def _upwards(bound: float) -> float:
    """Return the next number of three digits: on every processor the same one, whatever the rounding of sums."""
    power = floor(log10(bound)) - 2
    return float(f"{ceil(bound / float(f'1e{power}'))}e{power}")


LIMIT = 1e-12
"""Bounds of the error above this call for the next finer arithmetic."""
_MOMENTS, _AREA, _SQUARES = slice(10), 10, slice(11, 17)
"""Places among the sums of `volume_kernel`."""
_SMALL = 1e-60
"""Width below which moments of bodies, and not only of thin ones, can be too small for a float."""
_WIDER = 63
"""Fraction bits of a long double that is worth trying."""


def integrate(triangles: Triangles, exact: bool = False) -> Integrals:
    """V = integral of 1, first = integral of x - r and S = integral of (x - r)(x - r)^T over the volume, and the area.

    Sums of tetrahedra from a reference r inside the box (see `volume_kernel`), in float64; where the bound
    of the error of the volume or of a principal second moment is above 1e-12 in long double, if that has 64 bits; and
    where it still is, or `exact` is asked for, in integers. MeshError as for `surface`.

    Accuracy: volume and principal second moments within `bound` and `bound_second`, and so within 1e-12, on every
        closed surface; correctly rounded if exact.
    """
    return _refined(triangles, swept(triangles, volume_kernel), exact)


def measure(triangles: Triangles, exact: bool = False) -> tuple[Integrals, Fingerprint]:
    """`integrate` and `fingerprint` in one pass over the triangles.

    What an open surface encloses depends on the reference: its integrals stay in float64 unless they are to be exact.
    MeshError also where it is too large or small for products of moments, which judge symmetry and tessellation.
    """
    sweep = swept(triangles, volume_kernel, edges=True)
    assert sweep.edges is not None
    with np.errstate(over="ignore"):
        size = np.array((1.0, triangles.scale))
        far, width = max(np.abs(sweep.lo).max(), np.abs(sweep.hi).max()) * size, (sweep.hi - sweep.lo).max() * size
    if not far.max() <= LARGEST:
        raise sweep.beyond(triangles, "large")
    if 0 < width.min() < 1 / LARGEST:
        raise sweep.beyond(triangles, "small")
    return _refined(triangles, sweep, exact, limit=LIMIT if sweep.edges.closed else np.inf), sweep.edges


def _refined(triangles: Triangles, first: Sweep, exact: bool, limit: float = LIMIT) -> Integrals:
    """Return the integrals of a first sweep in float64, or finer ones where their bounds are above the limit."""
    wide = np.finfo(np.longdouble).nmant >= _WIDER
    for method in ("float64", "long double")[: 1 + wide] if first.safe and not exact else ():
        again = method != "float64"
        sweep = swept(triangles, volume_kernel, dtype=np.longdouble, reference=first.reference) if again else first
        sums = sweep.totals(_MOMENTS)
        moments = Moments(sums[0] / 6, sums[1:4] / 24, symmetric(sums[4:10] / 120))
        # perm, at least V with all its products taken as positive: in each block by its reach and Schwarz's inequality
        e, f = np.sqrt(sweep.sums[:, _SQUARES].astype(np.float64)).reshape(-1, 2, 3).swapaxes(0, 1)
        products = np.stack([e[:, i - 2] * f[:, i - 1] + e[:, i - 1] * f[:, i - 2] for i in range(3)], axis=1)
        perm, eps = float((sweep.reaches * products).sum()) / 6, float(np.finfo(sweep.sums.dtype).eps)
        bounds = volume_bound(moments, perm, eps), second_bound(moments, perm, sweep.reach, eps)
        if max(bounds) <= limit:
            return _integrals(triangles, first, moments, method, bounds)
    moments = exact_moments(triangles, first.reference)
    return _integrals(triangles, first, moments, "rational", (ROUNDING, ROUNDING))


def _integrals(
    triangles: Triangles, first: Sweep, moments: Moments, method: str, bounds: tuple[float, float]
) -> Integrals:
    try:
        volume, centre, S = (np.asarray(part).astype(np.float64) for part in moments)
    except OverflowError:
        raise first.beyond(triangles, "large") from None
    sizes = map(abs, (moments.volume, *moments.second.diagonal()))
    if first.reach.max() < _SMALL and any(0 < size < float_info.min for size in sizes):
        raise first.beyond(triangles, "small")
    return Integrals(
        volume=float(volume),
        first=centre,
        S=S,
        reference=first.reference,
        area=fsum(first.sums[:, _AREA].tolist()) / 2,
        lo=first.lo,
        hi=first.hi,
        count=triangles.count,
        bound=bounds[0],
        bound_second=bounds[1],
        method=method,
        least=first.least / 2,
        unrounded=moments,
    )
