"""How deep the convex hulls of shapes reach into each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robodyn.checks.meshes.extremes import spread_out
from robodyn.programs.vectors import length, product
from robodyn.robot.kinematics import Pose
from robodyn.solids.inertia.validity import Box
from robodyn.support.floats import Floats

_ALL_ROUND = spread_out(120)
_NARROW = (0.3, 0.15, 0.08, 0.04, 0.02, 0.01)
"""Radians by which directions are varied around the best one, time after time."""


@dataclass(frozen=True, eq=False)
class Hull:
    """The convex hull of a shape at a pose in the root's frame.

    Attributes:
        kind: box, cylinder, sphere, capsule or mesh.
        half: (3,) half the sides of the box around it in its own axes [m]; of a mesh, not used.
        points: (k, 3) of a mesh, in its own axes.
        box: around it, along the root's axes.
    """

    kind: str
    half: Floats
    points: Floats | None
    pose: Pose
    box: Box

    def reach(self, directions: Floats) -> Floats:
        """Return (n,) how far it reaches in unit directions (n, 3) of the root's frame [m].

        max over its points of d . x: a box |d| . half; a cylinder r sqrt(dx^2 + dy^2) + |dz| l / 2; a ball r; a capsule
        r + |dz| l / 2, l being the length of its cylinder.
        """
        own: Floats = product(directions, self.pose.R)
        there: Floats = product(directions, self.pose.p)
        return there + self._own_reach(own)

    def _own_reach(self, own: Floats) -> Floats:
        """Return (n,) how far it reaches from its origin in directions (n, 3) of its own axes [m]."""
        radius, up = float(self.half[0]), np.abs(own[:, 2])
        found: Floats
        if self.points is not None:
            found = product(own, self.points.T).max(axis=1)
        elif self.kind == "box":
            found = product(np.abs(own), self.half)
        elif self.kind == "cylinder":
            found = radius * np.hypot(own[:, 0], own[:, 1]) + up * self.half[2]
        else:
            found = radius + up * (self.half[2] - radius)
        return found


def depth(first: Hull, second: Hull, bound: float) -> float:
    """Return the least distance by which the one has to move for the two to be apart [m]; 0 where it is within a bound.

    Method: min over directions d of h1(d) + h2(-d), h being the reach; over the axes of both and the line between them,
    over 120 directions all round, and then ever nearer to the best.

    Accuracy: above the true depth of the hulls, by less than a percent of the bodies' size.
    """
    axes = np.concatenate((first.pose.R.T, second.pose.R.T))
    between = second.pose.p - first.pose.p
    line = between[None] / (length(between) or 1.0)
    least, best = _least(first, second, np.concatenate((axes, -axes, line)) if between.any() else axes)
    for angle in (None, *_NARROW):
        if least <= bound:
            return 0.0
        tried = _ALL_ROUND if angle is None else best + angle * _ALL_ROUND[::5]
        found, direction = _least(first, second, tried / np.sqrt((tried * tried).sum(axis=1))[:, None])
        if found < least:
            least, best = found, direction
    return least if least > bound else 0.0


def _least(first: Hull, second: Hull, directions: Floats) -> tuple[float, Floats]:
    shared = first.reach(directions) + second.reach(-directions)
    k = int(shared.argmin())
    return float(shared[k]), directions[k]
