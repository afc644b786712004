"""The fingerprint against what it stands for: directed edges, counted one by one."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from helpers.mesh_oracle import rational_moments_from, rotation
from helpers.mesh_samples import box, corners, cylinder, flipped, moved, sheet, torus, uv_sphere
from helpers.sampled import sampled
from hypothesis import given
from hypothesis import strategies as st

from robodyn.solids.mesh.closed import fingerprint
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


CLOSED = {
    "box": box(),
    "torus": torus(),
    "sphere": moved(uv_sphere(), (0.1, 0.2, 0.3), rotation(1)),
    "flipped": flipped(torus()),
    "cavity": np.concatenate([box((3, 3, 3)), flipped(box())]),
    "an edge of four faces": np.concatenate([box(), moved(box(), (1, 1, 0))]),
    "a corner of two": np.concatenate([box(), moved(box(), (1, 1, 1))]),
    "the same twice": np.concatenate([box(), box()]),
    "nothing left": np.concatenate([sheet(), flipped(sheet())]),
    "float32": uv_sphere().astype(np.float32),
    "far away": moved(box(), (1e8, 1e8, 1e8)),
    "several blocks": cylinder(1, 1, ROWS),
}


@pytest.mark.parametrize("body", sampled(CLOSED, 3))
def test_closed(body):
    assert agrees(CLOSED[body]).closed


@pytest.mark.parametrize("body", CLOSED)
def test_open_by_one_triangle(body):
    found = agrees(CLOSED[body][1:])
    assert not found.closed
    assert not found.mixed


@pytest.mark.parametrize("body", ["box", "torus", "sphere", "cavity", "several blocks"])
def test_mixed_winding(body):
    array = CLOSED[body].copy()
    array[3::5] = flipped(array[3::5])
    found = agrees(array)
    assert found.mixed
    assert not found.closed


def test_open_and_mixed_is_open():
    array = np.concatenate([flipped(torus()[:5]), torus()[5:-1]])
    assert not agrees(array).mixed


def test_a_duplicate_face_opens_the_boundary():
    assert not agrees(np.concatenate([torus(), torus()[:1]])).closed


def test_a_corner_in_the_middle_of_an_edge_opens_the_boundary():
    whole = box()
    a, b, c = whole[0]
    halves = np.array([(a, (a + b) / 2, c), ((a + b) / 2, b, c)])
    assert not agrees(np.concatenate([whole[1:], halves])).closed


def test_degenerate_faces_do_not_matter():
    a, b, _ = torus()[0]
    faces = np.array([(a, a, a), (a, a, b), (a, b, a), (b, a, a)])
    assert printed(np.concatenate([torus(), faces])) == printed(torus())
    assert printed(np.concatenate([torus()[1:], faces])) == printed(torus()[1:])


def test_minus_zero_is_zero():
    array = box((2, 2, 2)) + 1.0
    array[array == 0] = 0.0
    array[::2][array[::2] == 0] = -0.0
    assert np.signbit(array[array == 0]).any()
    assert agrees(array).closed


def test_neighbouring_floats_are_not_the_same_corner():
    array = box()
    array[0, 0, 0] = np.nextafter(array[0, 0, 0], 1)
    assert not agrees(array).closed


def test_order_does_not_matter():
    rng = np.random.default_rng(2)
    array = np.delete(torus(), [5, 77], axis=0)
    turned = np.roll(rng.permutation(array), 1, axis=1)
    assert printed(turned) == printed(array)


def test_reversed_winding_negates_the_chain():
    array = torus()[1:]
    here, there = printed(array), printed(flipped(array))
    assert (here.chain + there.chain) % 2**64 == 0
    assert here.parity == there.parity


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_every_triangle_of_a_grid_has_a_fingerprint_of_its_own(kind):
    lines = np.arange(40, dtype=kind)
    points = np.stack(np.meshgrid(lines, lines, lines[:2], indexing="ij"), axis=-1)
    i, j = np.indices((39, 39)).reshape(2, -1)
    faces = [points[i, j, 0], points[i + 1, j, 0], points[i, j + 1, 1]]
    prints = [printed(face[None]) for face in np.stack(faces, axis=1)]
    assert len({found.chain for found in prints}) == len(prints)
    assert len({found.parity for found in prints}) == len(prints)
    ones = np.mean([[found.chain >> k & 1 for k in range(64)] for found in prints], axis=0)
    expected = np.array([3 / 8, *[1 / 2] * 63])  # the lowest bits of the differences of three hashes add up to zero
    assert np.abs(ones - expected).max() <= 2.5 / np.sqrt(len(prints))


points = st.lists(st.tuples(*[st.integers(-2, 2)] * 3), min_size=5, max_size=9, unique=True)


@given(points, st.data())
def test_glued_tetrahedra(places, data):
    four = st.permutations(range(len(places))).map(lambda order: order[:4])
    solids = data.draw(st.lists(four, min_size=1, max_size=8))
    parts = [corners(places, [(a, c, b), (a, b, d), (a, d, c), (b, c, d)]) for a, b, c, d in solids]
    whole = np.concatenate(parts) * 0.1
    assert agrees(whole).closed
    dropped = data.draw(st.lists(st.integers(0, len(whole) - 1), max_size=3))
    turned = data.draw(st.lists(st.integers(0, len(whole) - 1), max_size=3))
    whole[turned] = flipped(whole[turned])
    agrees(np.delete(whole, dropped, axis=0))


@given(points, st.data())
def test_closed_is_when_the_integral_does_not_depend_on_the_origin(places, data):
    index = st.integers(0, len(places) - 1)
    faces = data.draw(st.lists(st.tuples(index, index, index), min_size=1, max_size=4))
    closing = data.draw(st.booleans())
    lids = [(0, b, a) for face in faces for a, b in zip(face, (*face[1:], face[0]), strict=True)]
    array = corners(places, faces + lids * closing)
    here, there = (rational_moments_from(apex, array) for apex in ((0, 0, 0), (1, 2, 4)))
    moved_there = here[0] * np.array((1, 2, 4))
    independent = here[0] == there[0] and (here[1] - moved_there == there[1]).all()
    assert independent or not printed(array).closed


@given(st.lists(st.floats(0.1, 2.0), min_size=3, max_size=20), st.floats(0.01, 10.0), st.integers(0, 99))
def test_extruded_polygons(radii, height, seed):
    angle = 2 * np.pi * np.arange(len(radii)) / len(radii)
    ring = np.stack([radii * np.cos(angle), radii * np.sin(angle), 0 * angle], axis=1)
    n, k = len(ring), np.arange(len(ring))
    places = np.concatenate([ring, ring + np.array((0, 0, height)), [(0, 0, 0), (0, 0, height)]])
    after = np.roll(k, -1)
    sides = [
        (k, after, after + n),
        (k, after + n, k + n),
        (after, k, 2 * n + 0 * k),
        (k + n, after + n, 2 * n + 1 + 0 * k),
    ]
    body = moved(corners(places, np.concatenate([np.stack(side, axis=1) for side in sides])), R=rotation(seed))
    assert agrees(body).closed
    assert not agrees(body[1:]).closed
