"""The visual shapes of a robot as triangles, for pictures; meshes are read by yourdfpy and trimesh."""

from __future__ import annotations

from dataclasses import dataclass
from io import BytesIO
from typing import Any

import numpy as np

from robodyn.programs.vectors import product, rotation_from_rpy
from robodyn.robot.urdf.parts import Description, Geometry
from robodyn.support.floats import Floats
from robodyn.support.libraries import library_messages

_AROUND, _ALONG = 32, 12
"""Corners of a circle, and of a quarter and a half circle along the axis."""


@dataclass(frozen=True, eq=False)
class Visuals:
    """What a robot looks like.

    Attributes:
        triangles: (m, 3, 3) of each link that has some, in its frame [m].
        missing: names of meshes without a file, or that cannot be read.
    """

    triangles: dict[str, Floats]
    missing: tuple[str, ...]


def visuals(description: Description) -> Visuals:
    """Return the visual shapes of a robot; nothing is fetched from a network.

    yourdfpy and trimesh, which take half a second to be imported, are not needed where no mesh is named.

    Raises:
        Exception: whatever yourdfpy and trimesh raise on what they cannot read.
    """
    named = [(link.name, each) for link in description.links for each in link.geometries]
    shapes = [(link, each) for link, each in named if each.kind == "visual"]
    if all(each.filename is None for _, each in shapes):
        found: dict[str, list[Floats]] = {}
        for link, each in shapes:
            found.setdefault(link, []).append(primitive(each))
        return Visuals({link: np.concatenate(parts) for link, parts in found.items()}, ())
    return _of_meshes(description)


def _of_meshes(description: Description) -> Visuals:
    import yourdfpy

    missing = list[str]()

    def path_of(fname: str) -> str:
        path = description.search.find(fname)
        if path is None:
            missing.append(fname)
        return "" if path is None else str(path)

    with library_messages("yourdfpy", "trimesh"):
        scene: Any = yourdfpy.URDF.load(BytesIO(description.data), filename_handler=path_of).scene
        placed: dict[str, list[Floats]] = {}
        for node in scene.graph.nodes_geometry:
            matrix, name = scene.graph.get(node)
            geometry = scene.geometry[name]
            if getattr(geometry, "faces", None) is not None and len(geometry.faces):
                link = scene.graph.transforms.parents[node]
                local = product(np.linalg.inv(scene.graph.get(link)[0]), matrix)
                corners = product(np.asarray(geometry.vertices, dtype=np.float64), local[:3, :3].T) + local[:3, 3]
                placed.setdefault(link, []).append(corners[np.asarray(geometry.faces)])
    return Visuals({link: np.concatenate(parts) for link, parts in placed.items()}, tuple(dict.fromkeys(missing)))


def primitive(geometry: Geometry) -> Floats:
    """Return the surface of a shape that is no mesh, (m, 3, 3) in its link's frame [m]."""
    R, p = rotation_from_rpy(*geometry.origin.rpy), np.array(geometry.origin.xyz)
    own = _box(geometry.size) if geometry.shape == "box" else _turned(_profile(geometry.shape, geometry.size))
    found: Floats = product(own, R.T) + p
    return found


def _box(size: tuple[float, ...]) -> Floats:
    faces = []
    for k in range(3):
        for side in (-1.0, 1.0):
            u, v = side * np.eye(3)[(k + 1) % 3], np.eye(3)[(k + 2) % 3]
            a, b, c, d = (side * np.eye(3)[k] + s * u + t * v for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1)))
            faces += [(a, b, c), (a, c, d)]
    found: Floats = np.array(faces) * np.array(size) / 2
    return found


def _profile(shape: str, size: tuple[float, ...]) -> Floats:
    """Return (k, 2) radius and height of a surface of revolution about z, from its bottom to its top."""
    radius = size[0]
    if shape == "cylinder":
        half = size[1] / 2
        return np.array(((0.0, -half), (radius, -half), (radius, half), (0.0, half)))
    turn = np.linspace(0.0, np.pi / 2, _ALONG)
    cap = radius * np.column_stack((np.cos(turn), np.sin(turn)))
    up = np.array((0.0, size[1] / 2 if shape == "capsule" else 0.0))
    return np.concatenate((cap[::-1] * (1, -1) - up, cap + up))


def _turned(profile: Floats) -> Floats:
    """Return the surface that a profile sweeps."""
    turn = np.linspace(0.0, 2 * np.pi, _AROUND + 1)
    rings = np.stack([np.column_stack((r * np.cos(turn), r * np.sin(turn), np.full_like(turn, z))) for r, z in profile])
    a, b, c, d = rings[:-1, :-1], rings[:-1, 1:], rings[1:, 1:], rings[1:, :-1]
    quads = (np.stack((a, b, c), axis=2), np.stack((a, c, d), axis=2))
    return np.concatenate([each.reshape(-1, 3, 3) for each in quads])
