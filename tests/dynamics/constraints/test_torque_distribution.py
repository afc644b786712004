"""Torques and forces of constraints against lstsq, null spaces and optimality conditions; which joints drive."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from helpers.command_line import ROBOTS

import robodyn
from robodyn import Contact, ContactCost, Drive, Loop, Scene
from robodyn.dynamics.constraints.solve import actuation
from robodyn.dynamics.constraints.torque_distribution import structure, torque_distribution
from robodyn.errors import SceneError

EPS = np.finfo(float).eps
KINDS = {
    "driven": {"rank": 3, "passive": 3, "actuated": 2},
    "redundant": {"rank": 3, "passive": 3, "actuated": 4, "redundant": 2},
    "overconstrained": {"rank": 3, "passive": 3, "actuated": 1, "implied": 3},
    "both": {"rank": 4, "passive": 4, "actuated": 5, "redundant": 3, "implied": 2},
    "undriven": {"rank": 2, "passive": 4, "actuated": 2},
    "all at once": {"rank": 5, "passive": 7, "actuated": 6, "redundant": 2, "implied": 3},
    "actuators fight": {"rank": 0, "passive": 0, "actuated": 4, "redundant": 3},
    "passives alone": {"rank": 4, "passive": 4, "actuated": 0, "implied": 1},
    "tree with passive joints": {"rank": 0, "passive": 2, "actuated": 3},
    "tree": {"rank": 0, "passive": 0, "actuated": 3},
    "rank 0 of many": {"rank": 0, "passive": 2, "actuated": 2, "redundant": 2, "implied": 1},
}


def drawn(rng, rank, passive, actuated, redundant=0, implied=0, samples=12):
    """J (samples, m, n), its passive rates, mixed among the others, and torques."""
    m, n = rank + redundant + implied, passive + actuated
    J = np.zeros((samples, m, n))
    for each in J:
        V = np.linalg.qr(rng.normal(size=(m, m)))[0]
        U = np.linalg.qr(rng.normal(size=(passive, passive)))[0][:, :rank]
        A = U * rng.uniform(0.3, 2.0, rank) @ V[:, :rank].T
        B = np.linalg.qr(rng.normal(size=(actuated, actuated)))[0][:, :redundant] @ V[:, rank : rank + redundant].T
        each[:] = np.vstack((A, rng.normal(size=(actuated, rank)) @ V[:, :rank].T + B)).T
    order = rng.permutation(n)
    return J[:, :, order], (np.arange(n) < passive)[order], rng.normal(size=(samples, n))


def balanced(J, passive, tau):
    out = tau.copy()
    for each, one in zip(J, out, strict=True):
        A = each[:, passive].T
        one[passive] = A @ np.linalg.lstsq(A, one[passive], rcond=1e-10)[0] if A.size else 0.0
    return out


def optimum(J, passive, tau, weights):
    """Multipliers and torques at one sample, by the optimality conditions and then the shortest multipliers."""
    m, a = len(J), int((~passive).sum())
    A, D = J[:, passive].T, J[:, ~passive].T
    p = len(A)
    conditions = np.block(
        [
            [np.diag(weights), np.zeros((a, m)), np.eye(a), np.zeros((a, p))],
            [np.zeros((m, a)), np.zeros((m, m)), D.T, A.T],
            [np.eye(a), D, np.zeros((a, a + p))],
            [np.zeros((p, a)), A, np.zeros((p, a + p))],
        ]
    )
    known = np.concatenate((np.zeros(a + m), tau[~passive], tau[passive]))
    torques = scipy.linalg.lstsq(conditions, known, cond=1e-12)[0][:a]
    rest = tau.copy()
    rest[~passive] -= torques
    return (np.linalg.lstsq(J.T, rest, rcond=1e-10)[0] if m else np.zeros(0)), torques


@pytest.mark.parametrize("kind", KINDS)
def test_forces_are_those_of_the_optimality_conditions_and_ranks_those_of_null_spaces(kind):
    rng = np.random.default_rng(len(kind))
    sizes = {"redundant": 0, "implied": 0} | KINDS[kind]
    J, passive, tau = drawn(rng, **sizes)
    tau = balanced(J, passive, tau)
    weights, decided = rng.uniform(0.1, 10.0, int((~passive).sum())), structure(J, passive)
    found = torque_distribution(decided, J, tau, weights)
    pairs = [optimum(each, passive, one, weights) for each, one in zip(J, tau, strict=True)]
    for got, expected in zip(found, map(np.array, zip(*pairs, strict=True)), strict=False):
        assert got.shape == expected.shape
        scale = max(np.abs(expected).max(initial=0.0), np.abs(tau).max())
        assert np.abs(got - expected).max(initial=0.0) <= 2000 * EPS * scale
    assert np.abs(found.unbalanced).max(initial=0.0) <= 200 * EPS * np.abs(tau).max()
    assert not found.singular.any()
    assert not found.higher.any()
    m = J.shape[1]
    assert (decided.rank, decided.redundancy) == (sizes["rank"], sizes["redundant"])
    assert decided.overconstrained == sizes["implied"]
    A = J[0][:, passive].T
    free = scipy.linalg.null_space(A, rcond=1e-10) if A.size else np.eye(m)
    moved = scipy.linalg.null_space(A.T, rcond=1e-10) if A.size else np.eye(len(A))
    assert decided.torque_determined.tolist() == [
        np.abs(row).max(initial=0) < 1e-10 for row in J[0][:, ~passive].T @ free
    ]
    assert decided.equation_determined.tolist() == [np.abs(row).max(initial=0) < 1e-10 for row in free]
    assert decided.undriven_rates.tolist() == [np.abs(row).max(initial=0) > 1e-10 for row in moved]


def test_what_no_force_gives_is_told_where_it_is_needed():
    """The remainder of least squares in equilibrated units; at a joint that no loop touches, all of it."""
    rng = np.random.default_rng(3)
    J, passive, tau = drawn(rng, **KINDS["undriven"])
    J[:, :, np.flatnonzero(passive)[0]] = 0.0
    decided = structure(J, passive)
    found = torque_distribution(decided, J, tau, np.ones(2))
    scale = decided.rate_scale[passive]
    for each, one, left in zip(J, tau, found.unbalanced, strict=True):
        A = each[:, passive].T * scale[:, None]
        expected = one[passive] - A @ np.linalg.lstsq(A, one[passive] * scale, rcond=1e-10)[0] / scale
        assert np.abs(left - expected).max() <= 1000 * EPS * np.abs(one).max()
    assert np.array_equal(found.unbalanced[:, 0], tau[:, np.flatnonzero(passive)[0]])


@pytest.mark.parametrize(("size", "mass"), [(1e-5, 1e6), (1e5, 1e-6)])
def test_units_change_nothing(size, mass):
    """The same robot, smaller or larger, lighter or heavier: the same ranks, and all figures in their units."""
    rng = np.random.default_rng(11)
    J, passive, tau = drawn(rng, **KINDS["both"])
    tau = balanced(J, passive, tau)
    weights = rng.uniform(0.1, 10.0, 5)
    of_equation = np.where(np.arange(J.shape[1]) % 2, size, 1.0)
    of_rate = np.where(np.arange(J.shape[2]) % 3, 1.0, 1.0 / size)
    other = J * of_equation[:, None] * of_rate
    here, there = structure(J, passive), structure(other, passive)
    names = ("rank", "redundancy", "overconstrained")
    assert [getattr(here, name) for name in names] == [getattr(there, name) for name in names]
    assert np.array_equal(here.equation_determined, there.equation_determined)
    found = torque_distribution(here, J, tau, weights)
    got = torque_distribution(there, other, mass * tau * of_rate, weights / of_rate[~passive] ** 2)
    expected = found.torques * mass * of_rate[~passive]
    assert (np.abs(got.torques - expected).max(axis=0) <= 1e5 * EPS * np.abs(expected).max(axis=0)).all()


def turning(angles):
    """J of two equations, two passive rates and one driven: the second equation turns into the first at angle 0."""
    c, s, one = np.cos(angles), np.sin(angles), np.ones_like(angles)
    return np.stack((np.stack((one, 0 * c, one), -1), np.stack((c, s, one), -1)), -2)


def test_where_the_rank_drops_nothing_is_divided_through():
    passive = np.array([True, True, False])
    angles = np.array([0.3, 1e-4, 0.0, 1e-9, -0.2])
    J = turning(angles)
    decided = structure(turning(np.array([0.3, 1.0])), passive)
    tau = np.tile([1.0, 2.0, 3.0], (5, 1))
    found = torque_distribution(decided, J, tau, np.ones(1))
    assert found.singular.tolist() == [False, False, True, True, False]
    assert found.smallest[2] <= 1e-15
    assert found.smallest[3] <= 1e-8
    for k in (0, 1, 4):
        exact = np.linalg.solve(J[k][:, :2].T, tau[k, :2])
        assert np.abs(found.multipliers[k] - exact).max() <= 1e-11 * np.abs(exact).max()
    c = decided.equation_scale
    shortest = c * np.linalg.lstsq(J[2][:, :2].T * c, [1.0, 0.0], rcond=1e-10)[0]
    assert np.allclose(found.multipliers[2], shortest, rtol=0, atol=1e-14)
    assert np.allclose(found.unbalanced[2], [0.0, 2.0], rtol=0, atol=1e-14)


def test_a_drop_of_the_redundant_part_is_singular_too():
    """Two drives hold one force between them, whose lever arms vanish."""
    levers = np.array([0.5, 0.1, 0.0])
    J = np.stack((levers, -levers, np.zeros(3)), -1)[:, None, :]
    decided = structure(J, np.zeros(3, dtype=bool))
    assert (decided.rank, decided.redundancy) == (0, 1)
    found = torque_distribution(decided, J, np.array([[1.0, 0.0, 2.0]] * 3), np.ones(3))
    assert found.singular.tolist() == [False, False, True]
    assert np.allclose(found.torques, [[0.5, 0.5, 2.0], [0.5, 0.5, 2.0], [1.0, 0.0, 2.0]], rtol=0, atol=1e-15)


def test_a_rank_that_no_reference_sample_had_is_told():
    J = turning(np.array([0.0, 0.4]))
    decided = structure(J[:1], np.array([True, True, False]))
    found = torque_distribution(decided, J, np.ones((2, 3)), np.ones(1))
    assert decided.rank == 1
    assert found.higher.tolist() == [False, True]


LOOP = Loop("wrist_pin", "rod", (0.3, 0.0, 0.0), "slider")


def driving(scene: Scene) -> set[str]:
    model = robodyn.load(ROBOTS / "crank_slider.urdf")
    found = actuation(model, scene)
    assert not (found.passive & found.driven).any()
    assert found.counted.all()
    return set(np.array(model.rates)[found.driven])


@pytest.mark.parametrize(
    ("scene", "expected"),
    [
        (Scene(loops=(LOOP,)), {"main", "pin", "rail"}),
        (Scene(loops=(LOOP,), actuated=("main",)), {"main"}),
        (Scene(loops=(LOOP,), actuated=()), set()),
        (Scene(loops=(LOOP,), passive=("rail",)), {"main", "pin"}),
        (Scene(loops=(LOOP,), drive={"main": Drive(4.0)}), {"main"}),
        (Scene(loops=(LOOP,), drive={"main": Drive(4.0)}, actuated=("rail",)), {"rail"}),
        (Scene(loops=(LOOP,), drive={"main": Drive(4.0)}, passive=("rail",)), {"main", "pin"}),
        (Scene(drive={"main": Drive(4.0)}, passive=("pin",)), {"main", "rail"}),
    ],
)
def test_who_drives(scene, expected):
    assert driving(scene) == expected


def test_weights():
    model = robodyn.load(ROBOTS / "crank_slider.urdf")
    scene = Scene(loops=(LOOP,), share="weighted", weights={"rail": 3.0, "main": "effort"})
    found = actuation(model, scene)
    expected = {"main": 1.0 / 20.0**2, "pin": 1.0, "rail": 3.0}
    assert dict(zip(model.rates, found.weights, strict=True)) == pytest.approx(expected, rel=1e-15)
    assert dict(zip(model.rates, found.limits, strict=True)) == {"main": 20.0, "pin": 200.0, "rail": 500.0}
    assert (actuation(model, replace(scene, share="least", weights={})).weights == 1.0).all()


def without_limits(moving_base: bool = False) -> robodyn.Model:
    text = (ROBOTS / "quadruped.urdf").read_text()
    head, *parts = text.split('effort="')
    return robodyn.load(
        "".join([head, *('effort="0' + part[part.index('"') :] for part in parts)]).encode(), moving_base=moving_base
    )


def test_limits_that_are_missing():
    with pytest.raises(SceneError, match=r"'lf_abduction' has no effort limit, by which \"effort\" weighs \(give its"):
        actuation(without_limits(), Scene(passive=("lf_knee",), share="weighted", weight="effort"))
    feet = (Contact("lf", "lf_foot"),)
    for cost in (ContactCost(torques=1.0), ContactCost(within_limits=True)):
        with pytest.raises(SceneError, match="counts torques by their effort limits, and no joint that drives has one"):
            actuation(without_limits(True), Scene(moving_base=True, contacts=feet, contact_cost=cost))


def test_bases_are_passive_where_contacts_or_loops_to_the_ground_hold_them():
    model = robodyn.load(ROBOTS / "quadruped.urdf", moving_base=True)
    feet = (Contact("lf", "lf_foot"),)
    assert actuation(model, Scene(moving_base=True, contacts=feet)).passive[:6].all()
    flying = actuation(model, Scene(moving_base=True, passive=("lf_knee",)))
    assert not flying.counted[:6].any()
    assert flying.passive.sum() == 1
    bolted = Scene(moving_base=True, loops=(Loop("bolt", "trunk", kind="weld"),))
    assert actuation(model, bolted).passive[:6].all()
    assert not actuation(model, replace(bolted, held=True)).counted[:6].any()
    assert not actuation(model, replace(bolted, loops=(replace(bolted.loops[0], to="lf_foot"),))).counted[:6].any()


def test_weights_of_joints_that_do_not_drive():
    with pytest.raises(SceneError, match=r"\[weights\]: nothing drives 'pin' \(give weights of joints that drive\)"):
        driving(Scene(loops=(LOOP,), actuated=("main",), share="weighted", weights={"pin": 2.0}))
