"""Bodies that are each on their own, for tests of maximal coordinates: random states, states that move, robots."""

from __future__ import annotations

import numpy as np

from helpers.oracles import random_state
from helpers.small_robots import body_numbers, built, chain, joint, link
from robodyn.equations.dae.dae import dae_at
from robodyn.scene.scene import DEFAULT, Loop, Scene


def taken_apart(model, seed=0, scene=DEFAULT):
    """The DAE form at a random state with random torques."""
    (q,), (qd,), (tau,) = random_state(model, np.random.default_rng(seed), 1)
    return dae_at(model, scene, q, qd, tau)


def four_bar(kind="hinge", **more):
    """Three links of length 1 in a plane whose end is held 1.2 m from the first joint, and a state next to closing."""
    loop = Loop("closure", "l3", (1.0, 0.0, 0.0), "ground", (1.2, 0.1, 0.0), kind, **more)
    return chain(3), Scene(loops=(loop,), gravity=(0.0, -9.81, 0.0))


def thrown():
    """A body that floats, from a turned place on a link that a hinge carries, and carries another link itself."""
    rng = np.random.default_rng(9)
    parts = [link(f"l{i}", *body_numbers(rng)) for i in range(4)]
    placed = [{"xyz": rng.uniform(-0.6, 0.6, 3), "rpy": rng.uniform(-3, 3, 3)} for _ in range(3)]
    return built(
        *parts,
        joint("hinge", "l0", "l1", axis=(0.6, 0, 0.8), **placed[0]),
        joint("free", "l1", "l2", "floating", **placed[1]),
        joint("slide", "l2", "l3", "prismatic", (0.48, 0.6, -0.64), **placed[2]),
    )


HINGE = {"axis": (0.0, 0.0, 1.0), "to_axis": (0.0, 0.0, 1.0)}
NEAR = ([1.5, -1.4, -1.3], [1.0, 0.0, 0.0], [0.1, 0.2, 0.3])
"""q, qd and tau of a four-bar that nearly closes."""
