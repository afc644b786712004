"""What must not matter to an integral, what must, and how often a mesh is read for it."""

from __future__ import annotations

import re

import numpy as np
import pytest
from helpers.mesh_oracle import deviation, exact, rational_moments, rotation
from helpers.mesh_samples import box, cylinder, flipped, moved, sheet, torus
from helpers.sampled import sampled

from robodyn.errors import MeshError
from robodyn.solids.mesh.closed import fingerprint
from robodyn.solids.mesh.integrals import integrate, measure
from robodyn.solids.mesh.triangles import BLOCK, ROWS, MemoryTriangles, reference_in

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


def same(found, expected, k=8):
    """Volume, centre and second moments about the centre agree normwise."""
    for a, b in zip(about_centre(found), about_centre(expected), strict=True):
        assert np.abs(a - b).max() <= k * EPS * np.abs(b).max()


def about_centre(found):
    offset = found.first / found.volume
    return found.volume, found.reference + offset, found.S - found.volume * np.outer(offset, offset)


def test_winding_inwards_changes_the_sign_of_everything():
    outwards, inwards = integrals(BODY), integrals(flipped(BODY))
    assert inwards.volume == pytest.approx(-outwards.volume, rel=4 * EPS)
    assert np.abs(inwards.S + outwards.S).max() <= 4 * EPS * np.abs(outwards.S).max()
    assert inwards.area == pytest.approx(outwards.area, rel=4 * EPS)
    assert inwards.bound <= 1e-13


def test_order_of_triangles_and_first_corner_do_not_matter():
    rng = np.random.default_rng(4)
    turns = rng.integers(0, 3, len(BODY))
    shuffled = np.stack([np.roll(face, shift, axis=0) for face, shift in zip(BODY, turns, strict=True)])
    same(integrals(rng.permutation(shuffled)), integrals(BODY))


def test_triangles_without_area_add_nothing():
    corner, edge = np.repeat(BODY[:9, :1], 3, axis=1), BODY[:9][:, [0, 1, 0]]
    line = np.stack([BODY[0, 0] * (1 - t) + BODY[0, 1] * t for t in (0, 0.5, 1)])[None]
    found = integrals(np.concatenate([corner, edge, BODY, line]))
    same(found, integrals(BODY))
    assert found.area == pytest.approx(integrals(BODY).area, rel=8 * EPS)


@pytest.mark.parametrize("count", sampled([ROWS, ROWS - 4, ROWS + 4, 2 * ROWS], 2))
@pytest.mark.parametrize("spare", [0, 1])
def test_the_edge_of_a_block(count, spare):
    array = np.concatenate([cylinder(0.7, 1.1, count // 4), np.zeros((spare, 3, 3))])
    found = integrals(array)
    V, _, S = rational_moments(array, found.reference)
    assert found.count == len(array) == count + spare
    assert deviation(found.volume, V) <= 4 * EPS
    assert deviation(found.S, S) <= 4 * EPS


@pytest.mark.parametrize("layout", ["float32", "columns", "reversed", "every second"])
def test_layout_of_the_corners_does_not_matter(layout):
    whole = BODY.astype(np.float32)
    array = {
        "float32": whole,
        "columns": np.ascontiguousarray(whole.transpose(1, 2, 0)).transpose(2, 0, 1),
        "reversed": whole[::-1].copy()[::-1],
        "every second": np.repeat(whole, 2, axis=0)[::2],
    }[layout]
    found, expected = integrals(array), integrals(whole.astype(np.float64))
    assert (found.volume, found.area) == (expected.volume, expected.area)
    assert (found.S == expected.S).all()


def test_box_and_reference():
    found = integrals(moved(box((2, 4, 6)), (10, 20, 30)))
    assert (found.lo == (9, 18, 27)).all()
    assert (found.hi == (11, 22, 33)).all()
    assert (found.reference == (10, 20, 30)).all()
    assert found.area == 88.0


def test_the_box_is_that_of_all_blocks():
    array = np.concatenate([moved(box(), (x, 0, 0)) for x in np.linspace(-50, 50, ROWS // 4)])
    found = integrals(np.concatenate([array, array[:, :, [1, 0, 2]]]))
    assert (found.lo == (-50.5, -50.5, -0.5)).all()
    assert (found.hi == (50.5, 50.5, 0.5)).all()


@pytest.mark.parametrize("offset", sampled([0.3, 0, 77, 1e4], 4))
def test_subtracting_the_reference_from_float32_is_exact(offset):
    array = moved(BODY, (offset, -offset, 2 * offset), rotation(8)).astype(np.float32)
    reference = integrals(array).reference
    differences = array.astype(np.float64) - reference
    assert (exact(differences) == exact(array) - exact(reference)).all()


@pytest.mark.parametrize("offset", [1e-300, 1.0, 1e8, 1e300])
def test_the_reference_lies_inside_the_box(offset):
    rng = np.random.default_rng(3)
    for size in (0, 1e-9, 1):
        array = offset * (1 + size * rng.random((5, 3, 3)))
        reference = reference_in(array.transpose(1, 2, 0))
        assert (array.min(axis=(0, 1)) <= reference).all()
        assert (reference <= array.max(axis=(0, 1))).all()


def test_the_reference_has_few_bits_of_the_size():
    found = integrals(BODY)
    _, exponent = np.frexp(found.hi - found.lo)
    assert (np.ldexp(found.reference, 3 - exponent) % 1 == 0).all()


def test_a_mesh_is_read_once():
    mesh = Counted(BODY)
    measure(mesh)
    integrate(mesh)
    assert mesh.reads == 2


def test_finer_arithmetic_reads_it_again():
    plate = Counted(moved(box((1, 1, 1e-6)), R=rotation(3)))
    assert integrate(plate).method == "rational"
    assert plate.reads >= 3


class Reused(Counted):
    """Triangles whose blocks are all the same array."""

    def blocks(self, rows=BLOCK):
        buffer = np.empty((rows, 3, 3))
        for block in super().blocks(rows):
            buffer[: len(block)] = block
            yield buffer[: len(block)]


@pytest.mark.parametrize("exactly", [False, True])
def test_blocks_need_not_outlive_the_next(exactly):
    array = np.concatenate([BODY, np.tile(moved(box(), (2**20, 0, 0)), (ROWS // 12, 1, 1))])
    found, expected = integrate(Reused(array), exactly), integrals(array, exactly)
    assert found.volume == expected.volume
    assert (found.S == expected.S).all()
    assert (measure(Reused(array))[0].S == integrals(array).S).all()


def test_measure_is_integrate_and_fingerprint():
    mesh = MemoryTriangles("body", BODY)
    found, edges = measure(mesh)
    assert edges == fingerprint(mesh)
    assert (found.volume, found.S.tolist()) == (integrate(mesh).volume, integrate(mesh).S.tolist())


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


@pytest.mark.parametrize("exactly", [False, True])
@pytest.mark.parametrize(("size", "how"), [(1e70, "large"), (1e200, "large"), (1e-70, "small"), (1e-200, "small")])
def test_beyond_the_range_of_floats(size, how, exactly):
    with pytest.raises(MeshError, match=re.escape(f"body: is too {how}, {size:.3g} wide: ")):
        integrals(box((size, size, size)), exactly)


@pytest.mark.parametrize("size", [1e-60, 1e60])
def test_near_the_ends_of_the_range(size):
    found = integrals(box((size, size, size)))
    assert found.volume == pytest.approx(size**3, rel=4 * EPS)
    assert found.S[0, 0] == pytest.approx(size**5 / 12, rel=8 * EPS)
    assert found.area == pytest.approx(6 * size**2, rel=4 * EPS)


def test_a_sheet_too_thin_for_floats_is_no_error():
    array = box()
    for height in (3e-310, 5e-324):
        array[..., 2] = np.where(array[..., 2] > 0, height, 0.0)
        assert integrals(array).volume == height


def test_no_triangles():
    with pytest.raises(MeshError, match="body: has no triangles"):
        integrals(np.zeros((0, 3, 3)))
