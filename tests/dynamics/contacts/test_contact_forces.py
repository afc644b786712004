"""Contact forces against Clarabel's and optimality; feet that slip, tip or pull; costs of torques."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest
from helpers.stances import LENGTH, all_around, base_columns, feet, near_the_edge, on_ice, stance

from robodyn.dynamics.contacts.dual import least_forces, projected
from robodyn.dynamics.contacts.solve import (
    STRONGEST,
    FreeTerms,
    Problem,
    TorqueTerms,
    centre_of_pressure,
    conic_forces,
    contact_forces,
    friction_used,
    kinds,
    least_friction,
    scaled,
)
from robodyn.errors import InputError

FAMILIES = {
    "normals all around": lambda n: all_around(20, n, 7),
    "one point": lambda n: near_the_edge(stance(2, n, 1)),
    "sixteen points": lambda n: stance(4, n, 16),
    "two feet": lambda n: feet(6, n, 2),
    "one point on ice": lambda n: on_ice(stance(7, n, 4, push=0.3)),
    "edges of cones": lambda n: near_the_edge(stance(8, n, 4)),
    "pushes that nothing balances": lambda n: stance(9, n, 4, push=5.0),
    "a gram": lambda n: stance(10, n, 6, mass=1e-3),
    "walls and floor": lambda n: replace(
        stance(12, n, 3), normals=np.array(((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -0.6, 0.8)))
    ),
}


def sizes(values):
    return np.sqrt((values.reshape(len(values), -1) ** 2).sum(axis=1))


@pytest.mark.parametrize("family", FAMILIES)
def test_forces_are_the_optimum(family):
    """They balance, f is in the cone, s = f - G^T nu in its dual, f . s = 0; Clarabel's cost and residual agree."""
    problem = FAMILIES[family](30)
    found = contact_forces(problem)
    held, weight = found.feasible, np.maximum(sizes(problem.b), sizes(found.f))
    assert (sizes(found.residual)[held] <= 1e-12 * weight[held]).all()
    total = problem.b[:, 3:] - found.f.sum(axis=1)
    assert (np.abs(total)[held] <= 1e-12 * weight[held, None]).all()
    cones = scaled(problem)[0].chosen(held)
    f, nu = least_forces(cones)
    z = np.einsum("ikcn,in->kcn", cones.G.reshape(6, problem.shape[2], 3, held.sum()), nu)
    f, n = f.reshape(z.shape), cones.normals.reshape(z.shape)
    s, size = f - z, np.maximum(1.0, np.abs(nu).max(axis=0))
    (press, along), (lift, across) = parts(f, n), parts(s, n)
    assert (cones.cosine * along - cones.sine * press <= 1e-13 * size).all()
    assert (cones.sine * across - cones.cosine * lift <= 1e-13 * size).all()
    assert (np.abs((f * s).sum(axis=1)) <= 1e-12 * size**2).all()
    first = slice(0, 4)
    theirs, size = conic_forces(problem.chosen(first)), np.where(sizes(problem.b) > 0.0, sizes(problem.b), 1.0)[first]
    ours, held = found.chosen(first), held[first]
    assert (held == theirs.feasible).all()
    cost, expected = ((x.f**2).sum(axis=(1, 2)) / size**2 for x in (ours, theirs))
    assert (np.abs(cost - expected)[held] <= 1e-8 * np.maximum(expected, 1.0)[held]).all()
    assert (sizes(ours.f - theirs.f)[held] <= 1e-5 * np.maximum(expected, 1.0)[held] ** 0.5 * size[held]).all()
    assert (np.abs(sizes(ours.residual) - sizes(theirs.residual)) <= 1e-8 * size).all()


def parts(f, n):
    press = (f * n).sum(axis=1)
    return press, np.sqrt(((f - press[:, None] * n) ** 2).sum(axis=1))


def test_the_least_of_what_nothing_balances_is_a_minimum():
    """1/2 |f|^2 + 1/2 |r|^2 / rho rises along every way within the cones, by first order: f - G^T r / rho is dual."""
    problem = replace(stance(13, 40, 4, push=5.0), active=None)
    found = contact_forces(problem)
    lost, weight = ~found.feasible, sizes(problem.b)
    assert lost.sum() > 30
    r = found.residual / weight[:, None]
    f = found.f / weight[:, None, None]
    s = f - np.einsum("nij,ni->nj", problem.G, r).reshape(f.shape) / 1e-6
    lift, across = parts(s.transpose(1, 2, 0), problem.normals[:, :, None])
    assert (problem.friction[:, None] * across - lift <= 1e-2)[:, lost].all()  # the parts are 1e6 |r|


def test_four_feet_carry_a_quarter_each():
    arms = np.array([(x, y, -0.5) for x in (-0.3, 0.3) for y in (-0.2, 0.2)])[None]
    up, b = np.array((0.0, 0.0, 1.0)), np.array([(0.0, 0.0, 0.0, 0.0, 0.0, 100.0)])
    for friction in (0.0, 0.5, np.inf):
        f = contact_forces(Problem(base_columns(arms, LENGTH), b, np.tile(up, (4, 1)), np.full(4, friction))).f
        assert np.abs(f - 25.0 * up).max() <= 1e-12 * 100.0


def test_results_depend_neither_on_blocks_nor_on_the_executor():
    problem, found = stance(14, 40, 4), []
    for executor in ("numpy", "compiled"):
        whole = contact_forces(problem, executor)
        parts = [contact_forces(problem.chosen(slice(k, k + 15)), executor).f for k in range(0, 40, 15)]
        assert (np.concatenate(parts) == whole.f).all()
        found.append(whole)
    ours, theirs = found
    assert (ours.feasible == theirs.feasible).all()
    assert (sizes(ours.f - theirs.f) <= 1e-9 * sizes(problem.b))[ours.feasible].all()


def test_inactive_points_do_not_push_and_nothing_needs_nothing():
    problem = stance(16, 100, 4)
    found = contact_forces(problem)
    assert (found.f[~problem.active] == 0.0).all()
    nothing = contact_forces(replace(problem, b=0.0 * problem.b))
    assert nothing.feasible.all()
    assert (nothing.f == 0.0).all()


UP = np.array((0.0, 0.0, 1.0))


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.5, np.pi / 2])
def test_the_nearest_point_of_a_cone_and_how_it_moves(angle):
    """p in the cone, z - p in the polar cone and across p (Moreau); its derivative by differences."""
    cosine, sine, h = (float(np.cos(angle)), float(np.sin(angle)), 1e-6) if angle < 1.57 else (0.0, 1.0, 1e-6)
    for z in np.random.default_rng(0).normal(size=(30, 3)):
        at = projected(z, UP, cosine, sine)
        p, rest = at.f, z - at.f
        assert cosine * np.hypot(*p[:2]) <= sine * p[2] + 1e-15
        assert sine * np.hypot(*rest[:2]) <= -cosine * rest[2] + 1e-15
        assert abs(p @ rest) <= 1e-14
        D = at.inside * np.eye(3) + at.edge * np.outer(at.u, at.u) + at.turn * np.outer(at.v, at.v)
        ends = np.array([[projected(z + s * h * e, UP, cosine, sine).f for e in np.eye(3)] for s in (1.0, -1.0)])
        if angle:
            assert np.abs(D - (ends[0] - ends[1]).T / (2.0 * h)).max() <= 1e-6


SQUARE = np.array([(x, y, 0.0) for x in (-0.1, 0.1) for y in (-0.1, 0.1)])
HALF = 0.1


def block(wanted, friction, height=0.0):
    """A block of half width 0.1 m on a floor, with so much force wanted at its mass centre."""
    b = np.zeros((len(wanted), 6))
    b[:, 3:] = wanted
    arms = np.tile(SQUARE - height * UP, (len(wanted), 1, 1))
    return Problem(base_columns(arms, HALF), b, np.tile(UP, (4, 1)), np.full(4, friction))


@pytest.mark.parametrize("angle", [0.5, 1.2])
def test_a_block_on_a_slope_needs_the_tangent_of_its_angle_and_lacks_the_distance_from_the_cone(angle):
    problem = block([50.0 * np.array((np.sin(angle), 0.0, np.cos(angle)))], 0.2)
    found = contact_forces(problem)
    assert kinds(problem, found) == ["slip"]
    assert least_friction(problem) == pytest.approx(np.tan(angle), rel=2e-6)
    lacking = np.linalg.norm(found.residual[0, 3:])
    assert lacking == pytest.approx(50.0 * np.sin(angle - np.arctan(0.2)), rel=1e-5)
    assert np.abs(found.residual[0, :3]).max() <= 1e-2


def test_a_block_tips_where_the_push_passes_its_edge():
    height, weight = 0.4, 30.0
    pushes = weight * 0.1 / height * np.array((0.5, 1.0 - 1e-6, 1.0 + 1e-6, 2.0))
    problem = block([(push, 0.0, weight) for push in pushes], 5.0, height)
    found = contact_forces(problem)
    assert kinds(problem, found) == ["", "", "tip", "tip"]
    assert least_friction(problem.chosen([3])) is None
    assert least_friction(problem.chosen([0, 1])) == pytest.approx(0.1 / height, rel=1e-5)


def test_feet_that_would_have_to_pull():
    problem = block([(0.0, 0.0, -7.0), (0.0, 0.0, 7.0)], 0.5)
    found = contact_forces(problem)
    assert kinds(problem, found) == ["pull", ""]
    assert found.residual[:, 3:] == pytest.approx(np.array([(0.0, 0.0, -7.0), (0.0, 0.0, 0.0)]), abs=1e-12)


@pytest.mark.parametrize("lean", [0.0, 0.2])
def test_between_walls_only_friction_carries(lean):
    """Walls lean over by `lean`: what is atan(W / 2 h) from the horizontal is `lean` more from the normal."""
    normals = np.array([(np.cos(lean), 0.0, -np.sin(lean)), (-np.cos(lean), 0.0, -np.sin(lean))])
    arms, b = np.array([[(-0.3, 0.0, 0.0), (0.3, 0.0, 0.0)]]), np.array([(0.0, 0.0, 0.0, 0.0, 0.0, 40.0)])
    squeeze = np.sqrt(0.5 * STRONGEST**2 - 0.25)
    expected = np.tan(lean + np.arctan(0.5 / squeeze))
    problem = Problem(base_columns(arms, 0.3), b, normals, np.full(2, 0.5))
    found = contact_forces(problem)
    assert found.feasible.all()
    assert found.f.sum(axis=1)[0] == pytest.approx((0.0, 0.0, 40.0), abs=40e-12)
    across = np.tan(np.arctan(0.5) - lean)  # the least forces are on the edges of the cones
    assert np.abs(found.f[0, :, 0]) == pytest.approx(20.0 / across, rel=1e-9)
    assert least_friction(problem) == pytest.approx(expected, rel=1e-5)


def test_the_least_friction_is_that_of_the_worst_sample():
    problem = feet(3, 2, 1, push=0.2)
    mu = least_friction(problem)
    alone = [least_friction(problem.chosen([k])) for k in range(2)]
    assert mu == pytest.approx(max(alone), rel=1e-5)
    assert least_friction(problem, known=0.5) == 0.5
    assert least_friction(problem.chosen([0]), known=0.5 * alone[0]) == pytest.approx(alone[0], rel=1e-5)


FOOT = np.array([(0.1, 0.05, 0.0), (-0.1, 0.05, 0.0), (-0.1, -0.05, 0.0), (0.1, -0.05, 0.0), (0.02, 0.01, 0.0)])


def test_the_centre_is_the_mean_weighed_by_the_press():
    random = np.random.default_rng(0)
    forces = random.uniform(0.1, 1.0, (50, 5, 3))
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    there = np.array((1.0, 2.0, 3.0))
    where, margin = centre_of_pressure(np.tile(FOOT @ turn.T + there, (50, 1, 1)), turn[:, 2], forces @ turn.T)
    expected = np.einsum("nk,ki->ni", forces[:, :, 2], FOOT) / forces[:, :, 2].sum(axis=1)[:, None]
    assert np.abs((where - there) @ turn - expected).max() <= 1e-13
    sides = np.stack((0.1 - np.abs(expected[:, 0]), 0.05 - np.abs(expected[:, 1])))
    assert margin == pytest.approx(sides.min(axis=0), abs=1e-13)


def test_forces_that_pull_put_it_beyond_an_edge():
    forces = np.outer((0.0, 2.0, 0.0, -1.0, 0.0), UP)[None]
    where, margin = centre_of_pressure(FOOT[None], UP, forces)
    assert where[0] == pytest.approx((-0.3, 0.15, 0.0))
    assert margin == pytest.approx([-0.2])


def test_friction_used():
    forces = np.array([(3.0, 4.0, 10.0), (0.0, 0.0, 10.0), (0.0, 0.0, 0.0)])[:, None]
    assert friction_used(forces, UP, 0.5) == pytest.approx([1.0, 0.0, np.nan], nan_ok=True)
    assert friction_used(forces, UP, 0.0) == pytest.approx([np.inf, 0.0, np.nan], nan_ok=True)


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
