"""Meshes that programs do not read, or that are not there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from os.path import splitext
from typing import NamedTuple

from robodyn.checks.consumers.found import Find, Found, named
from robodyn.checks.context import Context
from robodyn.checks.meshes.files import MeshUse, State, mesh_names


class Reads(NamedTuple):
    """Suffixes that a program reads, what it does with others, how that is known, and for which kinds of shapes."""

    suffixes: tuple[str, ...]
    otherwise: str
    source: str
    kinds: tuple[str, ...] = ("visual", "collision")


READS: Mapping[str, Reads] = {
    "mujoco": Reads((".stl", ".obj", ".msh"), "rejects the file", "MuJoCo 4.0, run", ("collision",)),
    "drake": Reads((".obj", ".gltf", ".vtk"), "rejects the file", "Drake 1.51, run", ("collision",)),
    "gz": Reads((".stl", ".dae", ".obj", ".gltf", ".glb", ".fbx"), "leaves the shape out", "gz-common 6, MeshManager"),
}


def unread(context: Context, target: str) -> dict[str, list[MeshUse]]:
    """Return the shapes whose mesh a program does not read, by the suffix."""
    found: dict[str, list[MeshUse]] = {}
    reads = READS.get(target)
    for name in context.once(mesh_names).values() if reads else ():
        suffix = splitext(name.uri)[1].lower()
        uses = [use for use in name.uses if reads and use.geometry.kind in reads.kinds]
        if uses and reads and suffix not in reads.suffixes:
            found.setdefault(suffix, []).extend(uses)
    return found


def unread_meshes(target: str) -> Find:
    """Return meshes in a format that a program does not read."""

    def find(context: Context) -> Iterator[Found]:
        for suffix, uses in unread(context, target).items():
            yield from (used(use, suffix or "no suffix") for use in uses)

    return find


def missing_meshes(*kinds: str) -> Find:
    """Return meshes that are not there."""

    def find(context: Context) -> Iterator[Found]:
        for name in context.once(mesh_names).values():
            if name.state in (State.MISSING, State.OTHER_CASE):
                yield from (used(use, name.uri) for use in name.uses if use.geometry.kind in kinds)

    return find


def used(use: MeshUse, what: str) -> Found:
    return Found(use.at, f"{what} in the {use.geometry.kind} of {named(use.link)}")
