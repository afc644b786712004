"""Closed surfaces, and one shell, against edges and faces counted one by one."""

from __future__ import annotations

from collections import Counter, defaultdict

import numpy as np
import pytest
from helpers.mesh_oracle import rotation
from helpers.mesh_samples import box, corners, cylinder, flipped, moved, torus, uv_sphere
from hypothesis import given
from hypothesis import strategies as st

from robodyn.solids.mesh import closed
from robodyn.solids.mesh.closed import fingerprint, is_one_shell
from robodyn.solids.mesh.triangles import ROWS, MemoryTriangles


def printed(array):
    return fingerprint(MemoryTriangles("body", np.asarray(array)))


def counted(array):
    """Whether the boundary vanishes, and whether it does but for the winding, by counting edges."""
    directed, undirected = Counter(), Counter()
    for face in (np.asarray(array) + 0.0).tolist():
        a, b, c = map(tuple, face)
        for p, q in ((a, b), (b, c), (c, a)):
            if p != q:
                directed[p, q] += 1
                directed[q, p] -= 1
                undirected[frozenset((p, q))] += 1
    return not any(directed.values()), not any(n % 2 for n in undirected.values())


def agrees(array):
    found = printed(array)
    closed, even = counted(array)
    assert found.closed == (found.chain == 0) == closed
    assert (found.parity == 0) == even
    assert found.mixed == (even and not closed)
    return found


def one_shell(array):
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


A, B, C = box()[0]
BESIDE = box()
BESIDE[0, 0, 0] = np.nextafter(BESIDE[0, 0, 0], 1)
MINUS = np.where(box((2, 2, 2)) + 1.0 == 0, -0.0, box((2, 2, 2)) + 1.0)
SURFACES = {
    "box": (box(), "one shell"),
    "inwards": (flipped(torus()), "one shell"),
    "float32": (torus().astype(np.float32), "one shell"),
    "turned": (moved(uv_sphere(), (0.1, 0.2, 0.3), rotation(1)), "one shell"),
    "far away": (moved(box(), (1e8, 1e8, 1e8)), "one shell"),
    "several blocks": (cylinder(1, 1, ROWS // 3), "one shell"),
    "zeros of both signs": (np.where(np.arange(12)[:, None, None] % 2, MINUS, MINUS + 0.0), "one shell"),
    "any order": (np.random.default_rng(0).permutation(torus(2.0, 0.5, 40, 30)), "one shell"),
    "any first corner": (np.roll(torus(), 1, axis=1), "one shell"),
    "a sheet from both sides": (np.array([(A, B, C), (C, B, A)]), "one shell"),
    "two": (np.concatenate([box(), moved(box(), (3, 0, 0))]), "closed"),
    "cavity": (np.concatenate([box((3, 3, 3)), flipped(box())]), "closed"),
    "an edge of four faces": (np.concatenate([box(), moved(box(), (1, 1, 0))]), "closed"),
    "a corner of two": (np.concatenate([box(), moved(box(), (1, 1, 1))]), "closed"),
    "the same twice": (np.concatenate([box(), box()]), "closed"),
    "a wall": (np.concatenate([box(), box()[:1], flipped(box()[:1])]), "closed"),
    "a face without area": (np.concatenate([torus(), torus()[:1, [0, 0, 1]]]), "closed"),
    "two blocks of shells": (
        np.concatenate([moved(cylinder(1, 1, ROWS // 6), (0, 0, 3 * k)) for k in range(2)]),
        "closed",
    ),
    "split": (np.concatenate([box()[1:], [(A, (A + B) / 2, C), ((A + B) / 2, B, C)]]), "open"),
    "beside": (BESIDE, "open"),
    "a face twice": (np.concatenate([torus(), torus()[:1]]), "open"),
    "mixed": (np.where(np.arange(12)[:, None, None] % 5 == 3, flipped(box()), box()), "mixed"),
}


@pytest.mark.parametrize("name", SURFACES)
def test_surfaces_and_what_is_left_without_a_face(name):
    array, kind = SURFACES[name]
    found, left = agrees(array), agrees(array[1:])
    assert (found.closed, found.mixed) == (kind in ("closed", "one shell"), kind == "mixed")
    assert one_shell(array) == visited(array) == (kind in ("one shell", "mixed"))
    assert (left.closed, left.mixed) == (name == "a face twice", False)


def test_degenerate_faces_do_not_matter():
    a, b, _ = torus()[0]
    faces = np.array([(a, a, a), (a, a, b), (a, b, a), (b, a, a)])
    assert printed(np.concatenate([torus(), faces])) == printed(torus())
    assert printed(np.concatenate([torus()[1:], faces])) == printed(torus()[1:])


points = st.lists(st.tuples(*[st.integers(-2, 2)] * 3), min_size=5, max_size=9, unique=True)


@given(points, st.data())
def test_glued_tetrahedra(places, data):
    four = st.permutations(range(len(places))).map(lambda order: order[:4])
    solids = data.draw(st.lists(four, min_size=1, max_size=5))
    parts = [corners(places, [(a, c, b), (a, b, d), (a, d, c), (b, c, d)]) for a, b, c, d in solids]
    whole = np.concatenate(parts) * 0.1
    assert agrees(whole).closed
    dropped = data.draw(st.lists(st.integers(0, len(whole) - 1), max_size=3))
    turned = data.draw(st.lists(st.integers(0, len(whole) - 1), max_size=3))
    whole[turned] = flipped(whole[turned])
    left = np.delete(whole, dropped, axis=0)
    agrees(left)
    for array in (whole, left):
        assert one_shell(array) == visited(array)


def test_edges_with_a_hash_in_common_are_told_apart(monkeypatch):
    """Hashes of 33 bits, of which strips leave some 20."""
    body, sides_of, exact = torus(2.0, 0.5, 40, 30), closed._sides, closed._two_on_each
    asked = []
    monkeypatch.setattr(closed, "_sides", lambda mesh: (sides_of(mesh)[0] >> np.uint64(30), sides_of(mesh)[1]))
    monkeypatch.setattr(closed, "_two_on_each", lambda sides: asked.append(len(sides)) or exact(sides))
    rng = np.random.default_rng(5)
    assert one_shell(rng.permutation(body))
    assert asked
    for other in (moved(body, (9, 0, 0)), body[:2], body):
        assert not one_shell(rng.permutation(np.concatenate([body, other])))
    assert not one_shell(rng.permutation(body)[1:])
