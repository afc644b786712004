"""Closures: their rates against dual numbers, J against rates, and forces against power."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.closed_chains import four_bars, spatial_loop
from helpers.small_robots import built, joint, link

from robodyn.dynamics.effects.effect import Sample
from robodyn.dynamics.loops.closed_chain import closed_chain, closure_of, independent
from robodyn.dynamics.loops.closure import Closure, equations_of
from robodyn.dynamics.plan import plan
from robodyn.dynamics.recursions.momentum import dual_state
from robodyn.scene.parts import Loop
from robodyn.scene.scene import Scene

KINDS = ("point", "hinge", "weld")


def sampled(model, scene, seed=1):
    """A closed chain, a sample of it, and its rates."""
    chain = closed_chain(plan(model, scene))
    rng = np.random.default_rng(seed)
    q, qd = rng.uniform(-1, 1, model.nq), rng.normal(size=model.n)
    sample = Sample(chain.model, tuple(q.tolist()), tuple(qd.tolist()), (0.0,) * model.n)
    return chain, sample, qd


@pytest.mark.parametrize(("moving", "to"), [(False, "b2"), (True, "b2"), (True, "ground")])
@pytest.mark.parametrize("kind", KINDS)
def test_rates_are_those_of_dual_numbers(kind, moving, to):
    chain, sample, qd = sampled(*spatial_loop(3, kind, moving, to))
    here = chain.equations(sample)
    q, qd_dual = dual_state(chain.model, sample.q, sample.qd, sample.qdd)
    dual = chain.equations(Sample(chain.model, tuple(q), tuple(qd_dual), sample.qdd))
    for ours, theirs in ((here.rate, dual.error), (here.bias, dual.rate)):
        expected = np.array([value.rate for value in theirs], dtype=float)
        assert np.abs(np.array(ours, dtype=float) - expected).max() <= 50 * np.finfo(float).eps * np.abs(expected).max()
    assert np.abs(chain.jacobian(sample) @ qd - np.array(here.rate, dtype=float)).max() <= 1e-14 * np.abs(qd).max() * 4


@pytest.mark.parametrize("kind", KINDS)
def test_forces_do_the_power_of_the_multipliers(kind):
    chain, sample, _ = sampled(*spatial_loop(5, kind))
    here = chain.equations(sample)
    place, equations = here.places[0], chain.closures[0].equations
    multipliers = np.random.default_rng(2).normal(size=len(equations))
    f = sum(value * equation.D for value, equation in zip(multipliers, equations, strict=True))
    n = sum(value * equation.moment(place.B) for value, equation in zip(multipliers, equations, strict=True))
    power = f @ place.speed.v + n @ place.speed.w
    assert power == pytest.approx(multipliers @ np.array(here.rate, dtype=float), rel=1e-13)


def test_a_weld_is_closed_where_its_turn_is():
    from robodyn.programs.vectors import rotation_from_rpy

    loop = Loop("a", "b", kind="weld", rpy=(0.3, -0.5, 1.1))
    R = rotation_from_rpy(*loop.rpy)
    errors = [equation.of(np.zeros(3), R) for equation in equations_of(loop)]
    assert np.abs(errors).max() <= 1e-16
    assert np.allclose([equation.moment(R) for equation in equations_of(loop)[3:]], np.eye(3), atol=1e-15)


def test_both_ends_are_followed_from_the_nearest_body_that_carries_them():
    model, scene = spatial_loop(0, moving_base=True)
    closure = closure_of(model, scene.loops[0])
    assert isinstance(closure, Closure)
    assert [len(chain) for chain in closure.chains] == [4, 3]
    assert 0 not in closure.chains[0] + closure.chains[1]
    to_ground = closure_of(model, Loop("b", "a3"))
    assert [len(chain) for chain in to_ground.chains] == [5, 0]


def test_planar_loops_drop_what_the_plane_implies():
    found = closed_chain(plan(*four_bars(2)))
    assert [(each.closure.loop.name, each.equation.about) for each in found.dropped] == [
        ("B1", "along y"),
        ("B2", "along y"),
    ]
    assert [len(closure.equations) for closure in found.closures] == [2, 2]


@pytest.mark.parametrize(("kind", "left"), [("point", 2), ("hinge", 2), ("weld", 3)])
def test_planar_loops_in_an_oblique_plane(kind, left):
    axis = (0.36, 0.48, 0.8)
    parts = [link("l0")]
    for k in range(3):
        parts += [link(f"l{k + 1}", 1.0, (0.1, 0.2, 0), (1, 0, 0, 1, 0, 1))]
        parts.append(joint(f"j{k}", f"l{k}", f"l{k + 1}", "continuous", axis, (0.8, -0.6, 0) if k else (0, 0, 0)))
    axes = {"axis": axis, "to_axis": axis} if kind == "hinge" else {}
    loop = Loop("tie", "l3", (0.8, -0.6, 0), "l0", (1.6, -1.2, 0), kind, **axes)
    found = closed_chain(plan(built(*parts), Scene(loops=(loop,))))
    assert len(found.closures[0].equations) == left


def test_rows_that_span_the_others():
    rng = np.random.default_rng(0)
    base = rng.normal(size=(3, 9))
    rows = np.vstack((base[0], 0 * base[0], base[1], base[0] + base[1], 1e-12 * base[2], base[2]))
    kept = independent(rows)
    assert np.linalg.matrix_rank(rows[kept]) == len(kept) == 3
    assert 1 not in kept
    assert 4 not in kept
