"""Eigenvalues of general matrices against LAPACK, exact ones and their own bound."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.oracles import EPS

from robodyn.programs.linear import general_eigen


@pytest.mark.parametrize("n", [1, 2, 3, 8, 24])
@pytest.mark.parametrize("spread", [0.0, 4.0])
def test_lapack(n, spread):
    """Within 8 n eps of the scaled size times the condition numbers; what belongs to them holds."""
    rng = np.random.default_rng(n)
    rows = 10.0 ** rng.uniform(-spread, spread, n)
    A = rng.normal(size=(n, n)) * rows[:, None] / rows
    found = general_eigen(A)
    expected = np.linalg.eigvals(A / rows[:, None] * rows)
    bound = 8 * n * EPS * found.size * found.conditions
    assert (np.abs(expected[:, None] - found.values).min(axis=0) <= bound).all()
    assert (np.abs(expected[:, None] - found.values).min(axis=1) <= bound.max()).all()
    scale = 8 * n * EPS * np.abs(A).max() * n
    assert np.abs(A @ found.right - found.right * found.values).max() <= scale
    assert np.abs(found.left.conj().T @ A - found.values[:, None] * found.left.conj().T).max() <= scale
    assert np.abs(np.linalg.norm(found.right, axis=0) - 1).max() <= 8 * EPS


def test_exact_ones():
    assert not general_eigen(np.zeros((3, 3))).values.any()
    assert (general_eigen(np.eye(4)).values == 1).all()
    found = general_eigen(np.roll(np.eye(4), 1, axis=0))
    assert np.abs(found.conditions - 1).max() <= 8 * EPS
    turn = found.values
    assert np.abs(np.sort_complex(turn) - np.array([-1, -1j, 1j, 1])).max() <= 8 * EPS


def test_two_that_meet_have_a_large_condition_number():
    assert general_eigen(np.array([[0.0, 1.0], [-1.0, -2.0]])).conditions.min() >= 1e7


def test_far_scales():
    """Osborne's scaling: 1e12 beside 1e-12, and the eigenvalues are +-1."""
    found = general_eigen(np.array([[0.0, 1e12], [1e-12, 0.0]]))
    assert np.abs(np.sort(found.values.real) - [-1, 1]).max() <= 4 * EPS
    assert found.conditions.max() <= 1.01


@pytest.mark.parametrize("entry", [np.nan, np.inf])
def test_not_finite(entry):
    with pytest.raises(np.linalg.LinAlgError, match="not finite"):
        general_eigen(np.array([[0.0, entry], [1.0, 0.0]]))
