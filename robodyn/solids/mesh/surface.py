"""Area, first and second moments of a surface of triangles, for shells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robodyn.solids.mesh.kernel import surface_kernel, symmetric
from robodyn.solids.mesh.sweep import Floats, swept
from robodyn.solids.mesh.triangles import Triangles


@dataclass(frozen=True, eq=False)
class SurfaceIntegrals:
    """Integrals over a surface, in units of the file. They do not depend on the winding.

    Attributes:
        area: A, of 1.
        first: (3,) of x - reference.
        S: (3, 3) of (x - reference)(x - reference)^T.
        reference: (3,) a point inside the box.
        lo, hi: (3,) corners of the box.
        count: triangles.
    """

    area: float
    first: Floats
    S: Floats
    reference: Floats
    lo: Floats
    hi: Floats
    count: int


def surface(triangles: Triangles) -> SurfaceIntegrals:
    """A = integral of 1, first = integral of x - r and S = integral of (x - r)(x - r)^T over the surface.

    Sums over triangles about a reference r inside the box; see `robodyn.solids.mesh.kernel`.

    Raises:
        MeshError: there are no triangles, or moments are beyond the range of a float.

    Accuracy: S within 1e-15 of its largest entry wherever the origin is, if no triangle is longer than ten times its
        height; the error grows with that ratio.
    """
    sweep = swept(triangles, surface_kernel)
    if not sweep.safe:
        raise sweep.beyond(triangles, "large" if sweep.reach.max() > 1 else "small")
    sums = sweep.totals().astype(np.float64)
    return SurfaceIntegrals(
        float(sums[0] / 2),
        sums[1:4] / 6,
        symmetric(sums[4:10] / 24),
        sweep.reference,
        sweep.lo,
        sweep.hi,
        triangles.count,
    )
