"""Whether a motion can be in the units that it is taken in: against the robot's limits, its own rates, and stamps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from robodyn.errors import Caveat, TrajectoryError, WrongUnits
from robodyn.trajectory.columns.layout import ABSENT, Layout
from robodyn.trajectory.columns.signals import ANGLES, EPOCH, RATES, TICKS, Clock, Signal, Signals
from robodyn.trajectory.motion import FEW, Trajectory

_SI = {"angle": ("rad", "angles are radians"), "length": ("m", "lengths are metres")}
_OTHER = {
    "angle": (ANGLES["deg"], "degrees", "--angle-unit deg, or --angle-unit rad if they are radians"),
    "length": (1000.0, "millimetres", "--map 'q_{joint} [mm]={column}', or [m] if they are metres"),
}
"""The unit that is used in place of that of SI: how many make one, its name, and the options that say what is meant."""
_UNITS = {"angle": "deg", "length": "mm"}
_TIMES = {"s": "seconds", "ms": "milliseconds", "us": "microseconds", "ns": "nanoseconds"}
_FAR = {"angle": 2.0 * math.pi, "length": 1.0}  # distance beyond a limit of position [rad, m] to which no joint moves
_SLACK = 0.1  # share of its range by which a joint may be beyond its limits in the unit that is proposed
_FAST = 20.0  # times its limit of speed, at which no joint moves
_MODERATE = {"angle": 5.0, "length": 1.0}
"""Speeds [rad/s, m/s] that joints reach whose limit is higher, or that have none."""
_SLOW, _COARSE = 2e-3, 0.15
"""A motion below this share of moderate speeds, sampled at steps [s] from this on, is rather one in ms, us or ns."""
_LATEST = 5e9  # seconds since 1970 that no clock has reached
_COMPARED = 1 << 12  # rows of a block whose rates are compared with slopes
_FEW, _OFTEN = 3, 0.9
_LIKE, _OFF, _SMOOTH = 0.95, 0.03, 0.1
"""Given rates are the slopes in another unit where the correlation of what they cover and what is covered is above the
first, their ratio within the second of that of the units, and what they change from row to row small beside them (in
coarse samples of fast swings they may be anything); of so many steps at least."""


def refuse_units(caveats: Sequence[Caveat], file: str | None) -> None:
    """Raise where caveats say that numbers can hardly be in their units, with the options that say what is meant."""
    if said := [caveat.text for caveat in caveats if isinstance(caveat, WrongUnits)]:
        raise TrajectoryError("; ".join(said), file=file)


class _Seen(NamedTuple):
    """What a scalar joint with a column of positions (of a unit that is told or not) has been seen to do: its ends, its
    largest speed, and the largest that lasts for 8 rows, as no glitch of a sensor does."""

    joint: Signal
    kind: str
    column: str
    told: bool
    least: float
    greatest: float
    speed: float
    lasting: float

    def beyond(self, parts: float = 1.0) -> float:
        """How far it goes beyond its limits, if so many of its unit make one of SI; -inf without limits."""
        return max(self.joint.lower - self.least / parts, self.greatest / parts - self.joint.upper)

    @property
    def use(self) -> float:
        """Its lasting speed as a share of its limit."""
        return self.lasting / self.joint.speed


class Plausibility:
    """What has been seen of a motion, block by block, and what is doubtful about its units."""

    def __init__(self, signals: Signals, layout: Layout) -> None:
        self._signals, self._layout = signals, layout
        self._rows, self._start, self._end = 0, 0.0, 0.0
        self._least, self._greatest = (np.full(len(layout.q), x) for x in (np.inf, -np.inf))
        self._fastest, self._lasting = np.zeros((2, len(layout.qd)))
        self._steps = {name: np.zeros((4, len(layout.qd))) for name in ("qd", "qdd")}

    def update(self, block: Trajectory, rough: bool = False) -> None:
        """Take in a block, which is not empty; where speeds are `rough`, those of zero by its positions: high
        differences of them, which no turn of 2 pi is among."""
        if rough and len(block) >= _FEW and block.q.shape == block.qd.shape:
            steps = np.quantile(np.abs(np.diff(block.q, axis=0)), _OFTEN, axis=0)
            speeds = steps / float(np.median(np.diff(block.time)))
            block = replace(block, qd=np.where(block.qd.any(axis=0), block.qd, speeds))
        if not self._rows:
            self._start = float(block.time[0])
        self._rows, self._end = self._rows + len(block), float(block.time[-1])
        np.minimum(self._least, block.q.min(axis=0), out=self._least)
        np.maximum(self._greatest, block.q.max(axis=0), out=self._greatest)
        speed = np.abs(block.qd)
        np.maximum(self._fastest, speed.max(axis=0), out=self._fastest)
        for rows in (1, 2, 4):
            if len(speed) > 4 * rows:
                speed = np.minimum(speed[rows:], speed[:-rows])
        np.maximum(self._lasting, speed.max(axis=0), out=self._lasting)
        self._compare(block)

    @np.errstate(all="ignore")
    def _compare(self, block: Trajectory) -> None:
        """Add to sums of x^2, x y, y^2 and z^2: x the steps of positions (of velocities), y what given rates make of
        them, z what the rates change from row to row."""
        q, qd, qdd = (x[:_COMPARED] for x in (block.q, block.qd, block.qdd))
        step = np.diff(block.time[:_COMPARED])
        for joint, ((start, *_), (rate, *others)) in self._signals.spans.items():
            if others:
                continue
            turns = self._signals.kinds[joint] == "angle"
            for name, values, rates in (("qd", q[:, start], qd), ("qdd", qd[:, rate], qdd)):
                if getattr(self._layout, name)[rate] != ABSENT:
                    x, y = np.diff(values), 0.5 * step * (rates[1:, rate] + rates[:-1, rate])
                    x = x - 2.0 * math.pi * np.rint(x / (2.0 * math.pi)) if turns and name == "qd" else x
                    z = step * np.diff(rates[:, rate])
                    self._steps[name][:, rate] += (x * x).sum(), (x * y).sum(), (y * y).sum(), (z * z).sum()

    def caveats(self) -> tuple[Caveat, ...]:
        """What is doubtful about the units, each with the option that mends it."""
        layout, clock, seen = self._layout, self._layout.clock, list[_Seen]()
        for joint, ((q, *_), (rate, *_)) in zip(self._signals.joints, self._signals.spans.values(), strict=True):
            if joint.kind != "floating" and (column := layout.q[q]) != ABSENT:
                done = map(float, (self._least[q], self._greatest[q], self._fastest[rate], self._lasting[rate]))
                kind, told = self._signals.kinds[joint.name], column in layout.told
                seen.append(_Seen(joint, kind, layout.names[column], told, *done))
        found = {kind: said for kind in _OTHER if (said := _positions(kind, seen) or self._rates(kind))}
        turning = [x for x in seen if x.kind == "angle" and not x.told and math.isfinite(x.joint.speed)]
        fast = max(turning, key=lambda each: each.use, default=None)
        if "angle" not in found and fast is not None and _FAST < fast.use <= 2.0 * ANGLES["deg"]:
            _, other, remedy = _OTHER["angle"]
            moves = f"joint {fast.joint.name!r} turns at {fast.lasting:.4g} rad/s, {fast.use:.3g} times its limit"
            found["angle"] = f"{moves}: are the angles {other}? ({remedy})"
        parts = {kind: _OTHER[kind][0] if kind in found else 1.0 for kind in _OTHER}
        caveats: list[Caveat] = [WrongUnits(f"if {_SI[kind][1]} (assumed)", said) for kind, said in found.items()]
        seen = [
            each._replace(speed=each.speed / parts[each.kind], lasting=each.lasting / parts[each.kind]) for each in seen
        ]
        step = (self._end - self._start) / max(1, self._rows - 1)
        first = float(clock.start) + self._start
        why, unit = _stamp_unit(seen, clock, step, first)
        if unit:
            now = next(name for name, ticks in TICKS.items() if ticks == clock.ticks)
            remedy = f"--time-unit {unit}" + ("" if clock.told else f", or --time-unit {now} if they are {_TIMES[now]}")
            said = f"{why}: are the stamps {_TIMES[unit]}? ({remedy})"
            few = self._rows < FEW and first <= _LATEST  # way-points, of a robot that may well be slow
            clause = f"if the stamps are {_TIMES[now]}{'' if clock.told else ' (assumed)'}"
            caveats.append((Caveat if few else WrongUnits)(clause, said))
        return tuple(caveats)

    def _rates(self, kind: str) -> str:
        """Why given velocities or accelerations are in the other unit while what they are rates of is not."""
        parts, other, _ = _OTHER[kind]
        for order, name in enumerate(self._steps if self._rows >= FEW else (), start=1):
            columns, ratios = getattr(self._layout, name), {}
            for joint, (q, (rate, *others)) in self._signals.spans.items():
                own = not others and self._signals.kinds[joint] == kind and self._layout.q[q[0]] != ABSENT
                square, both, covered, rough = self._steps[name][:, rate].tolist()
                clear = rough < _SMOOTH * covered and both > _LIKE * math.sqrt(square * covered)
                if own and clear and columns[rate] not in (ABSENT, *self._layout.told):
                    ratios[joint, self._layout.names[columns[rate]]] = both / square
            if ratios and all(abs(ratio / parts - 1.0) < _OFF for ratio in ratios.values()):
                (joint, column), ratio = next(iter(ratios.items()))
                what, of = (("velocities", "positions"), ("accelerations", "velocities"))[order - 1]
                seen = f"{what} of joint {joint!r} are {ratio:.4g} times the rates of its {of}"
                option = f"--map '{name}_{joint} [{_UNITS[kind]}{RATES[order]}]={column}' for each joint"
                told = ", or --angle-unit rad if they are meant so" if kind == "angle" else ""
                return f"{seen}: are these in {other}, beside {of} in {_SI[kind][0]}? ({option}{told})"
        return ""


def _positions(kind: str, seen: list[_Seen]) -> str:
    """Why positions are in the other unit, empty if they are not: far beyond limits, but not in that unit."""
    limited = [each for each in seen if each.kind == kind and not each.told and each.joint.lower < each.joint.upper]
    far = max(limited, key=_Seen.beyond, default=None)
    parts, other, remedy = _OTHER[kind]
    slack = {each.joint.name: _SLACK * (each.joint.upper - each.joint.lower) for each in limited}
    if far is None or far.beyond() <= _FAR[kind] or any(x.beyond(parts) > slack[x.joint.name] for x in limited):
        return ""
    low = far.joint.lower - far.least == far.beyond()
    si = _SI[kind][0]
    what = f"joint {far.joint.name!r} goes to {far.least if low else far.greatest:.6g} {si}"
    limits = f"far beyond its limits of {far.joint.lower:.4g} and {far.joint.upper:.4g} {si}"
    remedy = remedy.format(joint=far.joint.name, column=far.column)
    return f"{what}, {limits}, and all would be within theirs in {other}: are these {other}? ({remedy})"


def _stamp_unit(seen: list[_Seen], clock: Clock, step: float, first: float) -> tuple[str, str]:
    """Why stamps are of another unit, and of which, empty if they are not: speeds are far beyond limits; or no unit is
    told, and rows are far apart while little has moved, or stamps begin at no time since 1970."""
    use = max((each.use for each in seen), default=0.0)
    longer = [unit for unit, ticks in TICKS.items() if ticks < clock.ticks and use * ticks / clock.ticks <= 2.0]
    if longer and use > _FAST:
        return f"joints move at up to {use:.4g} times their limit of speed", longer[-1]
    if clock.told:
        return "", ""
    use = max((each.speed / min(each.joint.speed, _MODERATE[each.kind]) for each in seen), default=0.0)
    unit = next((unit for unit, n in TICKS.items() if step / n < _COARSE or use * n > _SLOW), "s")
    if use and unit != "s":
        return f"rows are {step:.6g} s apart and no joint moves faster than {100 * use:.2g} % of a moderate speed", unit
    unit = next((unit for unit, n in TICKS.items() if first > _LATEST and EPOCH <= first / n <= _LATEST), "")
    return f"stamps begin at {first:.15g}, which is no time in seconds since 1970", unit
