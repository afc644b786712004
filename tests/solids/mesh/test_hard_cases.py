"""Hard meshes through `robodyn.mass_properties`: what each must give, against exact rationals, and what must be said.

Meshes that must be refused are in `test_hard_refusals`.
"""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mesh_oracle import centred, deviation, exact, rational_moments, rotation
from helpers.mesh_samples import box, corners, flipped, moved, tetrahedron, torus, uv_sphere

import robodyn
from robodyn.solids.inertia.principal import principal_axes

BODIES = {
    "tetrahedron": tetrahedron(),
    "torus": torus(2.0, 0.5, 16, 8),
    "askew box": moved(box((1, 2, 3)), R=rotation(3)),
}


@pytest.fixture(params=BODIES)
def body(request):
    """Triangles of a sound body."""
    return BODIES[request.param]


def part(*triangles, **how):
    return robodyn.mass_properties(np.concatenate(triangles), density=1.0, **how)


def expected(triangles):
    """Volume, centre and inertia matrix about it, as fractions."""
    V, first, S = rational_moments(triangles, (0, 0, 0))
    S_c = centred(V, first, S)
    return V, first / V, np.trace(S_c) * exact(np.eye(3)) - S_c


def holds(found, triangles, bound=1e-15):
    """V and I are those of these triangles, the centre to the same part of the distance from the origin."""
    V, centre, I = expected(triangles)
    assert deviation(found.body.volume, V) <= bound
    assert deviation(found.body.inertia, I) <= bound
    far = float(np.abs(triangles).max())
    assert np.abs(exact(found.body.com) - centre).max() <= bound * far


def said(found):
    """(name, count) of every repair."""
    return [(step.name, step.count) for step in found.repairs]


@pytest.mark.parametrize("sizes", [1, 1e2, 1e4, 1e6, 1e8])
def test_moved_many_sizes_away(body, sizes):
    far = moved(body, np.array((1, -0.7, 0.3)) * sizes * np.ptp(body, axis=(0, 1)).max())
    found = part(far)
    holds(found, far)
    assert said(found) == []


def test_the_centre_is_the_reference_and_an_offset():
    """5e8 sizes away, where a coordinate is a multiple of 2^-21: the nearest float to the exact centre."""
    found = part(moved(tetrahedron(), (2.0**31, -(2.0**31), 2.0**30)))
    assert found.body.com.tolist() == [2.0**31 + 1.25, -(2.0**31) + 1, 2.0**30 + 0.75]


@pytest.mark.parametrize("sizes", [(1, 1, 1e-6), (1, 1e-6, 1e-6)])
@pytest.mark.parametrize("pose", range(4))
def test_plate_and_needle_in_any_pose(sizes, pose):
    thin = moved(box(sizes), (1.5, -0.25, 3.0), rotation(pose))
    found = part(thin)
    second = principal_axes(found.body.S_exact).second
    exactly = principal_axes(centred(*rational_moments(thin, (0, 0, 0)))).second
    assert np.abs(second / exactly - 1).max() <= 1e-12
    assert found.method in ("long double", "rational")
    assert said(found) == []


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3, 1e6])
def test_scale(body, scale):
    """The same body, and the same repairs, however small or large: no threshold has a unit."""
    holds(part(body * scale), body * scale)
    wrong = np.concatenate([flipped(body[:1]), body[1:], body[2:3]]) * scale
    found = part(wrong)
    holds(found, body * scale)
    assert {"duplicate", "winding"} <= {step.name for step in found.repairs}


def test_inverted_winding(body):
    found = part(flipped(body))
    holds(found, body)
    assert said(found) == [("orientation", 1)]
    assert found.repairs[0].what == "1 shell turned outwards"


def test_mixed_winding(body):
    wrong = body.copy()
    wrong[::4] = flipped(wrong[::4])
    found = part(wrong)
    holds(found, body)
    assert ("winding", len(body[::4])) in said(found)


def test_scattered_holes():
    """2 % of the faces: as they are flat, what fills them is what was there."""
    whole = moved(uv_sphere(1.0, 40, 80), (1, 2, 3), rotation(1))
    missing = np.arange(30, len(whole), 50)
    found = part(np.delete(whole, missing, axis=0))
    holds(found, whole, bound=2e-15)
    (step,) = found.repairs
    assert (step.name, step.count) == ("holes", len(missing))
    assert step.change == pytest.approx(found.body.volume - step.volume_before)
    assert found.union < 1e-3


def test_large_hole():
    """A seventh of a sphere, too much to be filled: the error is within the bar that is given."""
    ball = uv_sphere(1.0, 48, 96)
    cut = ball[(ball[:, :, 2] < 0.72).all(axis=1)]
    found = part(cut)
    V, _, I = expected(ball)
    assert said(found) == [("winding numbers", 1)]
    assert deviation(found.body.volume, V) < found.union < 0.5
    assert deviation(found.body.inertia, I) < found.union
    assert not found.closed
    assert found.warnings == ()


def test_duplicate_and_degenerate_faces(body):
    line = corners([(0, 0, 0), (1, 1, 1), (2, 2, 2)], [(0, 1, 2)])
    point = np.ones((2, 3, 3))
    found = part(body, body[:3], flipped(body[1:2]), line, point)
    holds(found, body)
    assert said(found) == [("degenerate", 3), ("duplicate", 4)]
    assert [step.what for step in found.repairs] == [
        "3 faces without area dropped",
        "4 faces given more than once dropped",
    ]


def test_unmerged_soup(body):
    """Triangles in any order, each with corners of its own, from any of them on."""
    rng = np.random.default_rng(0)
    soup = rng.permutation(body)
    turns = (rng.integers(3, size=len(soup))[:, None] + np.arange(3)) % 3
    found = part(np.take_along_axis(soup, turns[:, :, None], axis=1))
    holds(found, body)
    assert said(found) == []


def test_overlapping_shells():
    """The union exactly, and the signed sum, in which what they share counts twice."""
    found = part(box((2, 2, 2)), moved(box((2, 2, 2)), (1, 0.5, 0.25)))
    shared = 1 * 1.5 * 1.75
    assert found.body.volume == pytest.approx(16 - shared, rel=1e-12)
    assert said(found) == [("union", 2)]
    assert (found.repairs[0].volume_before, found.repairs[0].volume_after) == pytest.approx((16, 16 - shared))
    centre = (8 * np.array((1, 0.5, 0.25)) - shared * np.array((0.5, 0.25, 0.125))) / (16 - shared)
    assert found.body.com == pytest.approx(centre, abs=1e-12)


def test_overlapping_shells_that_are_no_manifolds():
    """A block and another flush with it that reaches into a third: four faces on some edges."""
    flush = moved(box(), (0.5, 0.5, 0.5)), moved(box((1, 1, 3)), (0.5, 0.5, 1.5))
    found = part(*(moved(block, R=rotation(5)) for block in flush))
    assert found.body.volume == pytest.approx(3, rel=1e-4)
    assert abs(found.body.volume / 3 - 1) <= found.union < 1e-4
    assert said(found) == [("overlaps", 1)]
    assert found.repairs[0].volume_before == pytest.approx(4)
    I = rotation(5) @ np.diag((2.5, 2.5, 0.5)) @ rotation(5).T
    np.testing.assert_allclose(found.body.inertia, I, rtol=0, atol=2e-4)


@pytest.mark.parametrize("asked", [False, True])
@pytest.mark.parametrize("outwards", [False, True])
def test_cavity(outwards, asked):
    """A shell that is wound as the one around it is no cavity, unless that is asked for."""
    outer, inner = moved(box((3, 2, 2)), R=rotation(4)), moved(box(), (0.5, 0.25, 0), rotation(4))
    found = part(outer, inner if outwards else flipped(inner), cavities=asked)
    if outwards and not asked:
        holds(found, outer)
        assert said(found) == [("nested", 1)]
        assert "taken as a part of it: if it is a cavity, say --cavities (1 m^3 less)" in found.warnings[0]
        return
    holds(found, np.concatenate([outer, flipped(inner)]))
    assert said(found) == [("orientation", 1)] * outwards
    assert found.warnings == ()


def test_disjoint_shells_one_inverted():
    apart = moved(torus(2.0, 0.5, 16, 8), (9, 1, 0))
    found = part(tetrahedron(), flipped(apart))
    holds(found, np.concatenate([tetrahedron(), apart]))
    assert said(found) == [("orientation", 1)]
    assert found.repairs[0].what == "1 shell turned outwards"


def test_stray_vertices_and_vertices_out_of_use_that_are_no_numbers(body):
    lines = [f"v {x:.17g} {y:.17g} {z:.17g}" for x, y, z in body.reshape(-1, 3)]
    lines += ["v 1e9 -1e9 1e9", "v nan 0 inf"]
    lines += [f"f {3 * k + 1} {3 * k + 2} {3 * k + 3}" for k in range(len(body))]
    found = robodyn.mass_properties("\n".join(lines).encode(), file_type="obj", density=1.0)
    holds(found, body)
    assert said(found) == []
    assert (found.lo == body.min(axis=(0, 1))).all()
