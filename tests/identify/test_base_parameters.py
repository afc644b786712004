"""Base parameters: known counts, closed forms, exact estimates; physically consistent ones against another solver."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.example_robots import VARIANTS, cases, path_of
from helpers.oracles import EPS, ROBOTS, random_state, robot, worst
from helpers.peers import peer
from helpers.possible_bodies import truth_near
from helpers.sampled import sampled
from helpers.small_robots import built, joint, link, random_tree

import robodyn
from robodyn.dynamics.regressor import INERTIAL, regressor
from robodyn.errors import InputError
from robodyn.identification.parameters.base import base_of, random_rows, structural_base
from robodyn.identification.parameters.consistent import (
    MARGIN,
    Prior,
    PriorBody,
    consistent_parameters,
    coordinates,
    ellipsoid,
    parameters_of,
    prior_of,
    pseudo_inertia,
)
from robodyn.robot.load import load
from robodyn.scene.scene import Friction, Scene
from robodyn.solids.inertia.validity import Box

LWR4 = Path(__file__).parents[1] / "data" / "lwr4.urdf"
_INERTIAL = '<inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
ARM = f"""<robot name="arm"><link name="base"/><link name="upper">{_INERTIAL}</link><link name="fore">{_INERTIAL}</link>
<joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
<joint name="elbow" type="continuous">
<origin xyz="0.7 0 0"/><parent link="upper"/><child link="fore"/><axis xyz="0 1 0"/></joint></robot>""".encode()


def inertial(names):
    return [k for k, name in enumerate(names) if name.rpartition(".")[2] in INERTIAL]


@pytest.mark.parametrize(
    ("path", "known"),
    [
        pytest.param(ROBOTS / "puma560.urdf", 36, id="PUMA 560: Gautier and Khalil 1990"),
        pytest.param(LWR4, 43, id="LWR4+: Jubien, Gautier and Janot 2014"),
        pytest.param(path_of("ur10_robot"), 36, id="UR10"),
        pytest.param(ROBOTS / "two_link_planar.urdf", 6, id="a double pendulum"),
    ],
)
def test_known_counts(path, known):
    rows, names = random_rows(load(path))
    columns = inertial(names)
    base = base_of(rows[:, columns], [names[k] for k in columns])
    assert base.rank == known
    assert base.kept > 0.1
    assert base.dropped < 1e-12


def test_groups_of_a_double_pendulum():
    """In closed form: M and m of both links, what the elbow carries is added to the upper arm at 0.7 m."""
    assert structural_base(load(ARM)).groups == (
        "upper.mx + 0.7 fore.m",
        "upper.mz",
        "upper.Iyy + 0.49 fore.m + shoulder.rotor",
        *("fore.mx", "fore.mz", "fore.Iyy", "shoulder.viscous", "shoulder.forward", "shoulder.backward"),
        *("elbow.viscous", "elbow.forward", "elbow.backward", "elbow.rotor"),
    )
    weightless = structural_base(load(ARM), Scene(gravity=(0.0, 0.0, 0.0)))
    assert weightless.groups[0] == "upper.Iyy + 0.49 fore.m + shoulder.rotor"


OURS = [
    ROBOTS / f"{name}.urdf" for name in ("scara", "gripper", "cylindrical", "puma560", "two_link_spatial", "satellite")
]


@pytest.mark.parametrize("path", [*sampled(OURS, 3), *sampled([*cases(VARIANTS)][::5], 6)])
def test_base_parameters_make_all_torques(path):
    """Coefficients below 1e-9 of a column are taken for rounding: so many small ones may be missing."""
    model = load(path)
    base = structural_base(model)
    found = regressor(model, *random_state(model, np.random.default_rng(2), 4), executor="numpy")
    chosen = found.Y[..., base.independent]
    largest = np.abs(found.Y).max(axis=(0, 1), initial=0.0)
    bound = 1e-9 * np.sqrt(base.rank) * largest
    assert (np.abs(chosen @ base.matrix - found.Y).max(axis=(0, 1), initial=0.0) <= bound)[
        [k for k in range(len(base.names)) if k not in base.invisible]
    ].all()
    expected = found.Y @ found.theta
    assert worst(chosen @ base.values(found.theta), expected, max(np.abs(expected).max(initial=0), 1e-300)) <= 3e-10
    assert base.matrix[:, base.independent].tolist() == np.eye(base.rank).tolist()


def test_every_kind_of_friction_and_a_base_that_floats():
    model = busy_robot(True)
    scene = replace(BUSY_SCENE, friction={"j1": Friction(0.1, 0.2, -0.3, 0.4, 0.05)})
    base = structural_base(model, scene)
    assert {"j1.stribeck", "j1.viscous", "j1.forward", "j1.backward"} <= {base.names[k] for k in base.independent}
    base_body = model.bodies[0].name
    assert base.groups[0].startswith(f"{base_body}.m + "), "afloat, the mass of the base is felt"


def test_estimates_are_exact_and_have_the_errors_of_the_normal_equations():
    model = robot("two_link_planar")
    base = structural_base(model)
    found = regressor(model, *random_state(model, np.random.default_rng(6), 30), executor="numpy")
    rows = found.Y.reshape(-1, len(found.names))
    factor = np.linalg.qr(np.column_stack((rows, rows @ found.theta)), mode="r")
    for estimate in (base.estimate(factor[:, :-1], factor[:, -1]), base.estimate(rows, rows @ found.theta)):
        assert worst(estimate.values, base.values(found.theta)) <= 1e-12
    estimate = base.estimate(rows / 0.3, np.zeros(len(rows)))
    chosen = rows[:, base.independent]
    expected = 0.09 * np.linalg.inv(chosen.T @ chosen)
    assert worst(estimate.covariance, expected) <= 1e-12
    assert worst(estimate.standard_errors, np.sqrt(np.diag(expected))) <= 1e-12


def test_what_a_motion_does_not_show():
    """The elbow at rest: its friction and rotor are invisible, and the forearm is a part of the upper arm."""
    model = load(ARM)
    base = structural_base(model)
    rng = np.random.default_rng(7)
    q, qd, qdd = rng.uniform(-1, 1, (3, 40, 2))
    q[:, 1], qd[:, 1], qdd[:, 1] = 0.3, 0.0, 0.0
    found = regressor(model, q, qd, qdd, executor="numpy")
    rows = found.Y.reshape(-1, len(found.names))
    shown = base.within(rows)
    assert {"elbow.viscous", "elbow.rotor", "elbow.forward"} <= {shown.names[k] for k in shown.invisible}
    chosen = [shown.names[k] for k in shown.independent]
    assert [name for name in chosen if name.startswith("upper")] == ["upper.mx", "upper.mz", "upper.Iyy"]
    assert worst(rows[:, shown.independent] @ shown.matrix, rows) <= 1e-10
    again = base.within(rows)
    assert again.groups == shown.groups


def test_names_do_not_hang_on_rounding_or_units():
    """In millimetres and grams, or with torques of another size, the same parameters are chosen."""
    rows, names = random_rows(robot("puma560"))
    rng = np.random.default_rng(8)
    base = base_of(rows, names)
    for _ in range(2):
        noisy = rows * (1.0 + 16 * EPS * rng.uniform(-1, 1, rows.shape))
        assert base_of(noisy[rng.permutation(len(rows))], names).groups == base.groups
    rows, names = random_rows(robot("puma"))
    sizes = 10.0 ** rng.integers(-3, 3, len(names))
    sizes[inertial(names)] = 1e-3
    assert base_of(1e6 * rows * sizes, names).independent == base_of(rows, names).independent


NAMES = tuple(f"b.{part}" for part in ("m", "mx", "my", "mz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"))


@cache
def arm(seed=3, n=4, samples=60):
    """A robot's regressor in random states, and its prior."""
    model, rng = random_tree(seed, n, kinds=("revolute", "prismatic")), np.random.default_rng(seed)
    q, qd, qdd = rng.normal(size=(3, samples, model.n)) * np.array((1.0, 2.0, 4.0))[:, None, None]
    found = robodyn.regressor(model, q, qd, qdd)
    return found.Y.reshape(-1, len(found.names)), prior_of(model, found.names, found.theta)


def log(noise, seed=5, zero=()):
    """Triangular factor and right side of the arm's torques, with noise, and the truth."""
    Y, prior = arm()
    rng = np.random.default_rng(seed)
    truth = truth_near(prior, rng)
    truth[[k for k, name in enumerate(prior.names) if name.rpartition(".")[2] in zero]] = 0.0
    tau = Y @ truth
    tau += noise * tau.std() * rng.normal(size=len(tau))
    factor = np.linalg.qr(np.column_stack((Y, tau)), mode="r")
    return factor[:-1, :-1], factor[:-1, -1], prior, truth


def smallest(theta, prior):
    """The least eigenvalue of P0^-1 P over the bodies."""
    return min(
        np.linalg.eigvals(np.linalg.solve(*(pseudo_inertia(t[b.columns]) for t in (prior.theta, theta)))).real.min()
        for b in prior.bodies
    )


def assert_possible(theta, prior):
    assert smallest(theta, prior) >= 0.9 * MARGIN
    for body in prior.bodies:
        m, c = theta[body.columns.start], theta[body.columns][1:4] / theta[body.columns.start]
        P = pseudo_inertia(theta[body.columns])
        second = np.linalg.eigvalsh(P[:3, :3] - m * np.outer(c, c))
        moments = sorted((second[0] + second[1], second[0] + second[2], second[1] + second[2]))
        assert min(m, *moments) > 0
        assert moments[0] + moments[1] > moments[2]
    for k, name in enumerate(prior.names):
        kind = name.rpartition(".")[2]
        assert kind not in ("viscous", "forward", "rotor", "stribeck") or theta[k] >= 0.0
        assert kind != "backward" or theta[k] <= 0.0


def one_body(R, prior_parameters, Q=None):
    prior = np.asarray(prior_parameters, dtype=float)
    return Prior(NAMES, prior, prior, (PriorBody("b", slice(0, 10), Q),), ())


def random_body(rng, scale=1.0):
    x = rng.normal(size=(8, 4)) * (scale, scale, scale, 0.0) + (0.0, 0.0, 0.0, 1.0)
    return parameters_of(np.einsum("k,ki,kj->ij", rng.uniform(0.1, 1.0, 8), x, x))


def test_units_and_magnitudes_do_not_matter():
    """Masses and lengths in other units make the same bodies of the same data."""
    rng, scale, size = np.random.default_rng(8), 1e9, 1e-3
    truth, prior, R = random_body(rng), random_body(rng), rng.normal(size=(8, 10))
    z = R @ truth + 0.1 * rng.normal(size=8)
    units = scale * np.array((1.0, *(size,) * 3, *(size * size,) * 6))
    plain = consistent_parameters(R, z, one_body(R, prior), 1e-3)
    other = consistent_parameters(R / units, z, one_body(R, prior * units), 1e-3)
    assert np.abs(other.theta / units - plain.theta).max() <= 1e-5 * np.abs(plain.theta).max()
    assert abs(other.error - plain.error) <= 1e-10 * (z @ z)
    with pytest.raises(InputError, match="not finite"):
        consistent_parameters(R * np.nan, z, one_body(R, prior))


@pytest.mark.parametrize(("noise", "strength"), [(0.0, 1e-8), (0.5, 0.0), (0.5, 1.0)])
def test_every_answer_is_possible_and_certain(noise, strength):
    R, z, prior, _ = log(noise, zero=("rotor",))
    found = consistent_parameters(R, z, prior, strength * (z @ z))
    assert_possible(found.theta, prior)
    assert found.gap <= 1e-10 * (z @ z)
    assert found.error == pytest.approx(0.5 * np.sum((R @ found.theta - z) ** 2), rel=1e-9)


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_descriptions_may_be_far_off(seed):
    """Thirty times too heavy or too light, three times too long or too short, with fewer rows than parameters."""
    rng = np.random.default_rng(seed)
    sizes = 10.0 ** rng.uniform((-1.5, -0.5), (1.5, 0.5), (3, 2, 2))
    prior, truth = (np.concatenate([m * random_body(rng, x) for m, x in sizes[:, k]]) for k in (0, 1))
    names = tuple(f"b{k}.{name[2:]}" for k in range(3) for name in NAMES)
    known = Prior(names, prior, prior, tuple(PriorBody(f"b{k}", slice(10 * k, 10 * k + 10)) for k in range(3)), ())
    R = rng.normal(size=(20, 30)) * np.tile(np.repeat(10.0 ** rng.uniform(-2, 2, 3), (1, 3, 6)), 3)
    z = R @ truth * (1.0 + 0.2 * rng.normal(size=20))
    found = consistent_parameters(R, z, known)
    assert found.gap <= 2e-12 * (z @ z)
    assert_possible(found.theta, known)


@pytest.mark.parametrize("seed", [11, 232])
def test_motions_that_show_little(seed):
    """Small motions of small robots, far from the description: one in a hundred of these stopped at a cone's border."""
    rng = np.random.default_rng(seed)
    model = random_tree(seed % 5, 2 + seed % 3, kinds=("revolute",))
    q, qd, qdd = rng.normal(size=(3, 40, model.n)) * np.array((1.0, 2.0, 4.0))[:, None, None] * 10 ** rng.uniform(-2, 0)
    found = robodyn.regressor(model, q, qd, qdd)
    Y, prior = found.Y.reshape(-1, len(found.names)), prior_of(model, found.names, found.theta)
    tau = Y @ (found.theta * np.exp(rng.standard_normal(len(found.theta))))
    tau += 10 ** rng.uniform(-4, -0.5) * np.linalg.norm(tau) / np.sqrt(len(tau)) * rng.standard_normal(len(tau))
    factor = np.linalg.qr(np.column_stack((Y, tau)), mode="r")
    R, z = factor[:, :-1], factor[:, -1]
    fit = consistent_parameters(R, z, prior, 10 ** rng.uniform(-9, -3) * float(z @ z))
    assert fit.gap < 1e-10 * float(z @ z)


def by_clarabel(R, z, prior):
    """min ||R theta - z||^2 / 2 over P - MARGIN P0 positive semidefinite and the signs, by a conic solver."""
    clarabel, sparse = peer("clarabel"), peer("scipy.sparse")
    p, rows, right, cones = R.shape[1], [], [], []
    for body in prior.bodies:
        P0 = pseudo_inertia(prior.theta[body.columns])
        L = np.linalg.cholesky(P0)
        inner = np.linalg.inv(L)
        block = np.zeros((10, p))
        unit = np.stack([coordinates(inner @ pseudo_inertia(e) @ inner.T) for e in np.eye(10)], axis=1)
        order = [0, 1, 4, 2, 5, 7, 3, 6, 8, 9]  # the upper triangle by columns, of the basis by rows
        block[:, body.columns] = unit[order]
        rows, right = [*rows, -block], [*right, -MARGIN * coordinates(np.eye(4))[order]]
        cones.append(clarabel.PSDTriangleConeT(4))
    for k, name in enumerate(prior.names):
        kind = name.rpartition(".")[2]
        if kind in ("viscous", "forward", "backward", "rotor"):
            row = np.zeros((1, p))
            row[0, k] = 1.0 if kind == "backward" else -1.0
            rows, right, cones = [*rows, row], [*right, np.zeros(1)], [*cones, clarabel.NonnegativeConeT(1)]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-10
    size = np.linalg.norm(z)
    A, b = np.vstack(rows), np.concatenate(right)
    P, q = sparse.csc_matrix(np.triu(R.T @ R / size**2)), -(R.T @ z) / size**2
    solution = clarabel.DefaultSolver(P, q, sparse.csc_matrix(A), b, cones, settings).solve()
    return np.array(solution.x)


def test_without_strength_it_is_the_optimum_of_another_solver():
    """And bounds are reached exactly."""
    R, z, prior, _ = log(0.3, zero=("rotor", "viscous"))
    ours, theirs = consistent_parameters(R, z, prior).theta, by_clarabel(R, z, prior)
    errors = [np.sum((R @ theta - z) ** 2) / (z @ z) for theta in (ours, theirs)]
    assert abs(errors[0] - errors[1]) <= 1e-6 * errors[1]
    unconstrained = np.linalg.lstsq(R, z, rcond=1e-12)[0]
    assert any(ours[k] == 0.0 for k, name in enumerate(prior.names) if name.endswith((".rotor", ".viscous")))
    assert errors[0] > 1.001 * np.sum((R @ unconstrained - z) ** 2) / (z @ z)  # the bounds are active


def test_mass_stays_within_the_ellipsoid():
    rng = np.random.default_rng(11)
    box = Box(np.array((-0.1, -0.2, 0.0)), np.array((0.3, 0.2, 0.1)))
    inside = rng.uniform(box.lo, box.hi, (50, 3))
    homogeneous = np.column_stack((inside, np.ones(50)))
    prior = parameters_of(np.einsum("ki,kj->ij", homogeneous, homogeneous) * 0.02)
    far = parameters_of(pseudo_inertia(prior) + np.outer(*((5.0, 0.0, 0.0, 1.0),) * 2) * 0.5)
    R, Q = rng.normal(size=(12, 10)), ellipsoid(box)
    assert np.einsum("ki,ij,kj->k", homogeneous, Q, homogeneous).min() >= 0.0
    corner = np.append(box.hi, 1.0)
    assert abs(corner @ Q @ corner) <= 1e-12
    free = consistent_parameters(R, R @ far, one_body(R, prior))
    bound = consistent_parameters(R, R @ far, one_body(R, prior, Q))
    assert np.sum(pseudo_inertia(free.theta) * Q) < -1.0
    assert np.sum(pseudo_inertia(bound.theta) * Q) >= -1e-12
    assert bound.gap <= 1e-10 * np.sum((R @ far) ** 2)


def test_what_is_not_seen_stays_as_described():
    Y, prior = arm()
    nothing = consistent_parameters(0.0 * Y[:5], np.zeros(5), prior)
    assert nothing.theta.tolist() == prior.described.tolist()
    R, z, prior, _ = log(0.1)
    found = consistent_parameters(R, z, prior)
    base = slice(0, 10)
    assert not R[:, base].any()
    assert found.theta[base].tolist() == prior.described[base].tolist()


def test_a_rank_of_one_is_enough():
    rng = np.random.default_rng(0)
    prior = random_body(rng)
    row = rng.normal(size=(1, 10))
    found = consistent_parameters(row, row @ prior * 1.3, one_body(row, prior))
    assert float(np.abs(row @ found.theta - 1.3 * row @ prior).max()) <= 1e-6 * np.abs(row @ prior).max()
    change = np.linalg.inv(pseudo_inertia(found.theta)) - np.linalg.inv(pseudo_inertia(prior))
    gradient = np.array([np.sum(change * pseudo_inertia(e)) for e in np.eye(10)])  # of D: along the row, if nearest
    assert abs(gradient @ row[0]) >= (1 - 1e-4) * np.linalg.norm(gradient) * np.linalg.norm(row)


def test_impossible_descriptions_are_replaced_and_said():
    model = built(
        link("base", 1.0, inertia=(1, 0, 0, 1, 0, 1)),
        link("a", 2.0, (0, 0, 0.3), (0.1, 0, 0, 0.1, 0, 0.5)),
        link("b", 0.2, (0, 0, 0.04)),
        link("c", 0.0, inertia=(0.1, 0, 0, 0.1, 0, 0.1)),
        link("frame"),
        link("tip", 1.0, (0, 0, 0.1), (0.1, 0, 0, 0.1, 0, 0.1)),
        *(joint(f"j{k}", a, b, xyz=(0, 0, 0.5)) for k, (a, b) in enumerate(pairwise(LINKS))),
    )
    found = robodyn.regressor(model, *np.zeros((3, 1, 5)))
    prior = prior_of(model, found.names, found.theta)
    assert [body.name for body in prior.bodies] == ["a", "b", "c", "tip"]
    for body in prior.bodies:
        assert np.linalg.eigvalsh(pseudo_inertia(prior.theta[body.columns])).min() > 0.0
    assert [note.split(":")[0] for note in prior.notes] == [
        "body 'a' has an inertia that no body has",
        "body 'b' has no inertia",
        "body 'c' has a mass of 0 kg",
    ]
    kept = [prior.bodies[3].columns, slice(0, 10)]
    assert all((prior.theta[own] == prior.described[own]).all() for own in kept)
    b = prior.theta[prior.bodies[1].columns]
    assert b[:4] == pytest.approx((0.2, 0, 0, 0.2 * 0.04))
    assert 0.0 < b[4] < 0.2 * 0.5**2


LINKS = ("base", "a", "b", "c", "frame", "tip")


def test_of_a_cloud_of_points_it_is_the_integral():
    rng = np.random.default_rng(1)
    m, x = rng.uniform(0.1, 2.0, 6), rng.normal(size=(6, 3))
    squares = (x * x).sum(axis=1)[:, None, None] * np.eye(3)
    I = np.einsum("k,kij->ij", m, squares - np.einsum("ki,kj->kij", x, x))
    P = pseudo_inertia(np.array((m.sum(), *(m @ x), *I[np.triu_indices(3)])))
    homogeneous = np.column_stack((x, np.ones(6)))
    expected = np.einsum("k,ki,kj->ij", m, homogeneous, homogeneous)
    assert np.abs(P - expected).max() <= 16 * np.finfo(float).eps * np.abs(expected).max()
