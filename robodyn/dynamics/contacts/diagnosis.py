"""Why no contact forces make a motion: what is missing, whether feet slip, pull or tip, and what friction would do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robodyn.dynamics.contacts.solve import Flags, Forces, Problem, axes_of, contact_forces
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

FORCES = slice(3, 6)
"""Rows of the equations, of which the first six are moments and forces on the base."""
STRONGEST = 100.0
"""Times |b|: what needs larger forces, as feet that are all but wedged do, counts as impossible."""
MANY = 100_000
"""Samples that a search is worth, by which its executor is chosen: it looks at few of them often."""
WORST, SECTIONS = 8, 15
"""Samples whose least friction is sought at a time, and how many coefficients are tried between two bounds."""


def kinds(problem: Problem, forces: Forces, executor: str = "auto") -> list[str]:
    """Return why each sample has no forces: "" (it has), "slip", "pull" or "tip".

    slip: unlimited friction would suffice. pull: even without the equations of moments, unlimited friction would not,
    so that contacts had to pull. tip: all else. The problem's first six equations are moments and forces on the base.
    """
    found = np.full(len(forces.feasible), "", dtype=object)
    lost = np.flatnonzero(~forces.feasible)
    if len(lost):
        unlimited = _with_friction(problem.chosen(lost), np.inf)
        slip = contact_forces(unlimited, executor).feasible
        found[lost] = np.where(slip, "slip", "tip")
        if not slip.all():
            rest = unlimited.chosen(~slip)
            alone = replace(rest, G=rest.G[:, FORCES], b=rest.b[:, FORCES], free=None)
            found[lost[~slip][~contact_forces(alone, executor).feasible]] = "pull"
    return [str(kind) for kind in found]


def least_friction(problem: Problem, known: float = 0.0, executor: str = "auto") -> float | None:
    """Return the least mu of all contacts alike, not below `known`, with which every sample has forces.

    Forces of more than 100 |b| do not count: where contacts wedge between each other, less friction would do, with
    forces beyond all bounds. What torques cost and their limits do not count either.

    Method: those samples that miss most where friction is not enough are solved for their own least mu, with many mu at
    a time; then those that still miss something, until none does. None where no friction suffices.

    Accuracy: 1e-6 relative; 1e-5 where forces become singular at the least mu.
    """
    mu, left = known, np.arange(len(problem.b))
    while True:
        part = problem.chosen(left)
        found = contact_forces(_with_friction(part, mu), executor, MANY)
        lost = ~_moderate(part, found)
        left = left[lost]
        if not len(left):
            return mu
        lacking = found.residual[lost]
        worst = np.argsort(-einsum("ni,ni->n", lacking, lacking), kind="stable")[:WORST]
        least = _least_of(problem.chosen(left[worst]), mu, executor)
        if least is None:
            return None
        mu = least


def _least_of(problem: Problem, low: float, executor: str) -> float | None:
    """The least mu, 1e-6 relative, with which all of a few samples have forces; `low` is not enough."""
    ladder: Floats = max(0.25, 2.0 * low) * 4.0 ** np.arange(SECTIONS, dtype=float)
    held = _suffices(problem, ladder, executor)
    if not held.any():
        return None
    first = int(held.argmax())
    low, high = max(low, float(ladder[first - 1]) if first else low), float(ladder[first])
    while high - low > 1e-6 * high:
        between = np.linspace(low, high, SECTIONS + 2)
        held = np.append(_suffices(problem, between[1:-1], executor), True)
        first = int(held.argmax())
        low, high = float(between[first]), float(between[first + 1])
    return high


def _suffices(problem: Problem, friction: Floats, executor: str) -> Flags:
    """Return (M,) with which of M mu all samples have forces."""
    M, (N, _, K) = len(friction), problem.shape
    mu = np.repeat(friction, N)[:, None] * np.ones(K)
    every = replace(problem.chosen(np.tile(np.arange(N), M)), friction=mu, torques=None)
    enough = _moderate(every, contact_forces(every, executor, MANY)).reshape(M, N)
    return np.asarray(enough.all(axis=1))


def _moderate(problem: Problem, found: Forces) -> Flags:
    """(N,) which samples have forces, of no more than 100 |b|."""
    strength, b = (np.sqrt(einsum("...i,...i->...", x, x)) for x in (found.f.reshape(len(found.f), -1), problem.b))
    return np.asarray(found.feasible & (strength <= STRONGEST * b))


def _with_friction(problem: Problem, mu: float) -> Problem:
    return replace(problem, friction=np.full(problem.shape[2], mu), torques=None)


FLAT = 1e-9
"""Of the largest distance between points: what stands out less from a line lies on it. Of the force that presses: less
along the ground is none."""


def centre_of_pressure(points: Floats, normal: Floats, forces: Floats) -> tuple[Floats, Floats]:
    """Return where the total force of a contact meets the plane of its points, and how far that is from the next edge.

    The plane is across the normal through the mean of the points; the polygon is the convex hull of the points,
    projected along the normal.

    Args:
        points, forces: (N, K, 3) m and N, in any axes; normal: (N, 3) or (3,), of length 1.

    Returns:
        (N, 3) m; and (N,) m, of the nearest of the lines through the polygon's edges, negative beyond one. They are not
        numbers where the contact does not press, nor is the distance where there are fewer than three points.
    """
    N, K, _ = points.shape
    normal = np.broadcast_to(normal, (N, 3))
    middle = points.mean(axis=1)
    arms, force = points - middle[:, None], forces.sum(axis=1)
    moment = np.cross(arms, forces).sum(axis=1)
    press = einsum("ni,ni->n", force, normal)
    with np.errstate(all="ignore"):
        place = np.cross(normal, moment) / np.where(press > 0.0, press, np.nan)[:, None]
    if K < 3:
        return middle + place, np.full(N, np.nan)
    tangents = axes_of(normal)[:, :, :2]
    corners = einsum("nki,nij->nkj", arms, tangents)
    return middle + place, _margin(corners, einsum("ni,nij->nj", place, tangents))


def _margin(corners: Floats, place: Floats) -> Floats:
    """Return the least distance (N,) of a place (N, 2) from the lines through edges of the hull of corners (N, K, 2).

    An edge is a pair of corners that has all others to its left.
    """
    along = corners[:, None, :, :] - corners[:, :, None, :]
    lengths = np.sqrt((along * along).sum(axis=-1))
    size = lengths.max(axis=(1, 2), keepdims=True)
    with np.errstate(all="ignore"):
        inward = np.stack((-along[..., 1], along[..., 0]), -1) / lengths[..., None]
        left = einsum("nabi,nabki->nabk", inward, corners[:, None, None] - corners[:, :, None, None])
        edge = (left >= -FLAT * size[..., None]).all(axis=-1) & (lengths > FLAT * size)
        distance = einsum("nabi,nabi->nab", inward, place[:, None, None] - corners[:, :, None])
    found: Floats = np.where(edge, distance, np.inf).min(axis=(1, 2))
    return np.where(np.isnan(place[:, 0]), np.nan, found)


def friction_used(forces: Floats, normal: Floats, friction: float) -> Floats:
    """Return sum |f_t| / (mu sum f_n) over the points of a contact: 1 is all that there is, at all of its points.

    Where nothing presses it is not a number; where mu is 0 it is 0 or infinite. forces: (..., K, 3), normal: (3,).
    """
    press = einsum("...i,i->...", forces, normal)
    across = forces - press[..., None] * normal
    along = np.sqrt(einsum("...i,...i->...", across, across)).sum(axis=-1)
    press = press.sum(axis=-1)
    with np.errstate(all="ignore"):
        return np.where(press > 0.0, np.where(along > FLAT * press, along / (friction * press), 0.0), np.nan)
