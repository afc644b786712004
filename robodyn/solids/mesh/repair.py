"""Putting a surface right step by step, saying what was done and what it did to the volume."""

from __future__ import annotations

from dataclasses import dataclass, replace

from robodyn.errors import MeshError
from robodyn.solids.mesh.columns import Quadrature, as_given, by_columns, by_winding_numbers
from robodyn.solids.mesh.holes import Filling, filled, one_sided
from robodyn.solids.mesh.indexed import Edges, Indexed, merged
from robodyn.solids.mesh.nesting import Nesting, nested
from robodyn.solids.mesh.shells import without_degenerate, without_duplicates, wound
from robodyn.solids.mesh.triangles import MemoryTriangles, Triangles
from robodyn.solids.mesh.union import United, united
from robodyn.support.floats import Floats
from robodyn.support.wording import count as many

_SAME = 1e-11
"""Share of its volume by which a body may differ that is measured twice."""

_BY_REGION = ("overlaps", "winding numbers")
"""Steps that leave the surface as it is."""


@dataclass(frozen=True)
class Step:
    """One kind of repair.

    Attributes:
        name: "degenerate", "duplicate", "winding", "holes", "orientation", "nested", "union", "overlaps" or "winding
            numbers"; the last two leave the surface as it is.
        count: of the faces, gaps, shells or bodies it was done to. what: in words.
        volume_before, volume_after: signed, in units of the file cubed; of an open surface about the middle of its box.
    """

    name: str
    count: int
    what: str
    volume_before: float
    volume_after: float

    @property
    def change(self) -> float:
        """Of the volume."""
        return self.volume_after - self.volume_before


@dataclass(frozen=True, eq=False)
class Repaired:
    """A surface after its repair.

    Attributes:
        triangles: the same object if nothing was done; shells: connected parts, before any union.
        closed: whether no boundary is left; missing: estimated share of the surface of open parts that is missing.
        doubt: volume that may be missing or too much where holes were filled.
        quadrature: integrals over what the surface encloses, where they are not those of its triangles.
        remarks: what was found and left as it is.
    """

    triangles: Triangles
    steps: tuple[Step, ...]
    shells: int
    closed: bool
    doubt: float
    missing: float
    quadrature: Quadrature | None
    remarks: tuple[str, ...]


def repair(triangles: Triangles, cavities: bool = False) -> Repaired:
    """The surface with bad faces dropped, small holes filled, shells wound as their nesting asks, and bodies united.

    Vertices are merged where they are equal, not where they are near. Shells that are open by more than a small hole,
    and those that overlap but are no manifolds, stay as they are: the region where the winding number is positive is
    integrated by columns.

    Args:
        cavities: shells in others are cavities, however they are wound; else by winding numbers (see `nested`).

    Raises:
        MeshError: no triangle has an area, a part of the surface has one side only, or shells are too many to be placed
            in each other.
    """
    mesh = merged(triangles.array())
    steps = _Steps(mesh.middle)
    given = steps.dropped(mesh, without_degenerate(mesh), "degenerate", "without area")
    single, copies = without_duplicates(given)
    mesh = steps.dropped(given, single, "duplicate", "given more than once")
    if not len(mesh.faces):
        raise MeshError("has no triangle with an area", remedy="give a surface", file=triangles.name)
    shells, turned = wound(mesh)
    twisted = one_sided(shells)
    if twisted:
        raise MeshError(
            f"{twisted} of {many(len(shells.mesh.faces), 'face')} form surfaces with one side only, like a "
            "Moebius strip or a Klein bottle: they cannot be wound and enclose no definite volume",
            remedy="--shell THICKNESS takes the surface as a sheet, --no-repair integrates it as it is",
            file=triangles.name,
        )
    steps.taken(mesh, shells.mesh, turned, "winding", f"{many(turned, 'face')} turned to agree with neighbours")
    filling = filled(shells)
    count = filling.holes + filling.seams
    gaps = " and ".join(many(each, kind) for each, kind in ((filling.holes, "hole"), (filling.seams, "seam")) if each)
    what = f"{gaps} filled by {many(filling.triangles, 'triangle')}"
    steps.taken(shells.mesh, filling.shells.mesh, count, "holes", what)
    nesting = nested(filling.capped, copies, filling.caps, cavities, triangles.name)
    count = nesting.bodies + nesting.cavities
    kinds = (nesting.bodies, "turned outwards"), (nesting.cavities, "turned inwards, being a cavity in another")
    what = ", ".join(f"{many(each, 'shell')} {how}" for each, how in kinds if each)
    steps.taken(filling.capped.mesh, nesting.shells.mesh, count, "orientation", what)
    union = united(nesting, filling.caps)
    whole, spare = nesting.shells.mesh, int(union.spare.sum())
    mesh = whole.keep(~union.spare[nesting.shells.label])
    steps.taken(whole, mesh, spare, "nested", f"{many(spare, 'shell')} in another, wound as it is, counted once")
    what = f"{many(union.bodies, 'overlapping body', 'overlapping bodies')} united"
    steps.taken(mesh, union.mesh, union.bodies, "union", what)
    mesh, region = _region(union, filling, steps)
    if (nesting.uneven or shells.tangled) and not Edges.between(given.faces).balance.any():
        region = _by_all_faces(given, mesh, region, steps)
    remarks = []
    if filling.left and region is None:
        share = f"{100 * filling.missing:.2g} % of their surface"
        remarks.append(f"{many(filling.left, 'gap')} too large to be filled: {share} is missing")
    changed = any(step.name not in _BY_REGION for step in steps.all)
    return Repaired(
        triangles=MemoryTriangles(corners=mesh.corners, **triangles.labels) if changed else triangles,
        steps=tuple(steps.all),
        shells=nesting.shells.count,
        closed=not filling.left,
        doubt=filling.doubt,
        missing=filling.missing,
        quadrature=region,
        remarks=(*remarks, *_within(nesting, triangles.scale)),
    )


def _region(union: United, filling: Filling, steps: _Steps) -> tuple[Indexed, Quadrature | None]:
    """Return the mesh without caps, and the region that it encloses if its winding number has to tell."""
    count = len(union.mesh.faces) - filling.caps
    mesh, caps = replace(union.mesh, faces=union.mesh.faces[:count]), union.mesh.faces[count:]
    if not filling.left:
        region = by_columns(mesh) if union.untested or union.folded else None
        bodies = [f"{union.untested} bodies"] if union.untested else []
        shells = [many(union.folded, "folded shell")] if union.folded else []
        what = f"overlaps of {' and '.join(bodies + shells)} counted once, by columns"
        steps.measured(mesh, region, union.untested + union.folded, "overlaps", what)
        return mesh, region
    region = by_winding_numbers(mesh, caps)
    what = f"{many(filling.left, 'gap')} too large to be filled, left to winding numbers"
    steps.measured(mesh, region, filling.left, "winding numbers", what)
    return mesh, region


def _by_all_faces(given: Indexed, mesh: Indexed, region: Quadrature | None, steps: _Steps) -> Quadrature | None:
    found, volume = as_given(given), mesh.volume(mesh.middle) if region is None else region.volume
    apart = abs(found.volume - volume) / abs(found.volume)
    if apart <= _SAME:
        return region
    found = replace(found, bar=max(found.bar, apart))
    steps.measured(mesh, found, 1, "overlaps", "bodies that share faces counted once, by columns")
    return found


class _Steps:
    """The steps so far; their volumes are about one point."""

    def __init__(self, reference: Floats) -> None:
        self.all: list[Step] = []
        self._reference = reference

    def measured(self, before: Indexed, region: Quadrature | None, count: int, name: str, what: str) -> None:
        if region is not None:
            self.all.append(Step(name, count, what, before.volume(self._reference), region.volume))

    def dropped(self, before: Indexed, after: Indexed, name: str, why: str) -> Indexed:
        count = len(before.faces) - len(after.faces)
        return self.taken(before, after, count, name, f"{many(count, 'face')} {why} dropped")

    def taken(self, before: Indexed, after: Indexed, count: int, name: str, what: str) -> Indexed:
        """Return the mesh after a step, which is kept in mind if it was done to anything."""
        if not count:
            return before
        self.all.append(Step(name, count, what, *(mesh.volume(self._reference) for mesh in (before, after))))
        return after


def _within(found: Nesting, scale: float) -> tuple[str, ...]:
    """Return what was taken of shells that lie in others and are wound alike, and how to have it otherwise."""
    count = int(found.within.sum())
    if not count:
        return ()
    one = count == 1
    is_or_are, cavity = ("is", "it is a cavity") if one else ("are", "they are cavities")
    return (
        f"{many(count, 'shell')} in another {is_or_are} wound as it is, and taken as a part of it: "
        f"if {cavity}, say --cavities ({found.less * scale**3:.4g} m^3 less)",
    )
