import numpy as np
from helpers import mesh_samples as samples
from helpers.symmetric_bodies import any_rotation

from robodyn.solids.mesh.asymmetry import TriangleSet

MIRROR = np.diag([1.0, 1.0, -1.0])


def test_turned_torus_is_the_same_set_whatever_the_order():
    R = any_rotation(6)
    body = samples.moved(samples.torus(rings=12), R=R)
    shuffled = np.roll(body[np.random.default_rng(0).permutation(len(body))], 1, axis=1)
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    assert TriangleSet(shuffled, 2.5).invariant(R @ turn @ R.T)
    assert not TriangleSet(shuffled, 2.5).invariant(R)


def test_corner_moved_by_a_millionth_makes_it_another():
    body = samples.cylinder(sectors=12)
    both = np.concatenate([body, body * (1, 1, -1)])
    assert TriangleSet(both, 2.0).invariant(MIRROR)
    both[3, 1, 2] += 1e-6
    assert not TriangleSet(both, 2.0).invariant(MIRROR)


def test_triangle_that_is_there_twice_counts_twice():
    body = samples.cylinder(sectors=12)
    both = np.concatenate([body, body * (1, 1, -1), body[:1]])
    assert not TriangleSet(both, 2.0).invariant(MIRROR)
