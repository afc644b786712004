"""Every rung of the repair: what it is called for by, what it does, and the volume that is left."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mesh_samples import (
    box,
    corners,
    flipped,
    moved,
    sheet,
    tetrahedron,
    torus,
    uv_sphere,
)
from helpers.repaired_meshes import R, repaired, taken, volume

from robodyn.errors import MeshError
from robodyn.solids.mesh.repair import repair
from robodyn.solids.mesh.triangles import MemoryTriangles

EPS = np.finfo(np.float64).eps
ANYWHERE = ((0.0, 0.0, 0.0), (1e3, -2e5, 3e4))


def same_volume(found, expected, k=64):
    assert volume(found) == pytest.approx(expected, rel=k * EPS, abs=0)


def without(triangles, *faces):
    return np.delete(triangles, faces, axis=0)


@pytest.mark.parametrize(
    "parts",
    [
        (box(),),
        (torus(),),
        (moved(tetrahedron(), R=R),),
        (box(), moved(uv_sphere(), (5, 0, 0))),
        (box((3, 3, 3)), flipped(box())),
        (box((5, 5, 5)), flipped(box((3, 3, 3))), box()),
    ],
)
def test_a_sound_surface_is_the_same_object(parts):
    given = MemoryTriangles("part", np.concatenate(parts))
    found = repair(given)
    assert found.triangles is given
    assert found.steps == ()
    assert found.remarks == ()
    assert found.closed
    assert found.shells == len(parts)


@pytest.mark.parametrize("seed", range(5))
def test_the_order_and_the_first_corners_of_triangles_do_not_matter(seed):
    rng = np.random.default_rng(seed)
    soup = rng.permutation(np.concatenate([torus(), moved(box(), (9, 0, 0))]))
    turns = (rng.integers(3, size=len(soup))[:, None] + np.arange(3)) % 3
    assert repaired(np.take_along_axis(soup, turns[:, :, None], axis=1)).steps == ()


def test_minus_zero_is_zero():
    soup = box((2, 2, 2)) + 1.0
    soup[::2][soup[::2] == 0] = -0.0
    assert repaired(soup).steps == ()


@pytest.mark.parametrize("offset", ANYWHERE)
def test_inverted(offset):
    found = repaired(moved(flipped(box((2, 3, 5))), offset))
    assert taken(found) == [("orientation", 1)]
    assert found.steps[0].what == "1 shell turned outwards"
    assert found.steps[0].change == pytest.approx(60, rel=1e-9)
    same_volume(found, 30)


@pytest.mark.parametrize("seed", range(5))
def test_mixed_winding(seed):
    rng = np.random.default_rng(seed)
    whole = torus()
    wrong = rng.choice(len(whole), 40, replace=False)
    whole[wrong] = flipped(whole[wrong])
    found = repaired(whole)
    assert taken(found) == [("winding", 40)]
    same_volume(found, volume(repaired(torus())))


def test_mixed_winding_and_inverted():
    whole = flipped(uv_sphere())
    whole[:7] = flipped(whole[:7])
    found = repaired(whole)
    assert taken(found) == [("winding", 7), ("orientation", 1)]
    same_volume(found, volume(repaired(uv_sphere())))


@pytest.mark.parametrize("offset", ANYWHERE)
def test_disjoint_shells_one_inverted(offset):
    found = repaired(moved(box(), offset), moved(flipped(box((2, 2, 2))), np.add(offset, (4, 0, 0))))
    assert taken(found) == [("orientation", 1)]
    assert found.steps[0].change == pytest.approx(16, rel=1e-9)
    same_volume(found, 9)


def test_disjoint_shells_with_overlapping_boxes():
    ring = moved(torus(major=2.0, minor=0.5), R=R)
    other = moved(box((0.2, 0.2, 0.2)), (0, 0, 0.1))
    found = repaired(ring, flipped(other))
    assert taken(found) == [("orientation", 1)]
    same_volume(found, volume(repaired(torus())) + 0.2**3)


def test_a_body_in_another_wound_alike_is_a_part_of_it_or_a_cavity_if_so_asked():
    found = repaired(box((3, 3, 3)), box())
    assert taken(found) == [("nested", 1)]
    assert found.steps[0].change == pytest.approx(-1, rel=1e-12)
    (remark,) = found.remarks
    assert remark.endswith("taken as a part of it: if it is a cavity, say --cavities (1 m^3 less)")
    same_volume(found, 27)
    found = repaired(box((3, 3, 3)), box(), cavities=True)
    assert taken(found) == [("orientation", 1)]
    assert found.steps[0].what == "1 shell turned inwards, being a cavity in another"
    assert found.remarks == ()
    same_volume(found, 26)


@pytest.mark.parametrize("signs", list(np.ndindex(2, 2, 2, 2)))
def test_nesting_of_any_winding(signs):
    sizes = (7, 5, 3, 1)
    parts = [flipped(box((s, s, s))) if flip else box((s, s, s)) for s, flip in zip(sizes, signs, strict=True)]
    found = repaired(*[moved(part, R=R) for part in parts], cavities=True)
    same_volume(found, 7**3 - 5**3 + 3**3 - 1)
    expected = sum(flip != depth % 2 for depth, flip in enumerate(signs))
    assert sum(step.count for step in found.steps) == expected


@pytest.mark.parametrize("signs", list(np.ndindex(2, 2, 2, 2)))
def test_nesting_by_winding_numbers(signs):
    """Between two shells the winding number says what is there, from each body in empty space on in its own sense."""
    sizes = (7, 5, 3, 1, 0)
    winding, sense, expected = 0, 0, 0
    for depth, flip in enumerate(signs):
        way = -1 if flip else 1
        sense = sense if winding else way
        winding += way * sense
        expected += (winding > 0) * (sizes[depth] ** 3 - sizes[depth + 1] ** 3)
    boxes = [box((s, s, s)) for s in sizes[:4]]
    parts = [flipped(one) if flip else one for one, flip in zip(boxes, signs, strict=True)]
    same_volume(repaired(*[moved(part, R=R) for part in parts]), expected)


@pytest.mark.parametrize("turn", [np.eye(3), R])
def test_volume_does_not_jump_when_a_body_slides_into_another(turn):
    """A cube of edge 1 slides into one of edge 3 through its side: what sticks out is all that it adds."""
    for reach in (-0.25, 0.0, 0.25, 0.75, 0.999999, 1.0, 1.000001, 1.5):
        slid = moved(box(), (2.0 - reach, 0.1, 0.2))
        found = repaired(moved(box((3, 3, 3)), R=turn), moved(slid, R=turn))
        assert volume(found) == pytest.approx(27 + 1 - min(max(reach, 0), 1), rel=1e-12)


def test_two_cavities_in_a_ring():
    ring = torus(major=2.0, minor=0.5, rings=64, sectors=32)
    cube = box((0.2, 0.2, 0.2))
    found = repaired(ring, flipped(moved(cube, (2, 0, 0))), flipped(moved(cube, (-2, 0.1, 0))), cube)
    assert taken(found) == []
    same_volume(found, volume(repaired(ring)) - 2 * 0.2**3 + 0.2**3)


def test_a_body_on_top_of_another_is_no_cavity():
    found = repaired(box((2, 2, 2)), moved(box(), (0.25, 0.25, 1.5)))
    assert found.steps == ()


def test_bodies_that_share_an_edge():
    found = repaired(box(), moved(flipped(box()), (1, 1, 0)))
    assert found.shells == 2
    assert found.quadrature is None
    assert taken(found) == [("orientation", 1)]
    same_volume(found, 2)


def test_bodies_that_share_a_wall_lose_it():
    found = repaired(box(), moved(box(), (1, 0, 0)))
    assert taken(found) == [("duplicate", 4)]
    assert found.steps[0].change == pytest.approx(0, abs=4 * EPS)
    same_volume(found, 2)


def test_a_sheet_without_thickness_does_not_hold():
    found = repaired(sheet())
    assert found.steps == ()
    assert not found.closed
    assert found.missing == pytest.approx(0.5)
    assert found.remarks == ("1 gap too large to be filled: 50 % of their surface is missing",)


def test_half_open_box_stays_open():
    given = MemoryTriangles("part", box()[2:])
    found = repair(given)
    assert found.triangles is given
    assert not found.closed
    assert found.missing == pytest.approx(1 / 6)
    assert found.remarks == ("1 gap too large to be filled: 17 % of their surface is missing",)


def test_nothing_but_lines_is_refused():
    with pytest.raises(MeshError, match="no triangle with an area"):
        repaired(corners([(0, 0, 0), (1, 1, 1), (2, 2, 2)], [(0, 1, 2)]))


def test_a_strip_with_one_side_is_refused():
    angle = np.pi * np.arange(24) / 12
    radial = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    across = np.cos(angle / 2)[:, None] * radial + np.sin(angle / 2)[:, None] * (0, 0, 1)
    rim = np.concatenate([3 * radial + across, 3 * radial - across])
    after = np.roll(rim.reshape(2, 24, 3), -1, axis=1)
    after[:, -1] = after[::-1, -1].copy()
    first, last = rim[:24], rim[24:]
    strip = np.concatenate([np.stack([first, last, after[1]], axis=1), np.stack([first, after[1], after[0]], axis=1)])
    with pytest.raises(MeshError, match="48 of 48 faces form surfaces with one side only"):
        repaired(strip)
