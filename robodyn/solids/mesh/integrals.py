"""Integrals over what a surface encloses, and how far their arithmetic can be trusted."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor, inf, log10
from sys import float_info

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.vectors import Array
from robodyn.solids.inertia.eigen import eigen
from robodyn.solids.mesh.exact import Moments

Floats = NDArray[np.float64]

ROUNDING = float_info.epsilon / 2
"""Relative error of the float nearest to a number."""


@dataclass(frozen=True, eq=False)
class Integrals:
    """Integrals over the volume inside a surface, in units of the file; negative where it is wound inwards.

    Attributes:
        volume: V, of 1.
        first: (3,) of x - reference.
        S: (3, 3) of (x - reference)(x - reference)^T.
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

    volume: float
    first: Floats
    S: Floats
    reference: Floats
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
        """Volume, first and S with all that is known of their digits."""
        return self.unrounded or Moments(self.volume, self.first, self.S)


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
