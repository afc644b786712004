"""The quantities of a motion whose peaks and mean squares are asked for, of loads and of their derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.varied_loads import Row
from robodyn.loads.bearings import NAMES, frame
from robodyn.loads.motors import LEAST, Train, allowed, load_torque, motor_torque, points
from robodyn.robot.model import Joint, Model
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
    """Functions of the loads of a sample, in columns, and figures made of one or two of them.

    Attributes:
        joints: names; figures: theirs, then of the base, bearings and motors; pairs: (2, figures) their a and b.
        rows: the columns but those of motors, as sums of loads.
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
        self.trains, self.joints = tuple(trains), tuple(names)
        figures = [Figure(name, "tau", k) for k, name in enumerate(names)]
        at = len(figures)
        figures += [Figure("", part, at + k) for k, part in enumerate(COMPONENTS)]
        figures += [Figure("", "fxy", at, at + 1), Figure("", "mxy", at + 3, at + 4)]
        at += len(COMPONENTS)
        taus = range(*rates.indices(model.n))
        rows: list[Row] = [[(k, 1.0)] for k in (*taus, *range(model.n, model.n + len(COMPONENTS)))]
        for k, body in enumerate(model.bodies[1:], 1) if bearings else ():
            joint = body.joint
            if joint.kind in NAMES:
                rows += _bearing(joint, model.n + 6 * k)
                figures += [Figure(joint.name, part, at + i) for i, part in enumerate(NAMES[joint.kind])]
                pairs = _PAIRS[joint.kind == "prismatic"]
                figures += [Figure(joint.name, part, at + a, at + b) for part, a, b in pairs]
                at += len(NAMES[joint.kind])
        self.rows = tuple(rows)
        for driven, _ in trains:
            figures += [Figure(names[driven], part, at + i) for i, part in enumerate(DRIVE[1:])]
            at += 3
        self.figures, self.columns = tuple(figures), at
        self.pairs = np.array([(figure.a, figure.b) for figure in figures]).T

    def with_motors(self, sums: Floats, qd: Floats, qdd: Floats) -> Floats:
        """Return all columns (columns, N), of those that are sums of loads, and qd and qdd (joints, N)."""
        rows = []
        for k, train in self.trains:
            load = load_torque(train, sums[k], qdd[k])
            torque = motor_torque(train, load, qd[k], qdd[k])
            rows += [torque, torque / self._most(train, qd[k]), load]
        return np.concatenate((sums, rows)) if rows else sums

    def changes(self, sums: Floats, values: Floats, qd: Floats) -> Floats:
        """Return the derivatives of all columns (columns, N, m).

        Args:
            sums: derivatives of those that are sums of loads; values: all columns (columns, N).
        """
        rows = []
        for i, (k, train) in enumerate(self.trains):
            load = values[len(sums) + 3 * i + 2]
            slope = motor_torque(train, np.sign(load), qd[k], np.zeros_like(load)) * np.sign(load)
            motor = sums[k] * np.where(load == 0.0, 1.0 / train.gear, slope)[:, None]
            rows += [motor, motor / self._most(train, qd[k])[:, None], sums[k]]
        return np.concatenate((sums, rows)) if rows else sums

    @staticmethod
    def _most(train: Train, qd: Floats) -> Floats:
        """Return what the motor's peak curve allows, infinite without one."""
        pace, curve = np.abs(qd * train.gear), train.motor.peak
        if curve is None:
            return np.full(pace.shape, np.inf)
        return np.maximum(allowed(curve, pace), LEAST * max(torque for _, torque in points(curve)))


def _bearing(joint: Joint, first: int) -> list[Row]:
    """Return the components of a bearing's load, of a body's wrench whose loads have the numbers from `first` on."""
    turned: list[Row] = [
        [(first + part + k, float(x)) for k, x in enumerate(axis) if x] for part in (0, 3) for axis in frame(joint.axis)
    ]
    gives_way = 2 if joint.kind == "prismatic" else 5
    return [*turned[:gives_way], *turned[gives_way + 1 :]]
