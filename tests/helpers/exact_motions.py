"""Random motions of whole robots that are known exactly at every instant, on both sides of every jump.

A `Path` is what one joint does: pieces, each with its position, velocity and acceleration as functions of time. Point
to point moves are one shape from 0 to 1, stretched; splines and sines are a piece each.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BPoly, PPoly, make_interp_spline

Array = NDArray[np.float64]
Rates = tuple[Array, Array, Array]
Rng = np.random.Generator
SIDE = 1e-9
"""How far beside a jump its two sides are looked at [s]."""
FASTEST = 30.0
"""Largest acceleration of a revolute joint [rad/s^2]."""
FAR = 2.0
"""Largest span of a joint [rad]."""


@dataclass(frozen=True)
class Piece:
    """What holds from `start` on: the motion as a function of time, and instants where a derivative may jump [s]."""

    start: float
    motion: Callable[[Array], Rates]
    corners: tuple[float, ...] = ()


@dataclass(frozen=True)
class Path:
    """Pieces one after another; the whole is moved and scaled: q = offset + scale * (what the pieces say)."""

    pieces: tuple[Piece, ...]
    offset: float = 0.0
    scale: float = 1.0

    def at(self, t: Array) -> Rates:
        """q, qd and qdd at these instants, of the right side where a derivative jumps."""
        found = np.empty((3, len(t)))
        which = np.searchsorted([piece.start for piece in self.pieces], t, side="right") - 1
        for k in np.unique(which):
            own = which == k
            found[:, own] = self.pieces[max(k, 0)].motion(t[own])
        return self.offset + self.scale * found[0], self.scale * found[1], self.scale * found[2]

    @property
    def corners(self) -> list[float]:
        """Instants where a derivative may jump [s]."""
        return [t for piece in self.pieces for t in (piece.start, *piece.corners)]


@dataclass(frozen=True)
class Course:
    """The paths of all joints of a robot, over a duration [s]."""

    paths: tuple[Path, ...]
    duration: float

    def at(self, t: Array) -> Rates:
        """(samples, joints) each of q, qd and qdd."""
        q, qd, qdd = (np.column_stack(part) for part in zip(*(path.at(t) for path in self.paths), strict=True))
        return q, qd, qdd

    def sides(self, t: Array) -> Rates:
        """The same at these instants, just before and just after each, but not beyond the first and the last."""
        every = np.concatenate((t, t[1:] - SIDE, t[:-1] + SIDE))
        return self.at(every)

    def within(self, t: Array, finer: int) -> Rates:
        """The same on a grid so many times finer than t, and on both sides of every jump between first and last."""
        grid = np.interp(np.arange((len(t) - 1) * finer + 1) / finer, np.arange(len(t)), t)
        corners = np.array([c for path in self.paths for c in path.corners])
        inner = np.concatenate((corners - SIDE, corners + SIDE))
        return self.at(np.concatenate((grid, inner[(inner >= t[0]) & (inner <= t[-1])])))


def rest(start: float, place: float) -> Piece:
    """Stand still."""
    return Piece(start, lambda t: (np.full_like(t, place), np.zeros_like(t), np.zeros_like(t)))


Shape = tuple[Callable[[Array], Rates], tuple[float, ...]]
"""s, s' and s'' as functions of the share of the time passed, s from 0 to 1; shares where a derivative jumps."""


def linear_accelerations(phases: Sequence[tuple[float, float, float]]) -> Shape:
    """The shape of accelerations that are linear in each phase (share, first, last), scaled to reach 1."""
    h, a, b = np.array([phase for phase in phases if phase[0] > 0]).T
    start = np.concatenate(([0.0], np.cumsum(h)))
    s = PPoly(np.array([(b - a) / h, a]), start).antiderivative(2)
    far = s(start[-1])
    return lambda x: (s(x) / far, s(x, 1) / far, s(x, 2) / far), tuple(start[1:-1].tolist())


def trapezoid(rng: Rng, tick: float) -> Shape:
    """Constant acceleration, constant speed (none in a third), constant braking; `tick` is the grid of its corners."""
    up = rng.uniform(0.1, 0.5)
    down = up if rng.random() < 0.6 else rng.uniform(0.1, 0.5)
    if rng.random() < 1 / 3:
        down = 1 - up
    if tick:
        up = max(round(up / tick), 1) * tick
        down = min(max(round(down / tick), 1) * tick, 1 - up)
    return linear_accelerations([(up, 1, 1), (1 - up - down, 0, 0), (down, -up / down, -up / down)])


def s_curve(rng: Rng, tick: float, hold: bool) -> Shape:
    """Acceleration rises, holds (or does not) and falls linearly; the same for braking, a stretch between in most."""
    ramp = 0.5 if rng.random() < 0.3 else rng.uniform(0.2, 0.5)
    rise = ramp * rng.uniform(0.15, 0.4) if hold else ramp / 2
    up = [(rise, 0, 1), (ramp - 2 * rise, 1, 1), (rise, 1, 0)]
    return linear_accelerations([*up, (1 - 2 * ramp, 0, 0), *((h, -a, -b) for h, a, b in up)])


def cosine(rng: Rng, tick: float) -> Shape:
    """Half a cosine of position, or of speed on its way up and down: the acceleration then is half a sine."""
    if rng.random() < 0.6:
        w = np.pi
        return lambda x: ((1 - np.cos(w * x)) / 2, w * np.sin(w * x) / 2, w**2 * np.cos(w * x) / 2), ()
    ramp = rng.uniform(0.2, 0.5)
    w, v = np.pi / ramp, 1 / (1 - ramp)

    def up(x: Array) -> Rates:
        return v * (x - np.sin(w * x) / w) / 2, v * (1 - np.cos(w * x)) / 2, v * w * np.sin(w * x) / 2

    def shape(x: Array) -> Rates:
        first, last = up(x), up(1 - x)
        cruise = (v * (x - ramp / 2), np.full_like(x, v), np.zeros_like(x))
        way = [x < ramp, x < 1 - ramp]
        ends = (1 - last[0], last[1], -last[2])
        s, ds, dds = (np.select(way, [a, b], c) for a, b, c in zip(first, cruise, ends, strict=True))
        return s, ds, dds

    return shape, (ramp, 1 - ramp)


def minimum_jerk(rng: Rng, tick: float) -> Shape:
    """10 x^3 - 15 x^4 + 6 x^5."""
    s = np.polynomial.Polynomial((0, 0, 0, 10, -15, 6))
    return lambda x: (s(x), s.deriv()(x), s.deriv(2)(x)), ()


def moves(shape: Callable[[Rng, float], Shape], rng: Rng, joints: int, duration: float, cycle: float) -> list[Path]:
    """Point to point moves, in half of all cases of all joints at once, with rests between in about half.

    `cycle` is the period of the controller on whose ticks moves start and end [s], or 0.
    """
    together = rng.random() < 0.5
    resting, first, last = rng.random(3) < 0.5
    seed = int(rng.integers(2**32))
    paths = []
    for joint in range(joints):
        own, far = np.random.default_rng(seed + (0 if together else joint)), np.random.default_rng(seed + 1000 + joint)
        pieces, start, place = [rest(0.0, 0.0)], first * own.uniform(0.05, 0.3), 0.0
        way = far.choice([-1.0, 1.0])
        while True:
            pause = own.uniform(0.03, 0.3) if resting and own.random() < 0.7 else 0.0
            span = own.uniform(0.25, 1.0)
            if cycle:
                start, span = round(start / cycle) * cycle, max(round(span / cycle), 4) * cycle
            if start + span > duration and last:
                break
            s, corners = shape(own, cycle / span)
            step = way * far.uniform(0.3, 1.0)
            way = -way if far.random() < 0.7 else way
            pieces.append(
                Piece(start, partial(stretched, s, start, span, place, step), tuple(start + span * c for c in corners))
            )
            place, start = place + step, start + span
            pieces.append(rest(start, place))
            start += pause
            if start > duration:
                break
        paths.append(Path(tuple(pieces)))
    return paths


def stretched(shape: Callable[[Array], Rates], start: float, span: float, place: float, step: float, t: Array) -> Rates:
    """A move by `step` from `place` within `span` seconds."""
    s, v, a = shape((t - start) / span)
    return place + step * s, step * v / span, step * a / span**2


def waypoints(rng: Rng, duration: float, cycle: float) -> tuple[Array, float]:
    """Times between waypoints, from 0, and when the first is left [s]; a rest before and after in half of all cases."""
    start, end = (rng.uniform(0.05, 0.3) if rng.random() < 0.5 else 0.0 for _ in range(2))
    steps = rng.uniform(0.5, 1.5, rng.integers(3, 9))
    times = np.concatenate(([0.0], np.cumsum(steps))) / steps.sum() * (duration - start - end)
    return (np.round(times / cycle) * cycle if cycle else times), start


def between_rests(spline: Callable[..., Array], times: Array, start: float) -> Path:
    """Rest, the spline, rest."""
    first, last = (float(spline(t)) for t in (0.0, times[-1]))
    between = Piece(
        start,
        lambda t: (spline(t - start), spline(t - start, 1), spline(t - start, 2)),
        tuple((start + times).tolist()),
    )
    return Path((rest(0.0, first), between, rest(start + float(times[-1]), last)))


def quintics(rng: Rng, joints: int, duration: float, cycle: float) -> list[Path]:
    """Quintics from via point to via point, at rest at both ends; velocities and accelerations meet between."""
    times, start = waypoints(rng, duration, cycle)
    paths = []
    for _ in range(joints):
        h = float(np.diff(times).mean())
        values = np.column_stack(
            (rng.uniform(-1, 1, len(times)), rng.normal(0, 1, (len(times), 2)) * (1 / h, 2 / h**2))
        )
        values[[0, -1], 1:] = 0.0
        if rng.random() < 0.5:
            values[:, 1:] = 0.0
        paths.append(between_rests(BPoly.from_derivatives(times, values), times, start))
    return paths


def b_splines(degree: int, rng: Rng, joints: int, duration: float, cycle: float) -> list[Path]:
    """Splines of this degree through waypoints, at rest at both ends."""
    times, start = waypoints(rng, duration, cycle)
    ends = [(order, 0.0) for order in range(1, (degree + 1) // 2)]
    through = [rng.uniform(-1, 1, len(times)) for _ in range(joints)]
    splines = [make_interp_spline(times, values, k=degree, bc_type=(ends, ends)) for values in through]
    return [between_rests(spline, times, start) for spline in splines]


def sines(rng: Rng, joints: int, duration: float, cycle: float) -> list[Path]:
    """One to four sines up to 3 Hz, under way from the first sample on, or in a third of all cases from a rest."""
    paths = []
    start = rng.uniform(0.05, 0.3) if rng.random() < 1 / 3 else 0.0
    for _ in range(joints):
        A, w, p = (rng.uniform(*ends, (4, 1)) for ends in ((0.1, 1.0), (0.6, 19.0), (0.0, 6.28)))
        count = rng.integers(1, 5)
        motion = partial(waves, A[:count], w[:count], p[:count] if not start else np.full((count, 1), np.pi / 2), start)
        before = [rest(0.0, float(motion(np.array([start]))[0][0]))] if start else []
        paths.append(Path((*before, Piece(start, motion))))
    return paths


def waves(A: Array, w: Array, p: Array, start: float, t: Array) -> Rates:
    """Sums of A / w sin(w (t - start) + p)."""
    angle = w * (t - start) + p
    return (A / w * np.sin(angle)).sum(0), (A * np.cos(angle)).sum(0), -(A * w * np.sin(angle)).sum(0)


Kind = Callable[[Rng, int, float, float], list[Path]]
MOTIONS: dict[str, Kind] = {
    "trapezoid": partial(moves, trapezoid),
    "S-curve, triangular": partial(moves, partial(s_curve, hold=False)),
    "S-curve, full": partial(moves, partial(s_curve, hold=True)),
    "cosine": partial(moves, cosine),
    "minimum jerk": partial(moves, minimum_jerk),
    "quintic": quintics,
    "sines": sines,
    "B-spline of degree 3": partial(b_splines, 3),
    "B-spline of degree 5": partial(b_splines, 5),
}


def course(kind: str, rng: Rng, ranges: Sequence[tuple[float, float]], cycle: float) -> Course:
    """A random motion of this kind, of joints within (lower, upper) each, of 1.2 to 2.4 s.

    Corners lie on ticks of the `cycle` in a third of all cases, as controllers make them.
    """
    duration = rng.uniform(1.2, 2.4)
    paths = MOTIONS[kind](rng, len(ranges), duration, cycle if rng.random() < 1 / 3 else 0.0)
    fine = np.linspace(0.0, duration, 2001)
    fitted = []
    for path, (lower, upper) in zip(paths, ranges, strict=True):
        q, _, qdd = path.at(fine)
        unit = min(upper - lower, FAR) / FAR
        scale = rng.uniform(0.15, 0.8) * unit * FAR / max(np.ptp(q), 1e-9)
        scale *= min(1.0, rng.uniform(0.3, 1.0) * FASTEST * unit / max(scale * np.abs(qdd).max(), 1e-9))
        low, high = lower - scale * q.min(), upper - scale * q.max()
        fitted.append(Path(path.pieces, rng.uniform(low + 0.1 * (high - low), high - 0.1 * (high - low)), scale))
    return Course(tuple(fitted), duration)
