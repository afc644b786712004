"""The visual shapes of a robot as triangles, for pictures: read by yourdfpy and trimesh."""

from __future__ import annotations

from dataclasses import dataclass
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.vectors import product
from robodyn.report.pictures.primitives import primitive
from robodyn.robot.urdf.parts import Description
from robodyn.support.libraries import library_messages

Floats = NDArray[np.float64]


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
    """The visual shapes of a robot; nothing is fetched from a network.

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
