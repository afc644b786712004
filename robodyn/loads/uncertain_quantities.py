"""The quantities of a motion whose peaks and mean squares are asked for, of loads and of their derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from robodyn.loads.bearings import NAMES, frame
from robodyn.loads.motors import LEAST, Train, allowed, load_torque, motor_torque, points
from robodyn.robot.model import Model
from robodyn.support.floats import Floats
from robodyn.trajectory.columns import COMPONENTS

_PAIRS = (("radial", 0, 1), ("tilting", 3, 4)), (("radial", 0, 1), ("tilting", 2, 3))
"""Of hinges and of slides, the components of a bearing that are one resultant."""

DRIVE = ("tau", "motor", "use", "gear")
"""Figures of a joint: its torque, its motor's, that as a share of the peak curve, and what the gear bears."""


class Figure(NamedTuple):
    """A quantity: a column, or the resultant of two.

    Attributes:
        owner: the joint, "" of the base; name: of `DRIVE`, or a component's.
        a, b: columns; b is -1 where there is one alone.
    """

    owner: str
    name: str
    a: int
    b: int = -1


class Quantities:
    """Linear functions of the loads of a sample, in columns, and figures made of one or two of them.

    Attributes:
        joints: names; figures: theirs, then of the base, bearings and motors; pairs: (2, figures) their a and b.
    """

    def __init__(
        self,
        model: Model,
        names: Sequence[str],
        rates: slice,
        trains: Sequence[tuple[int, Train]],
        bearings: bool,
    ) -> None:
        """Args: names: of joints; rates: their entries of tau; trains: the joints that have motors, with those."""
        self.n, self.rates, self.trains, self.joints = model.n, rates, tuple(trains), tuple(names)
        figures = [Figure(name, "tau", k) for k, name in enumerate(names)]
        at = len(figures)
        figures += [Figure("", part, at + k) for k, part in enumerate(COMPONENTS)]
        figures += [Figure("", "fxy", at, at + 1), Figure("", "mxy", at + 3, at + 4)]
        at += len(COMPONENTS)
        numbered = enumerate(body.joint for body in model.bodies[1:])
        self._bearings = [(k, joint) for k, joint in numbered if bearings and joint.kind in NAMES]
        self._turns = np.array([frame(joint.axis) for _, joint in self._bearings]).reshape(-1, 3, 3)
        kept = []
        for k, (_, joint) in enumerate(self._bearings):
            slide = joint.kind == "prismatic"
            kept += [6 * k + i for i in ((0, 1, 3, 4, 5) if slide else (0, 1, 2, 3, 4))]
            figures += [Figure(joint.name, part, at + i) for i, part in enumerate(NAMES[joint.kind])]
            figures += [Figure(joint.name, part, at + a, at + b) for part, a, b in _PAIRS[slide]]
            at += 5
        self._kept = np.array(kept, dtype=int)
        for driven, _ in trains:
            figures += [Figure(names[driven], part, at + i) for i, part in enumerate(DRIVE[1:])]
            at += 3
        self.figures, self.columns = tuple(figures), at
        self.pairs = np.array([(figure.a, figure.b) for figure in figures]).T

    def values(self, loads: Floats, qd: Floats, qdd: Floats) -> Floats:
        """Return the columns (..., columns, N).

        Args:
            loads: (..., N, m) tau, base wrench, and with bearings the wrenches of all other bodies.
            qd, qdd: (joints, N).
        """
        linear = self._linear(loads[..., None])[..., 0]
        tau = np.moveaxis(linear, -1, -2)
        rows = []
        for k, train in self.trains:
            load = load_torque(train, tau[..., k, :], qdd[k])
            torque = motor_torque(train, load, qd[k], qdd[k])
            rows += [torque, torque / self._most(train, qd[k]), load]
        return np.concatenate((tau, np.stack(rows, -2)), -2) if rows else tau

    def changes(self, derivatives: Floats, values: Floats, qd: Floats) -> Floats:
        """Return the derivatives of the columns (columns, N, k).

        Args:
            derivatives: of the loads (N, m, k); values: the columns (columns, N).
        """
        linear = np.moveaxis(self._linear(derivatives), 1, 0)
        rows = []
        for i, (k, train) in enumerate(self.trains):
            load = values[len(linear) + 3 * i + 2]
            zero = np.zeros_like(load)
            slope = motor_torque(train, np.sign(load), qd[k], zero) * np.sign(load)
            motor = linear[k] * np.where(load == 0.0, 1.0 / train.gear, slope)[:, None]
            rows += [motor, motor / self._most(train, qd[k])[:, None], linear[k]]
        return np.concatenate((linear, np.stack(rows)), 0) if rows else linear

    def _linear(self, loads: Floats) -> Floats:
        """Return (..., columns, k) of loads (..., m, k), without those of motors."""
        tau, base = loads[..., : self.n, :][..., self.rates, :], loads[..., self.n : self.n + 6, :]
        if not self._bearings:
            return np.concatenate((tau, base), -2)
        wrenches = loads[..., self.n + 6 :, :]
        shape = wrenches.shape
        of = wrenches.reshape(*shape[:-2], -1, 2, 3, shape[-1])[..., [k for k, _ in self._bearings], :, :, :]
        turned = np.einsum("jab,...jcbk->...jcak", self._turns, of)
        parts = turned.reshape(*shape[:-2], 6 * len(self._bearings), shape[-1])[..., self._kept, :]
        return np.concatenate((tau, base, parts), -2)

    @staticmethod
    def _most(train: Train, qd: Floats) -> Floats:
        """Return what the motor's peak curve allows, infinite without one."""
        pace, curve = np.abs(qd * train.gear), train.motor.peak
        if curve is None:
            return np.full(pace.shape, np.inf)
        return np.maximum(allowed(curve, pace), LEAST * max(torque for _, torque in points(curve)))
