"""Whether a surface is one shell, against edges that are counted and faces that are visited one by one."""

from __future__ import annotations

import tracemalloc
from collections import defaultdict

import numpy as np
import pytest
from helpers.mesh_samples import box, corners, cylinder, flipped, moved, sheet, tetrahedron, torus, uv_sphere
from helpers.sampled import sampled
from hypothesis import given
from hypothesis import strategies as st

from robodyn.solids.mesh import closed
from robodyn.solids.mesh.closed import is_one_shell
from robodyn.solids.mesh.triangles import BLOCK, ROWS, IndexedTriangles, MemoryTriangles


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


def test_memory_is_that_of_the_sides_held(monkeypatch):
    monkeypatch.setattr(closed, "HELD", 1 << 16)
    mesh = MemoryTriangles("body", torus(2.0, 0.5, 500, 100).astype(np.float32))
    tracemalloc.start()
    try:
        assert is_one_shell(mesh)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 3 << 20 < 3 * 8 * len(mesh.corners) * 1.5


class Counted(MemoryTriangles):
    """Triangles that count how often they are read."""

    reads: list[int]

    def records(self, rows=BLOCK):
        self.reads.append(rows)
        return super().records(rows)


def counted(array):
    mesh = Counted("body", array)
    object.__setattr__(mesh, "reads", [])
    return mesh


@pytest.mark.parametrize("body", [*ONE, *OTHER])
def test_parts_of_a_large_mesh(monkeypatch, body):
    array = {**ONE, **OTHER}[body]
    mesh = counted(array)
    monkeypatch.setattr(closed, "HELD", max(len(array) // 2, 6))
    assert is_one_shell(mesh) == (body in ONE)
    assert len(mesh.reads) > 1 or body in OTHER


def test_a_mesh_that_fits_is_read_once():
    mesh = counted(torus())
    assert is_one_shell(mesh)
    assert len(mesh.reads) == 1


def test_a_mesh_without_strips_is_read_again():
    mesh = counted(np.random.default_rng(3).permutation(torus(2.0, 0.5, 120, 80)))
    assert is_one_shell(mesh)
    assert len(mesh.reads) == 2


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


SCARCE = 44
"""Bits for strips that leave so few for hashes that some edges share theirs."""


@pytest.mark.parametrize("held", [closed.HELD, 2000])
def test_edges_with_a_hash_in_common_are_told_apart(monkeypatch, held):
    monkeypatch.setattr(closed, "HELD", held)
    body = torus(2.0, 0.5, 40, 30)
    mesh = counted(np.random.default_rng(5).permutation(body))
    split = (3 * len(body) // held).bit_length()
    assert closed._is_linked(mesh, SCARCE) is True
    assert len(mesh.reads) == 2 << split
    pair = np.concatenate([body, moved(body, (9, 0, 0))])
    for other in (pair, body[1:], np.concatenate([body, body[:2]]), np.concatenate([body, body])):
        assert not closed._is_linked(MemoryTriangles("body", np.random.default_rng(5).permutation(other)), SCARCE)
