"""How often what is costly is done in search of gaps: once for the same faces."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest
from helpers.mesh_samples import box, cylinder, moved, uv_sphere

from robodyn.solids.mesh import indexed
from robodyn.solids.mesh.repair import clean, holes
from robodyn.solids.mesh.repair.gaps import gaps
from robodyn.solids.mesh.triangles import MemoryTriangles

BALL = uv_sphere(rings=8, sectors=12)


@pytest.fixture
def sorts(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """Counts how often keys of so many faces or corners are sorted, and faces have their areas computed."""
    counts: Counter[str] = Counter()

    def count(owner: Any, name: str) -> None:
        function = getattr(owner, name)

        def call(*arguments: Any) -> Any:
            counts[name] += 1
            return function(*arguments)

        monkeypatch.setattr(owner, name, call)

    count(indexed, "distinct_points")
    count(indexed, "distinct")
    count(indexed, "areas")
    count(clean, "distinct")
    count(holes, "areas")
    return counts


@pytest.mark.parametrize(
    "surface",
    [BALL[1:], BALL[: len(BALL) // 2], np.concatenate([box()[2:], moved(cylinder(), (4.0, 0.0, 0.0))[3:]])],
    ids=["a face short", "half", "two open bodies"],
)
def test_of_open_shells_the_edges_are_found_once(surface: np.ndarray, sorts: Counter[str]) -> None:
    """Corners once, edges once, faces twice (by two corners, and by the third); areas of faces, and of caps, once."""
    gaps(MemoryTriangles("part", surface))
    assert sorts == {"distinct_points": 1, "distinct": 3, "areas": 2}


def test_beside_a_closed_shell_edges_are_found_anew_for_the_rest(sorts: Counter[str]) -> None:
    gaps(MemoryTriangles("part", np.concatenate([moved(BALL, (9.0, 0.0, 0.0)), BALL[1:]])))
    assert sorts["distinct"] == 4
