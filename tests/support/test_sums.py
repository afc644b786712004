"""Sums over named axes, where some have length zero and what is new holds dirt."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.dirty_memory import DIRT, soil
from hypothesis import given
from hypothesis import strategies as st

from robodyn.support.floats import einsum

NAMES = "abcd"


@st.composite
def cases(draw: st.DrawFn) -> tuple[str, list[np.ndarray]]:
    """Subscripts of one to three factors and the factors, of float64 or complex128, in C's order or Fortran's."""
    lengths = {name: draw(st.integers(0, 3)) for name in NAMES}
    axes = draw(st.lists(st.lists(st.sampled_from(NAMES), max_size=3, unique=True), min_size=1, max_size=3))
    inner = sorted({name for each in axes for name in each})
    kept = draw(st.lists(st.sampled_from(inner), unique=True)) if inner else []
    rng = np.random.default_rng(draw(st.integers(0, 99)))
    factors = []
    for each in axes:
        values = rng.normal(size=[lengths[name] for name in each])
        values = values + 1j * rng.normal(size=values.shape) if draw(st.booleans()) else values
        factors.append(np.asarray(values, order=draw(st.sampled_from("CF"))))
    return ",".join(map("".join, axes)) + "->" + "".join(kept), factors


def summed(subscripts: str, factors: list[np.ndarray]) -> np.ndarray:
    """Return the sum, term by term."""
    axes, kept = subscripts.split("->")
    lengths = {
        name: n
        for names, x in zip(axes.split(","), factors, strict=True)
        for name, n in zip(names, x.shape, strict=True)
    }
    found = np.zeros([lengths[name] for name in kept], np.result_type(*factors))
    for place in np.ndindex(*lengths.values()):
        at = dict(zip(lengths, place, strict=True))
        term = 1.0
        for names, x in zip(axes.split(","), factors, strict=True):
            term = term * x[tuple(at[name] for name in names)]
        found[tuple(at[name] for name in kept)] += term
    return found


@given(cases())
def test_sums_are_those_of_their_terms_whatever_stands_in_memory(case):
    subscripts, factors = case
    with pytest.MonkeyPatch.context() as monkeypatch:
        soil(monkeypatch)
        found = einsum(subscripts, *factors)
    expected = summed(subscripts, factors)
    assert found.shape == expected.shape
    assert found.dtype == expected.dtype
    np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-13)


def test_soiled_sums_over_nothing_are_dirt(monkeypatch):
    """What the tests of this file rest on."""
    soil(monkeypatch)
    assert (np.einsum("ij,j->i", np.zeros((2, 0)), np.zeros(0)) == DIRT).all()
    assert (np.empty(3) == DIRT).all()
