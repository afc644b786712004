"""Programs as SymPy expressions, and names as identifiers."""

from __future__ import annotations

import random
import sys

import numpy as np
import pytest
import sympy
from helpers.oracles import worst
from helpers.random_programs import random_program
from hypothesis import example, given
from hypothesis import strategies as st

from robodyn.equations.closed import expressions, number
from robodyn.equations.ode import identifier, identifiers
from robodyn.errors import InputError
from robodyn.programs.run.numpy_blocks import NumpyBlocks


@pytest.mark.parametrize("seed", range(3))
def test_random_programs(seed):
    program, widths = random_program(random.Random(seed), 25)
    symbols = {(source, i): sympy.Symbol(f"{source}{i}", real=True) for source in widths for i in range(widths[source])}
    found = expressions(program, symbols)
    sources = {name: np.random.default_rng(seed).uniform(-2, 2, (3, width)) for name, width in widths.items()}
    expected = NumpyBlocks(program, widths)(sources, 3)
    for row in range(3):
        values = {symbol: sources[source][row, i] for (source, i), symbol in symbols.items()}
        assert worst([float(entry.evalf(30, subs=values)) for entry in found], expected[row]) <= 1e-13


@example(9.48081709062641e275)  # its digits, in 17 and more bits than a double has, would be another
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_are_the_same_doubles(value):
    assert float(number(value)) == value


def test_short_decimals_are_exact(monkeypatch):
    assert number(0.1) == sympy.Rational(1, 10)
    assert number(-9.81) == sympy.Rational(-981, 100)
    assert not number(1 / 3).is_Rational
    monkeypatch.setitem(sys.modules, "sympy", None)
    with pytest.raises(InputError, match=r'closed forms need sympy.*pip install "robodyn\[symbolic\]"'):
        number(1.0)


@given(st.lists(st.text(), max_size=8))
def test_identifiers(names):
    found = identifiers(names, "joint")
    assert all(name.isidentifier() and name.isascii() and name[0].isalpha() for name in found)
    assert len({name.lower() for name in found}) == len(names)


def test_plain_names_stay():
    assert identifiers(["shoulder", "Elbow_2", "elbow-2", "7th", "", "\u00fc"], "joint") == (
        *("shoulder", "Elbow_2", "elbow_2_2"),
        *("joint_7th", "joint", "joint_2"),
    )
    assert identifier("a b/c", "robot") == "a_b_c"
