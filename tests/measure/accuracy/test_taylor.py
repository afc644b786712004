"""Power series of solutions against 30 digits and closed forms."""

from __future__ import annotations

from fractions import Fraction

import pytest
from helpers.oracles import reference
from helpers.series_reference import BITS, Taylor, fixed, step_of, summed
from helpers.simulated_robots import pendulum, slide

from robodyn.dynamics.plan import plan
from robodyn.errors import InputError
from robodyn.programs.program import trace
from robodyn.scene.parts import Friction, Spring
from robodyn.scene.scene import Scene
from robodyn.simulation.equations import STATE, Equations

mpmath = pytest.importorskip("mpmath")

ONE = 1 << BITS
DOUBLE = reference("double_pendulum")["data"]


def solved(program, state, duration, order=24, tolerance=1e-24):
    """The state after the duration, all in fixed point."""
    series_of = Taylor(program, "state", len(state), order)
    now = 0
    while now < duration:
        series = series_of(state)
        step = min(fixed(step_of(series, tolerance)), duration - now)
        state, now = summed(series, step), now + step
    return state


def of(model, scene, state, duration):
    equations = Equations(plan(model, scene))
    return solved(equations.derivatives(), [*state, 0, 0], duration)[: len(state)]


@pytest.mark.parametrize(("case", "eighths"), [("large(pi/2,0)", 4), ("chaotic(3pi/4,0)", 6)])
def test_double_pendulum(case, eighths):
    """Within the last digit of the reference; and orders agree far beyond it."""
    with mpmath.workdps(70):
        state = [int(mpmath.ldexp(eighths * mpmath.pi / 8, BITS)), 0, 0, 0]
    equations = Equations(plan(pendulum(masses=2), Scene()))
    ways = ((24, 1e-24), (16, 1e-20))
    found, other = (solved(equations.derivatives(), [*state, 0, 0], 2 * ONE, *way)[:4] for way in ways)
    for value, same, expected in zip(found, other, DOUBLE[case]["2"], strict=True):
        last = Fraction(1, 10 ** len(expected.partition(".")[2]))
        assert abs(Fraction(value, ONE) - Fraction(expected)) <= last
        assert abs(Fraction(value - same, ONE)) <= 1e-17


def test_a_damped_spring():
    m, k, d = 2.0, 50.0, 3.0
    scene = Scene(friction={"j1": Friction(viscous=d)}, spring={"j1": Spring(k, 0.0)})
    found = of(slide(m), scene, [fixed(0.25), 0], 2 * ONE)
    with mpmath.workdps(60):
        decay, w, t = mpmath.mpf(d) / (2 * m), mpmath.sqrt(mpmath.mpf(k) / m - (mpmath.mpf(d) / (2 * m)) ** 2), 2
        expected = mpmath.mpf("0.25") * mpmath.exp(-decay * t) * (mpmath.cos(w * t) + decay / w * mpmath.sin(w * t))
        assert abs(mpmath.ldexp(found[0], -BITS) - expected) <= 1e-22


def test_every_operation():
    """y' = exp(y) / (1 + sqrt(y)): its time as a function of y is an integral."""

    def outputs(tape):
        y = tape.input("state", 0)
        return [y.exp() / (1.0 + y.sqrt()) - 0.25 * (-y).exp() * y]

    found = solved(trace(outputs), [ONE], fixed(0.75), order=30)
    with mpmath.workdps(40):
        end = mpmath.ldexp(found[0], -BITS)

        def slowness(y):
            return 1 / (mpmath.exp(y) / (1 + mpmath.sqrt(y)) - y * mpmath.exp(-y) / 4)

        assert abs(mpmath.quad(slowness, mpmath.linspace(1, end, 9)) - 0.75) <= 1e-22


def test_jumps_and_tables_have_no_series():
    for outputs in (lambda tape: [tape.input("state", 0).sign()], lambda tape: [tape.input("time", 0)]):
        with pytest.raises(InputError, match="no power series"):
            Taylor(trace(outputs), STATE, 1, 8)
