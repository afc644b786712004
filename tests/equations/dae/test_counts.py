"""Counts of the DAE form: degrees of freedom by rank, redundant constraints, and the index by another road."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.oracles import robot
from helpers.single_bodies import HINGE, NEAR, four_bar, taken_apart
from helpers.small_robots import random_tree

from robodyn.equations.dae.dae import dae


def index_of_pencil(E, A):
    """How often algebraic equations must be differentiated until E x' = A x is an ODE: the shuffle algorithm."""
    for k in range(8):
        U, sizes, _ = np.linalg.svd(E)
        rank = int((sizes > 1e-9 * sizes[0]).sum())
        if rank == len(E):
            return k
        E, A = U.T @ E, U.T @ A
        E[rank:], A[rank:] = A[rank:], 0.0
    return None


def pencils(found):
    """E x' = A x of positions, velocities and reactions, with constraints on each of the three levels.

    Springs and dampers are random: they cannot change the index.
    """
    M, G = found.system.matrices.M, found.system.matrices.G
    n, m = len(M), len(G)
    K, D = np.random.default_rng(0).normal(size=(2, n, n))
    E = np.zeros((2 * n + m, 2 * n + m))
    E[:n, :n], E[n : 2 * n, n : 2 * n] = np.eye(n), M
    A = np.zeros_like(E)
    A[:n, n : 2 * n], A[n : 2 * n, :n], A[n : 2 * n, n : 2 * n], A[n : 2 * n, 2 * n :] = np.eye(n), K, D, G.T
    for level in range(3):
        B, F = A.copy(), E.copy()
        if level < 2:
            B[2 * n :, level * n : (level + 1) * n] = G
        else:
            rows = np.linalg.solve(M, A[n : 2 * n])
            B[2 * n :] = G @ rows
        yield F, B


@pytest.mark.parametrize("make", [lambda: random_tree(0, 3), lambda: random_tree(1, 3, moving_base=True)])
def test_index_of_the_linear_pencil(make):
    found = taken_apart(make())
    assert found.counts.index == (3, 2, 1)
    assert tuple(index_of_pencil(E, A) for E, A in pencils(found)) == (3, 2, 1)


def test_a_body_that_nothing_holds_has_an_ode():
    counts = taken_apart(robot("rigid_body")).counts
    assert (counts.reactions, counts.rank, counts.freedom, counts.index) == (0, 0, 6, (0, 0, 0))


@pytest.mark.parametrize(("name", "free"), [("scara", False), ("puma560", True), ("gripper", False), ("gripper", True)])
def test_trees_have_nothing_redundant(name, free):
    found = taken_apart(robot(name, free))
    counts, model = found.counts, found.system.model
    assert counts.freedom == model.n
    assert counts.reactions == counts.rank == 6 * len(model.bodies) - model.n
    assert counts.rank == np.linalg.matrix_rank(found.system.matrices.G)
    assert counts.unknowns == 12 * len(model.bodies) + counts.reactions
    assert not counts.redundant
    assert not counts.undetermined


def test_a_planar_four_bar_of_hinges():
    """Three bodies and the ground, 4 hinges: 18 - 20 = -2 by counting, 1 by rank; what is out of its plane is open."""
    counts = dae(*four_bar(**HINGE), *NEAR).counts
    assert (counts.bodies, counts.reactions, counts.rank, counts.freedom) == (4, 6 + 3 * 5 + 5, 23, 1)
    assert counts.redundant == (("closure", "Fz"), ("closure", "Mx"), ("closure", "My"))
    assert {reaction for _, reaction in counts.undetermined} == {"Fz", "Mx", "My"}
    assert len(counts.undetermined) == 5 * 3
    assert counts.index == (3, 2, 1)


@pytest.mark.parametrize(
    ("more", "redundant"), [({}, ["Fz"]), ({"directions": ((1.0, 0.0, 0.0), (0.0, 2.0, 0.0))}, [])]
)
def test_redundancy_depends_on_the_closure(more, redundant):
    counts = dae(*four_bar("point", **more), *NEAR).counts
    assert [reaction for _, reaction in counts.redundant] == redundant
    assert counts.freedom == 1
