"""What keeps a surface open, told as `repair` tells it, without repairing it."""

from __future__ import annotations

from dataclasses import dataclass

from robodyn.solids.mesh.indexed import merged
from robodyn.solids.mesh.repair.clean import welded, without_degenerate, without_duplicates
from robodyn.solids.mesh.repair.holes import filled
from robodyn.solids.mesh.repair.shells import Shells, wound
from robodyn.solids.mesh.triangles import Triangles


@dataclass(frozen=True)
class Gaps:
    """The gaps of a surface.

    Attributes:
        mended: holes and seams that repair fills.
        left: gaps that are too large for that; missing: the share of the surface of the open parts that they are.
        one_sided: faces of surfaces with one side only, which are refused; the rest is then 0.
    """

    mended: int = 0
    left: int = 0
    missing: float = 0.0
    one_sided: int = 0


def gaps(triangles: Triangles) -> Gaps:
    """Return the gaps of a surface without its superfluous faces."""
    mesh, _ = without_duplicates(without_degenerate(merged(triangles.array())))
    if not len(mesh.faces):
        return Gaps()
    shells, _ = wound(mesh)
    twisted = one_sided(shells)
    if twisted:
        return Gaps(one_sided=twisted)
    filling = filled(shells)
    return Gaps(filling.holes + filling.seams, filling.left, filling.missing)


def one_sided(shells: Shells) -> int:
    """Return how many faces are in surfaces that cannot be wound, whose inside and outside are not told apart.

    Open ones with rims put together where they nearly meet: caps on those of a Klein bottle would give it two sides.
    """
    if not shells.closed.all():
        whole = welded(shells.mesh, shells.lone)
        shells = shells if whole is shells.mesh else wound(whole)[0]
    return shells.twisted
