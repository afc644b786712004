"""Closed forms in letters against Lagrange's equations, robots with other numbers, and the recursion."""

from __future__ import annotations

import keyword
import random
import re
from functools import cache

import mpmath
import numpy as np
import pytest
import sympy
from helpers.command_line import ROBOTS
from helpers.lagrangian import Lagrangian, operations
from helpers.oracles import random_state, worst
from helpers.small_robots import body_numbers, built, joint, link, random_tree

import robodyn
from robodyn.equations.closed import closed
from robodyn.equations.letters import KINDS, Lettered
from robodyn.errors import InputError
from robodyn.report.equations.latex import closed_latex
from robodyn.report.equations.python import closed_python
from robodyn.report.renderers.letters import latex_of, text_of
from robodyn.scene.scene import Scene

TWINS = {"m_2": "m_1", "c_2y": "-c_1y", "I_2xx": "I_1xx", "I_2yy": "I_1yy", "I_2zz": "I_1zz"}
SYSTEMS = {
    **{name: {} for name in ("two_link_planar", "two_link_spatial", "scara", "cylindrical", "puma")},
    "satellite": {"moving": True, "alike": TWINS},
}


BY_DEFAULT = ("two_link_planar", "scara")


@cache
def in_letters(name, moving=False, **more):
    return closed(robodyn.load(ROBOTS / f"{name}.urdf", moving_base=moving), symbols=KINDS, **more)


def module(found):
    space = {}
    exec(closed_python(found), space)
    return space


def torques(found, q, qd, qdd, **letters):
    """tau of the module for rows of states."""
    run = module(found)["torques"]
    return np.array([run(*row, **letters) for row in zip(q, qd, qdd, strict=True)], dtype=float)


@pytest.mark.parametrize("name", [x if x in BY_DEFAULT else pytest.param(x, marks=pytest.mark.slow) for x in SYSTEMS])
def test_lagrange(name):
    """Symbol by symbol: at 100 random points in 50 digits, of coordinates and of letters."""
    found = in_letters(name, SYSTEMS[name].get("moving", False))
    expected = Lagrangian(ROBOTS / f"{name}.urdf", **SYSTEMS[name]).entries
    assert list(found.entries) == list(expected)
    whole = [x for constant in reversed(found.constants.items()) for x in [constant]]
    mine = list(found.entries.values())
    for symbol, meaning in whole:
        mine = [x.xreplace({symbol: meaning}) for x in mine]
    symbols = sorted(set().union(*(x.free_symbols for x in [*mine, *expected.values()])), key=str)
    assert set().union(*(x.free_symbols for x in mine)) <= set(symbols)
    left, right = (sympy.lambdify(symbols, x, "mpmath", cse=True) for x in (mine, list(expected.values())))
    rng = random.Random(1)
    with mpmath.workdps(50):
        for _ in range(100):
            point = [mpmath.mpf(rng.uniform(-2, 2)) for _ in symbols]
            assert max(abs(a - b) for a, b in zip(left(*point), right(*point), strict=True)) <= mpmath.mpf("1e-40")


SHORTEST = {"two_link_planar": 38, "two_link_spatial": 173, "scara": 40, "cylindrical": 48, "satellite": 283}
"""Operations of SymPy's cse of the Lagrangian's result, in the shortest of the forms below."""


OF_PUMA = 666
"""Likewise, which takes four minutes to find."""


@pytest.mark.parametrize("name", [*SHORTEST, "puma"])
def test_it_is_short(name):
    found = in_letters(name, SYSTEMS[name].get("moving", False))
    assert operations([*found.constants.values(), *found.entries.values()]) <= 1.3 * SHORTEST.get(name, OF_PUMA)


@pytest.mark.slow
@pytest.mark.parametrize("name", SHORTEST)
def test_the_shortest_form_of_the_lagrangian(name):
    raw = list(Lagrangian(ROBOTS / f"{name}.urdf", **SYSTEMS[name]).entries.values())
    forms = [raw, [sympy.expand(x) for x in raw]]
    forms.append([sympy.trigsimp(x) for x in forms[1]])
    forms.append([sympy.factor_terms(x) for x in forms[2]])
    forms.append([sympy.collect(sympy.expand(x), sorted(x.free_symbols, key=str)) if x.args else x for x in forms[2]])
    counts = []
    for form in forms:
        for optimizations in (None, "basic"):
            shared, left = sympy.cse(form, optimizations=optimizations)
            counts.append(sum(sympy.count_ops(x) for x in (*(x for _, x in shared), *left)))
    assert min(counts) == SHORTEST[name]


@pytest.mark.parametrize("name", ["puma", "scara"])
def test_other_numbers_are_another_robot(name, tmp_path):
    """Every letter changed in the module against a description with that number changed."""
    text = (ROBOTS / f"{name}.urdf").read_text()
    found = in_letters(name)
    changes = {
        "puma": {"m_3": ('mass value="6.04"', 'mass value="7.5"', 7.5), "c_3z": ("0.014 -0.143", "0.014 -0.2", -0.2)},
        "scara": {
            "l_1": ('<origin xyz="0.4 0 0"/>\n    <axis', '<origin xyz="0.45 0 0"/>\n    <axis', 0.45),
            "I_2zz": ('izz="0.065"', 'izz="0.08"', 0.08),
        },
    }[name]
    for letter, (old, new, value) in changes.items():
        assert text.count(old) == 1
        (tmp_path / "r.urdf").write_text(text.replace(old, new))
        other = robodyn.load(tmp_path / "r.urdf")
        state = random_state(other, np.random.default_rng(2), 5)
        assert worst(torques(found, *state, **{letter: value}), robodyn.inverse_dynamics(other, *state)) <= 1e-12


def agrees(model, scene=Scene(), kinds=KINDS):  # noqa: B008
    found = closed(model, scene, symbols=kinds)
    q, qd, qdd = random_state(model, np.random.default_rng(3), 4)
    if model.floating:
        q[:, :7] = 0, 0, 0, 0, 0, 0, 1
    expected = robodyn.inverse_dynamics(model, q, qd, qdd, scene=scene)
    assert worst(torques(found, q[:, 7 * model.floating :], qd, qdd), expected) <= 1e-12
    assert len({letter.name for letter in found.symbols}) == len(found.symbols)
    assert all(letter.name.isidentifier() and not keyword.iskeyword(letter.name) for letter in found.symbols)
    return found


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 2, 3))])
def test_skew_trees(seed):
    model = random_tree(seed, 1 if seed == 3 else 3, moving_base=seed == 3, kinds=("revolute", "prismatic"))
    agrees(model, Scene(gravity=(1.0, -2.0, 3.5)))


def test_skew_links_side_by_side():
    """Of them the Coriolis part is nothing but rounding."""
    found = agrees(random_tree(1, 2, kinds=("revolute",)))
    assert set(found.bias["coriolis"]) == {0}
    assert not any(re.search(r"(?<![\w.])1\*", text_of(x)) for x in found.entries.values())


def test_terms_with_three_factors():
    """The hand of a six-joint arm beside its wrist and elbow."""
    assert "- A_1*s_2*s_4*s_5 " in text_of(in_letters("puma560").M[0][1])


def test_mimics_frictions_payloads():
    rng = np.random.default_rng(5)
    follow = '<mimic joint="j1" multiplier="-0.5" offset="0.4"/>'
    model = built(
        link("a"),
        *(link(name, *body_numbers(rng)) for name in "bcd"),
        joint("j1", "a", "b", axis=(0, 1, 0)),
        joint("j2", "b", "c", "prismatic", axis=(0.6, 0, 0.8), xyz=(0.5, 0, -0.1)),
        joint("j3", "b", "d", axis=(0, 0.6, 0.8), xyz=(-0.3, 0, 0), more=follow),
    )
    friction = robodyn.Friction(viscous=0.2, forward=0.3, backward=0.3)
    load = robodyn.Payload("c", 2.0, (0.1, 0.0, 0.2))
    found = agrees(model, Scene(friction={"j1": friction, "j2": friction}, payloads=(load,), gravity=(3.0, 0.0, 4.0)))
    assert {"l_1x", "l_1z", "l_1_3"} <= {letter.name for letter in found.symbols}


def test_a_fluid_weighs_with_the_same_gravity():
    model = robodyn.load(ROBOTS / "two_link_planar.urdf")
    scene = Scene(immersed=(robodyn.Immersed("forearm", 1e-3, (0.1, 0, 0), (0.1, 0.2, 0.3)),), fluid_density=1000.0)
    agrees(model, scene, ("g",))
    state = random_state(model, np.random.default_rng(3), 4)
    other = robodyn.inverse_dynamics(model, *state, scene=scene.changed((0.0, 0.0, -3.0)))
    assert worst(torques(closed(model, scene, symbols=("g",)), *state, g=3.0), other) <= 1e-12


@pytest.mark.parametrize("gravity", [(0.0, 0.0, 0.0), (0.0, 0.0, 9.81), (0.1, 0.0, -1e8)])
def test_odd_numbers(gravity):
    """Names that mean something elsewhere, no mass, equal numbers, negative offsets, numbers large and small."""
    same = (0.2, 0, 0, 0.2, 0, 0.2)
    model = built(
        link("lambda"),
        link("x&quot;&quot;&quot;; import os", 1e6, (-0.5, -0.5, 0), same),
        link("c_2", 1e-6, (0.3, 0.3, 0.3), same),
        link("%"),
        joint("1", "lambda", "x&quot;&quot;&quot;; import os", axis=(0, 1, 0), xyz=(0.1, 0, 0)),
        joint("in", "x&quot;&quot;&quot;; import os", "c_2", axis=(1, 0, 0), xyz=(-0.5, 0, 0)),
        joint("q_1", "x&quot;&quot;&quot;; import os", "%", "prismatic", axis=(0, 0, -1), xyz=(0.5, 0, 0)),
    )
    found = agrees(model, Scene(gravity=gravity))
    assert found.error <= 1e-12
    letters = {letter.name: letter.value for letter in found.symbols}
    assert letters["l_1"] == 0.5
    assert ("g" in letters) == (gravity[0] == 0 and gravity[2] != 0)


def test_twins_and_letters_of_one_kind():
    model = robodyn.load(ROBOTS / "satellite.urdf", moving_base=True)
    found = agrees(model, kinds=("m", "l"))
    assert [letter.name for letter in found.symbols] == ["m_0", "m_1", "l_0", "g_x", "g_y", "g_z"]
    assert found.qd[0].name == "w_x"
    assert found.qdd[5].name == "a_z"
    assert found.q[:7] == (None,) * 6 + (sympy.Symbol("q_1", real=True),)


def test_numbers_of_a_base_that_moves():
    assert [letter.name for letter in agrees(random_tree(1, 2, moving_base=True), kinds=()).symbols] == [
        "g_x",
        "g_y",
        "g_z",
    ]


def test_assumptions():
    model = robodyn.load(ROBOTS / "puma.urdf")
    symbols = Lettered(model, positive=["l_1"]).symbols.values()
    assert [symbol.name for symbol in symbols if symbol.is_positive] == ["l_1"]
    for name, words in (
        ("l_7", "no symbol 'l_7'"),
        ("q_1", "no symbol 'q_1'"),
        ("c_2y", "c_2y is -0.016, not positive"),
    ):
        with pytest.raises(InputError, match=words):
            closed(model, symbols=KINDS, positive=[name])
    with pytest.raises(InputError, match="no symbols 'x'"):
        closed(model, symbols=("x",))


def test_what_a_base_that_turns_cannot_have():
    model = robodyn.load(ROBOTS / "satellite.urdf", moving_base=True)
    wind = robodyn.ExternalWrench("bus", force=(1.0, 0.0, 0.0), frame="world")
    with pytest.raises(InputError, match="axes of the world"):
        closed(model, Scene(wrenches=(wind,)))


def test_notation():
    q_1, q_2, q_3, q_12 = sympy.symbols("q_1 q_2 q_3 q_12")
    I, w, qd, l = sympy.symbols("I_1xx w_x qdd_1 l_1_2")
    written = {
        sympy.cos(q_2 + q_3): ("c_23", "c_{23}"),
        sympy.sin(2 * q_2 + q_3) ** 2: ("s_223^2", "s_{223}^{2}"),
        sympy.cos(q_1 - q_2): ("cos(q_1 - q_2)", r"\cos\left(q_{1} - q_{2}\right)"),
        sympy.cos(q_12 + q_1): ("cos(q_1 + q_12)", r"\cos\left(q_{1} + q_{12}\right)"),
        I * w * qd * sympy.Rational(-1, 2): ("-0.5*I_1xx*qdd_1*w_x", r"-0.5 I_{1xx} \ddot{q}_{1} \omega_{x}"),
        (q_1 - l) / (q_2 * q_3): ("(q_1 - l_1_2)/(q_2*q_3)", r"\frac{\left(q_{1} - l_{1,2}\right)}{q_{2} q_{3}}"),
        sympy.sign(qd) * 1e-7: ("1e-07*sign(qdd_1)", r"1 \cdot 10^{-7} \operatorname{sgn}\left(\ddot{q}_{1}\right)"),
        sympy.sqrt(q_1**2 + 1) - 2: ("sqrt(1 + q_1^2) - 2", r"\sqrt{1 + q_{1}^{2}} - 2"),
    }
    assert {x: (text_of(x), latex_of(x)) for x in written} == written


def test_latex_of_a_body_without_joints():
    assert r"I_{0xx}" in closed_latex(in_letters("rigid_body"))
