"""Closed forms against textbooks and the recursion in numbers; programs as SymPy expressions; names as identifiers."""

from __future__ import annotations

import random
import sys

import numpy as np
import pytest
import sympy
from helpers.command_line import ROBOTS
from helpers.oracles import random_state, worst
from helpers.random_programs import random_program
from helpers.small_robots import built, joint, link, random_tree
from hypothesis import example, given
from hypothesis import strategies as st

import robodyn
from robodyn.equations import closed as closed_module
from robodyn.equations.closed import closed
from robodyn.equations.forms import Forms, number
from robodyn.equations.ode import identifier, identifiers, ode
from robodyn.errors import InputError
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.scene.scene import Scene

R = sympy.Rational


def load(name):
    return robodyn.load(ROBOTS / f"{name}.urdf")


def equal(found, expected):
    return sympy.simplify(sympy.expand_trig(found - expected)) == 0


def evaluated(found, q, qd, qdd):
    symbols = [*found.q, *found.qd]
    M = sympy.lambdify(symbols, [list(row) for row in found.M])
    bias = sympy.lambdify(symbols, [list(share) for share in found.bias.values()])
    states = np.concatenate([q, qd], axis=1)
    return np.array([np.array(M(*x)) @ a + np.sum(bias(*x), axis=0) for x, a in zip(states, qdd, strict=True)])


def test_craig():
    found = closed(load("two_link_planar"))
    (q1, q2), (w1, w2) = found.q, found.qd
    l1, l2, m1, m2, g = R("0.5"), R("0.4"), 4, R("2.5"), R("9.81")
    c1, c2, s2, c12 = sympy.cos(q1), sympy.cos(q2), sympy.sin(q2), sympy.cos(q1 + q2)
    assert found.M[0][0] == l2**2 * m2 + 2 * l1 * l2 * m2 * c2 + l1**2 * (m1 + m2)
    assert found.M[0][1] == found.M[1][0] == l2**2 * m2 + l1 * l2 * m2 * c2
    assert found.M[1][1] == l2**2 * m2
    V, G = found.bias["coriolis"], found.bias["gravity"]
    assert equal(V[0], -m2 * l1 * l2 * s2 * (w2**2 + 2 * w1 * w2))
    assert equal(V[1], m2 * l1 * l2 * s2 * w1**2)
    assert (m2 * l2 * g * c12 + (m1 + m2) * l1 * g * c1, m2 * l2 * g * c12) == G
    assert list(found.bias) == ["gravity", "coriolis"]


@pytest.mark.parametrize("seed", range(3))
def test_skew_robots(seed):
    model = random_tree(seed, 3, kinds=("revolute", "prismatic", "continuous"))
    found = closed(model)
    q, qd, qdd = random_state(model, np.random.default_rng(4), 5)
    assert worst(evaluated(found, q, qd, qdd), robodyn.inverse_dynamics(model, q, qd, qdd)) <= 1e-13
    assert found.error <= 1e-13


def test_a_mimic_joint_with_an_offset():
    parts = [link("a"), *(link(name, 2, (0.3, 0, 0), (0.1, 0, 0, 0.1, 0, 0.1)) for name in "bc")]
    follow = '<mimic joint="j1" multiplier="-0.5" offset="0.4"/>'
    joints = joint("j1", "a", "b", axis=(0, 1, 0)), joint("j2", "b", "c", axis=(0, 1, 0), xyz=(0.5, 0, 0), more=follow)
    model = built(*parts, *joints)
    found = closed(model)
    q, qd, qdd = random_state(model, np.random.default_rng(5), 8)
    assert worst(evaluated(found, q, qd, qdd), robodyn.inverse_dynamics(model, q, qd, qdd)) <= 1e-14
    assert found.q[0] / 2 in {angle for wave in found.M[0][0].atoms(sympy.sin, sympy.cos) for angle in wave.args}


def test_fluid_drag_keeps_its_roots():
    model = load("two_link_planar")
    scene = Scene(immersed=(robodyn.Immersed("forearm", 1e-3, (0.1, 0, 0), (0.1, 0.2, 0.3)),), fluid_density=1000.0)
    found = closed(model, scene)
    q, qd, qdd = random_state(model, np.random.default_rng(6), 5)
    expected = robodyn.inverse_dynamics(model, q, qd, qdd, scene=scene)
    assert worst(evaluated(found, q, qd, qdd), expected) <= 1e-13


def test_an_entry_that_fails_its_check_is_not_used(monkeypatch):
    right = Forms.assembled
    monkeypatch.setattr(Forms, "assembled", lambda *args: right(*args) * (1 + R(1, 10**10)))
    with pytest.raises(InputError, match=r"the closed form is 1\.0e-10 off the recursion in numbers"):
        closed(load("two_link_planar"))


def test_refusals(monkeypatch):
    remedy = "--form ode has numbers at a configuration, robodyn export writes them as code"
    with pytest.raises(InputError, match="7 coordinates are too many for a closed form, which goes up to 6") as error:
        closed(random_tree(1, 7, kinds=("revolute",)))
    assert error.value.remedy == remedy
    monkeypatch.setattr(closed_module, "PRODUCTS", 5)
    for symbols, first in ((), ""), (("m",), "letters for fewer kinds, as --symbols m,l, make it shorter; "):
        with pytest.raises(InputError, match="the closed form of this robot is too long to be read") as error:
            closed(load("scara"), symbols=symbols)
        assert error.value.remedy == first + remedy


def test_shares_add_up_to_the_bias():
    scene = robodyn.load_scene(ROBOTS / "gripper.toml")
    found = ode(load("gripper"), scene, [0.1, 0.2, 0.01], {"wrist": -1.0, "lift": 0.2})
    assert worst(np.sum(list(found.shares.values()), axis=0), found.bias) <= 1e-15
    assert list(found.shares) == [
        "gravity",
        "coriolis",
        "payload",
        "viscous friction",
        "coulomb friction",
        "joint spring",
    ]
    assert found.units == ("N", "N m", "N")
    assert found.cond == pytest.approx(np.linalg.cond(found.M), rel=1e-12)


def test_a_singular_mass_matrix():
    parts = (link("a"), link("b", 1, (0.1, 0, 0), (1, 0, 0, 1, 0, 1)), link("c"))
    assert ode(built(*parts, joint("j1", "a", "b"), joint("j2", "b", "c"))).cond == np.inf


@pytest.mark.parametrize("seed", range(3))
def test_random_programs(seed):
    program, widths = random_program(random.Random(seed), 25)
    symbols = {(source, i): sympy.Symbol(f"{source}{i}", real=True) for source in widths for i in range(widths[source])}
    forms = Forms(symbols, 10**6)
    found = [forms.expression(form) for form in forms.outputs(program)]
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


@given(st.lists(st.text(st.sampled_from("aAz_Z09- ./\n\0\u00e9\u0663\uff0e\U0001d7d8")), max_size=8))
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
