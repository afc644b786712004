from __future__ import annotations

from math import prod

import numpy as np
import pytest
from helpers import mesh_samples as samples
from helpers.mesh_samples import box, corners, flipped, moved, tetrahedron, torus, uv_sphere
from helpers.repaired_meshes import R
from helpers.symmetric_bodies import any_rotation, bracket

from robodyn.solids.mesh.columns import Hits, Lattice, differing_volume, frame_along
from robodyn.solids.mesh.indexed import Indexed, merged
from robodyn.solids.mesh.inside import winding_numbers

ALONG = (0.0, 0.0, 1.0)
OBLIQUE = (0.36, 0.48, 0.8)
NO_HITS = Hits(np.empty(0, int), np.empty(0), np.empty(0, int))


def volume(body, direction, count=4096):
    lattice = Lattice.over(body, np.array(direction), count=count)
    return differing_volume(lattice.hits(body), NO_HITS, lattice.cell)


@pytest.mark.parametrize("direction", [ALONG, OBLIQUE, (1.0, 0.0, 0.0)])
@pytest.mark.parametrize("body", [samples.torus(), bracket(), samples.moved(samples.uv_sphere(), (50, 60, 70))])
def test_every_column_leaves_the_body_as_often_as_it_enters(body, direction):
    hits = Lattice.over(body, np.array(direction)).hits(body)
    assert len(hits.sign) > 3000
    assert not np.bincount(hits.column, hits.sign).any()


@pytest.mark.parametrize("direction", [ALONG, OBLIQUE])
@pytest.mark.parametrize(
    ("body", "exact"), [(samples.box((1, 2, 3)), 6.0), (bracket(), 6.0), (samples.tetrahedron(), 10.0)]
)
def test_volume(body, exact, direction):
    """Which columns meet the rim is chance: the error falls with their number, from 2.5e-3 at most to 2.3e-5 here."""
    assert volume(body, direction) == pytest.approx(exact, rel=4e-3)
    assert volume(body, direction, 400_000) == pytest.approx(exact, rel=1e-4)


def test_overlapping_bodies_count_once_and_cavities_not_at_all():
    two = np.concatenate([samples.box((1, 1, 1)), samples.moved(samples.box((1, 1, 1)), (0.5, 0.2, 0.1))])
    assert volume(two, OBLIQUE, 100_000) == pytest.approx(2 - 0.5 * 0.8 * 0.9, rel=1e-6)
    hollow = np.concatenate([samples.box((2, 2, 2)), samples.flipped(samples.box())])
    assert volume(hollow, OBLIQUE, 100_000) == pytest.approx(7, rel=1e-6)


def test_integral_is_exact_in_depth():
    """Two boxes that differ by far less than the distance of the columns."""
    lattice = Lattice.over(samples.box((1, 2, 3.001)), np.array(ALONG))
    hits = [lattice.hits(samples.box((1, 2, 3 + d))) for d in (0.0, 1e-9)]
    assert differing_volume(*hits, lattice.cell) == pytest.approx(2e-9, rel=1e-3)
    assert differing_volume(hits[0], hits[0], lattice.cell) == 0.0


@pytest.mark.parametrize("offset", [(0.3, 0.0, 0.0), (0.1, -0.2, 0.25), (9.0, 0.0, 0.0)])
def test_difference_of_a_box_and_the_same_moved(offset):
    one = samples.moved(samples.box(), R=any_rotation(4))
    other = samples.moved(samples.moved(samples.box(), offset), R=any_rotation(4))
    lattice = Lattice.over(np.concatenate([one, other]), np.array(OBLIQUE), count=100_000)
    shared = prod(max(0.0, 1 - abs(d)) for d in offset)
    found = differing_volume(lattice.hits(one), lattice.hits(other), lattice.cell)
    assert found == pytest.approx(2 - 2 * shared, rel=5e-3)


def test_reflected_hits_are_those_of_the_mirror_image():
    body = samples.moved(bracket(), R=any_rotation(1))
    image = samples.flipped(body * (1, 1, -1))
    lattice = Lattice.over(np.concatenate([body, image]), np.array(ALONG))
    assert differing_volume(lattice.hits(body).reflected(0.0), lattice.hits(image), lattice.cell) <= 1e-13


def test_lattice_seen_by_a_rotation_meets_the_body_as_it_meets_the_image():
    body, Q = bracket(), any_rotation(2)
    lattice = Lattice.over(body, np.array(OBLIQUE), Q)
    hits = lattice.seen_by(Q).hits(body), lattice.hits(samples.moved(body, R=Q))
    assert differing_volume(*hits, lattice.cell) <= 1e-12


def test_body_no_column_meets_has_no_volume():
    body = samples.box()
    lattice = Lattice.over(body, np.array(ALONG))
    hits = lattice.hits(samples.moved(body, (0, 50, 0)))
    assert len(hits.depth) == 0
    assert differing_volume(hits, NO_HITS, lattice.cell) == differing_volume(hits, hits, lattice.cell) == 0.0


@pytest.mark.parametrize("direction", [ALONG, OBLIQUE, (0.0, -1.0, 0.0)])
def test_frame_is_orthonormal_and_in_no_special_position(direction):
    frame = frame_along(np.array(direction))
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=4e-16)
    np.testing.assert_array_equal(frame[2], direction)
    assert np.abs(frame[0]).max() < 0.95


def numbers(triangles, *points):
    return winding_numbers(np.array(points, float), merged(triangles))


def test_a_side_of_a_cube_from_its_centre_and_a_corner_of_space_from_its_apex():
    assert numbers(moved(box()[:2], R=R), (0, 0, 0)) == pytest.approx([1 / 6], rel=1e-15)
    octant = corners([(1e9, 0, 0), (0, 1e9, 0), (0, 0, 1e9)], [(0, 1, 2)])
    assert numbers(octant, (0, 0, 0)) == pytest.approx([1 / 8], rel=1e-15)


def test_a_cube_without_a_side_from_the_middle_of_that_side():
    assert numbers(moved(box()[2:], R=R), R @ (-0.5, 0, 0)) == pytest.approx([0.5], abs=1e-15)


@pytest.mark.parametrize("body", [box(), torus(0.6, 0.3), uv_sphere(0.7, 32, 64), tetrahedron() / 5 - 0.2])
def test_a_closed_surface_from_within_and_from_outside(body):
    points = np.random.default_rng(0).normal(size=(300, 3))
    points = points[(np.linalg.norm(points[:, None] - merged(body).vertices, axis=2) > 1e-2).all(axis=1)]
    found = numbers(body, *points)
    assert np.abs(found - np.rint(found)).max() < 1e-12
    assert set(np.rint(found)) == {0, 1}
    np.testing.assert_allclose(numbers(flipped(body), *points), -found, rtol=0, atol=1e-12)
    np.testing.assert_allclose(numbers(np.concatenate([body, body]), *points), 2 * found, rtol=0, atol=1e-12)


def test_close_to_a_triangle_the_side_decides():
    side = moved(box()[:2], R=R)
    near = [R @ (-0.5 + distance, 0.1, 0.2) for distance in (1e-6, -1e-6)]
    assert numbers(side, *near) == pytest.approx([0.5, -0.5], abs=1e-5)


def test_blocks_of_points_and_vertices_out_of_use_change_nothing():
    mesh = merged(torus(rings=96, sectors=96))
    points = np.random.default_rng(1).normal(size=(50, 3))
    whole = winding_numbers(points, mesh)
    part = Indexed(mesh.vertices, mesh.faces[:4000])
    rest = Indexed(mesh.vertices, mesh.faces[4000:])
    np.testing.assert_allclose(winding_numbers(points, part) + winding_numbers(points, rest), whole, rtol=0, atol=1e-12)


def test_nothing_has_no_winding_number():
    nothing = Indexed(np.zeros((1, 3)), np.empty((0, 3), np.int64))
    assert winding_numbers(np.ones((2, 3)), nothing).tolist() == [0, 0]
