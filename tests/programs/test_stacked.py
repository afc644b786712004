"""Least squares of many matrices at once against NumPy's, one by one."""

from __future__ import annotations

import numpy as np
import pytest

from robodyn.programs.stacked import least_squares


@pytest.mark.parametrize("shape", [(5, 2, 2, 1), (40, 6, 4, 3), (9, 5, 5, 2), (7, 3, 1, 2)], ids=str)
def test_solutions_are_numpys(shape):
    N, m, k, r = shape
    rng = np.random.default_rng(k)
    A, B = rng.normal(size=(N, m, k)), rng.normal(size=(N, m, r))
    found = least_squares(A, B)
    for i in range(N):
        x = np.linalg.lstsq(A[i], B[i], rcond=None)[0]
        assert np.abs(found.x[i] - x).max() <= 1e-14 * np.abs(x).max() / found.ratio[i]
        rest = np.linalg.norm(A[i] @ x - B[i], axis=0)
        assert np.abs(found.rest[i] - rest).max() <= 1e-14 * np.linalg.norm(B[i]) / found.ratio[i]
        if m == k:
            assert found.sign[i] == np.sign(np.linalg.det(A[i]))


def test_the_ratio_tells_columns_that_depend_on_each_other():
    A = np.random.default_rng(0).normal(size=(3, 4, 3))
    A[1, :, 2] = A[1, :, 0] - 2.0 * A[1, :, 1]
    A[2, :, 2] *= 1e-3
    ratio = least_squares(A, A[:, :, :1]).ratio
    assert ratio[0] > 0.05
    assert ratio[1] <= 1e-15
    assert 1e-4 < ratio[2] < 1e-2
    assert least_squares(A[:, :2], A[:, :2, :1]).ratio.max() == 0.0


def test_nothing_to_solve_for():
    found = least_squares(np.zeros((4, 3, 0)), np.ones((4, 3, 1)))
    assert found.x.shape == (4, 0, 1)
    assert np.abs(found.rest - np.sqrt(3.0)).max() <= 1e-15
