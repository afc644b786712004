"""Bounds of arithmetic have three digits, rounded up: the same on every processor."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from robodyn.solids.mesh.integrals import Moments, volume_bound

ONE = Moments(Fraction(1), np.zeros(3), np.eye(3))


@pytest.mark.parametrize("perm", [1.0, 3.3, 12.34567, 9.999e5, 1e-3])
def test_last_digits_do_not_show(perm: float) -> None:
    bounds = [volume_bound(ONE, perm * (1 + k * 1e-15), 1e-16) for k in (-3, 0, 5)]
    exact = 8e-16 * perm + 2.0**-53
    assert len(set(bounds)) == 1
    assert exact <= bounds[0] <= 1.01 * exact
    assert float(f"{bounds[0]:.2e}") == bounds[0]
