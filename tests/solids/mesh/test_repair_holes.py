"""Small holes and T-junctions are filled; what that does to the volume is small, known and said."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mesh_samples import box, corners, cylinder, flipped, moved, sheet, tetrahedron, torus, uv_sphere
from helpers.repaired_meshes import R

from robodyn.solids.mesh.closed import fingerprint
from robodyn.solids.mesh.integrals import integrate
from robodyn.solids.mesh.repair import repair
from robodyn.solids.mesh.triangles import MemoryTriangles

EPS = np.finfo(np.float64).eps


def repaired(*parts):
    return repair(MemoryTriangles("part", np.concatenate(parts)))


def taken(found):
    return [(step.name, step.count) for step in found.steps]


def volume(triangles):
    return integrate(MemoryTriangles("part", triangles)).volume


def closed_volume(found):
    assert fingerprint(found.triangles).closed
    return integrate(found.triangles).volume


@pytest.mark.parametrize("missing", range(12))
def test_a_box_without_one_triangle(missing):
    whole = box((3, 4, 4))
    found = repaired(np.delete(whole, missing, axis=0))
    assert taken(found) == [("holes", 1)]
    assert found.steps[0].what == "1 hole filled by 1 triangle"
    assert closed_volume(found) == pytest.approx(48, rel=8 * EPS)


@pytest.mark.parametrize("count", range(1, 6))
@pytest.mark.parametrize("seed", range(8))
def test_scattered_holes_in_a_sphere(count, seed):
    whole = moved(uv_sphere(), (3, 1, -2))
    chosen = np.random.default_rng(seed).choice(len(whole), count, replace=False)
    found = repaired(np.delete(whole, chosen, axis=0))
    (step,) = found.steps
    assert step.name == "holes"
    assert 1 <= step.count <= count
    assert found.closed
    assert found.missing == 0
    assert closed_volume(found) == pytest.approx(volume(whole), rel=2e-3)
    assert step.change == pytest.approx(step.volume_after - step.volume_before)


def test_the_change_of_volume_is_that_of_the_cap():
    whole = uv_sphere()
    missing = whole[100:101]
    found = repaired(np.delete(whole, 100, axis=0))
    expected = np.linalg.det(missing[0]) / 6
    assert found.steps[0].change == pytest.approx(expected, rel=1e-12)
    assert closed_volume(found) == pytest.approx(volume(whole), rel=16 * EPS)


def test_a_hole_in_an_inverted_surface():
    whole = uv_sphere()
    found = repaired(flipped(whole[1:]))
    assert taken(found) == [("holes", 1), ("orientation", 1)]
    assert closed_volume(found) == pytest.approx(volume(whole), rel=16 * EPS)


def test_holes_that_touch_at_a_corner():
    whole = torus(rings=64, sectors=32)
    corner = whole[500, 0]
    around = np.flatnonzero((whole == corner).all(axis=2).any(axis=1))
    apart = [around[0], next(k for k in around[1:] if not _share_an_edge(whole[around[0]], whole[k]))]
    found = repaired(np.delete(whole, apart, axis=0))
    assert taken(found) == [("holes", 2)]
    assert closed_volume(found) == pytest.approx(volume(whole), rel=16 * EPS)


def _share_an_edge(one, other):
    return sum((one[:, None] == other).all(axis=2).any(axis=1)) > 1


@pytest.mark.parametrize("sectors", [8, 33, 200])
def test_a_long_tube_without_ends_is_plane_filled_to_rounding(sectors):
    whole = cylinder(radius=0.3, height=9.0, sectors=sectors)
    poles = (whole[:, :, :2] == 0).all(axis=2).any(axis=1)
    found = repaired(moved(whole[~poles], (5, 5, 5)))
    assert taken(found) == [("holes", 2)]
    assert closed_volume(found) == pytest.approx(volume(whole), rel=256 * EPS)


def test_a_plane_hole_that_is_not_convex():
    star = np.array([(np.cos(a), np.sin(a)) for a in np.pi * np.arange(10) / 5]) * np.tile([1.0, 0.4], 5)[:, None]
    bottom, top = np.insert(star, 2, 0.0, axis=1), np.insert(star, 2, 9.0, axis=1)
    after = np.roll(np.arange(10), -1)
    k = np.arange(10)
    sides = np.concatenate([np.stack([k, after, after + 10], axis=1), np.stack([k, after + 10, k + 10], axis=1)])
    found = repaired(corners(np.concatenate([bottom, top]), sides))
    (x, y), (xa, ya) = star.T, star[after].T
    area = float((x * ya - xa * y).sum()) / 2
    assert taken(found) == [("holes", 2)]
    assert closed_volume(found) == pytest.approx(9 * area, rel=64 * EPS)


def test_a_t_junction():
    a, b, c = box()[0]
    middle = a / 2 + b / 2
    found = repaired(box()[1:], np.array([(a, middle, c), (middle, b, c)]))
    assert taken(found) == [("holes", 1)]
    assert found.steps[0].what == "1 seam filled by 1 triangle"
    assert found.steps[0].change == pytest.approx(0, abs=4 * EPS)
    assert closed_volume(found) == 1


def test_an_edge_drawn_twice():
    """Corners of one meridian of a sphere that are off by rounding in the triangles on one side."""
    whole = uv_sphere(rings=32, sectors=64)
    on = (np.abs(whole[:, :, 1]) < 1e-15) & (whole[:, :, 0] > 0.05)
    east = whole[:, :, 1].sum(axis=1) > 0
    cracked = whole.copy()
    cracked[on & east[:, None]] *= 1 + 1e-7
    found = repaired(cracked)
    assert [step.name for step in found.steps] == ["holes"]
    assert found.steps[0].what.startswith("1 seam")
    assert closed_volume(found) == pytest.approx(volume(whole), rel=1e-7)


def test_a_stray_sheet_beside_a_body_weighs_nothing():
    found = repaired(box((20, 20, 20)), moved(sheet(), (0, 0, 50)))
    assert taken(found) == [("holes", 1)]
    assert closed_volume(found) == pytest.approx(8000, rel=16 * EPS)


def test_only_the_large_hole_stays_open():
    found = repaired(box((2, 2, 2))[2:], moved(uv_sphere(0.5)[1:], (9, 0, 0)))
    assert taken(found) == [("holes", 1)]
    assert not found.closed
    assert found.remarks == ("1 gap too large to be filled: 17 % of their surface is missing",)


def test_what_may_have_been_where_a_hole_is():
    """A sphere without its ends: what lies beyond the caps is less than the doubt, but not by orders of magnitude."""
    whole = uv_sphere(rings=48, sectors=96)
    for height in (0.95, 0.9, 0.82):
        found = repaired(moved(whole[(whole[:, :, 2] < height).all(axis=1)], R=R))
        assert volume(whole) - closed_volume(found) < found.doubt < 20 * (volume(whole) - closed_volume(found))


def test_a_tetrahedron_without_a_face_is_half_open():
    found = repaired(tetrahedron()[1:])
    assert found.steps == ()
    assert not found.closed
