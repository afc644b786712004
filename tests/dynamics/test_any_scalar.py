"""One recursion for every scalar: floats, 50 digits, symbols, traced and dual scalars run the same function."""

from __future__ import annotations

import mpmath
import numpy as np
import sympy
from helpers.oracles import golden_model, worst

from robodyn.dynamics.effects.effect import Sample
from robodyn.dynamics.plan import EFFECTS, applied, loads
from robodyn.dynamics.recursions.newton_euler import newton_euler
from robodyn.programs.vectors import vector
from robodyn.robot.kinematics import REST, joint_motion
from robodyn.robot.model import Joint
from robodyn.scene.scene import Scene
from robodyn.solids.inertia.laws import MASSLESS, Inertia


def _tau(model, q, qd, qdd, scene):
    """The torques of one sample in whatever scalar it is made of, all effects on."""
    sample = Sample(model, tuple(q), tuple(qd), tuple(qdd))
    return loads(sample, applied(EFFECTS, sample, scene)).tau


def test_fifty_digits_are_fifty():
    """The mass matrix by two accelerations: a float recursion would lose all but 16 digits of the difference."""
    model = golden_model("puma560_corke")
    weightless = Scene(gravity=(0.0, 0.0, 0.0))
    with mpmath.workdps(50):
        q, qdd = [mpmath.mpf(k) / 7 for k in range(1, 7)], [mpmath.mpf(1) / 3] * 6
        nudge = mpmath.mpf(10) ** -30
        still = [mpmath.mpf(0)] * 6
        one = _tau(model, q, still, qdd, weightless)
        two = _tau(model, q, still, [x + nudge for x in qdd], weightless)
        slope = [float((b - a) / nudge) for a, b in zip(one, two, strict=True)]
        expected = [float(x) for x in _tau(model, q, still, [mpmath.mpf(1)] * 6, weightless)]
    assert worst(slope, expected) <= 1e-15


def _carried(x):
    """A hinge about z whose body has its origin at x on its parent's x axis."""
    return Joint("hinge", "revolute", np.eye(3), np.array([x, 0, 0]), np.array([0, 0, 1]))


def test_symbols():
    """Point masses at the ends of two links: Craig's closed form, lengths and masses being symbols too."""
    l1, l2, m1, m2, g = sympy.symbols("l1 l2 m1 m2 g", positive=True)
    q1, q2, w1, w2, a1, a2 = sympy.symbols("q1 q2 w1 w2 a1 a2", real=True)
    hinges = joint_motion(_carried(0), [q1], [w1], [a1]), joint_motion(_carried(l1), [q2], [w2], [a2])
    masses = [Inertia(m, m * vector(r, 0, 0), m * r**2 * np.diag([0, 1, 1])) for m, r in ((m1, l1), (m2, l2))]
    reactions = newton_euler((-1, 0, 1), (REST, *hinges), (MASSLESS, *masses), vector(0, -g, 0))
    s2, c2 = sympy.sin(q2), sympy.cos(q2)
    M11 = l2**2 * m2 + 2 * l1 * l2 * m2 * c2 + l1**2 * (m1 + m2)
    M12 = l2**2 * m2 + l1 * l2 * m2 * c2
    weight = m2 * l2 * g * sympy.cos(q1 + q2)
    upper = M11 * a1 + M12 * a2 - m2 * l1 * l2 * s2 * (w2**2 + 2 * w1 * w2) + weight
    craig = upper + (m1 + m2) * l1 * g * sympy.cos(q1), M12 * a1 + l2**2 * m2 * a2 + m2 * l1 * l2 * s2 * w1**2 + weight
    for reaction, expected in zip(reactions[1:], craig, strict=True):
        difference = sympy.expand(sympy.expand_trig(sympy.nsimplify(reaction.n[2] - expected)))
        for q in (q1, q2):
            difference = sympy.rem(difference, sympy.sin(q) ** 2 + sympy.cos(q) ** 2 - 1, sympy.sin(q))
        assert sympy.expand(difference) == 0
