"""Many poses of a robot, each changed joint by joint towards the most that gravity asks of one of its joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from robodyn.programs.vectors import arctan2, product, skew
from robodyn.robot.model import Body, Model
from robodyn.support.floats import Floats


@dataclass(frozen=True, eq=False)
class _Hinge:
    """The constant matrices of E(q) x = R Rot(a, q) x = (along + cos q across + sin q turned) x."""

    forward: Floats
    back: Floats
    along: Floats
    turned: Floats

    @classmethod
    def of(cls, body: Body) -> _Hinge:
        R, axis = body.joint.R, body.joint.axis
        along, turned = np.outer(axis, axis), skew(axis)
        if body.joint.kind != "revolute":
            along, turned = np.eye(3), np.zeros((3, 3))
        across = np.eye(3) - along
        return cls(
            np.vstack((product(R, along), product(R, across), product(R, turned))),
            np.vstack((along, across, -turned)),
            along,
            turned,
        )


_NOTHING = 1e-12
"""First moments that are no more than this, by the robot's mass, are rounding [m]."""


class Sweep:
    """Poses in rows: for each target those that start at `starts`, once to raise its torque and once to lower it.

    The torque of gravity about the joint of body t, divided by g, is y . Rot(a_j, q_j) x in the angle of each joint j
    that matters, plus a constant, with x in the axes of body j and y in those of the joint. At t and above, x is
    v = a_t x sum m (c - p_t) and y points up (u). Below t, x is the first moment h = sum m (c - p_j) of what joint j
    carries and y is w = u x a_t. A row's v is zero beside and below its target, its w beside and above.

    Args:
        targets: bodies.
        starts: (s, n) positions of the coordinates.
        low, high: (n,) what they may be.
        free: (n,) whether a coordinate may be changed.
    """

    def __init__(
        self, model: Model, targets: Sequence[int], starts: Floats, low: Floats, high: Floats, free: Floats
    ) -> None:
        self._bodies, self._low, self._high, self._free = model.bodies, low, high, free
        self._hinges = [_Hinge.of(body) for body in model.bodies]
        self._carried = np.array([body.inertia.m for body in model.bodies])
        for i in reversed(range(1, len(model.bodies))):
            self._carried[model.parents[i]] += self._carried[i]
        self._relevant = around(model.parents, frozenset(targets))
        self._each = 2 * len(starts)
        self._rows = {t: slice(k * self._each, (k + 1) * self._each) for k, t in enumerate(targets)}
        self.q = np.tile(starts.T, (1, 2 * len(targets)))
        self._sign = np.tile(np.repeat((1.0, -1.0), len(starts)), len(targets))
        self._up: dict[int, Floats] = {}
        self._scale = float(self._carried[0]) or 1.0

    def poses(self) -> Floats:
        """Return (targets, rows, n) the poses."""
        found: Floats = self.q.T.reshape(len(self._rows), self._each, -1)
        return found

    def torques(self) -> Floats:
        """Return (targets, rows) torque / g."""
        return self._torques(self._inward()).reshape(len(self._rows), self._each)

    def improve(self) -> Floats:
        """Make one sweep from the base to the tips: the best position of each joint in turn, the others as they are.

        Returns:
            (rows of all targets,) torque / g before the sweep, times the sign that the row is to have; 0 before the
            first.
        """
        x = self._inward()
        before = self._sign * self._torques(x)
        self._outward(x)
        return before

    def _torques(self, x: Mapping[int, Floats]) -> Floats:
        torques = np.zeros(self.q.shape[1])
        for t, rows in self._rows.items():
            if t in self._up:
                torques[rows] = (self._up[t] * x[t][:, 1, rows]).sum(axis=0)
        return torques

    def _positions(self, i: int) -> Floats:
        joint = self._bodies[i].joint
        if joint.kind == "fixed":
            return np.zeros(self.q.shape[1])
        position: Floats = joint.multiplier * self.q[joint.coordinate] + joint.offset
        return position

    def _inward(self) -> dict[int, Floats]:
        """Return (3, 2, rows) h and v of the bodies that matter."""
        x = {i: np.zeros((3, 2, self.q.shape[1])) for i in self._relevant}
        for i in reversed(self._relevant):
            body, own = self._bodies[i], x[i]
            own[:, 0] += body.inertia.mc[:, None]
            if i in self._rows:
                rows, axis = self._rows[i], body.joint.axis
                sliding = body.joint.kind == "prismatic"
                own[:, 1, rows] = self._carried[i] * axis[:, None] if sliding else product(skew(axis), own[:, 0, rows])
            if body.parent < 0:
                continue
            above, q = x[body.parent], self._positions(i)
            above += _turned(self._hinges[i].forward, own, q)
            above[:, 0] += self._carried[i] * body.joint.p[:, None]
            if body.joint.kind == "prismatic":
                above[:, 0] += self._carried[i] * np.outer(product(body.joint.R, body.joint.axis), q)
        return x

    def _outward(self, x: Mapping[int, Floats]) -> None:
        """Change q, from the base to the tips, and keep where up is for each target."""
        ground = np.zeros((3, 2, self.q.shape[1]))
        ground[2, 0] = 1.0
        y = {0: ground}
        for i in self._relevant[1:]:
            body = self._bodies[i]
            here = product(body.joint.R.T, y[body.parent].reshape(3, -1)).reshape(ground.shape)
            if self._free[body.joint.coordinate] and body.joint.mimics is None:
                self._best(i, x[i], here)
            own = _turned(self._hinges[i].back, here, self._positions(i))
            if i in self._rows:
                rows = self._rows[i]
                self._up[i] = own[:, 0, rows]
                if body.joint.kind == "revolute":
                    own[:, 1, rows] = product(-skew(body.joint.axis), own[:, 0, rows])
            y[i] = own

    def _best(self, i: int, x: Floats, y: Floats) -> None:
        """Give the joint of body i its best position in every row in which it matters."""
        joint, hinge = self._bodies[i].joint, self._hinges[i]
        low, high = self._low[joint.coordinate], self._high[joint.coordinate]
        q = self.q[joint.coordinate]
        if joint.kind == "prismatic":
            gain = self._sign * product(joint.axis, y[:, 1])
            q[:] = np.where(gain > 0.0, high, np.where(gain < 0.0, low, q))
            return
        turned = product(hinge.turned, x.reshape(3, -1)).reshape(x.shape)
        along = product(hinge.along, x.reshape(3, -1)).reshape(x.shape)
        # y has up with h and w with v the other way about: v goes with up, h with w
        cosine = self._sign * (y * (x - along)[:, ::-1]).sum(axis=(0, 1))
        sine = self._sign * (y * turned[:, ::-1]).sum(axis=(0, 1))
        best = low + (arctan2(sine, cosine) - low) % (2.0 * np.pi)
        at_low = cosine * np.cos(low) + sine * np.sin(low)
        at_high = cosine * np.cos(high) + sine * np.sin(high)
        best = np.where(best <= high, best, np.where(at_low > at_high, low, high))
        matters = np.hypot(cosine, sine) > _NOTHING * self._scale
        q[:] = np.where(matters, best, q)


def around(parents: Sequence[int], targets: frozenset[int]) -> list[int]:
    """Return the bodies above and below the targets, the targets and the base, parents first."""
    below, above = set(targets), {0}
    for i, parent in enumerate(parents):
        if parent in below:
            below.add(i)
    for i in reversed(range(len(parents))):
        if i in targets or i in above:
            above.add(i)
            above.add(max(parents[i], 0))
    return sorted(above | below)


def _turned(parts: Floats, x: Floats, q: Floats) -> Floats:
    """Return (along + cos q across + sin q turned) x."""
    along, across, turned = product(parts, x.reshape(3, -1)).reshape(3, *x.shape)
    result: Floats = along + np.cos(q) * across + np.sin(q) * turned
    return result
