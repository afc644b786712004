"""Bodies that overlap are made one by their union; bodies that only touch, or lie in cavities, are left alone."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mesh_samples import box, cylinder, flipped, moved, torus, uv_sphere
from helpers.repaired_meshes import R, repaired, taken, volume

from robodyn.solids.mesh.integrals import integrate
from robodyn.solids.mesh.triangles import MemoryTriangles


@pytest.mark.parametrize("turn", [np.eye(3), R])
@pytest.mark.parametrize("offset", [(0, 0, 0), (1e3, -2e3, 5e2)])
def test_two_boxes(turn, offset):
    boxes = box((2, 2, 2)), moved(box((2, 2, 2)), (1, 0.5, 0.25))
    found = repaired(*[moved(part, offset, turn) for part in boxes])
    assert taken(found) == [("union", 2)]
    assert found.steps[0].what == "2 overlapping bodies united"
    assert found.steps[0].change == pytest.approx(-1 * 1.5 * 1.75, rel=1e-6)
    assert volume(found) == pytest.approx(16 - 1 * 1.5 * 1.75, rel=1e-12)
    assert found.quadrature is None


def test_a_cross_of_three_bars():
    bars = [box(np.where(np.arange(3) == k, 10.0, 2.0)) for k in range(3)]
    found = repaired(*bars, moved(uv_sphere(), (20, 0, 0)))
    assert taken(found) == [("union", 3)]
    sphere = integrate(MemoryTriangles("sphere", uv_sphere())).volume
    assert volume(found) == pytest.approx(3 * 40 - 2 * 8 + sphere, rel=1e-12)


def test_an_inverted_one_is_turned_first():
    found = repaired(box((2, 2, 2)), flipped(moved(box((2, 2, 2)), (1, 1, 1))))
    assert taken(found) == [("orientation", 1), ("union", 2)]
    assert volume(found) == pytest.approx(15, rel=1e-12)


def test_a_body_that_reaches_into_the_cavity_of_another():
    hollow = np.concatenate([box((4, 4, 4)), flipped(box((2, 2, 2)))])
    bar = moved(box((4, 1, 1)), (2, 0, 0))
    found = repaired(hollow, bar)
    assert taken(found) == [("union", 2)]
    assert volume(found) == pytest.approx(64 - 8 + 1 + 2, rel=1e-12)


def test_a_bar_across_a_frame_is_no_cavity_though_its_ends_are_within():
    along = [moved(box((6, 1, 1)), (0, y, 0)) for y in (-2.5, 2.5)]
    across = [moved(box((1, 6, 1)), (x, 0, 0)) for x in (-2.5, 2.5)]
    frame = repaired(*along, *across)
    assert volume(frame) == pytest.approx(20, rel=1e-12)
    found = repaired(frame.triangles.array(), box((5, 0.5, 0.5)))
    assert taken(found) == [("union", 2)]
    assert volume(found) == pytest.approx(21, rel=1e-12)


def test_linked_rings_do_not_overlap():
    turn = np.array([(1.0, 0, 0), (0, 0, -1), (0, 1, 0)])
    found = repaired(torus(), moved(torus(), (2, 0, 0), turn))
    assert found.steps == ()
    assert found.quadrature is None


def test_a_pin_in_its_bore_only_touches():
    pin = cylinder(radius=0.5, height=3, sectors=24)
    found = repaired(moved(pin, (0, 0, 1.5)), moved(cylinder(radius=2, height=3, sectors=24), (0, 0, -1.5)))
    assert found.steps == ()


def test_columns_where_one_body_is_no_manifold(monkeypatch):
    monkeypatch.setattr("robodyn.solids.mesh.inside.manifold", lambda vertices, faces: None)
    parts = box((2, 2, 2)), moved(box((2, 2, 2)), (1, 0.5, 0.25)), moved(box(), (9, 0, 0))
    found = repaired(*parts)
    assert taken(found) == [("overlaps", 2)]
    assert found.steps[0].what == "overlaps of 2 bodies counted once, by columns"
    assert found.quadrature.method == "columns"
    assert found.quadrature.volume == found.steps[0].volume_after == pytest.approx(17 - 1 * 1.5 * 1.75, rel=1e-4)
    np.testing.assert_array_equal(found.triangles.array(), np.concatenate(parts))


def test_bodies_of_which_only_the_boxes_overlap(monkeypatch):
    monkeypatch.setattr("robodyn.solids.mesh.inside.manifold", lambda vertices, faces: None)
    found = repaired(moved(box((4, 1, 1)), R=R), moved(box((4, 1, 1)), R @ (0, 1.5, 0), R))
    assert found.steps == ()
    assert found.quadrature is None


def test_a_wall_of_one_sheet_within_a_body():
    low, high = box((1, 1, 5)), moved(box((1, 1, 5)), (0, 0, 5))
    wall = (high[:, :, 2] == 2.5).all(axis=1)
    found = repaired(low, high[~wall], moved(box(), (0.5, 0, 0)))
    assert taken(found) == [("holes", 1), ("union", 2)]
    assert volume(found) == pytest.approx(10.5, rel=1e-12)
    assert found.quadrature is None
