"""Whether shells may cross is told by boxes of their triangles."""

from __future__ import annotations

import numpy as np
import pytest

from robodyn.solids.mesh.inside import may_cross


@pytest.mark.parametrize("rows", [10, 50])
@pytest.mark.parametrize(("shift", "meet"), [(0.5, False), (0.01, True)])
def test_boxes_are_told_apart_in_pairs_or_by_cells(rows: int, shift: float, meet: bool) -> None:
    """Two wavy layers within one another's range; those of 2500 boxes are compared by the cells that they touch."""
    x, y = np.divmod(np.arange(rows * rows), rows)
    low = np.stack([x, y, np.sin(0.3 * x)], axis=1)
    boxes = np.stack([low, low + np.array([0.2, 0.2, 0.02])])
    assert may_cross(boxes, boxes + np.array([0.0, 0.0, shift])) == meet
