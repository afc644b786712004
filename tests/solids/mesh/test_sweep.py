"""What a pass over the triangles finds besides its moments."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mesh_oracle import exact, rotation
from helpers.mesh_samples import binary_stl, box, cylinder, moved, torus
from helpers.sampled import sampled

from robodyn.errors import MeshError
from robodyn.solids.mesh.integrals import integrate, measure, swept
from robodyn.solids.mesh.kernel import volume_kernel
from robodyn.solids.mesh.read.load import load_triangles
from robodyn.solids.mesh.triangles import ROWS, MemoryTriangles

SQUARES = slice(11, 17)
BODIES = {
    "box": box((1, 2, 3)),
    "plate": moved(box((1, 1, 1e-6)), (0.1, 0.2, 0.3), rotation(5)),
    "torus": moved(torus(), (3, 2, 1), rotation(1)),
    "several blocks": np.concatenate([cylinder(1, 1, ROWS // 3), moved(box(), (3, 0, 0))]),
    "noise": np.random.default_rng(7).normal(size=(500, 3, 3)),
}


def exact_perm(array, reference):
    """Sum of a . |(b - a) x (c - a)| with all products taken as positive, as a fraction."""
    a = np.abs(exact(array[:, 0]) - exact(reference))
    e, f = (np.abs(exact(array[:, k]) - exact(array[:, 0])) for k in (1, 2))
    return sum((a[:, i] * (e[:, i - 2] * f[:, i - 1] + e[:, i - 1] * f[:, i - 2])).sum() for i in range(3))


@pytest.mark.parametrize("name", sampled(BODIES, 3))
def test_perm_is_a_bound_and_no_wild_one(name):
    sweep = swept(MemoryTriangles(name, BODIES[name]), volume_kernel)
    bound, least = sweep.perm(sweep.sums[:, SQUARES]), float(exact_perm(BODIES[name], sweep.reference))
    assert least <= bound * (1 + 1e-14)
    assert bound <= 12 * least


def test_perm_is_near_where_blocks_are_small_parts():
    array = torus(2.0, 0.5, 600, 40)
    sweep = swept(MemoryTriangles("torus", array), volume_kernel)
    assert sweep.perm(sweep.sums[:, SQUARES]) <= 5 * float(exact_perm(array[::7], sweep.reference) * 7)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("face", [0, ROWS - 1, ROWS + 5])
@pytest.mark.parametrize("use", [integrate, measure])
def test_a_corner_of_a_streamed_file_that_is_not_finite_names_its_face(use, face, value):
    corners = cylinder(1, 1, ROWS).astype(np.float32)
    corners[face, 1, 2] = value
    with pytest.raises(MeshError, match=rf"face {face + 1} has a corner at \(.*{value:g}\)"):
        use(load_triangles(binary_stl(corners)))
