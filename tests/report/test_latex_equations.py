"""The closed form as LaTeX: balanced, and what a reader evaluates from it is what the robot does."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from helpers.command_line import ROBOTS
from helpers.oracles import random_state, worst
from helpers.small_robots import built, joint, link

import robodyn
from robodyn.equations.closed import closed
from robodyn.report.equations.latex import closed_latex
from robodyn.scene.scene import DEFAULT

TOKEN = re.compile(
    r"(?P<wave>[cs])_\{(?P<angles>\d+)\}|\\dot\{q\}_\{(?P<rate>\d)\}|q_\{(?P<angle>\d)\}|\\cdot 10\^\{(?P<ten>-?\d+)\}"
    r"|\^\{(?P<power>\d+)\}|\\(?P<name>cos|sin|operatorname\{sgn\})|e\^\{(?P<exp>[^{}]*(?:\{[^{}]*\}[^{}]*)*)\}"
    r"|(?P<open>\\left\()|(?P<close>\\right\))|(?P<number>\d+\.?\d*)|(?P<sign>[+-])|\s+"
)


def python(latex):
    """LaTeX of an expression as Python: q1, d1 for coordinates and rates, juxtaposition as product."""
    out = []
    place = 0
    while place < len(latex):
        token = TOKEN.match(latex, place)
        assert token, f"cannot read {latex[place : place + 30]!r}"
        place = token.end()
        kind, text = token.lastgroup, token[token.lastgroup] if token.lastgroup else ""
        if kind is None:
            continue
        if kind == "angles":
            joints = "+".join(f"q{k}" for k in text)
            text = f"{'cos' if token['wave'] == 'c' else 'sin'}({joints})"
        spelt = {"rate": f"d{text}", "angle": f"q{text}", "ten": f"*10.0**{text}", "power": f"**{text}", "open": "("}
        spelt |= {"close": ")", "name": text[-4:-1] if "{" in text else text}
        written = f"exp({python(text)})" if kind == "exp" else spelt.get(kind, text)
        factor = kind in ("angles", "rate", "angle", "name", "exp", "open", "number")
        if factor and out and out[-1][1] and not (kind == "open" and out[-1][0] in ("cos", "sin", "sgn")):
            out.append(("*", False))
        out.append((written, kind not in ("sign", "open")))
    return "".join(text for text, _ in out)


def entries(text):
    """Name of each entry and what stands behind its equals sign."""
    body = re.search(r"\\begin\{align\*\}\n(.*)\n\\end\{align\*\}", text, re.DOTALL)[1].replace(
        "\\\\\n    &\\quad", " "
    )
    return dict(line.split(" &= ") for line in body.split(" \\\\\n"))


def value(latex, q, qd):
    names = {f"q{k}": x for k, x in enumerate(q, 1)} | {f"d{k}": x for k, x in enumerate(qd, 1)}
    sgn = {"sgn": np.sign, "cos": math.cos, "sin": math.sin, "exp": math.exp}
    return eval(python(latex), {"__builtins__": {}}, names | sgn)


@pytest.mark.parametrize("name", ["two_link_planar", "puma", "gripper"])
def test_a_reader_finds_the_same_numbers(name):
    scene = robodyn.load_scene(ROBOTS / "gripper.toml") if name == "gripper" else DEFAULT
    model = robodyn.load(ROBOTS / f"{name}.urdf")
    found = entries(closed_latex(closed(model, scene)))
    n = model.n
    for q, qd, _ in zip(*random_state(model, np.random.default_rng(1), 4), strict=True):
        M = [[value(found[f"M_{{{min(i, j)}{max(i, j)}}}"], q, qd) for j in range(1, n + 1)] for i in range(1, n + 1)]
        expected = robodyn.mass_matrix(model, q, scene=scene)
        assert worst(M, expected) <= 1e-5
        shares = [
            [value(text, q, qd) for key, text in found.items() if key.endswith(f"_{{{i + 1}}}")] for i in range(n)
        ]
        bias = robodyn.bias_forces(model, q, qd, scene=scene)
        assert worst([sum(row) for row in shares], bias) <= 3e-5  # a coefficient is rounded by 5e-6


def balanced(text):
    depth = 0
    for brace in re.findall(r"(?<!\\)[{}]", text):
        depth += 1 if brace == "{" else -1
        assert depth >= 0
    assert depth == 0
    assert text.count("\\left") == text.count("\\right")
    assert len(re.findall(r"(?<!\\)\$", text)) % 2 == 0
    for name in ("begin", "end"):
        assert text.count(f"\\{name}{{align*}}") == 1


def test_odd_names_are_escaped():
    rod = link("rod", 2, (0.5, 0, 0), (0, 0, 0, 0.1, 0, 0.1))
    model = built(link("base"), rod, joint("a_b%{$#~^\\", "base", "rod", axis=(0, 1, 0)))
    text = closed_latex(closed(replace(model, name="50% & more")))
    balanced(text)
    assert r"a\_b\%\{\$\#\textasciitilde{}\textasciicircum{}\textbackslash{}" in text
    assert r"equations of motion of 50\% \& more are" in text


def test_it_is_balanced_and_explains_its_notation():
    text = closed_latex(closed(robodyn.load(ROBOTS / "puma.urdf")))
    balanced(text)
    for words in (
        r"$c_{ij} = \cos(q_{i} + q_{j})$",
        "$q_{2}$ (shoulder, rad)",
        r"M(q)\,\ddot{q} + G(q) + V(q, \dot{q})",
    ):
        assert words in text
    assert max(map(len, text[text.index("begin") :].splitlines())) <= 300
