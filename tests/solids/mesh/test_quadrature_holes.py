"""Open surfaces by their winding number: where a little is missing, and where what is missing makes them indefinite."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mesh_samples import box, cylinder, flipped, moved, sheet, tetrahedron, torus, uv_sphere
from helpers.repaired_meshes import R, repaired, taken

from robodyn.solids.mesh.columns import by_winding_numbers
from robodyn.solids.mesh.holes import cap_of, followed
from robodyn.solids.mesh.indexed import Edges, merged
from robodyn.solids.mesh.integrals import integrate
from robodyn.solids.mesh.triangles import MemoryTriangles


def volume(triangles):
    return integrate(MemoryTriangles("part", triangles)).volume


def by_winding(triangles):
    """The region of an open surface, none of whose holes is filled."""
    mesh = merged(triangles)
    loops = followed(*Edges.between(mesh.faces).boundary()[1].T.tolist())
    return by_winding_numbers(mesh, np.concatenate([cap_of(mesh.vertices, loop) for loop in loops]))


def patches(body, gap, seed=0):
    """A surface in eight patches by the signs of coordinates, each moved by about this much at random."""
    rng = np.random.default_rng(seed)
    octant = (body.mean(axis=1) > 0) @ (1, 2, 4)
    return np.concatenate([moved(body[octant == k], gap * rng.normal(size=3)) for k in range(8)])


@pytest.mark.parametrize("whole", [uv_sphere(rings=64, sectors=128), torus(2, 0.7, 96, 48)])
def test_two_percent_of_the_faces_missing(whole):
    whole = moved(whole, (3, 1, -2), R)
    kept = np.random.default_rng(5).random(len(whole)) > 0.02
    found, exact = by_winding(whole[kept]), integrate(MemoryTriangles("whole", whole))
    assert found.volume == pytest.approx(exact.volume, rel=1e-4)
    assert found.bar < 2e-3
    r = exact.reference - found.reference
    S = exact.S + np.outer(exact.first, r) + np.outer(r, exact.first) + exact.volume * np.outer(r, r)
    assert np.abs(found.S - S).max() < 1e-4 * np.abs(S).max()
    assert found.first == pytest.approx(exact.first + exact.volume * r, abs=1e-4 * exact.volume * 2)


@pytest.mark.parametrize("share", [0.02, 0.05, 0.08])
@pytest.mark.parametrize("whole", [uv_sphere(1, 32, 64), torus(2, 0.8, 48, 24), moved(cylinder(1, 3, 48), R=R)])
def test_the_bar_of_one_hole_covers_what_was_there(whole, share):
    a, b, c = whole.transpose(1, 0, 2)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    order = np.argsort(np.linalg.norm(whole.mean(axis=1) - whole[7].mean(axis=0), axis=1))
    missing = order[: np.searchsorted(np.cumsum(area[order]), share * area.sum())]
    found = by_winding(np.delete(whole, missing, axis=0))
    assert found is not None
    assert abs(found.volume / volume(whole) - 1) < found.bar < 0.25


def test_a_plane_hole_closes_exactly():
    tube = box((1, 1, 9))
    found = by_winding(moved(tube[(tube[:, :, 2] < 4.5).any(axis=1)], (2, 3, 4), R))
    assert found.volume == pytest.approx(9, rel=1e-12)
    assert found.method == "winding numbers"
    np.testing.assert_allclose(
        np.linalg.eigvalsh(found.S - np.outer(found.first, found.first) / 9), [0.75, 0.75, 60.75], rtol=1e-9
    )


def test_patches_that_nearly_meet():
    whole = uv_sphere()
    found = repaired(moved(patches(whole, 1e-4), (30, 20, -10), R))
    assert taken(found) == [("winding numbers", 8)]
    assert found.steps[0].what == "8 gaps too large to be filled, left to winding numbers"
    assert found.quadrature.volume == pytest.approx(volume(whole), rel=1e-4)
    assert found.quadrature.bar < 1e-4
    assert not found.closed
    assert found.remarks == ()


def test_every_triangle_a_patch_of_its_own():
    """Each is shrunk by a thousandth: it is missing a part of each that is small, and none is a body."""
    whole = moved(torus(2.0, 0.7, 12, 6), (3, 2, 1), R)
    centres = whole.mean(axis=1, keepdims=True)
    found = repaired(whole + 1e-3 * (centres - whole))
    assert taken(found) == [("winding numbers", len(whole))]
    assert found.quadrature.volume == pytest.approx(volume(whole), rel=1e-3)
    assert found.quadrature.bar < 2e-3


def test_sides_of_a_box_in_place_but_apart():
    """Each side moved along its normal: the box of those planes."""
    shift = 1e-3 * np.array((1, -2, 3, -1, 2, 1.5))
    sides = box((1, 2, 3)).reshape(6, 2, 3, 3)
    normals = [np.cross(a[1] - a[0], a[2] - a[0]) for a in sides[:, 0]]
    parts = [moved(side, d * n / np.linalg.norm(n)) for side, d, n in zip(sides, shift, normals, strict=True)]
    found = repaired(moved(np.concatenate(parts), R=R))
    axis = np.argmax(np.abs(normals), axis=1)
    sizes = np.array((1, 2, 3)) + np.bincount(axis, shift)
    assert found.quadrature.volume == pytest.approx(sizes.prod(), rel=1e-4)


@pytest.mark.parametrize("inverted", [False, True])
@pytest.mark.parametrize("inner", [False, True])
def test_patches_around_a_cavity_or_a_body_wound_as_they_are(inverted, inner):
    ball, cube = patches(uv_sphere(), 1e-4), moved(box((0.5, 0.5, 0.5)), (0.1, 0.1, 0.1))
    found = repaired(flipped(ball) if inverted else ball, flipped(cube) if inner else cube)
    hollow = inverted != inner
    assert found.quadrature.volume == pytest.approx(volume(uv_sphere()) - 0.125 * hollow, rel=2e-4)
    assert ("orientation", 9 * inverted) in [*taken(found), ("orientation", 0)]
    assert (("nested", 1) in taken(found)) == (not hollow)


def test_patches_wound_inwards_beside_a_body():
    found = repaired(flipped(patches(uv_sphere(), 1e-4)), moved(box(), (4, 0, 0)))
    assert taken(found) == [("orientation", 8), ("winding numbers", 8)]
    assert found.quadrature.volume == pytest.approx(volume(uv_sphere()) + 1, rel=1e-4)


def test_what_overlaps_an_open_body_counts_once():
    ball = uv_sphere(rings=32, sectors=64)
    lid = (ball[:, :, 2] > 0.75).any(axis=1)
    cube = moved(box(), (0, 0, -1))
    whole = repaired(ball[~lid], moved(cube, (0, 0, 9))).quadrature
    found = repaired(ball[~lid], cube).quadrature
    cut = volume(ball) + 1 - volume(repaired(ball, cube).triangles.array())
    assert whole.volume - found.volume == pytest.approx(cut, rel=2e-3)


@pytest.mark.parametrize("seed", range(2))
def test_patches_without_a_common_winding_enclose_nothing_definite(seed):
    rng = np.random.default_rng(seed)
    ball = patches(uv_sphere(), 1e-4)
    octant = (ball.mean(axis=1) > 0) @ (1, 2, 4)
    wrong = np.isin(octant, rng.choice(8, 3, replace=False))
    ball[wrong] = flipped(ball[wrong])
    found = repaired(ball)
    assert found.quadrature is None
    assert "too large to be filled" in found.remarks[0]


@pytest.mark.parametrize(
    "body",
    [
        sheet(),
        box()[2:],
        box((3, 4, 4))[2:],
        tetrahedron()[1:],
        uv_sphere()[(uv_sphere()[:, :, 2] < 1e-9).all(axis=1)],
        cylinder(1, 2)[np.abs(cylinder(1, 2).mean(axis=1)[:, 2]) < 0.9],
    ],
)
def test_half_open_surfaces_and_sheets_enclose_nothing_definite(body):
    found = repaired(moved(body, (1, 2, 3), R))
    assert found.quadrature is None
    assert not found.closed
