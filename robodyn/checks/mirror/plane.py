"""The plane across which a robot is its own mirror image at q = 0, and where its frames are."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from robodyn.programs.vectors import product
from robodyn.robot.load import placement
from robodyn.robot.urdf.parts import Description, Joint
from robodyn.support.floats import Floats, first_largest

_NEAR = 2e-3
"""How far a frame may be from its mirror image, relative to the robot's size."""


@dataclass(frozen=True, eq=False)
class Plane:
    """The plane n . x = offset in the root's axes."""

    normal: Floats
    offset: float

    @property
    def H(self) -> Floats:
        """The reflection 1 - 2 n n^T."""
        return np.eye(3) - 2.0 * np.outer(self.normal, self.normal)

    def image(self, p: Floats) -> Floats:
        """Return (..., 3) the mirror images of points."""
        moved: Floats = product(p, self.H) + 2.0 * self.offset * self.normal
        return moved


def link_poses(description: Description) -> tuple[Mapping[str, Floats], Mapping[str, Floats]]:
    """Return the rotation and origin of every link in the root's axes at q = 0 [m]."""
    below: dict[str, list[Joint]] = {}
    for joint in description.joints:
        below.setdefault(joint.parent, []).append(joint)
    R, p = {description.root: np.eye(3)}, {description.root: np.zeros(3)}
    waiting = [description.root]
    while waiting:
        link = waiting.pop()
        for joint in below.get(link, ()):
            turn, shift = placement(joint.origin)
            R[joint.child], p[joint.child] = product(R[link], turn), p[link] + product(R[link], shift)
            waiting.append(joint.child)
    return R, p


def near_of(p: Mapping[str, Floats]) -> float:
    """Return how far a frame may be from its mirror image [m]: 2e-3 of the robot's size."""
    places = np.array(list(p.values()))
    return _NEAR * float(np.ptp(places, axis=0).max())


def planes(named: Sequence[tuple[str, str]], p: Mapping[str, Floats]) -> Iterator[tuple[Plane, list[tuple[str, str]]]]:
    """Yield the planes that may be the mirror, each with those of the named pairs that it has at mirrored places.

    They are across x, y or z of the root, or across the longest line between the two of a pair; amid the pairs, or
    through the root.
    """
    left, right = (np.array([p[names[k]] for names in named]).reshape(-1, 3) for k in (0, 1))
    near = near_of(p)
    apart = left - right
    lengths = np.linalg.norm(apart, axis=1)
    if not (lengths > near).any():
        return
    longest = first_largest(lengths)
    for normal in (*np.eye(3), apart[longest] / lengths[longest]):
        for offset in (median(product(left + right, normal).tolist()) / 2.0, 0.0):
            plane = Plane(normal, offset)
            there = (np.linalg.norm(plane.image(left) - right, axis=1) <= near) & (lengths > near)
            if there.any():
                yield plane, [named[k] for k in np.flatnonzero(there).tolist()]
