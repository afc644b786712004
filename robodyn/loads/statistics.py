"""Peaks, extremes and integrals along a motion, gathered block by block, and the figures that they become."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robodyn.dynamics.effects.forces import JointSpring
from robodyn.dynamics.effects.friction import friction_of
from robodyn.dynamics.plan import Plan, runner_of
from robodyn.errors import InputError
from robodyn.loads.result import ComponentLoad, EffectReport, JointLoad, Range
from robodyn.robot.limits import binding
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import BEYOND, Floats, einsum, first_of_ties, steady
from robodyn.trajectory.columns.signals import COMPONENTS

FOUNDATION = (*COMPONENTS, "fxy", "mxy")
"""Of the base wrench in reports: its components, and the resultants in the ground's plane that foundations bear."""
REMEDY = "are masses, lengths, times and the motion in SI units?"


class Greatest:
    """For each of several columns the sample at which a score is greatest, its time [s], its row of the data, from 1,
    and what else was given of it, by name (k,); of ties the first counts."""

    def __init__(self, columns: int) -> None:
        self.score = np.full(columns, -np.inf)
        self.time, self.row = np.zeros(columns), np.zeros(columns, dtype=np.int64)
        self.kept: dict[str, Floats] = {}

    def update(self, time: Floats, first_row: int, score: Floats, **values: Floats) -> list[tuple[int, int]]:
        """Take in time (N,), score and more values (k, N), N > 0; return (column, sample) of each new greatest."""
        columns = np.arange(len(score))
        at = first_of_ties(score)
        new = (self.row == 0) | (steady(score[columns, at]) > steady(self.score))
        self.score = np.where(new, score[columns, at], self.score)
        self.time = np.where(new, time[at], self.time)
        self.row = np.where(new, at + first_row, self.row)
        for name, of in values.items():
            self.kept[name] = np.where(new, of[columns, at], self.kept.get(name, 0.0))
        return [(int(column), int(at[column])) for column in np.flatnonzero(new)]


class Extremes:
    """Where each of some columns is smallest and largest; of ties the first counts."""

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self._low, self._high = Greatest(len(self.names)), Greatest(len(self.names))

    def update(self, time: Floats, values: Floats) -> None:
        """Take in a block: time (N,) and values (N, k), N > 0."""
        self._low.update(time, 1, -values.T)
        self._high.update(time, 1, values.T)

    def ranges(self) -> list[Range]:
        columns = (-self._low.score, self._low.time, self._high.score, self._high.time)
        return [Range(*row) for row in zip(self.names, *(each.tolist() for each in columns), strict=True)]


class Integrals:
    """Trapezoidal integrals over time, across blocks; samples: how many so far, from `start` to `end` [s]."""

    def __init__(self) -> None:
        self.samples, self.start, self.end = 0, 0.0, 0.0
        self.totals: dict[str, Floats] = {}
        self._last: dict[str, Floats] = {}

    @property
    def duration(self) -> float:
        return self.end - self.start

    def update(self, time: Floats, quantities: dict[str, Floats]) -> None:
        """Add a block of N > 0 samples; quantities: (columns, N) or (N,) integrands."""
        before = float(time[0] - self.end) if self.samples else 0.0
        after, weights = np.diff(time), np.zeros(len(time))
        weights[:-1] += after
        weights[1:] += after
        weights[0] += before
        for name, values in quantities.items():
            total = 0.5 * einsum("...k,k->...", values, weights)
            if name in self._last:
                total = total + 0.5 * before * self._last[name]
            self.totals[name] = self.totals.get(name, 0.0) + total
            self._last[name] = values[..., -1].copy()
        self.start, self.end = self.start if self.samples else float(time[0]), float(time[-1])
        self.samples += len(time)

    def mean(self, name: str, single: Floats) -> Floats:
        """Return the time average of a quantity; `single` for a motion without duration."""
        return self.totals[name] / self.duration if self.duration > 0 else single


class ShaftFigures:
    """Peaks and integrals of torques and speeds, of joints or of motors' shafts: by their magnitude, with their `value`
    and the `speed` or `torque` then."""

    def __init__(self, count: int) -> None:
        self.torque, self.speed, self.integrals = Greatest(count), Greatest(count), Integrals()
        self.power_most, self.power_least = np.full(count, -np.inf), np.full(count, np.inf)

    def gather(self, time: Floats, row: int, tau: Floats, qd: Floats, more: dict[str, Floats]) -> list[tuple[int, int]]:
        """Take in a block of tau and qd (count, N), and more integrands; return new peaks as `Greatest.update` does."""
        size, pace, power = np.abs(tau), np.abs(qd), tau * qd + 0.0  # no power is 0, and not -0
        np.maximum(self.power_most, power.max(axis=1), out=self.power_most)
        np.minimum(self.power_least, power.min(axis=1), out=self.power_least)
        positive, negative = np.maximum(power, 0.0), np.minimum(power, 0.0)
        shared = {"square": tau * tau, "travel": pace, "positive": positive, "negative": negative}
        self.integrals.update(time, shared | more)
        self.speed.update(time, row, pace, value=qd, torque=tau)
        return self.torque.update(time, row, size, value=tau, speed=qd)

    def figures(self, k: int) -> dict[str, Any]:
        """Return what `ShaftLoad` has; of one sample its torque is the RMS."""
        torque, speed, totals = self.torque, self.speed, self.integrals.totals
        return {
            "peak": float(torque.kept["value"][k]),
            "peak_time": float(torque.time[k]),
            "peak_row": int(torque.row[k]),
            "peak_speed": float(torque.kept["speed"][k]),
            "rms": float(np.sqrt(self.integrals.mean("square", torque.score**2)[k])),
            "max_speed": float(speed.kept["value"][k]),
            "max_speed_time": float(speed.time[k]),
            "max_speed_row": int(speed.row[k]),
            "torque_at_max_speed": float(speed.kept["torque"][k]),
            "peak_power": float(self.power_most[k]),
            "least_power": float(self.power_least[k]),
            "work_positive": float(totals["positive"][k]),
            "work_negative": float(totals["negative"][k]),
        }


class Statistics(ShaftFigures):
    """Peaks and integrals of joint torques and the base wrench; least, most: (joints,) between which the largest
    magnitude is, as far as torques are sure; at_peak: for each joint the state (q, qd, qdd, columns) of its peak
    torque."""

    def __init__(self, effort: Floats, velocity: Floats) -> None:
        """Args: effort, velocity: (joints,) limits, infinite where there is none."""
        n = len(effort)
        super().__init__(n)
        self._most = BEYOND * np.array((effort, velocity))[..., None]
        self.base, self.least, self.most = Greatest(len(FOUNDATION)), np.zeros(n), np.zeros(n)
        self.q_min, self.q_max = np.full(n, np.inf), np.full(n, -np.inf)
        self.at_peak: dict[int, dict[str, Floats]] = {}

    def update(
        self,
        time: Floats,
        q: Floats,
        qd: Floats,
        tau: Floats,
        base: Floats,
        state: dict[str, Floats],
        off: Floats | float = 0.0,
    ) -> None:
        """Take in a block of q, qd, tau (joints, N) and the base wrench f, n (6, N); state: (N, k) arrays of which a
        peak's sample is kept. off: (joints, N) by how much torques may be off."""
        base = np.vstack((base, np.hypot(base[0], base[1]), np.hypot(base[3], base[4])))
        row, size, power = self.integrals.samples + 1, np.abs(tau), tau * qd
        np.maximum(self.least, (size - off).max(axis=1), out=self.least)
        np.maximum(self.most, (size + off).max(axis=1), out=self.most)
        self.base.update(time, row, np.abs(base), value=base)
        np.minimum(self.q_min, q.min(axis=1), out=self.q_min)
        np.maximum(self.q_max, q.max(axis=1), out=self.q_max)
        more = {
            "torque": tau,
            "wear": tau * tau * np.abs(power),
            "base square": base * base,
            "over effort": (size > self._most[0]).astype(float),
            "over velocity": (np.abs(qd) > self._most[1]).astype(float),
        }
        for joint, at in self.gather(time, row, tau, qd, more):
            self.at_peak[joint] = {name: values[at].copy() for name, values in state.items()}


def check_loads(loads: Floats, names: Sequence[str], first_row: int, file: str | None) -> None:
    """Raise if a load (N, k) of some sample is not finite, naming the first row and its load."""
    if not np.isfinite(loads).all():
        row, column = np.argwhere(~np.isfinite(loads))[0]
        raise InputError(f"row {first_row + row}: {names[column]} overflows", remedy=REMEDY, file=file)


def check_figures(figures: Iterable[ArrayLike], peaks: ArrayLike, file: str | None) -> None:
    """Raise if a power, a square or an integral over the motion is not finite though the loads were."""
    if not all(np.isfinite(values).all() for values in figures):
        largest = float(np.abs(peaks).max(initial=0.0))
        what = f"the loads are finite, their squares or powers overflow; the largest is {largest:.3g}"
        raise InputError(what, remedy=REMEDY, file=file)


def joint_of_rates(model: Model) -> list[Joint]:
    return [joint for joint in model.independent for _ in range(6 if joint.kind == "floating" else 1)]


def position_of_rates(model: Model) -> list[int]:
    """Return the entry of q that goes with each entry of qd; for a floating joint qx qy qz and x y z."""
    places: list[int] = []
    for joint in model.independent:
        at = joint.coordinate
        places += [at + k for k in (3, 4, 5, 0, 1, 2)] if joint.kind == "floating" else [at]
    return places


def joint_load(
    gathered: Statistics,
    k: int,
    joint: Joint,
    name: str,
    scene: Scene,
    shares: Mapping[str, float],
    uncertainty: tuple[float, float | None],
) -> JointLoad:
    """Figures of joint k: RMS `sqrt(integral tau^2 dt / T)`, cubic mean `cbrt(integral |qd tau^3| dt / integral
    |qd| dt)`, work `integral max(+-tau qd, 0) dt`; of one sample its torque is mean and RMS. `uncertainty` is the
    standard deviation and the error bar of the peak."""
    totals = gathered.integrals.totals
    travel = float(totals["travel"][k])
    friction = friction_of(joint, scene)
    held = shares.get("gravity", 0.0) + shares.get(JointSpring.name, 0.0)
    return JointLoad(
        name=name,
        unit="N" if joint.kind == "prismatic" else "N m",
        **gathered.figures(k),
        mean=float(gathered.integrals.mean("torque", gathered.torque.kept["value"])[k]),
        cubic_mean=float(totals["wear"][k] / travel) ** (1 / 3) if travel else 0.0,
        hold=0.5 * (friction.forward - friction.backward) + friction.load * abs(held),
        effort_limit=binding(joint.effort),
        velocity_limit=binding(joint.velocity),
        seconds_over_effort=float(totals["over effort"][k]),
        seconds_over_velocity=float(totals["over velocity"][k]),
        lower=joint.lower,
        upper=joint.upper,
        q_min=float(gathered.q_min[k]),
        q_max=float(gathered.q_max[k]),
        uncertainty=uncertainty[0],
        error_bar=uncertainty[1],
        shares=dict(shares),
    )


def shares_at_peaks(plan: Plan, at_peak: Mapping[int, Mapping[str, Floats]], first_rate: int) -> list[dict[str, float]]:
    """For each joint what every active effect adds to its peak, each from the recursion with that effect alone; they
    add up to it within 1e-12 of the largest torque."""
    states = [at_peak[k] for k in range(len(at_peak))]
    shares: list[dict[str, float]] = [{} for _ in states]
    if states:
        sources = {name: np.stack([state[name] for state in states]) for name in states[0] if name != "off"}
        for effect in plan.effects:
            tau = runner_of(plan.share(effect), plan)(sources, len(states), executor="numpy")
            for k, share in enumerate(shares):
                share[effect.name] = float(tau[k, first_rate + k])
    return shares


def base_loads(gathered: Statistics) -> tuple[ComponentLoad, ...]:
    """Peak with sign, its time, and RMS of each component of the base wrench, and of Fxy and Mxy: foundation loads."""
    peaks = gathered.base.kept["value"]
    rms = np.sqrt(gathered.integrals.mean("base square", peaks**2))
    rows = zip(FOUNDATION, peaks, gathered.base.time, rms, strict=True)
    return tuple(ComponentLoad(name, float(peak), float(time), float(mean)) for name, peak, time, mean in rows)


def effect_reports(plan: Plan, explain: bool) -> tuple[EffectReport, ...]:
    """Return every effect with its verdict and its operations; with `explain`, what its absence would save."""
    total, reports = plan.torques().size, []
    for effect, verdict in plan.verdicts:
        operations = plan.share(effect).size if verdict.active else 0
        saved = (total - plan.without(effect).size if verdict.active else 0) if explain else None
        reports.append(EffectReport(effect.name, verdict, operations, saved))
    return tuple(reports)
