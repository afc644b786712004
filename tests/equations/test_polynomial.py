"""Trigonometric polynomials against the functions that they stand for."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robodyn.equations.closed import ONE, Budget, TooLargeError, constant, generator, linear, product, total, wave

X = (0.7, -1.3, 2.1)
multiples = st.tuples(*[st.sampled_from([-2.0, -1.0, 0.0, 0.5, 1.0])] * 3)
leaves = st.one_of(
    st.sampled_from([0.0, 1.0, -2.5, 0.3]).map(lambda x: (constant(x), x)),
    st.integers(0, 2).map(lambda k: (generator(k), X[k])),
    st.tuples(st.sampled_from(["sin", "cos"]), multiples).map(
        lambda pair: (wave(*pair), getattr(math, pair[0])(math.fsum(m * x for m, x in zip(pair[1], X, strict=True))))
    ),
)


def joined(pair):
    return st.tuples(st.sampled_from("+-*"), pair, pair).map(_apply)


def _apply(step):
    op, (a, x), (b, y) = step
    if op == "*":
        return product(a, b, Budget(10**6)), x * y
    return (total(a, b), x + y) if op == "+" else (total(a, b, -1.0), x - y)


def value(form):
    """The value at X, and the sum of the magnitudes that add up to it."""
    terms = []
    for key, (coefficient, _) in form.items():
        angle = math.fsum(m * X[k] for k, m in enumerate(key.angle))
        terms.append(coefficient * math.prod(X[k] for k in key.powers) * getattr(math, key.wave)(angle))
    return math.fsum(terms), math.fsum(map(abs, terms))


@given(st.recursive(leaves, joined, max_leaves=8))
def test_sums_and_products(pair):
    form, expected = pair
    found, size = value(form)
    sizes = math.fsum(entry.size for entry in form.values())
    assert abs(found - expected) <= 1e-14 * (sizes * 20 + size + 500)


@pytest.mark.parametrize("kind", ["sin", "cos"])
def test_equal_functions_have_equal_forms(kind):
    budget = Budget(100)
    s, c = wave("sin", (1.0,)), wave("cos", (1.0,))
    one = total(product(s, s, budget), product(c, c, budget))
    assert {key: entry.value for key, entry in one.items()} == {ONE: 1.0}
    a, b = (1.0, 2.0, 0.0), (0.0, 1.0)
    first, second = ("sin", "cos") if kind == "sin" else ("cos", "sin")
    sum_of = wave(kind, (1.0, 3.0))
    parts = product(wave(first, a), wave("cos", b), budget), product(wave(second, a), wave("sin", b), budget)
    left = total(*parts, 1.0 if kind == "sin" else -1.0)
    assert {key: entry.value for key, entry in left.items()} == {key: entry.value for key, entry in sum_of.items()}


def test_what_is_linear():
    assert linear(total(generator(1), constant(0.5))) == ((0.0, 1.0), 0.5)
    assert linear({}) == ((), 0.0)
    assert linear(product(generator(1), generator(1), Budget(9))) is None
    assert linear(wave("cos", (1.0,))) is None


def test_budget():
    two = total(generator(0), generator(1))
    product(two, two, Budget(4))
    with pytest.raises(TooLargeError):
        product(two, two, Budget(3))
