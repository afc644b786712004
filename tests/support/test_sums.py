"""Sums over named axes, where some have length zero and what is new holds dirt."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.dirty_memory import DIRT, soil

from robodyn.support.floats import einsum


@pytest.mark.parametrize(
    ("subscripts", "shapes"),
    [
        ("ij,j->i", [(2, 0), (0,)]),
        ("ij,jk->ik", [(0, 3), (3, 2)]),
        ("ij,j->", [(2, 3), (3,)]),
        ("abc,cb,a->", [(2, 0, 3), (3, 0), (2,)]),
        ("abc,cd->bd", [(2, 3, 2), (2, 3)]),
    ],
)
@pytest.mark.parametrize("order", ["C", "F"])
def test_sums_are_those_of_their_terms_whatever_stands_in_memory(subscripts, shapes, order, monkeypatch):
    rng = np.random.default_rng(1)
    factors = [np.asarray(rng.normal(size=shape) + 1j * rng.normal(size=shape), order=order) for shape in shapes]
    soil(monkeypatch)
    for parts in (factors, [factor.real for factor in factors]):
        found = einsum(subscripts, *parts)
        axes, kept = subscripts.split("->")
        lengths = dict(
            pair for names, x in zip(axes.split(","), parts, strict=True) for pair in zip(names, x.shape, strict=True)
        )
        expected = np.zeros([lengths[name] for name in kept], np.result_type(*parts))
        for place in np.ndindex(*lengths.values()):
            at = dict(zip(lengths, place, strict=True))
            terms = (x[tuple(at[name] for name in names)] for names, x in zip(axes.split(","), parts, strict=True))
            expected[tuple(at[name] for name in kept)] += np.prod([*terms])
        assert (found.shape, found.dtype) == (expected.shape, expected.dtype)
        np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-13)


def test_soiled_sums_over_nothing_are_dirt(monkeypatch):
    """What the tests of this file rest on."""
    soil(monkeypatch)
    assert (np.einsum("ij,j->i", np.zeros((2, 0)), np.zeros(0)) == DIRT).all()
    assert (np.empty(3) == DIRT).all()
