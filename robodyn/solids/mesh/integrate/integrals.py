"""Volume, first and second moments of what a surface encloses, to the digits that are asked for, with bounds."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor, fsum, inf, log10
from sys import float_info

import numpy as np

from robodyn.programs.linear import eigen
from robodyn.programs.vectors import Array, Scalar
from robodyn.solids.mesh.closed.fingerprint import Fingerprint
from robodyn.solids.mesh.integrate.compiled_kernel import kernel_for
from robodyn.solids.mesh.integrate.exact import Moments, VolumeIntegrals, exact_moments
from robodyn.solids.mesh.integrate.kernel import symmetric, volume_kernel
from robodyn.solids.mesh.integrate.sweep import Sweep, swept
from robodyn.solids.mesh.triangles import Triangles
from robodyn.support.floats import Floats

ROUNDING = float_info.epsilon / 2
"""Relative error of the float nearest to a number."""


@dataclass(frozen=True, eq=False)
class Integrals(VolumeIntegrals):
    """Integrals over the volume inside a surface, in units of the file; negative where it is wound inwards.

    Attributes:
        reference: (3,) a point inside the box.
        area: of the surface.
        lo, hi: (3,) corners of its box.
        count: triangles.
        bound: of the arithmetic error of the volume, relative to it; infinite where it is all there is.
        method: "float64", "long double" or "rational".
        least: area of the smallest triangle.
        bound_second: as `bound`, of each principal second moment about the centre.
        unrounded: volume, first and S as fractions, before they were rounded to floats; not needed.
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
    """8 eps perm / |V| and the rounding to a float, of the relative error of V.

    perm is V with all its products taken as positive.

    Accuracy: a bound on closed surfaces, where rounding a corner in all its triangles alike moves V little.
    """
    volume = abs(float(moments.volume))
    return _upwards(8 * eps * perm / volume + ROUNDING) if volume else inf


def second_bound(moments: Moments, perm: float, reach: Array, eps: float) -> float:
    """eps perm / s and the rounding to a float, of the relative error of principal second moments about the centre.

    s is the smallest eigenvalue of D^-1 S_c D^-1 with D = diag(reach). The errors of S_c are eps perm D_i D_j or less,
    and scaling leaves relative bounds of eigenvalues as they are (Demmel, Veselic 1992): a thin body that lies along
    the axes is well conditioned, and the same one askew is not.

    Args:
        reach: (3,) how far the box reaches from the reference.
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


__all__ = ["Integrals", "integrate", "measure"]

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
    where it still is, or `exact` is asked for, in integers. The area is always in float64.

    Raises:
        MeshError: there are no triangles, or moments are beyond the range of a float.

    Accuracy: S within 1e-15 of its largest entry where `bound_second` is below 1e-13, wherever the origin is. Volume
        and principal second moments within `bound` and `bound_second`, and so within 1e-12, on every closed surface.
        Correctly rounded if exact.
    """
    return _refined(triangles, swept(triangles, kernel_for(triangles.count)), exact)


def measure(triangles: Triangles, exact: bool = False) -> tuple[Integrals, Fingerprint]:
    """`integrate` and `fingerprint` in one pass over the triangles.

    What an open surface encloses depends on the reference: its integrals stay in float64 unless they are to be exact.

    Raises:
        MeshError: as `integrate`, or it is too large or too small for products of moments.
    """
    sweep = swept(triangles, kernel_for(triangles.count), edges=True)
    assert sweep.edges is not None
    sweep.check_size(triangles)
    return _refined(triangles, sweep, exact, limit=LIMIT if sweep.edges.closed else np.inf), sweep.edges


def _refined(triangles: Triangles, first: Sweep, exact: bool, limit: float = LIMIT) -> Integrals:
    """Return the integrals of a first sweep in float64, or finer ones where their bounds are above the limit."""
    if first.safe and not exact:
        found = _estimated(triangles, first, first, "float64")
        if _worst_bound(found) > limit and np.finfo(np.longdouble).nmant >= _WIDER:
            second = swept(triangles, volume_kernel, dtype=np.longdouble, reference=first.reference)
            found = _estimated(triangles, first, second, "long double")
        if _worst_bound(found) <= limit:
            return found
    moments = exact_moments(triangles, first.reference, first.lo, first.hi)
    return _integrals(triangles, first, moments, "rational", (ROUNDING, ROUNDING))


def _worst_bound(found: Integrals) -> float:
    return max(found.bound, found.bound_second)


def _estimated(triangles: Triangles, first: Sweep, sweep: Sweep, method: str) -> Integrals:
    """Return the integrals that a sweep found, with their bounds; the area is that of the first."""
    sums = sweep.totals(_MOMENTS)
    moments = Moments(sums[0] / 6, sums[1:4] / 24, symmetric(sums[4:10] / 120))
    perm, eps = sweep.perm(sweep.sums[:, _SQUARES]) / 6, float(np.finfo(sweep.sums.dtype).eps)
    bounds = volume_bound(moments, perm, eps), second_bound(moments, perm, sweep.reach, eps)
    return _integrals(triangles, first, moments, method, bounds)


def _integrals(
    triangles: Triangles, first: Sweep, moments: Moments, method: str, bounds: tuple[float, float]
) -> Integrals:
    try:
        volume, centre, S = (np.asarray(part).astype(np.float64) for part in moments)
    except OverflowError:
        raise first.beyond(triangles, "large") from None
    if first.reach.max() < _SMALL and any(map(_lost, (moments.volume, *moments.second.diagonal()))):
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


def _lost(number: Scalar) -> bool:
    """Return whether a number that is not zero is below the least float of full precision."""
    return bool(0 < abs(number) < float_info.min)
