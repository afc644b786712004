"""Closed configurations of a chain with given coordinates, wherever they are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robodyn.dynamics.loops.branch import Branch
from robodyn.dynamics.loops.closed_chain import ClosedChain
from robodyn.programs.vectors import product, rotation_from_rpy
from robodyn.robot.limits import coordinate_ranges
from robodyn.support.floats import Floats

STARTS = 32
"""From which Newton's method looks for closed configurations, drawn at random but for the first."""
TRIES = 40
APART = 1e-4
"""rad, or of the loops' size: configurations that are farther apart are two."""
SLACK = 1e-6
"""rad or m, that a joint may be beyond its limits."""


class Start(NamedTuple):
    """Closed configurations for one row.

    Attributes:
        places: (k, nq), the first is the one that is taken; none if the loops do not close.
        missed: the least that they miss by, in words.
    """

    places: Floats
    missed: str


def search(branch: Branch, q: Floats, near: Floats, tolerance: float) -> Start:
    """Return closed configurations with given coordinates, those within the limits and nearest first.

    Args:
        q: (nq,), of which only given coordinates count. near: (nq,) from where those that follow are sought.
        tolerance: rad, or of the loops' size.
    """
    equations = branch.equations
    guesses = np.repeat(q[None], STARTS, axis=0)
    around = equations.moved(np.repeat(near[None], STARTS, axis=0), _drawn(branch))
    guesses[:, branch.coordinates] = around[:, branch.coordinates]
    found = branch.corrected(guesses, TRIES)
    phi = np.abs(equations.places(found.q)[0]) / equations.scale
    left = phi.max(axis=1, initial=0.0)
    best = int(np.argmin(left))
    worst = int(np.argmax(phi[best]))
    missed = f"{phi[best, worst] * equations.scale[worst]:.3g} {equations.units[worst]}"
    places = _unwound(branch, found.q[found.closed & (left <= tolerance)], near)
    if any(closure.loop.kind == "weld" for closure in equations.chain.closures):
        places = places[[_unturned(equations.chain, place) for place in places]]
    return Start(_distinct(branch, places, near), f'loop "{equations.names[worst]}" misses by {missed}')


def _unturned(chain: ClosedChain, q: Floats) -> bool:
    """Return whether no weld is half a turn from where it should be, where its equations hold too."""
    turns = [
        float(np.trace(product(place.B, rotation_from_rpy(*closure.loop.rpy).T)))
        for closure, place in zip(chain.closures, chain.equations(chain.sample(q.tolist())).places, strict=True)
        if closure.loop.kind == "weld"
    ]
    return all(turn > 1.0 for turn in turns)


def _drawn(branch: Branch) -> Floats:
    """Return (STARTS, n) displacements, the first of nothing: up to half a turn, or twice the loops' size."""
    equations = branch.equations
    reach = np.array([np.pi if unit == "rad" else 2.0 * equations.size for unit in equations.rate_units])
    moves: Floats = np.random.default_rng(0).uniform(-1.0, 1.0, (STARTS, equations.model.n)) * reach
    moves[0] = 0.0
    return moves


def _unwound(branch: Branch, places: Floats, near: Floats) -> Floats:
    """Return the places with angles that follow less than half a turn away from those near."""
    for joint in branch.equations.model.independent:
        k = joint.coordinate
        if joint.kind == "revolute" and k in branch.coordinates:
            places[:, k] -= 2.0 * np.pi * np.rint((places[:, k] - near[k]) / (2.0 * np.pi))
    return places


def _distinct(branch: Branch, places: Floats, near: Floats) -> Floats:
    """Return places that are apart, those within the limits and nearest first; equally near ones as they were found."""
    own = branch.coordinates
    least, largest = coordinate_ranges(branch.equations.model)
    beyond = np.maximum(least[own] - places[:, own], places[:, own] - largest[own]).max(axis=1, initial=0.0) > SLACK
    away = np.abs(places[:, own] - near[own]).max(axis=1, initial=0.0)
    kept: list[int] = []
    for k in np.lexsort((np.arange(len(places)), np.round(away, 6), beyond)).tolist():
        if all(np.abs(places[k, own] - places[other, own]).max(initial=0.0) > APART for other in kept):
            kept.append(k)
    found: Floats = places[kept]
    return found
