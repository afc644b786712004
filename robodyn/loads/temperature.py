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
from itertools import accumulate
from math import isqrt
from typing import Any, NamedTuple

import numpy as np

from robodyn.errors import SceneError
from robodyn.scene.scene import Thermal
from robodyn.support.floats import Floats

MOST = 1 << 17
"""Intervals that are kept of a motion, at most."""
_FINE, _PARTS = 0.1, 4096
"""An interval is parted where it is longer than this share of a winding's time constant; so many more at most."""
_NEWTON = 60
_SCALE, _MELTED = 500.0, 1e9
"""Kelvin above ambient at which a page's curve ends that is never steady, and at which numbers do."""
_LAST = 0.005
"""The share of the way to the steady state that is left where a page's curve over cycles ends."""


@dataclass(frozen=True)
class Electric:
    """What comes from the DC bus, repeated for ever: energy drawn and, negative, returned in a cycle [J], and the
    greatest and least power [W], between rows. On a bus that motors share what one returns another takes."""

    drawn: float
    returned: float
    peak_power: float
    least_power: float


@dataclass(frozen=True)
class MotorHeat(Electric):
    """How hot a motor gets; temperatures in degrees Celsius.

    Attributes:
        copper_loss: per cycle [J], at the limit where it runs away.
        ambient, winding_limit, housing_limit: as the scene has them.
        winding_once, housing_once: greatest along the motion, done once from the start.
        winding, housing: greatest where the motion is repeated for ever; None where each cycle heats more than it cools
            (thermal runaway).
    """

    copper_loss: float
    ambient: float
    winding_limit: float
    housing_limit: float | None
    winding_once: float | None
    housing_once: float | None
    winding: float | None
    housing: float | None


class Heat(NamedTuple):
    """Motors by joint, and the bus; for pages, by joint, times since the start (C,) and the greatest of winding and
    housing (C, 2) in the cycle that begins then. That is by the change of one cycle, which with a torque constant that
    depends on temperature is that near the steady state."""

    motors: dict[str, MotorHeat]
    bus: Electric
    courses: dict[str, tuple[Floats, Floats]]


class HeatPass:
    """Gathers time and the integrals of T^2 and T w between rows, of motors with thermal data, by their place."""

    def __init__(self, thermals: dict[int, Thermal]) -> None:
        self.thermals, self.places = thermals, list(thermals)
        self._last = np.empty((1 + 2 * len(thermals), 0))
        self._kept, self._per = list[Floats](), 1

    def update(self, time: Floats, torque: Floats, speed: Floats) -> None:
        """Take in time (N,), torque and speed (motors, N) at the shafts."""
        T = torque[self.places]
        rows = np.hstack((self._last, np.vstack((time, T * T, T * speed[self.places]))))
        self._last, steps = rows[:, -1:], np.diff(rows[0])
        between = np.vstack((steps, 0.5 * steps * (rows[1:, 1:] + rows[1:, :-1])))
        self._kept.append(_merged(between, self._per))
        while sum(part.shape[1] for part in self._kept) > MOST:
            self._kept, self._per = [_merged(np.hstack(self._kept), 2)], 2 * self._per

    def report(self, names: Sequence[str], history: bool) -> Heat:
        """Return what motors at these joints get to, and their courses if a page shows them."""
        whole, k = np.hstack(self._kept), len(self.places)
        still = not whole.shape[1]
        whole = np.vstack(([[1.0]], self._last[1:])) if still else whole  # a pose is held for ever
        quickest = min(each.winding_housing * each.winding_capacity for each in self.thermals.values())
        parts = np.ceil(whole[0] / max(_FINE * quickest, float(np.sum(whole[0])) / _PARTS)).astype(int)
        whole = np.repeat(whole / parts, parts, axis=1)
        lengths, means = whole[0], whole[1:] / whole[0]
        steps = 0.0 * lengths if still else lengths
        motors, courses, bus = dict[str, MotorHeat](), dict[str, tuple[Floats, Floats]](), np.zeros(len(steps))
        for place, square, mechanical in zip(self.places, means[:k], means[k:], strict=True):
            thermal, name = self.thermals[place], names[place]
            start = 0.0 if thermal.start is None else thermal.start - thermal.ambient
            cold = np.array((start, start if thermal.housing_capacity else 0.0))
            once, steady = response(thermal, steps, square, cold)[0], response(thermal, lengths, square, None)
            limit = np.full((len(steps) + 1, 2), thermal.winding_limit - thermal.ambient)
            hot = limit if steady[0] is None else steady[0]
            copper = square * loss_factor(thermal, 0.5 * (hot[1:, 0] + hot[:-1, 0]))[0]
            power = mechanical + copper
            power = power * np.where(power > 0.0, 1.0 / thermal.drive_efficiency, thermal.drive_efficiency)
            bus += power
            reached: list[Any] = []
            for states in (once, steady[0]):
                reached += [None, None] if states is None else (thermal.ambient + states.max(axis=0)).tolist()
            given = float(np.sum(copper * steps)), thermal.ambient, thermal.winding_limit, thermal.housing_limit
            motors[name] = MotorHeat(*_energies(power, steps), *given, *reached)
            if history and not still:
                cycles, hottest = _over_cycles(steady[1], cold)
                courses[name] = cycles * float(np.sum(steps)), thermal.ambient + hottest
        if not np.isfinite(bus).all():
            remedy = "are resistance and torque_constant in ohm and N m/A?"
            raise SceneError("[motor.thermal]: the power of motors overflows", remedy=remedy)
        return Heat(motors, Electric(*_energies(bus, steps)), courses)


def _merged(intervals: Floats, per: int) -> Floats:
    return np.add.reduceat(intervals, np.arange(0, intervals.shape[1], per), axis=1)


def _energies(power: Floats, steps: Floats) -> tuple[float, float, float, float]:
    drawn, returned = (float(np.sum(part(power, 0.0) * steps)) + 0.0 for part in (np.maximum, np.minimum))
    return drawn, returned, float(power.max()), float(power.min())


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
    (G,), from a start (2,) on or, without one, in the periodic steady state; None where there is no such. And D
    (G, 3, 3): from the start to the end of each interval (x, y, 1) changes by D (x, y, 1).

    The loss is linearized about the last course: by Newton's method where the torque constant depends on temperature,
    else at once. For magnets that get weaker the loss is convex, so that courses from below never pass the solution,
    and where a map expands there is none.
    """
    inside, changes = np.full(len(steps), 0.0 if start is None else start[0]), np.empty((0, 3, 3))
    low = 1.0 + thermal.torque_coefficient * (thermal.ambient - thermal.reference)
    for _ in range(_NEWTON):
        factor, slope = loss_factor(thermal, inside)
        changes = prefixes(_intervals(thermal, steps, square * slope, square * (factor - slope * inside)))
        begin, cycle = start, changes[-1, :2]
        if begin is None:
            # an eigenvalue of the cycle's map, I + D, is 1 or more: it heats more than it cools
            if not (np.trace(cycle) < 0.0 and np.linalg.det(cycle[:, :2]) > 0.0):
                return None, changes
            begin = np.asarray(np.linalg.solve(-cycle[:, :2], cycle[:, 2]), dtype=float)
        states = np.vstack((begin, begin + changes[:, :2] @ np.append(begin, 1.0)))
        before, inside = inside, 0.5 * (states[1:, 0] + states[:-1, 0])
        if not (states <= _MELTED).all() or (low + thermal.torque_coefficient * states[:, 0]).min() <= 0.0:
            return None, changes
        if not thermal.torque_coefficient or np.abs(inside - before).max() <= 1e-11 * (1.0 + np.abs(inside).max()):
            return states, changes
    return None, changes


def _intervals(thermal: Thermal, steps: Floats, gain: Floats, heat: Floats) -> Floats:
    """Return the changes D (G, 3, 3) over intervals in which the winding is heated by `heat + gain x` [W], by the
    eigenvalues of M h: `e^(M h) - I = M h phi(M h)` and `h phi(M h) b`, `phi(z) = (e^z - 1)/z`."""
    to_housing = 1.0 / (thermal.winding_housing * thermal.winding_capacity)
    M = np.zeros((len(steps), 2, 2))
    M[:, 0, 0], M[:, 1, 1] = gain / thermal.winding_capacity - to_housing, -to_housing
    if thermal.housing_capacity and thermal.housing_ambient:
        M[:, 0, 1], M[:, 1, 0] = to_housing, 1.0 / (thermal.winding_housing * thermal.housing_capacity)
        M[:, 1, 1] = -M[:, 1, 0] - 1.0 / (thermal.housing_ambient * thermal.housing_capacity)
    M *= steps[:, None, None]
    (a, b), (c, d) = np.moveaxis(M, 0, 2)
    lower = 0.5 * (a + d) - np.sqrt(0.25 * (a - d) ** 2 + b * c)
    upper = a + d - lower
    p, q = (np.where(z == 0.0, 1.0, np.expm1(z) / np.where(z == 0.0, 1.0, z)) for z in (lower, upper))
    slope = np.where(upper > lower, (q - p) / np.where(upper > lower, upper - lower, 1.0), 0.0)
    phi = slope[:, None, None] * M + (p - slope * lower)[:, None, None] * np.eye(2)
    changes = np.zeros((len(steps), 3, 3))
    changes[:, :2, :2] = M @ phi
    changes[:, :2, 2] = phi[:, :, 0] * (steps * heat / thermal.winding_capacity)[:, None]
    return changes


def then(first: Floats, second: Floats) -> Floats:
    """Return one change after another, `(I + B)(I + A) - I`; the identity left out, small changes keep their digits."""
    return first + second + second @ first


def prefixes(changes: Floats) -> Floats:
    """Return the changes by the first 1, 2 ... of changes (G, 3, 3): inside rows of a square, then of rows."""
    rows = isqrt(len(changes) - 1) + 1
    square = np.zeros((rows, rows, 3, 3))
    square.reshape(-1, 3, 3)[: len(changes)] = changes
    for k in range(1, rows):
        square[:, k] = then(square[:, k - 1], square[:, k])
    before = np.array([*accumulate(square[:-1, -1], then, initial=np.zeros((3, 3)))])
    return then(before[:, None], square).reshape(-1, 3, 3)[: len(changes)]


def _over_cycles(changes: Floats, start: Floats) -> tuple[Floats, Floats]:
    """Return numbers of cycles, from 0, and the hottest winding and housing of each, until they are steady."""
    powers = [changes[-1]]  # of 1, 2, 4 ... cycles
    while len(powers) < 60 and _LAST < np.abs(powers[-1][:2, :2] + np.eye(2)).max() < 10.0:
        powers.append(then(powers[-1], powers[-1]))
    first, states = max(len(powers) - 8, 0), [np.append(start, 1.0)]
    while len(states) <= 2 ** (len(powers) - 1 - first) and states[-1][0] < _SCALE:
        states.append(states[-1] + powers[first] @ states[-1])
    peaks = [(x + np.maximum(0.0, (changes @ x).max(axis=0)))[:2] for x in states]
    return np.arange(float(len(states))) * 2**first, np.array(peaks)
