"""What keeps a surface open is told as repair tells it."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mesh_samples import box, cylinder, flipped, moved, sheet, uv_sphere
from helpers.one_sided import klein_bottle

from robodyn.errors import MeshError
from robodyn.solids.mesh.holes import Gaps, gaps
from robodyn.solids.mesh.repair import repair
from robodyn.solids.mesh.triangles import MemoryTriangles

BALL = uv_sphere(rings=8, sectors=12)
SURFACES = {
    "sound": box(),
    "a face short": box()[1:],
    "a side short": box()[2:],
    "three faces short": BALL[[k for k in range(len(BALL)) if k not in (20, 60, 100)]],
    "half a ball": BALL[: len(BALL) // 2],
    "a face twice": np.concatenate([box(), box()[:1]]),
    "a stray sheet": np.concatenate([box(), moved(0.01 * sheet(), (2.0, 0.0, 0.0))]),
    "a sheet": sheet(),
    "wound at random": np.where((np.arange(12) % 3 > 0)[:, None, None], box(), flipped(box()))[1:],
    "two open bodies": np.concatenate([box()[2:], moved(cylinder(), (4.0, 0.0, 0.0))[3:]]),
}


@pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
def test_as_repair_has_it(surface: np.ndarray) -> None:
    triangles = MemoryTriangles("part", surface)
    found, fixed = gaps(triangles), repair(triangles)
    steps = {step.name: step for step in fixed.steps}
    assert (not found.left) == fixed.closed
    assert found.missing == fixed.missing
    assert found.one_sided == 0
    words = steps["holes"].what.split(" filled")[0] if "holes" in steps else ""
    assert found.mended == sum(int(word) for word in words.split() if word.isdigit())
    if "winding numbers" in steps:
        assert steps["winding numbers"].count == found.left


def test_one_sided_ones_are_told_where_repair_refuses_them() -> None:
    triangles = MemoryTriangles("part", klein_bottle()[1:])
    assert gaps(triangles) == Gaps(one_sided=len(klein_bottle()) - 1)
    with pytest.raises(MeshError, match="one side only"):
        repair(triangles)


def test_nothing_is_left_of_faces_without_area() -> None:
    assert gaps(MemoryTriangles("part", np.zeros((2, 3, 3)))) == Gaps()
