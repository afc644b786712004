"""Faces without area and faces given twice: dropped, counted, and kept where they hold the surface together."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from helpers.mesh_samples import box, corners, flipped, moved, sheet, torus, uv_sphere
from hypothesis import given
from hypothesis import strategies as st

from robodyn.solids.mesh.integrals import integrate
from robodyn.solids.mesh.repair import repair
from robodyn.solids.mesh.shells import collinear
from robodyn.solids.mesh.triangles import MemoryTriangles


def repaired(*parts):
    return repair(MemoryTriangles("part", np.concatenate(parts)))


def taken(found):
    return [(step.name, step.count) for step in found.steps]


def same_faces(found, expected):
    assert sorted(map(bytes, found.triangles.array())) == sorted(map(bytes, expected))


def rotated(triangles, turns):
    return np.roll(triangles, turns, axis=1)


def test_faces_with_equal_corners():
    extra = torus()[:5]
    extra[:, 2] = extra[:, 0]
    found = repaired(torus(), extra)
    assert taken(found) == [("degenerate", 5)]
    assert found.steps[0].what == "5 faces without area dropped"
    assert found.steps[0].change == 0
    same_faces(found, torus())


def test_stray_faces_on_a_line():
    line = corners([(0, 0, 0), (1, 2, 3), (3, 6, 9), (0.5, 0.5, 0.5)], [(0, 1, 2), (0, 2, 1)])
    found = repaired(torus(), line[:1])
    assert taken(found) == [("degenerate", 1)]
    same_faces(found, torus())


def test_a_face_on_a_line_that_closes_a_seam_stays():
    a, b, c = box()[0]
    middle = a / 2 + b / 2
    split = np.array([(a, middle, c), (middle, b, c)])
    whole = np.concatenate([box()[1:], split, [(a, b, middle)]])
    found = repaired(whole)
    assert found.steps == ()
    assert found.closed


@pytest.mark.parametrize("turns", range(3))
@pytest.mark.parametrize("copies", [1, 2])
def test_duplicates_of_some_faces(turns, copies):
    found = repaired(torus(), *[rotated(torus()[10:20], turns)] * copies)
    assert taken(found) == [("duplicate", 10 * copies)]
    assert found.steps[0].what == f"{10 * copies} faces given more than once dropped"
    same_faces(found, torus())


def test_all_faces_twice():
    found = repaired(uv_sphere(), rotated(uv_sphere(), 1))
    assert taken(found) == [("duplicate", len(uv_sphere()))]
    assert found.steps[0].volume_before == pytest.approx(2 * found.steps[0].volume_after)
    same_faces(found, uv_sphere())


def test_both_sides_of_every_face_make_one_body():
    found = repaired(uv_sphere(), flipped(uv_sphere()))
    assert taken(found) == [("duplicate", len(uv_sphere()))]
    same_faces(found, uv_sphere())


def test_a_face_given_both_ways_in_a_sound_surface_stays_once():
    found = repaired(torus(), flipped(torus()[:1]))
    assert taken(found) == [("duplicate", 1)]
    same_faces(found, torus())


def test_both_sides_of_a_sheet_leave_a_sheet():
    found = repaired(sheet(), flipped(sheet()))
    assert taken(found) == [("duplicate", 2)]
    assert not found.closed
    assert found.triangles.count == 2


def test_faces_of_bodies_that_are_flush_stay_and_their_overlap_counts_once():
    given = MemoryTriangles(
        "part", np.concatenate([moved(box(), (0.5, 0.5, 0.5)), moved(box((1, 1, 3)), (0.5, 0.5, 1.5))])
    )
    found = repair(given)
    assert found.triangles is given
    assert found.closed
    assert taken(found) == [("overlaps", 1)]
    assert found.steps[0].what == "overlaps of 1 folded shell counted once, by columns"
    assert (found.steps[0].volume_before, found.steps[0].volume_after) == pytest.approx((4, 3), rel=1e-5)


def test_walls_within_a_block_of_eight_boxes_cancel():
    offsets = np.array(list(np.ndindex(2, 2, 2)))
    found = repaired(*[moved(box(), offset) for offset in offsets])
    assert found.triangles.count == 4 * 12
    assert integrate(found.triangles).volume == 8
    assert taken(found) == [("duplicate", 4 * 12)]


@given(st.lists(st.integers(-(2**20), 2**20), min_size=6, max_size=6), st.integers(1, 2**20), st.integers(-1, 1))
def test_lines_are_told_from_triangles_without_rounding(numbers, factor, nudge):
    a, step = np.array(numbers[:3], float), np.array(numbers[3:], float)
    c = a + factor * step
    c[0] += nudge
    triangle = np.array([[a, a + step, c]])
    p, q, r = ([Fraction(x) for x in corner] for corner in triangle[0].tolist())
    e, f = [y - x for x, y in zip(p, q, strict=True)], [y - x for x, y in zip(p, r, strict=True)]
    exact = all(e[i] * f[j] == e[j] * f[i] for i, j in ((0, 1), (1, 2), (2, 0)))
    assert collinear(triangle)[0] == exact
