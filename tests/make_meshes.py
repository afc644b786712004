"""Write every mesh of robots/meshes: `python tests/make_meshes.py [FOLDER]`, by default into robots/meshes itself."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from helpers.mesh_samples import Floats, binary_stl, box, corners, flipped, moved

Outline = Sequence[tuple[float, float]]
FOLDER = Path(__file__).parent.parent / "robots" / "meshes"


def bracket() -> Floats:
    """An angle bracket in millimetres: a leg of 60 x 5 and one of 5 x 40, 30 wide. Volume 300 + 175, times 30, mm^3."""
    outline = [(0, 0), (60, 0), (60, 5), (5, 5), (5, 40), (0, 40)]
    cut = [(0, 1, 2), (0, 2, 3), (0, 3, 5), (3, 4, 5)]
    n = len(outline)
    points = [(x, y, z) for y in (-15.0, 15.0) for x, z in outline]
    far = [(a + n, b + n, c + n) for a, b, c in cut]
    near = [(c, b, a) for a, b, c in cut]
    sides = [face for k in range(n) for face in _side(k, (k + 1) % n, n)]
    return flipped(corners(points, [*near, *far, *sides]))


def hollow_box() -> Floats:
    """A box of 0.1 x 0.08 x 0.06 m with walls of 0.01 m: the cavity is a shell of its own, wound inwards."""
    return np.concatenate((box((0.1, 0.08, 0.06)), flipped(box((0.08, 0.06, 0.04)))))


def open_tray() -> Floats:
    """A sheet folded to a tray of 0.2 x 0.1 x 0.05 m without a lid: not closed."""
    tray = box((0.2, 0.1, 0.05))
    return moved(tray[(tray[:, :, 2] < 0.025).any(axis=1)], (0, 0, 0.025))


def cross() -> Floats:
    """Two bars of 0.2 x 0.04 x 0.04 m through each other, two shells that share a cube of 0.04 m."""
    return np.concatenate((box((0.2, 0.04, 0.04)), box((0.04, 0.2, 0.04))))


def twisted_block() -> Floats:
    """A block of 0.12 x 0.06 x 0.04 m, five of its twelve triangles wound the wrong way."""
    block = box((0.12, 0.06, 0.04))
    return np.concatenate((flipped(block[:5]), block[5:]))


def torn_block() -> Floats:
    """A block of 0.12 x 0.06 x 0.04 m without one of its twelve triangles."""
    return box((0.12, 0.06, 0.04))[1:]


def hub() -> Floats:
    """A prism on an octagon, in millimetres, 40 high: turned by quarters and mirrored it is the same."""
    return _prism(_OCTAGON)


def worn_pad() -> Floats:
    """80 x 60 x 40 mm, in millimetres, one upright edge broken by 3: nearly symmetric, not its own mirror image."""
    return _prism([(40, -30), (40, 27), (37, 30), (-40, 30), (-40, -30)])


_OCTAGON = [(30, 12), (12, 30), (-12, 30), (-30, 12), (-30, -12), (-12, -30), (12, -30), (30, -12)]


def _prism(outline: Outline) -> Floats:
    """Between z = 0 and z = 40, on a convex outline that turns to the left."""
    n = len(outline)
    points = [(x, y, z) for z in (0.0, 40.0) for x, y in outline]
    lid = [(n, n + k, n + k + 1) for k in range(1, n - 1)]
    floor = [(0, k + 1, k) for k in range(1, n - 1)]
    sides = [face for k in range(n) for face in _side(k, (k + 1) % n, n)]
    return corners(points, [*lid, *floor, *sides])


def _side(a: int, b: int, n: int) -> list[tuple[int, int, int]]:
    return [(a, b, b + n), (a, b + n, a + n)]


MESHES: dict[str, Callable[[], Floats]] = {
    "bracket.stl": bracket,
    "cross.stl": cross,
    "hollow_box.stl": hollow_box,
    "hub.stl": hub,
    "open_tray.stl": open_tray,
    "torn_block.stl": torn_block,
    "twisted_block.stl": twisted_block,
    "worn_pad.stl": worn_pad,
}


def content(name: str) -> bytes:
    """The bytes of a mesh: binary STL."""
    return binary_stl(MESHES[name](), header=f"robodyn: {name.removesuffix('.stl').replace('_', ' ')}".encode())


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    for name in MESHES:
        (folder / name).write_bytes(content(name))
