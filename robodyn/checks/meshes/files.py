"""The files of the meshes that a description names: where they are, why they are not there, and in which unit."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from functools import cache
from math import dist
from pathlib import Path
from typing import NamedTuple

from robodyn.checks.context import STDIN, Context
from robodyn.checks.meshes.facts import MeshFacts, facts_of
from robodyn.checks.rule import Edit, Fault, Fix, Severity
from robodyn.robot.urdf.document import Span, unexpanded
from robodyn.robot.urdf.sources import package_of
from robodyn.robot.urdf.view import GeometryView, LinkView, value_span
from robodyn.support.wording import count, shown_path

_LONGEST, _SHORTEST = 20.0, 1e-3
"""Metres beyond which no part of a robot is; and, for such ones, of its sizes over the reach of the robot's joints."""
_TIMES, _MINUTE = 20.0, 100.0
_TWIN = (300.0, 3000.0)
"""Ratio of a link's meshes that a factor of 1000 between them explains."""
_UNEVEN = (900.0, 1100.0)
_KILOMETRES = 900.0
"""A scale in all axes that no file asks for: of 86 published robots none has more than 1."""


class State(Enum):
    FOUND = "there"
    OTHER_CASE = "there in another case"
    MISSING = "not there"
    UNKNOWN = "in a package of which nothing is known"
    REMOTE = "somewhere else"


class MeshUse(NamedTuple):
    """A mesh of a link, and where its file is named."""

    link: LinkView
    geometry: GeometryView
    at: Span


@dataclass(frozen=True, slots=True, eq=False)
class MeshName:
    """A file name as it is written, every <mesh> that has it, the path of the file if it is there, and the name as it
    should be written where its case is wrong."""

    uri: str
    uses: tuple[MeshUse, ...]
    state: State
    path: Path | None = None
    found: str | None = None

    def fault(self, what: str, remedy: str, severity: Severity | None = None, fix: Fix | None = None) -> Fault:
        others = f" (and {count(len(self.uses) - 1, 'more place')})" if self.uses[1:] else ""
        sentence = f"the mesh {shown_path(self.uri)} {what}{others}"
        return Fault(self.uses[0].at, sentence, remedy, severity=severity, fix=fix)

    def renamed(self, better: str) -> Fix:
        edits = tuple(Edit(use.at.start, use.at.end, better) for use in self.uses)
        return Fix(f"write {shown_path(better)}", edits, safe=True)


def mesh_uses(context: Context) -> Iterator[MeshUse]:
    for link in context.view.links:
        for geometry in link.geometries:
            if geometry.shape is not None and geometry.tag == "mesh":
                yield MeshUse(link, geometry, value_span(geometry.shape, "filename"))


def mesh_names(context: Context) -> Mapping[str, MeshName]:
    """The names of meshes; those that are empty or not expanded are none."""
    uses: dict[str, list[MeshUse]] = {}
    for use in mesh_uses(context):
        if use.geometry.uri and not unexpanded(use.geometry.uri):
            uses.setdefault(use.geometry.uri, []).append(use)
    meshes = MeshSearch(context)
    return {uri: meshes.find(uri, tuple(found)) for uri, found in uses.items()}


def all_facts(context: Context) -> Mapping[str, MeshFacts]:
    """By name the facts of every mesh whose file is found."""
    names = context.once(mesh_names).values()
    known = facts_of(name.path for name in names if name.path is not None)
    return {name.uri: known[name.path] for name in names if name.path is not None}


class MeshSearch:
    """How names are looked up; folders are listed once."""

    def __init__(self, context: Context) -> None:
        self._bytes = context.reading.file == STDIN
        self._search = context.search
        self._listed: dict[Path, frozenset[str]] = {}

    def find(self, uri: str, uses: tuple[MeshUse, ...]) -> MeshName:
        path = self._search.find(uri)
        scheme, separator, _ = uri.partition("://")
        for root, prefix, rest in self._roots(uri):
            name = self._true_name(root, rest)
            if name is not None and name != rest and (path is None or path == root / rest):
                return MeshName(uri, uses, State.OTHER_CASE, root / name, prefix + name)
            if path == root / rest:
                break
        if path is not None:
            return MeshName(uri, uses, State.FOUND, path)
        if separator and scheme not in ("file", "package", "model"):
            return MeshName(uri, uses, State.REMOTE)
        return MeshName(uri, uses, State.MISSING if self._known(uri) else State.UNKNOWN)

    def _roots(self, uri: str) -> Iterator[tuple[Path, str, str]]:
        """Yield folders that exist, what of the name stands for them, and the path in them."""
        package = package_of(uri)
        if package is not None and package[0]:
            rest = package[1]
            for root in dict.fromkeys(self._search.packages(package[0])):
                if root.is_dir():
                    yield root, uri[: len(uri) - len(rest)], rest
        elif "://" not in uri and not os.path.isabs(uri):
            yield from ((folder, "", uri) for folder in self._search.folders)

    def _known(self, uri: str) -> bool:
        """Whether it is known where the file ought to be."""
        package = package_of(uri)
        if package is None:
            return not (self._bytes and not os.path.isabs(uri) and "://" not in uri)
        return not package[0] or any(True for _ in self._roots(uri)) or self._search.knows_packages

    def _true_name(self, root: Path, rest: str) -> str | None:
        """The path in a folder as its folders spell it, if it is there in any case."""
        parts = []
        for part in rest.split("/"):
            names, alike = self._names(root), [part]
            if part not in ("", ".", "..") and part not in names:
                alike = [name for name in names if name.casefold() == part.casefold()]
            if len(alike) != 1:
                return None
            root = root / alike[0]
            parts += alike
        return "/".join(parts)

    def _names(self, folder: Path) -> frozenset[str]:
        if folder not in self._listed:
            self._listed[folder] = frozenset()
            with suppress(OSError, ValueError):
                self._listed[folder] = frozenset(os.listdir(folder))
        return self._listed[folder]


class UnitSlip(NamedTuple):
    """A mesh as it is used: its longest side [m], or its scale where the file is not known, the factor of its size, and
    how that shows."""

    name: MeshName
    longest: float
    factor: float
    how: str


def mesh_slips(context: Context) -> Mapping[GeometryView, UnitSlip]:
    """The uses of meshes that are 1000 times too large or too small."""
    around = reach(context)
    found: dict[GeometryView, UnitSlip] = {}

    @cache
    def twin(link: LinkView, kind: str) -> float | None:
        """The longest side of the largest mesh of a link that is of another kind, collision or visual."""
        sides = (longest(other, context) for other in link.geometries if other.kind != kind)
        return max((side for side in sides if side is not None), default=None)

    for name in context.once(mesh_names).values():
        for use in name.uses:
            side = longest(use.geometry, context)
            sizes = sorted(map(abs, use.geometry.scale.or_default(1.0, 1.0, 1.0) or (1.0,)))
            if side is None:
                if sizes[0] >= _KILOMETRES:
                    how = f"a scale of {sizes[0]:g} is for a file in kilometres"
                    found[use.geometry] = UnitSlip(name, sizes[0], 1e3, how)
                continue
            mistaken = _mistaken(side, twin(use.link, use.geometry.kind), around)
            if mistaken is None and sizes[0] > 0 and _UNEVEN[0] <= sizes[-1] / sizes[0] <= _UNEVEN[1]:
                mistaken = sizes[-1] / sizes[0], "its scale differs by a factor of 1000 between axes"
            if mistaken is not None:
                found[use.geometry] = UnitSlip(name, side, *mistaken)
    return found


def longest(geometry: GeometryView, context: Context) -> float | None:
    """The longest side of the box of a mesh, scaled [m]; None where it is not known."""
    known = context.once(all_facts).get(geometry.uri)
    scale = geometry.scale.or_default(1.0, 1.0, 1.0)
    if known is None or known.problem is not None or scale is None or not all(scale):
        return None
    return max(abs(factor) * (hi - lo) for factor, lo, hi in zip(scale, known.lo, known.hi, strict=True))


def _mistaken(side: float, twin: float | None, reach: float) -> tuple[float, str] | None:
    if side > _LONGEST and side > _TIMES * reach:
        return 1e3, f"it is {side:.4g} m long"
    if side < _SHORTEST and reach > _MINUTE * side:
        return 1e-3, f"it is {1e3 * side:.3g} mm long in a robot whose joints are up to {reach:.3g} m apart"
    if twin is None or not twin > 0:
        return None
    ratio = side / twin
    too_large = 0 < _TIMES * reach < max(side, twin)
    if _TWIN[0] <= ratio <= _TWIN[1] and too_large:
        return 1e3, f"it is {ratio:.0f} times as large as the link's other mesh"
    if _TWIN[0] <= 1 / ratio <= _TWIN[1] and not too_large:
        return 1e-3, f"it is {1 / ratio:.0f} times smaller than the link's other mesh"
    return None


def reach(context: Context) -> float:
    """The largest distance between the origins of neighbouring links [m]; 0 where there is none."""
    offsets = (joint.origin.xyz.or_default(0.0, 0.0, 0.0) for joint in context.view.joints)
    return max((dist(xyz, (0.0, 0.0, 0.0)) for xyz in offsets if xyz is not None), default=0.0)
