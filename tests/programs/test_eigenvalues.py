"""Jacobi's eigenvalues against 160 digits: small ones of graded matrices, any matrix normwise, exact zeros kept."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from helpers.oracles import EPS

from robodyn.programs.linear import eigen


def _exact(S):
    """Descending eigenvalues with 160 digits."""
    with mpmath.workdps(160):
        return sorted(mpmath.eigsy(mpmath.matrix(S.tolist()), eigvals_only=True), reverse=True)


def _scaled(S):
    root = np.sqrt(np.diagonal(S))
    return S / np.outer(root, root)


@pytest.mark.parametrize("seed", range(60))
def test_small_eigenvalues_of_graded_matrices(seed):
    rng = np.random.default_rng(seed)
    spread = rng.normal(size=(3, 6))
    scale = 10.0 ** rng.uniform(-15, 15, 3)
    S = scale[:, None] * (spread @ spread.T) * scale
    S = (S + S.T) / 2
    bound = 8 * EPS * np.linalg.cond(_scaled(S))
    assert bound < 1e-10
    found, _ = eigen(S)
    for value, expected in zip(found, _exact(S), strict=True):
        assert abs(value - expected) <= bound * expected


@pytest.mark.parametrize("seed", range(60))
def test_any_symmetric_matrix(seed):
    rng = np.random.default_rng(seed)
    S = rng.normal(size=(3, 3)) * 10.0 ** rng.uniform(-200, 200)
    S = S + S.T
    if seed % 3 == 0:
        S = np.outer(S[0], S[0] / np.abs(S).max())
    found, axes = eigen(S)
    expected = _exact(S)
    largest = max(map(abs, expected))
    assert max(abs(f - e) for f, e in zip(found, expected, strict=True)) <= 8 * EPS * largest
    assert np.abs(axes @ axes.T - np.eye(3)).max() <= 8 * EPS
    assert np.abs(axes.T @ np.diag(found) @ axes - S).max() <= 16 * EPS * largest


def test_zeros_stay_zeros():
    found, axes = eigen(np.diag([1.0, 3.0, 2.0]))
    assert found.tolist() == [3.0, 2.0, 1.0]
    assert axes.tolist() == [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
    found, axes = eigen(np.array([[2.0, 1.0, 0], [1.0, 2.0, 0], [0, 0, 1e-30]]))
    assert found[2] == 1e-30
    assert axes[2].tolist() == [0, 0, 1]
    assert axes[:2, 2].tolist() == [0, 0]
    assert not eigen(np.zeros((3, 3)))[0].any()


def test_numbers_at_the_ends_of_the_range():
    huge = np.full((3, 3), 1e308) - np.diag([0.5e308, 0, 0])
    tiny = np.diag([3e-310, 2e-310, 1e-310])
    assert np.isfinite(eigen(huge)[1]).all()
    assert eigen(tiny)[0].tolist() == [3e-310, 2e-310, 1e-310]
    assert np.isfinite(eigen(np.array([[1.0, 1e-320, 0], [1e-320, 0.0, 0], [0, 0, 1.0]]))[0]).all()


@pytest.mark.parametrize("n", [1, 2, 4, 9])
def test_matrices_of_other_sizes(n):
    """Against LAPACK; and V S V^T is diagonal."""
    A = np.random.default_rng(n).normal(size=(n, n))
    S = A @ A.T
    values, vectors = eigen(S)
    largest = np.linalg.eigvalsh(S)[-1]
    np.testing.assert_allclose(values, np.linalg.eigvalsh(S)[::-1], rtol=0, atol=16 * n * EPS * largest)
    np.testing.assert_allclose(vectors @ vectors.T, np.eye(n), atol=4 * n * EPS)
    np.testing.assert_allclose(vectors @ S @ vectors.T, np.diag(values), atol=16 * n * EPS * largest)
