"""The outermost points of a mesh: what of it counts where programs take its convex hull."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robodyn.checks.meshes.facts import Shelf
from robodyn.errors import MeshError
from robodyn.support.floats import Floats


def spread_out(count: int) -> Floats:
    """Return (count, 3) directions that are spread evenly: points of a spiral around the sphere (Fibonacci)."""
    k = np.arange(count) + 0.5
    z, turn = 1.0 - 2.0 * k / count, np.pi * (1.0 + 5.0**0.5) * k
    across = np.sqrt(1.0 - z * z)
    return np.stack((across * np.cos(turn), across * np.sin(turn), z), axis=1)


_DIRECTIONS = spread_out(240)


def extremes(path: Path, digest: str) -> Floats | None:
    """Return (k, 3) the points of a mesh that lie farthest in 240 directions, in metres before any scale of the URDF;
    None where it cannot be read.

    Args:
        digest: of the file's content, by which they are kept; empty keeps nothing.

    Accuracy: their hull lies in the mesh's; of a smooth body of size d it falls short of that by about d / 240.
    """
    shelf = Shelf(digest, f"{path.suffix.lower()} extremes")
    data = shelf.get()
    if data is not None:
        return np.frombuffer(data).reshape(-1, 3)
    from robodyn.solids.mesh.read.load import load_triangles

    best, farthest = np.zeros((len(_DIRECTIONS), 3)), np.full(len(_DIRECTIONS), -np.inf)
    try:
        triangles = load_triangles(path)
        for block in triangles.blocks():
            _farther(np.asarray(block, float).reshape(-1, 3), best, farthest)
    except MeshError:
        return None
    points = np.unique(best * triangles.scale, axis=0)
    shelf.put(points.tobytes())
    return points


def _farther(points: Floats, best: Floats, farthest: Floats) -> None:
    """Put the points that lie farther than the best so far in their place.

    Method: d . x in order, one direction after the other over coordinates that stay in the processor's cache.
    """
    x, y, z = points.T.copy()
    reach, term = np.empty_like(x), np.empty_like(x)
    for k, (along_x, along_y, along_z) in enumerate(_DIRECTIONS.tolist()):
        np.multiply(x, along_x, out=reach)
        reach += np.multiply(y, along_y, out=term)
        reach += np.multiply(z, along_z, out=term)
        most = int(reach.argmax())
        if reach[most] > farthest[k]:
            best[k], farthest[k] = points[most], reach[most]
