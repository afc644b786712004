"""The pseudo-inertia: closed forms, and what it says of bodies that can exist."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from robodyn.identification.parameters.prior import divergence, parameters_of, pseudo_inertia

EPS = np.finfo(float).eps


def cloud(seed, points=6):
    """Masses and places of a few points."""
    rng = np.random.default_rng(seed)
    return rng.uniform(0.1, 2.0, points), rng.normal(size=(points, 3))


def test_of_a_cloud_of_points_it_is_the_integral():
    m, x = cloud(1)
    I = np.einsum(
        "k,kij->ij", m, np.einsum("kd,kd->k", x, x)[:, None, None] * np.eye(3) - np.einsum("ki,kj->kij", x, x)
    )
    P = pseudo_inertia(np.array((m.sum(), *(m @ x), *I[np.triu_indices(3)])))
    homogeneous = np.column_stack((x, np.ones(len(m))))
    expected = np.einsum("k,ki,kj->ij", m, homogeneous, homogeneous)
    assert np.abs(P - expected).max() <= 16 * EPS * np.abs(expected).max()


@given(st.integers(0, 1000), st.integers(-9, 9))
def test_parameters_and_back(seed, decade):
    parameters = np.random.default_rng(seed).normal(size=(3, 10)) * 10.0**decade
    back = parameters_of(pseudo_inertia(parameters))
    assert np.abs(back - parameters).max() <= 4 * EPS * np.abs(parameters).max()


def test_the_divergence_does_not_depend_on_axes_origin_or_units():
    (m, x), (m0, x0) = cloud(2), cloud(3)
    T = np.array(((1e3, 20.0, 0.0, 5.0), (0.0, 1e3, 7.0, 3.0), (0.0, 0.0, 1e3, 1.0), (0.0, 0.0, 0.0, 1e-2)))
    P, P0 = (np.einsum("k,ki,kj->ij", a, *(np.column_stack((b, np.ones(len(a)))),) * 2) for a, b in ((m, x), (m0, x0)))
    here, there = divergence(P, P0), divergence(T @ P @ T.T, T @ P0 @ T.T)
    assert abs(here - there) <= 1e-9 * here
    ratio = np.linalg.solve(P0, P)
    assert abs(here - (np.trace(ratio) - np.linalg.slogdet(ratio)[1] - 4)) <= 1e-10 * here
    assert abs(divergence(P0, P0)) <= 64 * EPS
