"""Drive torques of closed chains by virtual work, in the few coordinates that describe them, with no loop forces.

The kinetic energy is a sum of `c(u) |f'(u)|^2 / 2`, so that Lagrange's equation has no derivative of a velocity:
    Q_j = sum (c' f' + c f'') . df/du_j - dc/du_j |f'|^2 / 2 + dV/du_j,
and what motors at th(u) must give is `tau = (dth/du)^-T Q`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from helpers.jets import Jet, jet


class Moving(NamedTuple):
    """What has the kinetic energy `c |f'|^2 / 2`: a mass and its place, or a moment of inertia and its angle."""

    c: Jet | float
    f: tuple[Jet, ...]


class Place(NamedTuple):
    """A mechanism where its coordinates say.

    Attributes:
        joints: all coordinates of the tree, by joint.
        motors: names of those that are driven, as many as there are coordinates.
        moving: all that has kinetic energy.
        potential: V [J].
    """

    joints: dict[str, Jet]
    motors: tuple[str, ...]
    moving: list[Moving]
    potential: Jet


Mechanism = Callable[[Sequence[Jet]], Place]


def torques(
    mechanism: Mechanism, u: Sequence[Jet], taken: Mapping[str, np.ndarray] | None = None
) -> dict[str, np.ndarray]:
    """Return (samples,) of each motor along a motion: jets of arrays.

    Args:
        taken: by joint (samples,) what friction, springs and rotors take there; it works at dq/du.
    """
    Q, seeds = _forces(mechanism, u)
    for name, tau in (taken or {}).items():
        Q += np.array([tau * seed.joints[name].v for seed in seeds])
    motors = seeds[0].motors
    tau = np.linalg.solve(_slopes(seeds, motors, Q), Q.T[..., None])[..., 0]
    return dict(zip(motors, tau.T, strict=True))


def shared(mechanism: Mechanism, u: Sequence[Jet], weights: Mapping[str, float]) -> dict[str, np.ndarray]:
    """Return (samples,) of the joints of `weights`, all of which drive, with the least sum of weight tau^2.

    With W = dq/du and D the weights, `W' tau = Q` is met by `tau = D^-1 W (W' D^-1 W)^-1 Q`.
    """
    Q, seeds = _forces(mechanism, u)
    slopes = _slopes(seeds, tuple(weights), Q)
    eased = slopes / np.array(list(weights.values()))
    multipliers = np.linalg.solve(np.einsum("nji,nki->njk", eased, slopes), Q.T[..., None])[..., 0]
    return dict(zip(weights, np.einsum("nji,nj->in", eased, multipliers), strict=True))


def _forces(mechanism: Mechanism, u: Sequence[Jet]) -> tuple[np.ndarray, list[Place]]:
    """Return Q (coordinates, samples), and the mechanism with each coordinate's rate 1 in turn."""
    here = mechanism(u)
    seeds = [mechanism([Jet(x.x, float(k == j), 0.0) for k, x in enumerate(u)]) for j in range(len(u))]
    return np.array([_force(here, seed) for seed in seeds]), seeds


def _slopes(seeds: list[Place], joints: tuple[str, ...], Q: np.ndarray) -> np.ndarray:
    """Return (samples, coordinates, joints) dq/du."""
    slopes = [[seed.joints[name].v + 0 * Q[0] for name in joints] for seed in seeds]
    return np.array(slopes).transpose(2, 0, 1)


def _force(here: Place, seed: Place) -> np.ndarray:
    """Q_j; rates in `seed` are derivatives by u_j."""
    total = seed.potential.v
    for now, change in zip(here.moving, seed.moving, strict=True):
        c, dc = jet(now.c), jet(change.c).v
        for f, df in zip(now.f, change.f, strict=True):
            total = total + (c.v * f.v + c.x * f.a) * df.v - 0.5 * dc * f.v * f.v
    return np.asarray(total)
