"""Accelerations of closed chains against the tree's own inverse dynamics, and the least change against NumPy's."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.closed_chains import spatial_loop
from helpers.small_robots import built, joint, link

import robodyn
from robodyn.dynamics.effects.effect import Sample
from robodyn.dynamics.loops.closed_chain import GivensProjection, closed_chain
from robodyn.dynamics.momenta import position_rates
from robodyn.dynamics.plan import applied, plan
from robodyn.dynamics.recursions.articulated_body import Root
from robodyn.errors import InputError
from robodyn.programs.derivative import FUNCTIONS, along
from robodyn.programs.program import trace
from robodyn.scene.scene import Loop, Scene


def solved(model, scene, q, qd, tau):
    """qdd, lambda, and J in the ground's axes of a fixed-base robot."""
    a_plan = plan(model, scene)
    chain = closed_chain(a_plan)
    sample = Sample(chain.model, tuple(q.tolist()), tuple(qd.tolist()), (0.0,) * model.n)
    qdd, multipliers = chain.accelerations(sample, applied(a_plan.effects, sample, scene), tau.tolist())
    here = chain.equations(sample)
    return np.array(qdd), np.array(multipliers), chain.jacobian(sample), np.array(here.bias, dtype=float)


@pytest.mark.parametrize(("moving", "to"), [(False, "b2"), (True, "b2"), (True, "ground")])
@pytest.mark.parametrize("kind", ["point", "hinge", "weld"])
def test_rates_are_derivatives_along_the_motion(kind, moving, to):
    model, scene = spatial_loop(3, kind, moving, to)
    chain, rng = closed_chain(plan(model, scene)), np.random.default_rng(1)
    q, qd = rng.uniform(-1, 1, model.nq), rng.normal(size=model.n)
    sample = Sample(chain.model, tuple(q.tolist()), tuple(qd.tolist()), (0.0,) * model.n)
    here = chain.equations(sample)
    given = {"q": q, "qd": qd}

    def rates(tape, of):
        state = {source: [tape.input(source, k) for k in range(len(array))] for source, array in given.items()}
        motion = [*position_rates(chain.model, **state), *sample.qdd]
        direction = dict(zip((*state["q"], *state["qd"]), motion, strict=True))
        return along(getattr(chain.equations(chain.sample(**state)), of), direction)

    for ours, of in ((here.rate, "error"), (here.bias, "rate")):
        found = trace(lambda tape, of=of: rates(tape, of))
        expected = np.array(found.evaluated(lambda source, k: given[source][k], float, FUNCTIONS))
        assert np.abs(np.array(ours, dtype=float) - expected).max() <= 50 * np.finfo(float).eps * np.abs(expected).max()
    assert np.abs(chain.jacobian(sample) @ qd - np.array(here.rate, dtype=float)).max() <= 1e-14 * np.abs(qd).max() * 4


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


def test_a_loop_with_a_follower_in_it():
    """Two hinges that turn as one, closed to the base by a slide: J and M act on the shared coordinate."""
    more = {"j2": '<mimic joint="j1" multiplier="-1.5" offset="0.4"/>'}
    parts = [link("l0")]
    for k in range(1, 4):
        parts.append(link(f"l{k}", 1.0, (0.2, 0.1, 0.05), (0.1, 0.01, 0, 0.2, 0.02, 0.15)))
        place = {"axis": (0, 0.6, 0.8), "xyz": (0.5 if k > 1 else 0.0, 0, 0)}
        parts.append(joint(f"j{k}", f"l{k - 1}", f"l{k}", more=more.get(f"j{k}", ""), **place))
    scene = Scene(loops=(Loop("slot", "l3", (0.4, 0, 0), directions=((0, 1, 1),)),))
    model = built(*parts)
    q, qd, tau = np.array((0.4, -0.7)), np.array((1.1, -0.6)), np.array((3.0, -2.0))
    qdd, multipliers, J, bias = solved(model, scene, q, qd, tau)
    assert J.shape == (1, 2)
    needed = robodyn.inverse_dynamics(model, q, qd, qdd)
    assert np.abs(needed - tau - J.T @ multipliers).max() <= 1e-13 * np.abs(needed).max()
    assert np.abs(J @ qdd + bias).max() <= 1e-13 * np.abs(bias).max()
    step = 1e-6
    chain = closed_chain(plan(model, scene))
    errors = [
        chain.equations(Sample(chain.model, tuple((q + sign * step * qd).tolist()), (0.0, 0.0), (0.0, 0.0))).error[0]
        for sign in (-1, 1)
    ]
    assert (errors[1] - errors[0]) / (2 * step) == pytest.approx(J[0] @ qd, rel=1e-8)


def test_least_change_of_columns_that_nearly_depend():
    """The error of y grows like the condition, 1e7 here, and not like its square."""
    rng = np.random.default_rng(0)
    A = rng.normal(size=(7, 3))
    A[:, 2] = A[:, 0] + 1e-7 * A[:, 2]
    y = rng.normal(size=7)
    x = y + rng.normal(size=7)
    x -= (np.eye(7) - A @ np.linalg.pinv(A)) @ (x - y)
    rows = [dict(enumerate(row.tolist())) for row in A]
    found, _ = GivensProjection(rows, [2.0**-40] * 3).solve(x.tolist(), (A.T @ y).tolist())
    assert np.abs(np.array(found) - y).max() <= 1e-8


def test_a_joint_without_inertia_is_named():
    parts = (link("l0"), link("l1"), link("l2", 1.0, (1, 0, 0)), joint("j1", "l0", "l1"), joint("j2", "l0", "l2"))
    with pytest.raises(InputError, match='joint "j1" moves nothing that has inertia'):
        robodyn.simulate(built(*parts), Scene(loops=(Loop("a", "l1", (1, 0, 0), "l2", (1, 0, 0)),)), 0.1)
    with pytest.raises(InputError, match='joint "b"'):
        Root({(0, 0): 1.0}, [0, 1], ["a", "b"])
