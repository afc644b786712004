"""Motors as heat: winding and housing along a motion and when it is repeated for ever, and power on the DC bus.

`C_w x' = R (T/k)^2 - (x - y)/R_wh` and `C_h y' = (x - y)/R_wh - y/R_ha`, x and y above ambient, R and k at that of the
winding. Between two rows T^2 is held at its mean, so that its integral is that of the RMS torque. For that the solution
is exact: the exponential of each interval's matrix, intervals composed to the map of the motion, whose fixed point is
the periodic steady state. Where k depends on temperature Newton's method on the whole course meets the loss.

Accuracy: 1e-9 of the analytic solution with constant coefficients (a test). Motions of more than `MOST` rows are kept
as pairs, fours ... of intervals, each with its integral of T^2; long intervals, as pauses are, are cut into parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isqrt
from typing import NamedTuple

import numpy as np

from robodyn.errors import SceneError
from robodyn.scene.scene import Thermal
from robodyn.support.floats import Floats, first_largest

MOST = 1 << 17
"""Intervals that are kept of a motion, at most."""
_FINE, _PARTS = 0.1, 4096
"""An interval is parted where it is longer than this share of a winding's time constant; so many more at most."""
_SHOWN = 2000
"""Points of a page's curves, at most."""
_NEWTON = 60
_SCALE, _MELTED = 500.0, 1e9
"""Kelvin above ambient at which a page's curve ends that is never steady, and at which numbers do."""
_LAST = 0.005
"""The share of the way to the steady state that is left where a page's curve over cycles ends."""


@dataclass(frozen=True)
class MotorHeat:
    """How hot a motor gets, and what it takes from the DC bus; temperatures in degrees Celsius.

    Attributes:
        ambient, winding_limit, housing_limit: as the scene has them.
        winding_once, winding_once_time, housing_once: greatest along the motion, done once from the start, when [s].
        winding, winding_time, housing: greatest where the motion is repeated for ever; None where each cycle heats more
            than it cools (thermal runaway).
        copper_loss: per cycle [J], at the limit where it runs away; drawn, returned: energy from the bus and,
            negative, back to it [J].
        peak_power, least_power: of the bus, between rows [W].
    """

    ambient: float
    winding_limit: float
    housing_limit: float | None
    winding_once: float | None
    winding_once_time: float | None
    housing_once: float | None
    winding: float | None
    winding_time: float | None
    housing: float | None
    copper_loss: float
    drawn: float
    returned: float
    peak_power: float
    least_power: float


@dataclass(frozen=True)
class Bus:
    """The DC bus that motors share, in the steady state: what one returns another takes. Power [W] is the mean between
    rows, energy [J] per cycle; missing: joints whose motors have no thermal data, and are not in it."""

    motors: tuple[str, ...]
    missing: tuple[str, ...]
    mean_power: float
    drawn: float
    returned: float
    peak_power: float
    least_power: float


class HeatCourse(NamedTuple):
    """What a page shows of one motor: the winding (B,) repeated for ever, if that is steady; and over the time since
    the start (C,) the greatest of winding and housing in a cycle (C, 2). That is by the map of one cycle, which with a
    torque constant that depends on temperature is that near the steady state."""

    name: str
    winding: Floats | None
    begins: Floats
    hottest: Floats


class Heat(NamedTuple):
    """Results of motors, by their place, and of the bus; for pages time (B,), courses of motors, and the bus's power,
    least and greatest until the next time."""

    motors: dict[int, MotorHeat]
    bus: Bus
    time: Floats
    courses: list[HeatCourse]
    power: tuple[Floats, Floats]


class HeatPass:
    """Gathers time and the integrals of T^2 and T w between rows, of motors with thermal data, by their place."""

    def __init__(self, thermals: dict[int, Thermal]) -> None:
        self.thermals, self.places = thermals, list(thermals)
        self._kept: list[Floats] = []
        self._per, self._last, self.start = 1, np.empty((0, 0)), 0.0

    def update(self, time: Floats, torque: Floats, speed: Floats) -> None:
        """Take in time (N,), torque and speed (motors, N) at the shafts."""
        T = torque[self.places]
        rows = np.vstack((time, T * T, T * speed[self.places]))
        if self._last.size:
            rows = np.hstack((self._last, rows))
        else:
            self.start = float(time[0])
        self._last, steps = rows[:, -1:], np.diff(rows[0])
        if len(steps):
            between = np.vstack((steps, 0.5 * steps * (rows[1:, 1:] + rows[1:, :-1])))
            self._kept.append(np.add.reduceat(between, np.arange(0, len(steps), self._per), axis=1))
        while sum(part.shape[1] for part in self._kept) > MOST:
            whole = np.hstack(self._kept)
            self._kept, self._per = [np.add.reduceat(whole, np.arange(0, whole.shape[1], 2), axis=1)], 2 * self._per

    def report(self, names: Sequence[str], history: bool) -> Heat:
        """Return what motors of these names get to, and their courses if a page shows them."""
        still, last, k = not self._kept, self._last[:, 0], len(self.places)
        whole = np.append(1.0, last[1:])[:, None] if still else np.hstack(self._kept)  # a pose is held for ever
        quickest = min(each.winding_housing * each.winding_capacity for each in self.thermals.values())
        parts = np.ceil(whole[0] / max(_FINE * quickest, float(np.sum(whole[0])) / _PARTS)).astype(int)
        whole = np.repeat(whole / parts, parts, axis=1)
        steps, means = 0.0 * whole[0] if still else whole[0], whole[1:] / whole[0]
        time, total = self.start + np.append(0.0, np.cumsum(steps)), float(np.sum(steps))
        shown = np.unique(np.linspace(0, len(steps) - 1, _SHOWN).astype(int))
        motors, courses, bus = dict[int, MotorHeat](), list[HeatCourse](), np.zeros(len(steps))
        for place, square, mechanical in zip(self.places, means[:k], means[k:], strict=True):
            thermal = self.thermals[place]
            start = 0.0 if thermal.start is None else thermal.start - thermal.ambient
            cold = np.array((start, start if thermal.housing_capacity else 0.0))
            once = response(thermal, steps, square, cold)[0]
            steady, maps = response(thermal, whole[0], square, None)
            limit = np.full((len(time), 1), thermal.winding_limit - thermal.ambient)
            hot = steady if steady is not None else limit if once is None else np.minimum(once, limit)
            copper = square * loss_factor(thermal, 0.5 * (hot[1:, 0] + hot[:-1, 0]))[0]
            electric = mechanical + copper
            power = electric * np.where(electric > 0.0, 1.0 / thermal.drive_efficiency, thermal.drive_efficiency)
            bus += power
            given = thermal.ambient, thermal.winding_limit, thermal.housing_limit
            reached = *_greatest(thermal, once, time), *_greatest(thermal, steady, time)
            motors[place] = MotorHeat(*given, *reached, float(np.sum(copper * steps)), *_energies(power, steps))
            if history and not still:
                winding = None if steady is None else thermal.ambient + steady[shown, 0]
                cycles, hottest = _over_cycles(maps, cold)
                courses.append(HeatCourse(names[place], winding, cycles * total, thermal.ambient + hottest))
        if not np.isfinite(bus).all():
            remedy = "are resistance and torque_constant in ohm and N m/A?"
            raise SceneError("[motor.thermal]: the power of motors overflows", remedy=remedy)
        own, missing = [names[i] for i in self.places], [name for i, name in enumerate(names) if i not in self.places]
        mean = float(np.sum(bus * whole[0]) / np.sum(whole[0]))
        shared = Bus(tuple(own), tuple(missing), mean, *_energies(bus, steps))
        power = np.minimum.reduceat(bus, shown), np.maximum.reduceat(bus, shown)
        return Heat(motors, shared, time[shown], courses, power)


def loss_factor(thermal: Thermal, rise: Floats) -> tuple[Floats, Floats]:
    """R / k^2 [W/(N m)^2] of windings that are so much above ambient, and its slope [1/K]."""
    above, a, b = thermal.ambient - thermal.reference + rise, thermal.resistance_coefficient, thermal.torque_coefficient
    resistance, constant = thermal.resistance * (1.0 + a * above), thermal.torque_constant * (1.0 + b * above)
    factor = resistance / (constant * constant)
    slope = thermal.resistance * a / (constant * constant) - 2.0 * factor * thermal.torque_constant * b / constant
    return factor, slope


@np.errstate(all="ignore")
def response(thermal: Thermal, steps: Floats, square: Floats, start: Floats | None) -> tuple[Floats | None, Floats]:
    """Return winding and housing above ambient (G + 1, 2) at the ends of intervals of steps (G,) [s] with a mean T^2
    (G,), from a start (2,) on or, without one, in the periodic steady state; None where there is no such. And the maps
    (2, 3, G) from the start to the end of each interval, `x - start = D start + c`.

    The loss is linearized about the last course: by Newton's method where the torque constant depends on temperature,
    else at once. For magnets that get weaker the loss is convex, so that courses from below never pass the solution,
    and where a map expands there is none.
    """
    inside = np.full(len(steps), 0.0 if start is None else float(start[0]))
    maps, low = np.empty((2, 3, 0)), 1.0 + thermal.torque_coefficient * (thermal.ambient - thermal.reference)
    for _ in range(_NEWTON):
        factor, slope = loss_factor(thermal, inside)
        maps = prefixes(_intervals(thermal, steps, square * slope, square * (factor - slope * inside)))
        begin, whole = start, maps[..., -1]
        if begin is None:
            (a, b, u), (c, d, v) = whole
            det = a * d - b * c
            if not (a + d < 0.0 and det > 0.0):  # an eigenvalue of I + D is 1 or more: it heats more than it cools
                return None, maps
            begin = np.array((b * v - d * u, c * u - a * v)) / det
        states = begin[:, None] + maps[:, 0] * begin[0] + maps[:, 1] * begin[1] + maps[:, 2]
        states = np.column_stack((begin, states))
        before, inside = inside, 0.5 * (states[0, 1:] + states[0, :-1])
        if not (states <= _MELTED).all() or (low + thermal.torque_coefficient * states[0]).min() <= 0.0:
            return None, maps
        if not thermal.torque_coefficient or np.abs(inside - before).max() <= 1e-11 * (1.0 + np.abs(inside).max()):
            return states.T, maps
    return None, maps


def _intervals(thermal: Thermal, steps: Floats, gain: Floats, heat: Floats) -> Floats:
    """Return the maps (2, 3, G) of intervals in which the winding is heated by `heat + gain x` [W]: D = e^(M h) - I and
    c = h phi(M h) b by the eigenvalues of M h, `phi(z) = (e^z - 1)/z`."""
    to_housing = 1.0 / (thermal.winding_housing * thermal.winding_capacity)
    a, b, c, d = gain / thermal.winding_capacity - to_housing, 0.0, 0.0, -to_housing
    if thermal.housing_capacity and thermal.housing_ambient:
        b, c = to_housing, 1.0 / (thermal.winding_housing * thermal.housing_capacity)
        d = -c - 1.0 / (thermal.housing_ambient * thermal.housing_capacity)
    lower = 0.5 * (a + d) - np.sqrt(0.25 * (a - d) ** 2 + b * c)
    upper = a + d - lower
    lower, upper = lower * steps, upper * steps
    p, q = (np.where(z == 0.0, 1.0, np.expm1(z) / np.where(z == 0.0, 1.0, z)) for z in (lower, upper))
    slope = np.where(upper > lower, (q - p) / np.where(upper > lower, upper - lower, 1.0), 0.0)
    phi = np.array((p + slope * (a * steps - lower), slope * c * steps))  # its first column
    second = np.array((slope * b * steps, p + slope * (d * steps - lower)))
    D = np.array([[steps * (a * x[0] + b * x[1]), steps * (c * x[0] + d * x[1])] for x in (phi, second)])
    return np.stack((*D, phi * (steps * heat / thermal.winding_capacity)), axis=1)


def then(first: Floats, second: Floats) -> Floats:
    """Return the map (2, 3, ...) of one map after another; as differences from the identity they keep their digits."""
    return first + second + second[:, :1] * first[:1] + second[:, 1:2] * first[1:2]


def prefixes(maps: Floats) -> Floats:
    """Return the compositions of the first 1, 2 ... of maps (2, 3, G): inside rows of a square, then of rows."""
    G = maps.shape[2]
    rows = isqrt(G - 1) + 1
    square = np.zeros((2, 3, rows * rows))
    square[..., :G] = maps
    square = np.ascontiguousarray(np.moveaxis(square.reshape(2, 3, rows, rows), 3, 0))
    for k in range(1, rows):
        square[k] = then(square[k - 1], square[k])
    before = np.zeros((2, 3, rows))
    for k in range(1, rows):
        before[..., k] = then(before[..., k - 1], square[-1, ..., k - 1])
    whole = then(before[..., None], np.moveaxis(square, 0, 3))
    return whole.reshape(2, 3, -1)[..., :G]


def _greatest(thermal: Thermal, states: Floats | None, time: Floats) -> tuple[float | None, float | None, float | None]:
    """Return the hottest winding, when, and the hottest housing."""
    if states is None:
        return None, None, None
    at = first_largest(states[:, 0])
    hottest = float(states[at, 0]), float(states[:, 1].max())
    return thermal.ambient + hottest[0], float(time[at]), thermal.ambient + hottest[1]


def _over_cycles(maps: Floats, start: Floats) -> tuple[Floats, Floats]:
    """Return numbers of cycles, from 0, and the hottest winding and housing of each, until they are steady."""
    powers = [maps[..., -1]]  # the maps of 1, 2, 4 ... cycles
    while len(powers) < 60 and _LAST < np.abs(powers[-1][:, :2] + np.eye(2)).max() < 10.0:
        powers.append(then(powers[-1], powers[-1]))
    first, states = max(len(powers) - 8, 0), [start]
    step = powers[first]
    while len(states) <= 2 ** (len(powers) - 1 - first) and states[-1][0] < _SCALE:
        states.append(states[-1] + step[:, :2] @ states[-1] + step[:, 2])
    peaks = [x + np.maximum(0.0, (maps[:, 0] * x[0] + maps[:, 1] * x[1] + maps[:, 2]).max(axis=1)) for x in states]
    return np.arange(float(len(states))) * 2**first, np.array(peaks)


def _energies(power: Floats, steps: Floats) -> tuple[float, float, float, float]:
    """Return what is drawn and returned [J], and the greatest and least power [W]."""
    drawn, returned = (float(np.sum(part(power, 0.0) * steps)) + 0.0 for part in (np.maximum, np.minimum))
    return drawn, returned, float(power.max()), float(power.min())
