"""What must not matter to an integral, what must; how often a mesh is read, what a pass finds; stretched meshes."""

from __future__ import annotations

import re
import tracemalloc
from functools import partial

import numpy as np
import pytest
from helpers import mesh_samples
from helpers.mesh_oracle import deviation, rational_moments, rotation
from helpers.mesh_samples import binary_stl, box, cylinder, flipped, moved, sheet, torus

from robodyn.errors import MeshError
from robodyn.solids.mass_properties import mass_properties
from robodyn.solids.mesh.asymmetry import TriangleSet, mirror
from robodyn.solids.mesh.integrals import integrate, measure, surface
from robodyn.solids.mesh.read.load import load_triangles
from robodyn.solids.mesh.triangles import BLOCK, ROWS, MemoryTriangles, scaled

EPS = np.finfo(float).eps
BODY = moved(torus(2.0, 0.5, 60, 40), (0.3, 0.2, 0.1), rotation(1))


class Counted:
    """Triangles that count how often they are read."""

    scale = 1.0

    def __init__(self, array):
        self._kept = MemoryTriangles("counted", array)
        self.name, self.count, self.reads = "counted", len(array), 0

    def blocks(self, rows=BLOCK):
        self.reads += 1
        return self._kept.blocks(rows)

    records = blocks


def integrals(array, exactly=False):
    return integrate(MemoryTriangles("body", array), exactly)


def test_winding_inwards_changes_the_sign_of_everything():
    outwards, inwards = integrals(BODY), integrals(flipped(BODY))
    assert inwards.volume == pytest.approx(-outwards.volume, rel=4 * EPS)
    assert np.abs(inwards.S + outwards.S).max() <= 4 * EPS * np.abs(outwards.S).max()
    assert inwards.area == pytest.approx(outwards.area, rel=4 * EPS)
    assert inwards.bound <= 1e-13


@pytest.mark.parametrize(("count", "spare"), [(ROWS, 0), (ROWS - 4, 1), (ROWS + 4, 1)])
def test_the_edge_of_a_block(count, spare):
    array = np.concatenate([cylinder(0.7, 1.1, count // 4), np.zeros((spare, 3, 3))])
    found = integrals(array)
    V, _, S = rational_moments(array, found.reference)
    assert found.count == len(array) == count + spare
    assert deviation(found.volume, V) <= 4 * EPS
    assert deviation(found.S, S) <= 4 * EPS


def test_a_mesh_is_read_once_and_again_for_finer_arithmetic():
    mesh, plate = Counted(BODY), Counted(moved(box((1, 1, 1e-6)), R=rotation(3)))
    measure(mesh)
    integrate(mesh)
    assert mesh.reads == 2
    assert integrate(plate).method == "rational"
    assert plate.reads >= 3


def test_an_open_surface_is_not_worth_finer_arithmetic():
    flat = MemoryTriangles("body", sheet())
    found, edges = measure(flat)
    assert not edges.closed
    assert (found.method, found.bound) == ("float64", np.inf)
    assert measure(flat, exact=True)[0].method == integrate(flat).method == "rational"


def test_shells_that_cancel_have_exactly_no_volume():
    found = integrals(np.concatenate([BODY, flipped(BODY)]))
    assert found.volume == 0
    assert not found.S.any()
    assert found.area == pytest.approx(2 * integrals(BODY).area, rel=4 * EPS)


@pytest.mark.parametrize(("size", "how"), [(1e70, "large"), (1e200, "large"), (1e-70, "small"), (1e-200, "small")])
def test_beyond_the_range_of_floats(size, how):
    for use in (integrals, partial(integrals, exactly=True), lambda array: surface(MemoryTriangles("body", array))):
        with pytest.raises(MeshError, match=re.escape(f"body: is too {how}")):
            use(box((size, size, size)))


def test_no_triangles():
    with pytest.raises(MeshError, match="body: has no triangles"):
        integrals(np.zeros((0, 3, 3)))


@pytest.mark.parametrize(("value", "face"), [(np.nan, 0), (np.inf, ROWS - 1), (-np.inf, ROWS + 5)])
@pytest.mark.parametrize("use", [integrate, measure])
def test_a_corner_of_a_streamed_file_that_is_not_finite_names_its_face(use, face, value):
    corners = cylinder(1, 1, ROWS).astype(np.float32)
    corners[face, 1, 2] = value
    with pytest.raises(MeshError, match=rf"face {face + 1} has a corner at \(.*{value:g}\)"):
        use(load_triangles(binary_stl(corners)))


def test_above_a_limit_neither_is_sought_though_asked(monkeypatch):
    body = torus()
    found = mass_properties(body, symmetry=True, tessellation=True)
    assert found.symmetry is not None
    assert found.tessellation is not None
    monkeypatch.setenv("ROBODYN_LIMITS", f"mesh_shape={len(body) - 1}")
    found = mass_properties(body, symmetry=True, tessellation=True)
    assert found.symmetry is None
    assert found.tessellation is None
    assert [note.partition(",")[0] for note in found.notes] == [
        "symmetry: not sought above 1023 triangles",
        "tessellation: not sought above 1023 triangles",
    ]
    assert found.body.volume > 0
    with pytest.raises(MeshError, match="ROBODYN_LIMITS=mesh_shape=NUMBER"):
        mass_properties(body, symmetrize=True)


def test_triangles_are_compared_in_blocks():
    corners = torus(rings=512, sectors=256)
    tracemalloc.start()
    same = TriangleSet(corners, 2.5)
    assert same.invariant(np.diag((-1.0, -1.0, 1.0)))
    assert not same.invariant(mirror(np.array((0.6, 0.8, 0.0))))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < corners.nbytes


WEDGE = mesh_samples.tetrahedron()


def memory(corners=WEDGE):
    return MemoryTriangles("wedge", corners)


@pytest.mark.parametrize("factors", [(0.5, 2, 4), (1, -1, 1), (-1, -1, 3), (-2, -2, -2)])
def test_moments_are_those_of_the_stretched_body(factors):
    """V' = |det A| V, c' = A c, S' = |det A| A S A for A = diag(factors), mirror images included."""
    A, det = np.diag(factors), abs(np.prod(factors))
    before = mass_properties(WEDGE, density=1).body
    part = mass_properties(WEDGE, density=1, scale=factors)
    assert (part.closed, part.repairs) == (True, ())
    assert part.body.volume == pytest.approx(det * before.volume, rel=8 * EPS)
    np.testing.assert_allclose(part.body.com, A @ before.com, rtol=8 * EPS)
    expected = det * A @ before.S_c @ A
    np.testing.assert_allclose(part.body.S_c, expected, rtol=0, atol=32 * EPS * np.abs(expected).max())
    corners = WEDGE * factors
    np.testing.assert_array_equal((part.lo, part.hi), (corners.min(axis=(0, 1)), corners.max(axis=(0, 1))))


@pytest.mark.parametrize("factors", [(0, 1, 1), (1, np.nan, 1), (1, 1, np.inf)])
def test_refused(factors):
    with pytest.raises(MeshError, match="leaves no volume"):
        scaled(memory(), factors)


def test_a_part_in_millimetres_is_not_doubted():
    assert mass_properties(100 * WEDGE, scale=(0.001,) * 3).warnings == ()
    assert len(mass_properties(100 * WEDGE).warnings) == 1
