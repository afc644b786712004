"""Every method against closed forms and exact rationals, with the order in which its error falls."""

from __future__ import annotations

import numpy as np
import pytest

from robodyn.errors import MeshError
from robodyn.measure.accuracy.meshes import (
    by_box,
    by_columns,
    by_decimation,
    by_hull,
    by_voxels,
    by_winding_numbers,
    inertia,
    integral_operations,
    mesh_accuracy,
    union_with_a_copy,
)
from robodyn.solids.mesh.read.load import from_array

TETRAHEDRON = np.array([(0, 0, 0), (5, 0, 0), (0, 4, 0), (0, 0, 3)], float)[
    np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
]
I_TETRAHEDRON = np.array([[9.375, 2.5, 1.875], [2.5, 12.75, 1.5], [1.875, 1.5, 15.375]])


def error(moments) -> float:
    off = inertia(moments).astype(float) - I_TETRAHEDRON
    return max(abs(float(moments.volume) / 10 - 1), float(np.linalg.norm(off) / np.linalg.norm(I_TETRAHEDRON)))


def test_box() -> None:
    found = by_box(TETRAHEDRON)
    assert found.volume == 60
    expected = 60 / 12 * np.diag([4**2 + 3**2, 5**2 + 3**2, 5**2 + 4**2])
    np.testing.assert_allclose(inertia(found).astype(float), expected, rtol=0, atol=2e-13)


def test_hull_of_a_convex_body_is_the_body() -> None:
    assert error(by_hull(TETRAHEDRON)) < 1e-15


def test_columns_converge() -> None:
    """Error of sums over a lattice of columns falls at least in proportion to their distance."""
    errors = [error(by_columns(TETRAHEDRON, count)) for count in (256, 4096, 65536)]
    assert errors[0] < 2e-2
    assert errors[1] < errors[0] / 4
    assert errors[2] < errors[1] / 4


def test_voxels_converge() -> None:
    errors = [error(by_voxels(TETRAHEDRON, count)) for count in (64, 1024, 16384)]
    assert errors[0] < 1e-1
    assert errors[1] < errors[0] / 4
    assert errors[2] < errors[1] / 4


def test_chance_is_within_its_deviation() -> None:
    """A sixth of the box is inside: the relative deviation of the volume is sqrt(5 / N)."""
    for count in (1000, 30000):
        assert abs(by_winding_numbers(TETRAHEDRON, count).volume / 10 - 1) < 3 * np.sqrt(5 / count)


def test_ladder_of_a_tetrahedron() -> None:
    found = mesh_accuracy(from_array(TETRAHEDRON + 1 / 3))
    (ladder,) = found.ladders
    errors = {rung.name: rung.error for rung in ladder.rungs}
    assert errors["integral, exact rationals"] <= 2.0**-53
    assert errors["integral, float64"] < 16 * 2.0**-52
    assert errors["integral, escalated to float64"] == errors["integral, float64"]
    kinds = ("bounding box", "convex hull", "decimated", "voxels", "columns", "winding numbers")
    assert all(any(kind in name for name in errors) for kind in kinds)
    assert 1e-12 < errors["integral, float32"] < 1e-6
    assert {rung.name: rung.errors[0] for rung in ladder.rungs}["bounding box"] == pytest.approx(5, rel=1e-14)
    assert [price.name for price in found.prices] == [
        *("proof that it is closed", "proof that it is one shell", "repair ladder", "tessellation error"),
        *("union with a copy of it", "symmetry"),
    ]


def test_a_body_of_few_triangles_is_not_decimated() -> None:
    assert error(by_decimation(TETRAHEDRON, 1e-3)) < 1e-14


def test_union_with_a_copy() -> None:
    """A fifth of the box apart they share a tetrahedron of 2 / 5 of the size."""
    assert union_with_a_copy(TETRAHEDRON) == pytest.approx(20 - 10 * 0.4**3, rel=1e-12)


def test_no_manifold_is_left_out_and_said() -> None:
    with pytest.raises(MeshError, match="no manifold"):
        by_decimation(TETRAHEDRON[:3], 1e-3)


@pytest.mark.parametrize("scale", [2.0**-50, 2.0**40])
def test_sizes_that_single_precision_cannot_hold(scale: float) -> None:
    found = mesh_accuracy(from_array((TETRAHEDRON + 1 / 3) * scale))
    errors = {rung.name: rung.error for rung in found.ladders[0].rungs}
    assert errors["integral, float64"] < 16 * 2.0**-52
    assert errors.get("integral, float32", 1.0) >= 0.1
    assert ("integral, float32" not in errors) == ("integral, float32: finds no volume" in found.notes)


def test_what_is_open_has_no_exact_reference() -> None:
    with pytest.raises(MeshError, match="no definite volume"):
        mesh_accuracy(from_array(TETRAHEDRON[:1]))


def test_operations_are_counted() -> None:
    assert integral_operations(1000) == 1000 * integral_operations(1)
    assert 80 < integral_operations(1) < 200
