"""Contact forces that cost torques, are bounded by efforts, and share equations with other unknowns."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest
from helpers.stances import base_columns, feet, stance

from robodyn.dynamics.contacts.solve import FreeTerms, Problem, TorqueTerms, contact_forces, least_friction
from robodyn.errors import InputError

UP = np.array((0.0, 0.0, 1.0))
GAP = 1e-5
"""Of the largest force: the root of the 1e-10 of the cost at which Clarabel's duality gap stops."""


def legs(push=0.0, limits=None, weights=1.0):
    """Two points on a line, of legs whose torque is 0.1 m times the sideways force and 0.2 m times the press."""
    arms = np.array([[(-0.2, 0.0, -0.5), (0.2, 0.0, -0.5)]])
    b = np.array([(0.0, 0.0, 0.0, push, 0.0, 100.0)])
    T = np.zeros((1, 2, 6))
    T[0, 0, :3], T[0, 1, 3:] = (0.1, 0.0, 0.2), (0.1, 0.0, 0.2)
    torques = TorqueTerms(np.zeros((1, 2)), T, np.full(2, weights), limits)
    return Problem(base_columns(arms, 0.3), b, np.tile(UP, (2, 1)), np.full(2, 0.9), torques=torques)


def torques_of(problem, found):
    free = 0.0 if problem.free is None else np.einsum("nij,nj->ni", problem.free.S, found.free)
    return problem.torques.tau0 - np.einsum("nij,nj->ni", problem.torques.T, found.f.reshape(len(found.f), -1)) - free


def test_pushed_beyond_what_holds_with_feet_on_ice():
    """Where some points have no friction and no forces balance, the least unbalanced are found."""
    plain = feet(6, 10, 2, push=30.0).chosen(np.array([5]))
    plain = replace(plain, friction=np.repeat((0.0, 0.7), 4))
    ours = contact_forces(plain)
    theirs = contact_forces(replace(plain, torques=TorqueTerms(np.zeros((1, 1)), np.zeros((1, 1, 24)), np.ones(1))))
    assert not ours.feasible[0]
    assert not theirs.feasible[0]
    assert theirs.f == pytest.approx(ours.f, abs=1e-5 * np.abs(ours.f).max())


def test_the_optimum_inside_cones_is_that_of_the_linear_equations():
    """Random costs of torques, against the conditions of the optimum as one dense system."""
    random = np.random.default_rng(0)
    problem = replace(stance(17, 20, 4, push=0.0, friction=50.0), normals=np.tile(UP, (4, 1)), active=None)
    T, tau0 = random.normal(size=(20, 6, 12)), random.normal(size=(20, 6))
    problem = replace(problem, torques=TorqueTerms(tau0, 0.01 * T, np.full(6, 2.0)))
    found, looked = contact_forces(problem), 0
    for n in range(20):
        G, M = problem.G[n], 0.01 * T[n]
        H = np.block([[np.eye(12) + 2.0 * M.T @ M, G.T], [G, np.zeros((6, 6))]])
        expected = np.linalg.solve(H, np.concatenate((2.0 * M.T @ tau0[n], problem.b[n])))[:12].reshape(4, 3)
        if (50.0 * expected[:, 2] > 1.1 * np.hypot(expected[:, 0], expected[:, 1])).all():
            assert found.f[n] == pytest.approx(expected, abs=GAP * np.abs(expected).max())
            looked += 1
    assert looked >= 3


def test_limits_are_kept_where_they_can_be():
    """The press is 50 N each; sideways forces against each other take torque off."""
    free = torques_of(legs(), contact_forces(legs(weights=0.0)))
    assert np.abs(free) == pytest.approx(10.0, abs=1e-4)
    problem = legs(limits=np.array((9.0, np.inf)), weights=0.0)
    found = contact_forces(problem)
    assert found.feasible.all()
    assert found.within_limits.all()
    assert np.abs(torques_of(problem, found)[0, 0]) <= 9.0 * (1.0 + 1e-8)
    assert found.f[0, 0, 0] == pytest.approx(-10.0, rel=1e-6)


def test_limits_give_way_before_the_equations():
    problem = legs(limits=np.array((0.5, 0.5)))
    found = contact_forces(problem)
    assert found.feasible.all()
    assert not found.within_limits.any()
    assert np.abs(found.residual).max() <= 1e-8


def test_free_unknowns_balance_what_contacts_cannot():
    """A free unknown that pulls down by x: the equations hold, f at least cost."""
    problem = legs(push=0.0)
    H, S = np.zeros((1, 6, 1)), np.zeros((1, 2, 1))
    H[0, 5], S[0, 0] = 1.0, 0.5
    pulled = replace(problem, b=-problem.b, free=FreeTerms(H, S))
    found = contact_forces(pulled)
    assert found.feasible.all()
    assert found.free[0, 0] == pytest.approx(found.f[0, :, 2].sum() * -1.0 - 100.0, rel=1e-8)
    assert not contact_forces(replace(pulled, free=None)).feasible.any()


def test_the_least_friction_beside_other_unknowns_does_not_depend_on_torques():
    """What the unknowns take from the torques is left out with these."""
    problem = legs(push=30.0)
    H, S = np.zeros((1, 6, 1)), np.full((1, 2, 1), 0.5)
    without, beside = (least_friction(replace(problem, free=FreeTerms(H, each))) for each in (None, S))
    assert beside == without == pytest.approx(0.3, rel=1e-5)


def test_without_clarabel_one_line_says_so(monkeypatch):
    monkeypatch.setitem(sys.modules, "clarabel", None)
    with pytest.raises(InputError, match=r"need clarabel.*robodyn\[conic\]"):
        contact_forces(legs())


def test_where_clarabel_gets_stuck_one_line_says_so(monkeypatch):
    monkeypatch.setattr("robodyn.dynamics.contacts.solve._by_clarabel", lambda sample, limited: None)
    with pytest.raises(InputError, match="no contact forces are found"):
        contact_forces(legs())
