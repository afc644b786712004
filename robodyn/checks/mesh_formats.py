"""Which formats of meshes programs read."""

from __future__ import annotations

from collections.abc import Mapping
from os.path import splitext
from typing import NamedTuple

from robodyn.checks.context import Context
from robodyn.checks.mesh_files import MeshUse, mesh_names


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
    """The shapes whose mesh a program does not read, by the suffix."""
    found: dict[str, list[MeshUse]] = {}
    reads = READS.get(target)
    for name in context.once(mesh_names).values() if reads else ():
        suffix = splitext(name.uri)[1].lower()
        uses = [use for use in name.uses if reads and use.geometry.kind in reads.kinds]
        if uses and reads and suffix not in reads.suffixes:
            found.setdefault(suffix, []).extend(uses)
    return found
