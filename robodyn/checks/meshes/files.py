"""The files of the meshes that a description names: where they are, or why they are not there."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from robodyn.checks.context import STDIN, Context
from robodyn.checks.meshes.facts import MeshFacts, facts_of
from robodyn.checks.rule import Edit, Fault, Fix, Severity
from robodyn.robot.urdf.document import unexpanded
from robodyn.robot.urdf.elements import Span
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.packages import package_of
from robodyn.robot.urdf.view import GeometryView, LinkView
from robodyn.support.wording import count, shown_path


class State(Enum):
    FOUND = "there"
    OTHER_CASE = "there in another case"
    MISSING = "not there"
    UNKNOWN = "in a package of which nothing is known"
    REMOTE = "somewhere else"


@dataclass(frozen=True, slots=True)
class MeshUse:
    link: LinkView
    geometry: GeometryView

    @property
    def at(self) -> Span:
        assert self.geometry.shape is not None, "it is a mesh"
        return value_span(self.geometry.shape, "filename")

    @property
    def uri(self) -> str:
        return (self.geometry.shape and self.geometry.shape.get("filename")) or ""


@dataclass(frozen=True, slots=True, eq=False)
class MeshName:
    """A file name, and every <mesh> that has it.

    Attributes:
        uri: as it is written.
        uses: in the order of the file.
        state: see `State`.
        path: of the file, if it is found.
        found: the name as it should be written, where its case is wrong.
    """

    uri: str
    uses: tuple[MeshUse, ...]
    state: State
    path: Path | None = None
    found: str | None = None

    @property
    def gives_mass(self) -> bool:
        """Whether it is a <collision> of a link without <inertial>, which simulators weigh by it."""
        return any(use.geometry.kind == "collision" and use.link.inertial is None for use in self.uses)

    def fault(self, what: str, remedy: str, severity: Severity | None = None, fix: Fix | None = None) -> Fault:
        """Return `the mesh NAME what`, at its first use, with the count of the others."""
        others = f" (and {count(len(self.uses) - 1, 'more place')})" if self.uses[1:] else ""
        sentence = f"the mesh {shown_path(self.uri)} {what}{others}"
        return Fault(self.uses[0].at, sentence, remedy, severity=severity, fix=fix)

    def renamed(self, better: str) -> Fix:
        edits = tuple(Edit(use.at.start, use.at.end, better) for use in self.uses)
        return Fix(f"write {shown_path(better)}", edits, safe=True)


def mesh_uses(context: Context) -> Iterator[MeshUse]:
    for link in context.view.links:
        for geometry in link.geometries:
            if geometry.shape is not None and geometry.shape.tag == "mesh":
                yield MeshUse(link, geometry)


def mesh_names(context: Context) -> Mapping[str, MeshName]:
    """Return the names of meshes; those that are empty or not expanded are none."""
    uses: dict[str, list[MeshUse]] = {}
    for use in mesh_uses(context):
        if use.uri and not unexpanded(use.uri):
            uses.setdefault(use.uri, []).append(use)
    meshes = MeshSearch(context)
    return {uri: meshes.find(uri, tuple(found)) for uri, found in uses.items()}


def all_facts(context: Context) -> Mapping[str, MeshFacts]:
    """Return by name the facts of every mesh whose file is found."""
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
        """Return whether it is known where the file ought to be."""
        package = package_of(uri)
        if package is None:
            return not (self._bytes and not os.path.isabs(uri) and "://" not in uri)
        return not package[0] or any(True for _ in self._roots(uri)) or self._search.knows_packages

    def _true_name(self, root: Path, rest: str) -> str | None:
        """Return the path in a folder as its folders spell it, if it is there in any case."""
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
