"""A surface measured, after what it needed of repair."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from robodyn.errors import MeshError
from robodyn.solids.mesh.integrals import Integrals
from robodyn.solids.mesh.integrate import measure
from robodyn.solids.mesh.sound import is_sound
from robodyn.solids.mesh.triangles import Triangles

if TYPE_CHECKING:
    from robodyn.solids.mesh.quadrature import Quadrature
    from robodyn.solids.mesh.repair import Repaired, Step


@dataclass(frozen=True, eq=False)
class Measured:
    """A surface and its integrals.

    Attributes:
        triangles: after repair; closed: whether they have no boundary.
        fixed: what was repaired, None if nothing had to be looked at.
    """

    triangles: Triangles
    integrals: Integrals
    closed: bool
    fixed: Repaired | None = None

    @property
    def region(self) -> Quadrature | None:
        """What the surface encloses where that is not the sum over its triangles."""
        return None if self.fixed is None else self.fixed.quadrature

    @property
    def defined(self) -> bool:
        """Whether the triangles themselves enclose the body."""
        return self.closed and self.region is None

    @property
    def remarks(self) -> tuple[str, ...]:
        return () if self.fixed is None else self.fixed.remarks

    @property
    def steps(self) -> tuple[Step, ...]:
        """The repairs, with volumes in m^3."""
        cube = self.triangles.scale**3
        steps = () if self.fixed is None else self.fixed.steps
        return tuple(
            replace(step, volume_before=step.volume_before * cube, volume_after=step.volume_after * cube)
            for step in steps
        )

    @property
    def union(self) -> float | None:
        """Relative error bar for overlaps and holes, None if there are none."""
        if self.region is not None:
            return self.region.bar
        doubt = 0.0 if self.fixed is None else self.fixed.doubt
        return doubt / abs(self.integrals.volume) if doubt else None


def measured(
    triangles: Triangles, *, exact: bool = False, repair: bool = True, strict: bool = False, cavities: bool = False
) -> Measured:
    """The surface as it is if it is proven sound, or if no repair is wanted; else put right and closed.

    Args:
        exact: integrate in exact arithmetic.
        strict: refuse what needs repair, and what may not be the whole mesh.
        cavities: see `repair`.

    Raises:
        MeshError: the surface needs repair and that is not wanted, or cannot be closed.

    Accuracy: as `measure`.
    """
    if strict and triangles.warnings:
        remedy = "--strict refuses what is doubtful"
        raise MeshError("; ".join(triangles.warnings), remedy=remedy, file=triangles.name)
    integrals, edges = measure(triangles, exact)
    if not repair or is_sound(triangles, integrals, edges):
        return Measured(triangles, integrals, edges.closed)
    fixed = _repaired(triangles, strict, cavities)
    if fixed.triangles is not triangles:
        integrals, edges = measure(fixed.triangles, exact)
    return Measured(fixed.triangles, integrals, edges.closed, fixed)


def _repaired(triangles: Triangles, strict: bool, cavities: bool) -> Repaired:
    """The surface put right and closed."""
    from robodyn.solids.mesh.repair import repair

    fixed = repair(triangles, cavities)
    if strict and fixed.steps:
        remedy = "--strict refuses what needs repair"
        raise MeshError("; ".join(step.what for step in fixed.steps), remedy=remedy, file=triangles.name)
    if not fixed.closed and fixed.quadrature is None:
        why = f" ({'; '.join(fixed.remarks)})" if fixed.remarks else ""
        raise MeshError(
            f"the surface is not closed{why}, so it encloses no definite volume",
            remedy="--shell THICKNESS takes it as a sheet, --no-repair integrates it as it is",
            file=triangles.name,
        )
    return fixed
