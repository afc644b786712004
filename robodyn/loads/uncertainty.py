"""How peaks and mean squares change with uncertain parameters x (m,), gathered block by block."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.effect import ZeroColumns
from robodyn.dynamics.plan import plan
from robodyn.dynamics.regressor import Row, derivative_runner, misfits, summed, variations
from robodyn.loads.sizing import LEAST, NAMES, Train, allowed, load_torque, motor_torque, points
from robodyn.loads.statistics import Greatest, Integrals
from robodyn.programs.run.runner import Runner
from robodyn.programs.vectors import frame
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats, einsum
from robodyn.support.wording import shown
from robodyn.trajectory.columns.signals import COMPONENTS
from robodyn.trajectory.motion import Trajectory

_PAIRS = (("radial", 0, 1), ("tilting", 3, 4)), (("radial", 0, 1), ("tilting", 2, 3))
"""Of hinges and of slides, the components of a bearing that are one resultant."""

DRIVE = ("tau", "motor", "use", "gear")
"""Figures of a joint: its torque, its motor's, that as a share of the peak curve, and what the gear bears."""
ROOM = 4_000_000  # numbers of derivatives that are held at a time
GROWING = 0.1  # friction that grows with load more than this may put error bars off by more than 5 %
ROWS = 1024  # samples that are kept of the whole motion at the most, evenly spread, and half as many at least


class Figure(NamedTuple):
    """The magnitude of column a, the resultant of a and b, or a motor's torque `|a + |b||`; b is -1 where there is one
    column. `owner` is the joint, "" of the base; `name` one of `DRIVE` or a component's."""

    owner: str
    name: str
    a: int
    b: int = -1

    @property
    def columns(self) -> list[int]:
        return [self.a] if self.b < 0 else [self.a, self.b]

    @property
    def lossy(self) -> bool:
        return self.name in ("motor", "use")

    def size(self, columns: Floats) -> Floats:
        if self.b < 0:
            return np.asarray(np.abs(columns[0]))
        a, b = columns
        return np.asarray(np.abs(a + np.abs(b)) if self.lossy else np.sqrt(a * a + b * b))

    def half(self, columns: Floats) -> Floats:
        """Return half the derivatives of the magnitude's square by the columns (1 or 2, ...)."""
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
    """Functions of the loads of a sample, in columns, of which `rows` are sums of loads and then come those of motors,
    and figures made of one or two of them: of joints, then of the base, bearings and motors."""

    def __init__(
        self, model: Model, names: Sequence[str], rates: slice, trains: Sequence[tuple[int, Train]], bearings: bool
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
                turned: list[Row] = [
                    [(model.n + 6 * k + part + i, float(x)) for i, x in enumerate(axis) if x]
                    for part in (0, 3)
                    for axis in frame(joint.axis)
                ]
                del turned[2 if joint.kind == "prismatic" else 5]  # to which the joint gives way
                rows += turned
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
            ahead = np.where(train.gear * qd[k] < 0.0, -1.0, 1.0)
            torque = ahead * (train.gear * train.inertia) * qdd[k] + mean * load
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

    @staticmethod
    def _most(train: Train, qd: Floats) -> Floats:
        """Return what the motor's peak curve allows, infinite without one."""
        curve = train.motor.peak
        least = 0.0 if curve is None else LEAST * max(torque for _, torque in points(curve))
        return np.maximum(allowed(curve, np.abs(qd * train.gear)), least)


def _shares(train: Train, qd: Floats) -> tuple[Floats, Floats]:
    """Return what a motor gives for a joint's load: a times the load and |b load| more, in the direction that it turns.
    Of `motor_torque`, |b| is half the difference between a load that is driven and one that drives."""
    ahead, still = np.where(qd < 0.0, -1.0, 1.0), np.zeros_like(qd)
    driven, driving = (np.abs(motor_torque(train, load, qd, still)) for load in (ahead, -ahead))
    return 0.5 * (driven + driving) * ahead, 0.5 * (driven - driving)


class Kept(NamedTuple):
    """Samples of a motion: time (rows,), columns with derivatives (columns, rows, 1 + m), |qd| (joints, rows)."""

    time: Floats
    columns: Floats
    pace: Floats


class UncertaintyPass:
    """Gathers derivatives by x: at the peaks of figures their columns (figures, 2, 1 + m), integrals of "square"
    (figures,), "product" (figures, m), half the derivative of the squares, and of gears the "wear" (gears,), "wear
    change" (gears, m) and "travel", and evenly spread samples."""

    def __init__(
        self,
        model: Model,
        scene: Scene,
        rates: slice,
        trains: Sequence[tuple[int, Train]],
        bearings: bool,
        executor: str = "auto",
        threads: int | None = None,
    ) -> None:
        """Args: rates: entries of tau that are joints; trains: joints with motors; bearings: whether they count."""
        self.model, self.scene, self.rates, self.executor, self.threads = model, scene, rates, executor, threads
        self.notes = misfits(model, scene)
        if names := [name for name in scene.loaded if scene.friction[name].load > GROWING]:  # it may change sides
            what = f"friction of {', '.join(map(shown, names))} grows with more than {100 * GROWING:.3g} % of the load"
            self.notes += (f"{what}: where that load is about zero, error bars may be off by more than 5 %",)
        self.found = variations(model, scene)
        self.of = Quantities(model, model.rates[rates], rates, trains, bearings)
        self._m = len(self.found.each)
        self._peaks, self.at = Greatest(len(self.of.figures)), np.zeros((len(self.of.figures), 2, 1 + self._m))
        self.integrals = Integrals()
        nothing = np.zeros((self.of.columns, 0, 1 + self._m)), np.zeros((len(self.of.joints), 0))
        self.kept, self._stride, self._seen = Kept(np.zeros(0), *nothing), 1, 0
        self._runners: dict[ZeroColumns, Runner] = {}

    def take(
        self, block: Trajectory, sources: Mapping[str, Floats], loads: Floats, zero: ZeroColumns, expected: int
    ) -> None:
        """Take in a block of loads (N, ...): tau, base wrench, and with bearings the wrenches of all other bodies."""
        if zero not in self._runners:
            self._runners[zero] = derivative_runner(plan(self.model, self.scene, zero), self.found, self.of.rows)
        runner = self._runners[zero]
        step = max(2, ROOM // len(runner.program.outputs))
        for start in range(0, len(block), step):
            part = slice(start, start + step)
            time = block.time[part]
            given = {name: values[part] for name, values in sources.items()}
            given["x"] = np.zeros((len(time), self._m))
            found = runner.run(given, len(time), executor=self.executor, threads=self.threads, expected=expected).values
            qd, qdd = (np.ascontiguousarray(each[part, self.rates].T) for each in (block.qd, block.qdd))
            sums = np.array(summed(self.of.rows, list(loads[part].T)))
            values = self.of.with_motors(sums, qd, qdd)
            by_x = np.moveaxis(found.reshape(len(time), len(sums), self._m), 1, 0)
            changes = self.of.changes(np.ascontiguousarray(by_x), qd)
            sizes = np.stack([figure.size(values[figure.columns]) for figure in self.of.figures])
            self._integrate(time, values, changes, sizes, qd)
            self._keep(time, values, changes, qd)
            for k, sample in self._peaks.update(time, block.first_row + start, sizes):
                for i, column in enumerate(self.of.figures[k].columns):
                    self.at[k, i, 0], self.at[k, i, 1:] = values[column, sample], changes[column, sample]
            self._seen += len(time)

    def _integrate(self, time: Floats, values: Floats, changes: Floats, sizes: Floats, qd: Floats) -> None:
        columns = ((figure, figure.columns) for figure in self.of.figures)
        halves = [einsum("cn,cnm->mn", figure.half(values[c]), changes[c]) for figure, c in columns]
        quantities = {"square": sizes * sizes, "product": np.stack(halves)}
        if self.of.trains:
            gears = [figure.a for figure in self.of.figures if figure.name == "gear"]
            pace = np.abs(qd[[k for k, _ in self.of.trains]])
            load, by = values[gears], changes[gears]
            quantities["travel"] = pace
            quantities["wear"] = np.abs(load * load * load) * pace
            quantities["wear change"] = np.moveaxis((load * np.abs(load) * pace)[..., None] * by, -1, 1)
        self.integrals.update(time, quantities)

    def _keep(self, time: Floats, values: Floats, changes: Floats, qd: Floats) -> None:
        """Keep every so many-th sample; twice as few whenever there are too many."""
        while (self._seen + len(time)) / self._stride > ROWS:
            self._stride *= 2
            self.kept = Kept(self.kept.time[::2], self.kept.columns[:, ::2], self.kept.pace[:, ::2])
        rows = np.arange(-self._seen % self._stride, len(time), self._stride)
        columns = np.concatenate((values[:, rows, None], changes[:, rows]), -1)
        times = np.concatenate((self.kept.time, time[rows]))
        pace = np.concatenate((self.kept.pace, np.abs(qd[:, rows])), 1)
        self.kept = Kept(times, np.concatenate((self.kept.columns, columns), 1), pace)
