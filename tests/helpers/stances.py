"""Random stances of points on feet and polygons."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robodyn.dynamics.contacts.solve import Problem

LENGTH = 0.3


def base_columns(arms, length):
    """The columns of G (N, 6, 3 K) in the equations of moments, in units of `length`, and forces about a point.

    Args:
        arms: (N, K, 3) m, from that point to the points of contact, in the axes of forces.
    """
    N, K, _ = arms.shape
    moments = np.stack([np.cross(arms / length, axis) for axis in np.eye(3)], -1)
    forces = np.broadcast_to(np.eye(3), (N, K, 3, 3))
    return np.concatenate((moments, forces), axis=2).transpose(0, 2, 1, 3).reshape(N, 6, 3 * K)


def stance(seed, samples, points, push=1.0, mass=30.0, friction=0.6):
    """Points below a body that is pushed and turned by parts of its weight, on slopes of some 10 degrees."""
    random = np.random.default_rng(seed)
    arms = random.normal(size=(samples, points, 3)) * (0.3, 0.2, 0.05) - (0.0, 0.0, 0.5)
    normals = np.array((0.0, 0.0, 1.0)) + 0.2 * random.normal(size=(points, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    b = np.zeros((samples, 6))
    b[:, 5] = 1.0
    b += push * random.normal(size=(samples, 6)) * (0.1, 0.1, 0.1, 0.2, 0.2, 0.2)
    active = random.random((samples, points)) < 0.9
    return Problem(base_columns(arms, LENGTH), 9.81 * mass * b, normals, np.full(points, friction), active)


def feet(seed, samples, count, push=0.3, mass=80.0, friction=0.7):
    """Flat feet of four points under a body, on one floor."""
    random = np.random.default_rng(seed)
    corners = np.array([(x, y, 0.0) for x in (-0.1, 0.12) for y in (-0.05, 0.05)])
    places = np.stack((random.normal(size=(samples, count)) * 0.05, np.tile(np.arange(count) * 0.2, (samples, 1))), -1)
    arms = np.zeros((samples, count, 4, 3))
    arms[..., :2] = places[:, :, None] + corners[:, :2]
    arms -= (0.0, 0.1 * (count - 1), 0.9)
    b = np.array((0.0, 0.0, 0.0, 0.0, 0.0, 1.0)) + push * random.normal(size=(samples, 6)) * 0.1
    K = 4 * count
    G = base_columns(arms.reshape(samples, K, 3), LENGTH)
    return Problem(G, 9.81 * mass * b, np.tile((0.0, 0.0, 1.0), (K, 1)), np.full(K, friction))


def on_ice(problem):
    return replace(problem, friction=np.where(np.arange(problem.shape[2]) == 0, 0.0, problem.friction))


def near_the_edge(problem, seed=0):
    """The same, pushed by what forces on the edges of the cones and some inside them balance."""
    random = np.random.default_rng(seed)
    N, _, K = problem.shape
    angle, share = random.uniform(0.0, 2.0 * np.pi, (N, K)), random.choice((1.0, 1.0, 1.0, 1.0 - 1e-6, 0.5), (N, K))
    axes = np.stack([np.linalg.svd(normal[None])[2][1:] for normal in problem.normals])
    along = np.cos(angle)[..., None] * axes[:, 0] + np.sin(angle)[..., None] * axes[:, 1]
    press = random.uniform(0.1, 1.0, (N, K, 1)) * (1.0 if problem.active is None else problem.active[..., None])
    f = 100.0 * press * (problem.normals + share[..., None] * problem.friction[:, None] * along)
    return replace(problem, b=np.einsum("nij,nj->ni", problem.G, f.reshape(N, 3 * K)))


def all_around(seed, samples, points):
    """Contacts on walls, floors and ceilings, each sample with its own, some on ice and some that cannot slip."""
    random = np.random.default_rng(seed)
    normals = random.normal(size=(samples, points, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    friction = random.choice((0.0, 0.1, 0.5, 1.0, np.inf), (samples, points))
    return replace(stance(seed, samples, points), normals=normals, friction=friction)
