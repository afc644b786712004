"""Where the force of a contact acts, how far that is from the edge of its polygon, and how much friction it takes."""

from __future__ import annotations

import numpy as np

from robodyn.dynamics.contacts.problem import axes_of
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

FLAT = 1e-9
"""Of the largest distance between points: what stands out less from a line lies on it. Of the force that presses: less
along the ground is none."""


def centre_of_pressure(points: Floats, normal: Floats, forces: Floats) -> tuple[Floats, Floats]:
    """Return where the total force of a contact meets the plane of its points, and how far that is from the next edge.

    The plane is across the normal through the mean of the points; the polygon is the convex hull of the points,
    projected along the normal.

    Args:
        points: (N, K, 3) m, in any axes.
        normal: (N, 3) or (3,), of length 1.
        forces: (N, K, 3) N, at the points.

    Returns:
        (N, 3) m; and (N,) m, of the nearest of the lines through the polygon's edges, negative beyond one. They are not
        numbers where the contact does not press, nor is the distance where there are fewer than three points.

    Accuracy: 1e-13 of the size of the polygon where forces press alike.
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

    Where nothing presses it is not a number.

    Args:
        forces: (..., K, 3) N, at the points.
        normal: (3,), of length 1.
        friction: mu; where it is 0, the result is 0 or infinite.

    Accuracy: 1e-15 relative where no point pulls.
    """
    press = einsum("...i,i->...", forces, normal)
    across = forces - press[..., None] * normal
    along = np.sqrt(einsum("...i,...i->...", across, across)).sum(axis=-1)
    press = press.sum(axis=-1)
    with np.errstate(all="ignore"):
        return np.where(press > 0.0, np.where(along > FLAT * press, along / (friction * press), 0.0), np.nan)
