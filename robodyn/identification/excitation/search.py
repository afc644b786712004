"""The search for a telling motion: a barrier method with quasi-Newton steps, from several places."""

from __future__ import annotations

import numpy as np

from robodyn.errors import InputError
from robodyn.identification.excitation.landscape import Landscape
from robodyn.support.floats import Floats, ranked
from robodyn.support.sums import einsum

_EARLY, _LATE = (10.0, 1.0), (0.1, 0.03)
"""Pressures of the barrier, stage by stage: those that all starts go through, and those of the best of them."""
_STEPS = 60
"""Of a stage at most."""
_SETTLED = 1e-4
"""Per base parameter: what ten steps must gain to go on."""
_REMEMBERED = 30
"""Steps from which the search knows how the slope bends."""
GRID = 2.0**16
"""After each step positions are rounded to its reciprocal, so that processors whose last digits differ go on alike."""
_POSTURES = 200
"""That are tried for some which effort limits allow."""


def search(landscape: Landscape, starts: int, seed: int) -> Floats:
    """Return the best position that is found from so many places.

    Raises:
        InputError: no posture that is tried can be held.
    """
    ends = [_staged(landscape, start, _EARLY) for start in _starts(landscape, starts, seed)]
    return _staged(landscape, ranked(ends, lambda end: -landscape.height(end, 0.0)[0])[0], _LATE)


def _staged(landscape: Landscape, y: Floats, pressures: tuple[float, ...]) -> Floats:
    for pressure in pressures:
        y = _lowest(landscape, y, pressure)
    return y


def _starts(landscape: Landscape, count: int, seed: int) -> list[Floats]:
    """Return motions well within the bounds, about postures that effort limits allow."""
    rng = np.random.default_rng(seed)
    bounds, k = landscape.bounds, list(landscape.bounds.moving)
    made: list[Floats] = []
    for tried in range(_POSTURES):
        centre = bounds.middle[k] + bounds.half[k] * rng.uniform(-0.5, 0.5, len(k)) * (tried > 0)
        swings = rng.normal(size=(len(k), landscape.size))
        for halvings in range(12):
            y = on_grid(landscape.position(centre, 0.5**halvings * swings))
            if landscape.most(y) < 0.95 and np.isfinite(landscape.height(y, 0.0)[0]):
                made.append(y)
                break
        if len(made) == count:
            break
    if not made:
        what = f"none of {_POSTURES} postures can be held and moved about within the effort limits"
        raise InputError(what, remedy="check limits and masses, or move fewer joints: --joints")
    return made


def on_grid(y: Floats) -> Floats:
    """Return numbers rounded so that their last digits are gone."""
    return np.asarray(np.round(y * GRID) / GRID)


def _lowest(landscape: Landscape, y: Floats, pressure: float) -> Floats:
    """Return where the landscape is low, near where the search starts.

    Method: quasi-Newton steps from the last slopes (Nocedal and Wright 2006, algorithm 7.4) on top of the bounds' own
    second derivative, no farther than 0.99 of the way to a bound, and halved until they gain.
    """
    value, slope = landscape.height(y, pressure)
    past: list[tuple[Floats, Floats]] = []
    values = [value]
    while len(values) <= _STEPS:
        step = -_bent(landscape.stiffness(y, pressure), past[-_REMEMBERED:], slope)
        size, steepness = min(1.0, 0.99 * landscape.reach(y, step)), float((slope * step).sum())
        for _ in range(30):
            place = on_grid(y + size * step)
            there = landscape.height(place, pressure)
            if there[0] <= value + 1e-4 * size * steepness:
                break
            size *= 0.5
        else:
            break
        s, change = place - y, there[1] - slope
        if (s * change).sum() > 0.0:
            past.append((s, change))
        y, (value, slope) = place, there
        values.append(value)
        if len(values) > 10 and values[-11] - value < _SETTLED * landscape.programs.r:
            break
    return y


def _bent(stiffness: Floats, past: list[tuple[Floats, Floats]], slope: Floats) -> Floats:
    """Return the inverse second derivative times the slope."""
    v, factors = slope.copy(), []
    for s, change in reversed(past):
        factors.append((v * s).sum() / (s * change).sum())
        v -= factors[-1] * change
    softness = 1.0
    if past:
        s, change = past[-1]
        own = change - einsum("nab,nb->na", stiffness, s)
        softness = max(1e-3, float((s * own).sum() / (s * s).sum()))
    softness += 1e-12 * einsum("naa->n", stiffness).max()
    v = np.linalg.solve(stiffness + softness * np.eye(stiffness.shape[1]), v[..., None])[..., 0]
    for (s, change), factor in zip(past, reversed(factors), strict=True):
        v += (factor - (change * v).sum() / (s * change).sum()) * s
    return v
