"""Shapes, meshes and materials that MuJoCo 4.0 refuses or alters; each was learnt by running it."""

from __future__ import annotations

from collections.abc import Iterator
from math import prod

from robodyn.checks.consumers.found import Found, named
from robodyn.checks.consumers.meshes import used
from robodyn.checks.consumers.water import compiler, first_object, of_mesh
from robodyn.checks.context import Context
from robodyn.checks.meshes.files import MeshName, all_facts, mesh_names, mesh_uses
from robodyn.errors import InputError
from robodyn.solids.inertia.solids import WATER
from robodyn.support.input_file import read_input

_LEAST = 1e-15
"""Volume [m^3]."""
_MOST_FACES = 200_000
"""Of an STL file."""
_SURELY = 1e3
"""What the volume of a closed surface exceeds the least by, so that nothing need be computed."""


def uris(context: Context) -> Iterator[Found]:
    """Yield meshes to collide with that are named by a URI, where MuJoCo is not told to strip it."""
    if context.once(compiler).get("strippath") != "true":
        for use in mesh_uses(context):
            if "://" in use.uri and use.geometry.kind == "collision":
                yield used(use, use.uri)


def sizeless(context: Context) -> Iterator[Found]:
    """Yield shapes to collide with, one of whose sizes is not positive."""
    for link in context.view.links:
        for shape in link.geometries:
            sizes = [value for size in shape.sizes for value in size.values or ()]
            if shape.kind == "collision" and min(sizes, default=1.0) <= 0:
                yield Found(shape.element.span, f"the collision of {named(link)}")


def blank_materials(context: Context) -> Iterator[Found]:
    """Yield materials of visuals that have neither a colour nor a name to look one up by."""
    for link in context.view.links:
        for shape in link.geometries:
            material = shape.element.find("material") if shape.kind == "visual" else None
            if material is not None and material.get("name") is None and material.find("color") is None:
                yield Found(material.span, named(link))


def bad_stl(context: Context) -> Iterator[Found]:
    """Yield STL files whose header has no count of faces from 1 to 200 000, as that of a text has not."""
    for name in _collision_files(context):
        if name.path is None or name.path.suffix.lower() != ".stl":
            continue
        try:
            faces = int.from_bytes(read_input(name.path, 84)[80:], "little")
        except OSError:
            continue
        if not 1 <= faces <= _MOST_FACES:
            yield from (used(use, name.uri) for use in name.uses if use.geometry.kind == "collision")


def cut_meshes(context: Context) -> Iterator[Found]:
    """Yield .obj files to collide with, of more than one object or group."""
    for name in _collision_files(context):
        if name.path is None or name.path.suffix.lower() != ".obj":
            continue
        try:
            data = read_input(name.path)
        except (OSError, InputError):
            continue
        if len(first_object(data)) < len(data):
            yield from (used(use, name.uri) for use in name.uses if use.geometry.kind == "collision")


def thin_meshes(context: Context) -> Iterator[Found]:
    """Yield meshes to collide with that enclose next to nothing, as flat ones do."""
    for name in _collision_files(context):
        known = context.once(all_facts).get(name.uri)
        for use in name.uses if known is not None and known.problem is None else ():
            scale = use.geometry.scale.or_default(1.0, 1.0, 1.0)
            if use.geometry.kind != "collision" or known is None or scale is None:
                continue
            whole = name.path is None or name.path.suffix.lower() != ".obj"
            if whole and known.closed and abs(known.volume * prod(scale)) > _SURELY * _LEAST:
                continue
            weight = of_mesh(context, use.geometry)
            if weight is not None and weight.mass < WATER * _LEAST:
                yield used(use, name.uri)


def _collision_files(context: Context) -> Iterator[MeshName]:
    return (name for name in context.once(mesh_names).values() if not name.is_seen_only)
