"""The quantities of a motion whose peaks and mean squares are asked for, of loads and of their derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.varied_loads import Row
from robodyn.loads.motors import LEAST, Train, allowed, load_torque, motor_torque, points
from robodyn.loads.sizing import NAMES, frame
from robodyn.robot.model import Joint, Model
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum
from robodyn.trajectory.columns.signals import COMPONENTS

_PAIRS = (("radial", 0, 1), ("tilting", 3, 4)), (("radial", 0, 1), ("tilting", 2, 3))
"""Of hinges and of slides, the components of a bearing that are one resultant."""

DRIVE = ("tau", "motor", "use", "gear")
"""Figures of a joint: its torque, its motor's, that as a share of the peak curve, and what the gear bears."""


class Figure(NamedTuple):
    """A quantity: the magnitude of a column, the resultant of two, or a motor's torque, `|a + |b||`.

    Attributes:
        owner: the joint, "" of the base; name: of `DRIVE`, or a component's.
        a, b: columns; b is -1 where there is one alone.
    """

    owner: str
    name: str
    a: int
    b: int = -1

    @property
    def columns(self) -> list[int]:
        """The columns that it is made of."""
        return [self.a] if self.b < 0 else [self.a, self.b]

    @property
    def lossy(self) -> bool:
        """Whether it is a motor's torque, whose gear loses as b has it."""
        return self.name in ("motor", "use")

    def size(self, columns: Floats) -> Floats:
        """Return the magnitude, of columns (1 or 2, ...)."""
        if self.b < 0:
            return np.asarray(np.abs(columns[0]))
        a, b = columns
        return np.asarray(np.abs(a + np.abs(b)) if self.lossy else np.sqrt(a * a + b * b))

    def half(self, columns: Floats) -> Floats:
        """Return half the derivatives of the magnitude's square by the columns (1 or 2, ...).

        Times the columns, they add up to that square.
        """
        if not self.lossy:
            return columns
        torque = columns[0] + np.abs(columns[1])
        return np.stack((torque, torque * np.sign(columns[1])))

    def gradient(self, columns: Floats, changes: Floats) -> Floats:
        """Return the derivatives (..., m) of the magnitude, of columns (1 or 2, ...) with theirs; 0 where it is 0."""
        size = self.size(columns)
        found = einsum("c...,c...k->...k", self.half(columns), changes)
        return np.asarray(found / np.where(size > 0.0, size, np.inf)[..., None])


class Quantities:
    """Functions of the loads of a sample, in columns, and figures made of one or two of them.

    Attributes:
        joints: names; figures: theirs, then of the base, bearings and motors.
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
            owner = names[driven]
            figures += [Figure(owner, "motor", at, at + 1), Figure(owner, "use", at + 2, at + 3)]
            figures.append(Figure(owner, "gear", at + 4))
            at += 5
        self.figures, self.columns = tuple(figures), at

    def with_motors(self, sums: Floats, qd: Floats, qdd: Floats) -> Floats:
        """Return all columns (columns, N), of those that are sums of loads, and qd and qdd (joints, N)."""
        rows = []
        for k, train in self.trains:
            (mean, half), most = _shares(train, qd[k]), self._most(train, qd[k])
            load = load_torque(train, sums[k], qdd[k])
            torque = _direction(train.gear * qd[k]) * (train.gear * train.inertia) * qdd[k] + mean * load
            rows += [torque, half * load, torque / most, half * load / most, load]
        return np.concatenate((sums, rows)) if rows else sums

    def changes(self, sums: Floats, qd: Floats) -> Floats:
        """Return the derivatives of all columns (columns, N, m), of those that are sums of loads."""
        rows = []
        for k, train in self.trains:
            mean, half = (share[:, None] * sums[k] for share in _shares(train, qd[k]))
            most = self._most(train, qd[k])[:, None]
            rows += [mean, half, mean / most, half / most, sums[k]]
        return np.concatenate((sums, rows)) if rows else sums

    def halves(self, values: Floats) -> Floats:
        """Return half the derivatives of the figures' squares by their columns, as `Figure.half` has them."""
        found = values.copy()
        for figure in self.figures:
            if figure.lossy:
                found[figure.columns] = figure.half(values[figure.columns])
        return found

    @staticmethod
    def _most(train: Train, qd: Floats) -> Floats:
        """Return what the motor's peak curve allows, infinite without one."""
        curve = train.motor.peak
        least = 0.0 if curve is None else LEAST * max(torque for _, torque in points(curve))
        return np.maximum(allowed(curve, np.abs(qd * train.gear)), least)


def _direction(speed: Floats) -> Floats:
    return np.where(speed < 0.0, -1.0, 1.0)


def _shares(train: Train, qd: Floats) -> tuple[Floats, Floats]:
    """Return what a motor gives for a joint's load: a times the load and |b load| more, in the direction that it turns.

    Of `motor_torque`, |b| is half the difference between a load that is driven and one that drives.
    """
    ahead, still = _direction(qd), np.zeros_like(qd)
    driven, driving = (np.abs(motor_torque(train, load, qd, still)) for load in (ahead, -ahead))
    return 0.5 * (driven + driving) * ahead, 0.5 * (driven - driving)


def _bearing(joint: Joint, first: int) -> list[Row]:
    """Return the components of a bearing's load, of a body's wrench whose loads have the numbers from `first` on."""
    turned: list[Row] = [
        [(first + part + k, float(x)) for k, x in enumerate(axis) if x] for part in (0, 3) for axis in frame(joint.axis)
    ]
    gives_way = 2 if joint.kind == "prismatic" else 5
    return [*turned[:gives_way], *turned[gives_way + 1 :]]
