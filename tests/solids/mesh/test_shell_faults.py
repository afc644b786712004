"""Shells that are inside out or overlap, told apart without a repair."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mesh_samples import box, flipped, moved, torus, uv_sphere

from robodyn.solids.mesh.inside import shell_faults
from robodyn.solids.mesh.read.load import from_array
from robodyn.solids.mesh.repair import repair

ROUND = uv_sphere()
CASES = {
    "one": ([box()], 0, False),
    "inside out": ([flipped(box())], 1, False),
    "apart": ([box(), moved(box(), (2.0, 0.0, 0.0))], 0, False),
    "a cavity": ([box(), flipped(box((0.5, 0.5, 0.5)))], 0, False),
    "a body in a cavity": ([box(), flipped(box((0.8, 0.8, 0.8))), box((0.5, 0.5, 0.5))], 0, False),
    "one of two inside out": ([box(), moved(flipped(box()), (2.0, 0.0, 0.0))], 1, False),
    "both inside out": ([flipped(box()), moved(flipped(box()), (2.0, 0.0, 0.0))], 2, False),
    "crossing": ([box((3.0, 1.0, 1.0)), moved(box((1.0, 3.0, 0.5)), (0.1, 0.0, 0.0))], 0, True),
    "shifted": ([box(), moved(box(), (0.5, 0.5, 0.5))], 0, True),
    "touching": ([box(), moved(box(), (1.0, 0.25, 0.25))], 0, False),
    "through a ring": ([torus(2.0, 0.5, 24, 12), box((0.5, 0.5, 6.0))], 0, False),
    "round ones": ([ROUND, moved(ROUND, (0.7, 0.2, 0.1))], 0, True),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_known_cases(case: str, size: float) -> None:
    parts, inverted, overlapping = CASES[case]
    assert shell_faults(from_array(size * np.concatenate(parts))) == (inverted, overlapping)


@pytest.mark.parametrize("seed", range(12))
def test_what_is_found_is_there(seed: int) -> None:
    """Against the union of the repair, which finds every overlap."""
    rng = np.random.default_rng(seed)
    parts = [moved(box(rng.uniform(0.3, 1.0, 3)), rng.uniform(-1.0, 1.0, 3)) for _ in range(4)]
    triangles = from_array(np.concatenate(parts))
    inverted, overlapping = shell_faults(triangles)
    steps = {step.name for step in repair(triangles).steps}
    assert inverted == 0
    assert overlapping == bool(steps & {"union", "overlaps"})
