"""What must not change torques: links split in two, the order of the file, the attitude of the whole."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.oracles import EPS, random_state, run, worst
from helpers.small_robots import body_numbers, joint, link, random_tree_parts, urdf

from robodyn.dynamics.inverse import inverse_dynamics, mass_matrix
from robodyn.dynamics.plan import Plan
from robodyn.programs.vectors import rotation_from_rpy
from robodyn.robot.load import load
from robodyn.scene.scene import Scene


def _pair(first, second, seed=1):
    """tau and M of two robots with the same joints in the same state, whatever the order of their coordinates."""
    q, qd, qdd = random_state(first, np.random.default_rng(seed), 20)
    order = [first.rates.index(name) for name in second.rates]
    back = np.argsort(order)
    other = inverse_dynamics(second, q[:, order], qd[:, order], qdd[:, order])[:, back]
    M = mass_matrix(second, q[:, order])[:, back][:, :, back]
    return inverse_dynamics(first, q, qd, qdd), other, mass_matrix(first, q), M


def _agree(first, second, eps=4):
    tau, other, M, M_other = _pair(first, second)
    assert worst(other, tau) <= eps * EPS
    assert worst(M_other, M) <= eps * EPS


@pytest.mark.parametrize("turn", [(0, 0, 0), (0.4, -1.2, 2.0)], ids=["along", "turned"])
def test_a_link_split_in_two_by_a_fixed_joint(turn):
    """The second half stands in a frame of its own; its numbers are the same in space."""
    rng = np.random.default_rng(2)
    m, c, six = body_numbers(rng)
    m2, c2, six2 = body_numbers(rng)
    R, p = rotation_from_rpy(*turn), np.array([0.2, -0.1, 0.3])
    halves = [
        link("l1", m, c, six),
        link("half", m2, c2, six2),
        joint("glue", "l1", "half", "fixed", (1, 0, 0), p, turn),
    ]
    centre = R @ c2 + p
    I, I2 = (np.array([[a, b, d], [b, e, f], [d, f, g]]) for a, b, d, e, f, g in (six, six2))
    total, mean = m + m2, (m * np.array(c) + m2 * centre) / (m + m2)

    def shifted(mass, inertia, place):
        r = place - mean
        return inertia + mass * (r @ r * np.eye(3) - np.outer(r, r))

    whole = (shifted(m, I, np.array(c)) + shifted(m2, R @ I2 @ R.T, centre))[np.triu_indices(3)]
    rest = [link("l0"), link("l2", *body_numbers(rng)), joint("j1", "l0", "l1", axis=(0.6, 0, 0.8))]
    rest.append(joint("j2", "l1", "l2", "prismatic", (0, 0.8, 0.6), (0.3, 0.2, 0.1), (1, 2, 3)))
    _agree(load(urdf(link("l1", total, mean, whole), *rest)), load(urdf(*halves, *rest)))


@pytest.mark.parametrize("seed", range(2))
def test_the_order_of_the_file(seed):
    """Links and joints shuffled: the same torques joint by joint, in the order in which the file names the joints."""
    rng = np.random.default_rng(seed)
    parts = random_tree_parts(rng, 9)
    shuffled = [parts[k] for k in rng.permutation(len(parts))]
    first, second = load(urdf(*parts)), load(urdf(*shuffled))
    named = [part.split('"')[1] for part in shuffled if part.startswith("<joint") and 'type="fixed"' not in part]
    assert list(second.joint_names) == named
    assert sorted(named) == sorted(first.joint_names)
    assert all(0 <= parent < i for i, parent in enumerate(second.parents) if i)
    _agree(first, second)


@pytest.mark.parametrize("turn", [(0.3, -0.7, 2.9), (np.pi / 2, 0, 0), (0, np.pi / 2, 0.4)])
def test_the_whole_robot_turned_with_gravity(turn):
    parts = random_tree_parts(np.random.default_rng(4), 8)
    upright = load(urdf(link("world"), *parts, joint("mount", "world", "l0", "fixed")))
    tilted = load(urdf(link("world"), *parts, joint("mount", "world", "l0", "fixed", rpy=turn)))
    R, gravity = rotation_from_rpy(*turn), np.array([1.0, -2.0, -9.0])
    state = random_state(upright, np.random.default_rng(5), 20)
    first, second = Plan(upright, Scene(tuple(gravity))), Plan(tilted, Scene(tuple((R @ gravity).tolist())))
    one, two = run(first.wrenches(), first, *state), run(second.wrenches(), second, *state)
    n = upright.n
    assert worst(two[:, :n], one[:, :n]) <= 8 * EPS
    assert worst(two[:, n : n + 3], one[:, n : n + 3] @ R.T) <= 8 * EPS
    assert worst(two[:, n + 3 :], one[:, n + 3 :] @ R.T) <= 8 * EPS
