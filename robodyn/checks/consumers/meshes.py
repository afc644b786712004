"""Which formats of meshes programs read, and where a description has shapes that one does not take as they are.

That meshes cannot be read is reported only of programs that are asked for: nearly every robot has some.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from os.path import splitext
from typing import NamedTuple

from robodyn.checks.consumers.facts import Find, Found
from robodyn.checks.context import Context
from robodyn.checks.meshes.files import MeshUse, State, mesh_names, mesh_uses


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
        for suffix, uses in unread(context, target).items() if target in context.asked.targets else ():
            yield from (_use(use, suffix or "no suffix") for use in uses)

    return find


def missing_meshes(target: str, *kinds: str) -> Find:
    """Return meshes that are not there."""

    def find(context: Context) -> Iterator[Found]:
        for name in context.once(mesh_names).values() if target in context.asked.targets else ():
            if name.state in (State.MISSING, State.OTHER_CASE):
                yield from (_use(use, name.uri) for use in name.uses if use.geometry.kind in kinds)

    return find


def uris(context: Context) -> Iterator[Found]:
    """Yield meshes to collide with that are named by a URI, where MuJoCo is not told to strip it."""
    extension = context.view.root.find("mujoco")
    compiler = None if extension is None else extension.find("compiler")
    if "mujoco" not in context.asked.targets or (compiler is not None and compiler.get("strippath") == "true"):
        return
    for use in mesh_uses(context):
        name = use.geometry.shape.get("filename") if use.geometry.shape is not None else None
        if name and "://" in name and use.geometry.kind in READS["mujoco"].kinds:
            yield _use(use, name)


def visuals(context: Context) -> Iterator[Found]:
    for link in context.view.links:
        visual = [geometry for geometry in link.geometries if geometry.kind == "visual"]
        yield from ((geometry.element.span, f"link '{link.name}'") for geometry in visual)


def _use(use: MeshUse, what: str) -> Found:
    return use.at, f"{what} in the {use.geometry.kind} of link '{use.link.name}'"
