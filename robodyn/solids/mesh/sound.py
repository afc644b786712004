"""Whether a surface can be integrated as it is."""

from __future__ import annotations

from sys import float_info

from robodyn.solids.mesh.closed import Fingerprint
from robodyn.solids.mesh.integrals import Integrals
from robodyn.solids.mesh.one_shell import is_one_shell
from robodyn.solids.mesh.triangles import Triangles

_FLAT = 1e-12
"""Volume over area and width below which a shell may have no sign: ten times what `nesting` asks."""

_COLLINEAR = 64 * float_info.epsilon
"""Area, over the square of the reach of the box, below which three corners may lie on a line: their edges from the
reference are exact within 2 eps, and the products of these within 35 eps."""


def is_sound(triangles: Triangles, integrals: Integrals, edges: Fingerprint) -> bool:
    """Whether `robodyn.solids.mesh.repair` is sure to find nothing to do and nothing to say.

    So it is where the surface has no boundary, a volume that is positive beyond doubt, no triangle without area, and
    is one shell with exactly two triangles on every edge: then no face is there twice, no winding has to be turned,
    there is no other shell that could overlap it or lie in it, and none that could be folded.

    Args:
        integrals, edges: of these triangles.
    """
    size = (integrals.hi - integrals.lo).max()
    return (
        edges.closed
        and bool(integrals.volume > _FLAT * integrals.area * size)
        and bool(integrals.least > _COLLINEAR * size**2)
        and is_one_shell(triangles)
    )
