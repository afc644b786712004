"""Consistent initial values: how far places and speeds are from fulfilling the constraints, and the nearest that do."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robodyn.equations.dae.equations import stacked, values
from robodyn.equations.dae.state import STILL, Place, Speed, State
from robodyn.equations.dae.system import System
from robodyn.errors import InputError
from robodyn.programs.linear import min_norm_solution
from robodyn.programs.vectors import narrowed, product, rotation_about
from robodyn.support.floats import Floats

STEPS = 40
FULFILLED = 1e-13
"""Of the robot's size or of one radian: a projection that comes to rest above this has not met the constraints."""


class Residuals(NamedTuple):
    """What the constraints are off by.

    Attributes:
        places: (m,) g(x) [m, rad].
        speeds: (m,) G v [m/s, rad/s].
    """

    places: Floats
    speeds: Floats


def residuals(system: System, at: State) -> Residuals:
    """g(x) and G v."""
    return Residuals(values(system.equations, at), product(stacked(system.equations, at), flat_speeds(at)))


def flat_speeds(at: State) -> Floats:
    """(w, v) of all bodies, 6 N numbers."""
    return narrowed(np.concatenate([part for speed in at.speeds[:-1] for part in speed]))


def projected(system: System, at: State, length: float) -> State:
    """Return the state near `at` whose places and speeds fulfil the constraints.

    Places by Newton's method, each step the smallest that makes g + G dx = 0, angles being counted as arcs of
    `length`: R turns by exp[dw], c moves by dc. Then speeds, by the smallest change that makes G v = 0.

    Args:
        length: of the robot [m].

    Raises:
        InputError: Newton's method comes to rest where the constraints are not fulfilled.

    Accuracy: g within 1e-14 of the robot's extent, G v within 1e-14 of the largest speed.
    """
    arcs = arcs_of(len(system.inertias), length)
    best, error = at, np.inf
    for _ in range(STEPS):
        off = values(system.equations, at)
        found = float(np.abs(off).max(initial=0.0))
        if found < error:
            best, error, since = at, found, 0
        else:
            since += 1
        if found == 0.0 or since == 3:
            break
        at = _moved(at, arcs * _smallest(stacked(system.equations, at) * arcs, -off))
    extent = max(length, *(float(np.abs(place.c).max()) for place in best.places))
    if error > FULFILLED * max(extent, 1.0):
        raise InputError(
            f"no places of the bodies near these fulfil the constraints: they stay {error:.2g} apart",
            remedy="begin nearer, or look for a loop that cannot close",
        )
    return _slowed(system, best, arcs)


def _slowed(system: System, at: State, arcs: Floats) -> State:
    G, v = stacked(system.equations, at), flat_speeds(at)
    for _ in range(2):
        v = v + arcs * _smallest(G * arcs, product(-G, v))
    speeds = tuple(Speed(part[:3], part[3:]) for part in v.reshape(-1, 6))
    return State(at.places, (*speeds, STILL))


def arcs_of(bodies: int, length: float) -> Floats:
    """Return what turns arcs of `length` into angles, and leaves distances."""
    return np.tile(np.repeat((1.0 / length, 1.0), 3), bodies)


def _smallest(A: Floats, b: Floats) -> Floats:
    """Return the smallest x with A x = b, or with the smallest error where the equations depend on each other."""
    return min_norm_solution(A, b, 1e-10)


def _moved(at: State, step: Floats) -> State:
    places = []
    for place, (dw, dc) in zip(at.places[:-1], step.reshape(-1, 2, 3), strict=True):
        angle = float(np.sqrt(product(dw, dw)))
        turn = rotation_about(dw / angle, angle) if angle else np.eye(3)
        places.append(Place(_orthonormal(product(place.R, turn)), place.c + dc))
    return State((*places, at.places[-1]), at.speeds)


def _orthonormal(R: Floats) -> Floats:
    """Return the rotation next to a matrix that is one but for rounding: R (3 - R^T R) / 2."""
    turned: Floats = product(R, 1.5 * np.eye(3) - 0.5 * product(R.T, R))
    return turned
