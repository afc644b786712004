"""Masses and moments that several rules ask for."""

from __future__ import annotations

from collections.abc import Mapping
from math import fsum, sqrt

from robodyn.checks.context import Context
from robodyn.checks.frames import centres_of_mass
from robodyn.checks.rule import Severity
from robodyn.checks.tree import Group
from robodyn.checks.view import LinkView

Tensor = tuple[float, ...]
"""ixx, ixy, ixz, iyy, iyz, izz [kg m^2]."""

POINT = 1e-6
"""Radius of gyration [m] below which a body counts as a point."""


def carried_masses(context: Context) -> Mapping[Group, float]:
    """For each rigid group the mass of all that moves with it, itself included; unreadable masses count as 0."""
    carried: dict[Group, float] = {}
    for group in reversed(context.tree.groups):
        own = fsum(link.mass or 0.0 for link in group.links)
        carried[group] = own + fsum(carried[child] for child in group.children)
    return carried


def principal_moments(tensor: Tensor) -> tuple[float, float, float]:
    """The principal moments of inertia, ascending [kg m^2].

    Accuracy: that of `robodyn.solids.inertia.eigen`.
    """
    import numpy as np

    from robodyn.solids.inertia.eigen import eigen

    xx, xy, xz, yy, yz, zz = tensor
    size = max(map(abs, tensor)) or 1.0
    moments, _ = eigen(np.array(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))) / size)
    large, middle, small = (float(moment) * size for moment in moments)
    return small, middle, large


def severity_of_zero(context: Context, link: LinkView) -> Severity | None:
    """Of a link's zero mass: none in a body that has mass by its other links, or that does not move."""
    tree = context.tree_or_none
    group = None if tree is None else tree.group[link.name]
    if group is None or group.joint is None or group.mass != 0:
        return None
    return Severity.I if context.once(carried_masses)[group] > 0 else Severity.E


def is_a_point(link: LinkView) -> bool:
    """Whether what inertia it has is that of a point: a radius of gyration below a micrometre."""
    if link.tensor is None or link.mass is None:
        return False
    return max(map(abs, link.tensor)) <= POINT * POINT * max(link.mass, 0.0)


def trace(tensor: Tensor) -> float:
    return tensor[0] + tensor[3] + tensor[5]


def gyration(context: Context, group: Group) -> float | None:
    """sqrt(tr(S) / m) [m], S being the second moments of the group about its centre of mass.

    tr(S) is the sum of tr(I) / 2 + m |c - c_group|^2 over the links. None where a number of it cannot be read, or no
    mass is there.
    """
    parts = [_part(context, link) for link in group.links if link.inertial is not None]
    known = [part for part in parts if part is not None]
    mass = fsum(m for m, _, _ in known)
    if len(known) < len(parts) or not mass > 0:
        return None
    centre = [fsum(m * c[k] for m, _, c in known) / mass for k in range(3)]
    spread = fsum(half + m * fsum((c[k] - centre[k]) ** 2 for k in range(3)) for m, half, c in known)
    return sqrt(max(spread, 0.0) / mass)


def _part(context: Context, link: LinkView) -> tuple[float, float, tuple[float, ...]] | None:
    centre = context.once(centres_of_mass).get(link.name)
    if link.mass is None or link.tensor is None or centre is None:
        return None
    return link.mass, trace(link.tensor) / 2, centre


def widest(tensor: Tensor) -> int:
    """Which of the six entries to point at in an inertia that no body has: a diagonal entry that is not positive, or
    the product that is largest beside its moments; where neither stands out, the largest moment."""
    diagonal = {0: tensor[0], 3: tensor[3], 5: tensor[5]}
    least = min(diagonal, key=lambda k: diagonal[k])
    if diagonal[least] <= 0:
        return least
    pairs = {1: (0, 3), 2: (0, 5), 4: (3, 5)}
    excess = {k: tensor[k] ** 2 - tensor[i] * tensor[j] for k, (i, j) in pairs.items()}
    worst = max(excess, key=lambda k: excess[k])
    return worst if excess[worst] > 0 else max(diagonal, key=lambda k: diagonal[k])
