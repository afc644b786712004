"""Whether a surface is one shell, against edges that are counted and faces that are visited one by one."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import pytest
from helpers.mesh_samples import box, corners, cylinder, flipped, moved, sheet, tetrahedron, torus, uv_sphere
from helpers.sampled import sampled
from hypothesis import given
from hypothesis import strategies as st

from robodyn.solids.mesh import closed
from robodyn.solids.mesh.closed import is_one_shell
from robodyn.solids.mesh.triangles import ROWS, IndexedTriangles, MemoryTriangles


def found(array):
    return is_one_shell(MemoryTriangles("body", np.asarray(array)))


def visited(array):
    """Two faces on every edge, and all of them reached from the first over edges."""
    faces_on = defaultdict(list)
    faces = [[tuple(corner) for corner in face] for face in (np.asarray(array) + 0.0).tolist()]
    for number, (a, b, c) in enumerate(faces):
        for edge in ((a, b), (b, c), (c, a)):
            faces_on[frozenset(edge)].append(number)
    waiting, seen = [0], {0}
    while waiting:
        a, b, c = faces[waiting.pop()]
        for edge in ((a, b), (b, c), (c, a)):
            new = set(faces_on[frozenset(edge)]) - seen
            seen |= new
            waiting.extend(new)
    two = all(len(edge) == 2 and len(numbers) == 2 for edge, numbers in faces_on.items())
    return two and len(seen) == len(faces)


ONE = {
    "box": box(),
    "tetrahedron": tetrahedron(),
    "torus": torus(),
    "sphere": uv_sphere(),
    "inwards": flipped(torus()),
    "float32": torus().astype(np.float32),
    "several blocks": cylinder(1, 1, ROWS),
    "any order": np.random.default_rng(0).permutation(torus(2.0, 0.5, 80, 60)),
    "any first corner": np.roll(torus(), 1, axis=1),
    "a sheet from both sides": np.concatenate([sheet(), flipped(sheet()[:, [1, 2, 0]])])[[0, 2]],
}
OTHER = {
    "two": np.concatenate([box(), moved(box(), (3, 0, 0))]),
    "many": np.concatenate([moved(box(), (2 * k, 0, 0)) for k in range(ROWS // 12 + 5)]),
    "cavity": np.concatenate([box((3, 3, 3)), flipped(box())]),
    "an edge of four faces": np.concatenate([box(), moved(box(), (1, 1, 0))]),
    "a corner of two": np.concatenate([box(), moved(box(), (1, 1, 1))]),
    "the same twice": np.concatenate([box(), box()]),
    "a wall": np.concatenate([box(), box()[:1], flipped(box()[:1])]),
    "open": torus()[1:],
    "a face without area": np.concatenate([torus(), torus()[:1, [0, 0, 1]]]),
    "a point": np.concatenate([torus(), np.repeat(torus()[:1, :1], 3, axis=1)]),
    "two blocks of shells": np.concatenate([cylinder(1, 1, ROWS), moved(cylinder(1, 1, ROWS), (0, 0, 3))]),
}


@pytest.mark.parametrize("body", sampled(ONE, 3))
def test_one_shell(body):
    assert visited(ONE[body])
    assert found(ONE[body])


@pytest.mark.parametrize("body", OTHER)
def test_not_one_shell(body):
    assert not visited(OTHER[body])
    assert not found(OTHER[body])


def test_minus_zero_is_zero():
    array = box((2, 2, 2)) + 1.0
    array[::2][array[::2] == 0] = -0.0
    assert found(array)


def test_faces_of_numbered_vertices():
    points, faces = np.unique(torus().reshape(-1, 3), axis=0, return_inverse=True)
    assert is_one_shell(IndexedTriangles("body", points, faces.reshape(-1, 3)))


points = st.lists(st.tuples(*[st.integers(-2, 2)] * 3), min_size=5, max_size=9, unique=True)


@given(points, st.data())
def test_glued_tetrahedra(places, data):
    four = st.permutations(range(len(places))).map(lambda order: order[:4])
    solids = data.draw(st.lists(four, min_size=1, max_size=4))
    parts = [corners(places, [(a, c, b), (a, b, d), (a, d, c), (b, c, d)]) for a, b, c, d in solids]
    whole = np.concatenate(parts) * 0.1
    dropped = data.draw(st.lists(st.integers(0, len(whole) - 1), max_size=2))
    for array in (whole, np.delete(whole, dropped, axis=0)):
        assert found(array) == visited(array)


def test_edges_with_a_hash_in_common_are_told_apart(monkeypatch):
    """Hashes of 33 bits, of which strips leave some 20."""
    body, sides_of, exact = torus(2.0, 0.5, 40, 30), closed._sides, closed._two_on_each
    asked = []
    monkeypatch.setattr(closed, "_sides", lambda mesh: (sides_of(mesh)[0] >> np.uint64(30), sides_of(mesh)[1]))
    monkeypatch.setattr(closed, "_two_on_each", lambda sides: asked.append(len(sides)) or exact(sides))
    rng = np.random.default_rng(5)
    assert found(rng.permutation(body))
    assert asked
    for other in (moved(body, (9, 0, 0)), body[:2], body):
        assert not found(rng.permutation(np.concatenate([body, other])))
    assert not found(rng.permutation(body)[1:])
