"""The DAE form, its counts and its elimination: a closed form, the ODE form, and that each step can fail."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.example_robots import kinds
from helpers.oracles import EPS, random_state, robot, worst
from helpers.single_bodies import taken_apart, thrown
from helpers.small_robots import built, chain, joint, link, random_tree

import robodyn
from robodyn.equations.dae import dae as form
from robodyn.equations.dae.dae import dae, dae_at, reduced
from robodyn.equations.dae.system import joint_connections, stacked, state_of
from robodyn.errors import InputError
from robodyn.robot.load import load
from robodyn.scene.scene import DEFAULT, Rotor, Scene

STILL_BUSY = replace(BUSY_SCENE, wrenches=BUSY_SCENE.wrenches[::2])


def agrees(found, bar=1e-12):
    both, counts, model = found.comparison, found.counts, found.system.model
    assert counts.freedom == model.n
    assert counts.reactions == counts.rank == 6 * len(model.bodies) - model.n
    assert counts.rank == np.linalg.matrix_rank(found.system.matrices.G)
    assert counts.unknowns == 12 * len(model.bodies) + counts.reactions
    assert not counts.redundant
    assert not counts.undetermined
    assert max(both.accelerations, both.forces, both.moments) <= bar
    assert np.abs(found.residuals.places).max(initial=0.0) <= 1e-13 * max(found.system.length, 1.0)


@pytest.mark.parametrize("speed", [0.0, 3.0])
def test_rope_tension_of_a_pendulum(speed):
    """A bob of 2 kg on a rope of 1.5 m at 0.4 rad: T = m (g cos + l w^2), wd = -g/l sin."""
    m, l, angle = 2.0, 1.5, 0.4
    model = built(link("frame"), link("bob", m, (0, 0, -l)), joint("rope", "frame", "bob", "continuous", (0, 1, 0)))
    found = dae(model, at=[angle], qd=[speed])
    force = found.wrenches[1].f
    assert worst(force, [0, 0, m * (9.81 * np.cos(angle) + l * speed**2)]) <= 8 * EPS
    assert worst(found.qdd, [-9.81 / l * np.sin(angle)]) <= 8 * EPS
    assert found.counts.index == (3, 2, 1)


def test_a_body_that_nothing_holds_has_an_ode():
    counts = taken_apart(robot("rigid_body")).counts
    assert (counts.reactions, counts.rank, counts.freedom, counts.index) == (0, 0, 6, (0, 0, 0))


SAME = {
    "satellite": lambda: robot("satellite", True),
    "gripper": lambda: robot("gripper"),
    "random tree": lambda: random_tree(0, 8),
    "random tree that floats": lambda: random_tree(1, 8, moving_base=True),
    "a body that floats from a moving link": thrown,
    "each link a tenth of the one before it": lambda: chain(8, skew=True, taper=0.1),
}


@pytest.mark.parametrize("case", SAME)
def test_both_forms_agree(case):
    agrees(taken_apart(SAME[case]()))


@pytest.mark.parametrize("free", [False, True])
def test_both_forms_agree_with_every_effect(free):
    agrees(taken_apart(busy_robot(free), 1, replace(STILL_BUSY, moving_base=free)))


@pytest.mark.parametrize("path", kinds())
def test_both_forms_agree_on_real_robots(path):
    """1e-12, or a few roundings times the condition of M."""
    model = load(path, moving_base=path.stem in ("anymal", "talos_full_v2", "simple_humanoid"))
    found = taken_apart(model)
    agrees(found, max(1e-12, 64 * EPS * np.linalg.cond(found.reduced.M)))


def test_a_robot_far_away_moves_alike():
    """1000 km from the ground's origin to the last bit, but for the position itself."""
    model = robot("satellite", True)
    (q,), (qd,), (tau,) = random_state(model, np.random.default_rng(0), 1)
    far = q + np.array([1e6, -1e6, 1e6] + [0.0] * (model.nq - 3))
    here, there = (dae_at(model, DEFAULT, x, qd, tau) for x in (q, far))
    assert np.array_equal(here.solution.a, there.solution.a)
    assert np.array_equal(here.solution.reactions, there.solution.reactions)


def test_a_moment_keeps_its_place_in_the_other_body_while_a_hinge_turns():
    """lambda of a hinge is along axes that do not turn with the body."""
    model = chain(2, skew=True)
    centres = [body.inertia.centre_of_mass for body in model.bodies]
    for q in ([0.3, 0.1], [-0.4, 0.8]):
        hinge, at = joint_connections(model, centres, q)[2], state_of(model, centres, q, [0.0, 0.0])
        moments = stacked(hinge.equations[3:], at)[:, 6:9]
        assert worst(moments, -(model.bodies[2].joint.R @ np.eye(3)[:, :2]).T) <= 16 * EPS


def test_nothing_resists():
    model = built(link("l0", 1.0), link("l1"), joint("j", "l0", "l1", "continuous"))
    found = dae(model)
    assert (found.solution, found.comparison, found.counts.index) == (None, None, None)
    assert found.counts.coefficients[2] < found.counts.size
    assert len(found.steps) == 5
    with pytest.raises(InputError, match="moves nothing that has inertia"):
        robodyn.forward_dynamics(model, found.q, found.qd, found.tau)


def test_names_and_numbers_are_checked():
    with pytest.raises(InputError, match="no joint 'elbw'"):
        dae(robot("scara"), tau={"elbw": 1.0})
    with pytest.raises(InputError, match="overflow"):
        dae(robot("scara"), qd=[1e200, 0, 0])
    with pytest.raises(InputError, match="nothing can move"):
        dae(robot("composite"))


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


@pytest.mark.parametrize(("what", "first"), [("J", 0), ("drift", 1)])
def test_a_wrong_transformation_would_show(monkeypatch, what, first):
    """Each step can fail: 1e-6 more of J or of Jdot qd is seen."""

    def wrong(system):
        found = reduced(system)
        right = getattr(found, what)
        return replace(found, **{what: right + 1e-6 * np.arange(right.size).reshape(right.shape)})

    monkeypatch.setattr(form, "reduced", wrong)
    errors = [step.error for step in taken_apart(random_tree(0, 6)).steps]
    assert errors[first] > 1e-9
