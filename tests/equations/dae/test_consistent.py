"""Consistent initial values: bodies that are pushed apart find back, and joints read their coordinates off bodies."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.busy_robot import busy_robot
from helpers.oracles import random_state, robot
from helpers.single_bodies import HINGE, NEAR, disturbed, four_bar, thrown
from helpers.small_robots import chain, random_tree

from robodyn.equations.dae.closed import consistent, coordinates_of, quaternion
from robodyn.equations.dae.consistent import flat_speeds, projected, residuals
from robodyn.equations.dae.posed import posed
from robodyn.errors import InputError
from robodyn.programs.vectors import rotation_about, rotation_from_quaternion
from robodyn.scene.parts import Loop
from robodyn.scene.scene import DEFAULT, Scene


def placed(model, seed=0, scene=DEFAULT):
    (q,), (qd,), (tau,) = random_state(model, np.random.default_rng(seed), 1)
    return posed(model, scene, q, qd, tau), q, qd


def off(robot_, at):
    """The residuals of places and speeds beside the robot's extent and its largest speed."""
    found = residuals(robot_.system, at)
    extent = max(np.abs([place.c for place in at.places]).max(), robot_.length)
    return np.abs(found.places).max() / extent, np.abs(found.speeds).max() / np.abs(flat_speeds(at)).max()


ROBOTS = {
    "puma560": lambda: robot("puma560"),
    "tree": lambda: random_tree(3, 9),
    "free tree": lambda: random_tree(4, 9, moving_base=True),
    "mimic joints": busy_robot,
    "gripper": lambda: robot("gripper"),
    "thrown": thrown,
    "chain": lambda: chain(8, skew=True),
}


@pytest.mark.parametrize("size", [1e-6, 0.05])
@pytest.mark.parametrize("name", ROBOTS)
def test_disturbed_bodies_find_back(name, size):
    model = ROBOTS[name]()
    single, *_ = placed(model)
    apart = disturbed(np.random.default_rng(1), single.at, size)
    assert off(single, apart)[0] > 0.1 * size
    together = projected(single.system, apart, single.length)
    places, speeds = off(single, together)
    assert places <= 1e-14
    assert speeds <= 1e-14
    moved = max(np.abs(a.c - b.c).max() for a, b in zip(apart.places, together.places, strict=True))
    assert moved <= 20 * size


@pytest.mark.parametrize("name", ROBOTS)
def test_coordinates_go_there_and_back(name):
    """q and qd of the nearest consistent state place all bodies where they are in it."""
    model = ROBOTS[name]()
    single, *_ = placed(model)
    together = projected(single.system, disturbed(np.random.default_rng(2), single.at, 0.02), single.length)
    q, qd = coordinates_of(single, together)
    again = posed(model, DEFAULT, q, qd, np.zeros(model.n)).at
    reach = max(np.abs([place.c for place in together.places]).max(), 1.0)
    speed = np.abs(flat_speeds(together)).max()
    for one, other in zip(again.places, together.places, strict=True):
        assert np.abs((one.c - again.places[-1].c) - (other.c - together.places[-1].c)).max() <= 3e-14 * reach
        assert np.abs(one.R - other.R).max() <= 3e-14
    assert np.abs(flat_speeds(again) - flat_speeds(together)).max() <= 1e-13 * speed


@pytest.mark.parametrize("free", [False, True])
def test_a_consistent_state_stays(free):
    model = random_tree(5, 8, moving_base=free)
    single, q, qd = placed(model)
    found = consistent(single)
    if free:
        q[3:7] *= np.sign(q[6])
    assert np.abs(found[0] - q).max() <= 1e-14 * 3
    assert np.abs(found[1] - qd).max() <= 1e-13


def test_a_loop_closes():
    model, scene = four_bar(**HINGE)
    single = posed(model, scene, *NEAR)
    assert np.abs(residuals(single.system, single.at).places).max() > 0.1
    q, qd = consistent(single)
    closed = posed(model, scene, q, qd, [0.0] * 3)
    assert max(off(closed, closed.at)) <= 1e-14
    assert np.abs(q - NEAR[0]).max() <= 0.3


def test_what_cannot_close_is_refused():
    loop = Loop("far", "l3", (1.0, 0.0, 0.0), "ground", (5.0, 0.0, 0.0))
    with pytest.raises(InputError, match=r"they stay .* apart \(begin nearer, or look for a loop that cannot close\)"):
        consistent(posed(chain(3), Scene(loops=(loop,)), *NEAR))


def test_quaternions_of_all_turns():
    rng = np.random.default_rng(0)
    for k in range(200):
        axis = rng.normal(size=3) if k % 4 else np.eye(3)[k % 3]
        R = rotation_about(axis / np.linalg.norm(axis), (np.pi if k % 2 else 1.0) * rng.uniform(-1, 1) ** (k % 3))
        found = quaternion(R)
        assert found[3] >= 0.0
        assert np.abs(rotation_from_quaternion(*found) - R).max() <= 2e-15
