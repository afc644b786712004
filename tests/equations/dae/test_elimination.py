"""The elimination step by step: its identities, and that they can fail."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sympy
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.oracles import robot
from helpers.single_bodies import taken_apart
from helpers.small_robots import built, joint, link, random_tree

from robodyn.equations.dae import dae
from robodyn.equations.dae.dae import reduced
from robodyn.equations.dae.system import system_at
from robodyn.scene.parts import Rotor
from robodyn.scene.scene import Scene

STILL_BUSY = replace(BUSY_SCENE, wrenches=BUSY_SCENE.wrenches[::2])
FORMULAS = [
    "v = J(q) qd",
    "a = J qdd + Jdot qd",
    "J^T M (J qdd + Jdot qd) = J^T f + J^T G^T lambda",
    "J^T M J = M(q)",
    "J^T (f - M Jdot qd) = tau - bias(q, qd)",
    "M(q) qdd = tau - bias(q, qd)",
    "G^T lambda = M a - f",
]


CASES = {
    "puma560 with motors": (lambda: robot("puma560"), Scene(rotor={"elbow": Rotor(1e-4, 100.0)})),
    "every effect, free": (lambda: busy_robot(True), replace(STILL_BUSY, moving_base=True)),
}


@pytest.mark.parametrize("case", CASES)
def test_every_step_holds(case):
    make, scene = CASES[case]
    found = taken_apart(make(), 3, scene)
    assert [step.formula for step in found.steps] == FORMULAS
    assert max(step.error for step in found.steps) <= 4e-15
    assert min(step.scale for step in found.steps) > 1e-3


@pytest.mark.parametrize(("what", "first"), [("velocity_transformation", 0), ("accelerations_at_rest", 1)])
def test_a_wrong_transformation_would_show(monkeypatch, what, first):
    """Each step can fail: 1e-6 more of J or of Jdot qd is seen."""
    right = getattr(dae, what)
    monkeypatch.setattr(dae, what, lambda given: right(given) + 1e-6 * np.arange(right(given).size).reshape(
        right(given).shape))  # fmt: skip
    errors = [step.error for step in taken_apart(random_tree(0, 6)).steps]
    assert errors[first] > 1e-9


def test_a_wrong_mass_matrix_would_show(monkeypatch):
    right = dae.mass_matrix
    monkeypatch.setattr(dae, "mass_matrix", lambda *a, **b: 1.0001 * right(*a, **b))
    errors = [step.error for step in taken_apart(random_tree(0, 6)).steps]
    assert errors[3] > 1e-6
    assert max(errors[:3]) <= 4e-15


def vanishes(expression):
    return sympy.simplify(sympy.nsimplify(expression, rational=True)) == 0


def test_the_pendulum_in_symbols():
    """The same functions for SymPy: M = m l^2, tau - m g l sin q, and the rope's pull m (g cos q + l w^2)."""
    model = built(link("frame"), link("bob", 2.0, (0, 0, -0.5)), joint("rope", "frame", "bob", "continuous", (0, 1, 0)))
    q, w, tau = sympy.symbols("q w tau", real=True)
    single = system_at(model, Scene(gravity=(0.0, 0.0, -10.0)), [q], [w], [tau])
    left = reduced(single)
    assert vanishes(left.M[0, 0] - 0.5)
    assert vanishes(left.free[0] - (tau - 10 * sympy.sin(q)))
    a = left.J[:, 0] * (left.free[0] / left.M[0, 0]) + left.drift
    needed = single.matrices.M @ a - single.matrices.f
    along = sympy.Matrix([sympy.sin(q), 0, sympy.cos(q)])
    pull = sympy.Matrix(needed[9:12]).dot(along).subs(tau, 0)
    assert vanishes(pull - 2 * (10 * sympy.cos(q) + w**2 / 2))
    assert all(vanishes(x) for x in single.matrices.G @ a - single.matrices.gamma)
