"""A path in the shortest time that a robot's limits allow, or as drives go from point to point: `robodyn retime`.

1. `path.py` reads way-points and leads a curve through them.
2. `along.py` says what limits speed and acceleration along it, by the recursion and the motors' data sheets.
3. `reachability.py` finds the fastest pass of lines; here these are taken anew about each pass until it stays, then
   limits are checked exactly between grid points, and lowered where they are passed, until none is.
4. A limit of jerk is kept as drives do: a moving average of the place on the path, over some time.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robodyn.errors import InputError
from robodyn.loads.sizing import allowed, load_torque, motor_torque
from robodyn.robot.limits import coordinate_ranges
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.sizing.along import (
    ACCELERATION,
    EFFORT,
    FINE,
    GEAR,
    JERK,
    LIMITS,
    MOTOR_TORQUE,
    SLOWEST,
    Along,
    Bounds,
    PerJoint,
    bounds_of,
    inner,
)
from robodyn.sizing.path import Path, lines, read_path, spline
from robodyn.sizing.reachability import Intervals
from robodyn.support.floats import Floats, first_of_ties, ranked
from robodyn.support.wording import shown

PROFILES = ("optimal", "trapezoid", "scurve")
GRID, RATE = 2000, 250.0
MOST_GRID, MOST_SAMPLES = 50_000, 2_000_000
PASSED, BINDS = 1e-9, 0.995
"""Of a limit: what it may be passed by, and from where on it is said to bind."""
RAMP = 0.25
"""Of the time of speeding up: that over which an S-curve's acceleration grows, where no jerk is given."""
_ROUNDS, _NEAR, _ROUNDING = 40, 1e-7, 1e-12
_TRIED, _SOFTER = 2, 4
"""Widths of moving averages that are tried behind the best, and how often accelerations are lowered for each."""
MOST_STOPS = 500
"""Way-points from stop to stop; a path of more is followed in one go."""


class Course(NamedTuple):
    """s(t) of K polynomials of the third degree: how long each lasts [s]; s, sd, sdd where it begins; sddd; the leg of
    the path, from stop to stop, that it is on. The last is the rest at the end."""

    lasts: Floats
    s: Floats
    speed: Floats
    u: Floats
    jerk: Floats
    leg: NDArray[np.int64]

    @property
    def time(self) -> Floats:
        """(K + 1,) when polynomials begin, and the last ends [s]."""
        return np.concatenate(([0.0], np.cumsum(self.lasts)))

    @property
    def duration(self) -> float:
        return float(self.lasts.sum())

    def knot(self, time: Floats) -> NDArray[np.int64]:
        """Return by which polynomials these times are."""
        return np.clip(np.searchsorted(self.time, time, side="right") - 1, 0, len(self.lasts) - 1)

    def slower(self, factor: float) -> Course:
        """Return the same in `factor` times the time."""
        f = 1.0 / factor
        return Course(factor * self.lasts, self.s, f * self.speed, f * f * self.u, f * f * f * self.jerk, self.leg)

    def at(self, time: Floats, k: NDArray[np.int64]) -> tuple[Floats, Floats, Floats, Floats]:
        """Return s and its derivatives at these times, by polynomials k."""
        t, j = time - self.time[k], self.jerk[k]
        s = self.s[k] + t * (self.speed[k] + t * (self.u[k] / 2.0 + t * (j / 6.0)))
        sd = self.speed[k] + t * (self.u[k] + t * (j / 2.0))
        return s, np.where(sd > _ROUNDING * self.speed.max(), sd, 0.0), self.u[k] + j * t, j

    def states(self, path: Path, time: Floats, k: NDArray[np.int64]) -> tuple[Floats, Floats, Floats, Floats]:
        """Return q, qd, qdd and qddd (..., n) at these times, by polynomials k."""
        s, sd, u, j = self.at(time, k)
        q, first, second, third = path.at(s, path.pieces(s, self.leg[k]))
        sd, u, j = (each[..., None] for each in (sd, u, j))
        return q, first * sd, first * u + second * sd * sd, first * j + 3.0 * second * sd * u + third * sd**3

    def fine(self, parts: int = FINE) -> tuple[Floats, NDArray[np.int64]]:
        """Return times (parts + 1, K) in all polynomials, and the numbers of these."""
        inside = inner(np.append(self.speed, 0.0) == 0.0, np.linspace(0.0, 1.0, parts + 1))
        return self.time[:-1] + inside * self.lasts, np.broadcast_to(np.arange(len(self.lasts)), inside.shape)

    def averaged(self, width: float) -> Course:
        """Return the moving average of s over this time, of a course without jerk that begins and ends at rest, which
        takes it longer: `sdd(t) = (sd(t) - sd(t - width)) / width`; the same where the width is 0."""
        if width <= 0.0:
            return self
        time = self.time
        knots = np.sort(np.concatenate((time, time + width)))
        knots = knots[np.append(True, np.diff(knots) > 1e-7 * width)]  # those that rounding alone parts are one
        now, then = (np.interp(knots - late, time, np.append(self.speed, 0.0)) for late in (0.0, width))
        u, steps = (now - then) / width, np.diff(knots)
        jerk = np.diff(u) / steps
        speed = np.concatenate(([0.0], np.cumsum(0.5 * steps * (u[1:] + u[:-1])))).clip(0.0)
        ways = steps * (speed[:-1] + steps * (u[:-1] / 2.0 + steps * jerk / 6.0))
        s = self.s[0] + np.concatenate(([0.0], np.cumsum(ways)))
        lasts, leg = np.append(steps, 0.0), self.leg[self.knot(knots + 0.5 * np.append(steps, 0.0))]
        return Course(lasts, s, speed, u, np.append(jerk, 0.0), leg)


@dataclass(frozen=True)
class Binding:
    """A limit of a joint, and the share of the time in which it is the one that binds."""

    joint: str
    limit: str
    share_of_time: float


@dataclass(frozen=True)
class JointUse:
    """What a joint uses at most of each of its limits, 1 at the limit; those that it has not are left out."""

    name: str
    use: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Retimed:
    """A path in time.

    Attributes:
        feasible: whether a motion keeps all limits; if not, `reason` says why, `where` the joint, the row of the path,
            and what is `missing` in its `unit`.
        time: (N,) [s]; q, qd, qdd, tau: (N, n); row: (N,) where on the path, as rows of its table.
        binding: which limits bind, the most frequent first; joints: what each uses of its limits.
        used: (7, N, n) what is used of each of `LIMITS`, 0 where there is none; limits: (7, n).
    """

    model: Model
    scene: Scene
    profile: str
    path: Path
    limits: Floats
    reason: str = ""
    where: Mapping[str, Any] = field(default_factory=dict)
    time: Floats = field(default_factory=lambda: np.zeros(0))
    q: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    qd: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    qdd: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    tau: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    row: Floats = field(default_factory=lambda: np.zeros(0))
    binding: tuple[Binding, ...] = ()
    joints: tuple[JointUse, ...] = ()
    used: Floats = field(default_factory=lambda: np.zeros((0, 0, 0)))
    warnings: tuple[str, ...] = ()

    @property
    def feasible(self) -> bool:
        return not self.reason

    @property
    def duration(self) -> float | None:
        return float(self.time[-1]) if len(self.time) else None

    @property
    def samples(self) -> int:
        return len(self.time)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(f"{kind}_{name}" for kind in ("q", "qd", "qdd") for name in self.model.joint_names)

    @property
    def columns(self) -> Floats:
        """(N, 3 n): q, qd and qdd."""
        return np.hstack((self.q, self.qd, self.qdd))


class InfeasibleError(Exception):
    """No motion along the path keeps the limits: why, and where."""

    def __init__(self, why: str, model: Model, path: Path, s: float, i: int, missing: float, unit: str) -> None:
        super().__init__(why)
        row = float(path.row(s))
        self.where = {"joint": model.joint_names[i], "row": row, "missing": missing, "unit": unit}


def retime(
    model: Model,
    path: str | os.PathLike[str] | ArrayLike,
    scene: Scene = DEFAULT,
    *,
    profile: str = "optimal",
    speed: float = 1.0,
    acceleration: PerJoint | None = None,
    jerk: PerJoint | None = None,
    blend: float | None = None,
    rate: float = RATE,
    grid: int = GRID,
    **reading: Any,
) -> Retimed:
    """Return a motion along a path: the fastest that keeps all limits, or that of drives from point to point.

    Args:
        path: a table of way-points, or of a dense path, as `read_path` has it; or positions (M, n).
        scene: with friction, payloads, motors; loops, contacts and a base that moves are refused.
        profile: "optimal": by reachability analysis (Pham and Pham 2018); "trapezoid" or "scurve": straight in joint
            space, stopping at every way-point, all joints in the time of the slowest.
        speed: share of the velocity limits that is used.
        acceleration, jerk: limits [rad/s^2, rad/s^3; m for slides], one number for all, one for each joint, or by name.
        blend: straight lines with corners rounded from this distance on [rad, m in joint space], 0: stopping in them;
            None: a cubic spline through the way-points.
        rate: rows per second at least; grid: intervals of the path about; reading: as of `read_motion`.

    Raises:
        InputError: the path, an option or the scene does not fit; nothing limits the motion.

    Accuracy: no limit is passed by more than 1e-9 of it at ten times the points of the grid; the duration is longer
        than the shortest by less than 1e-3 with 2000 intervals, 1e-6 of a double integrator.
    """
    _check(profile, speed, blend, rate, grid, jerk)
    bounds = bounds_of(model, scene, acceleration, jerk, speed)
    points = read_path(path, model, scene, **reading)
    way = spline(points) if profile == "optimal" and blend is None else lines(points, blend)
    try:
        _check_range(model, way, grid)
        if profile == "optimal":
            along = Along(bounds, way, way.grid(max(grid, len(way.breaks) - 1)))
            kept, x = _fastest(along)
            jerky = np.isfinite(bounds.limits[JERK]).any()
            course = _within_jerk(along, kept, x) if jerky else _course(along, x)
        elif len(way.breaks) > MOST_STOPS:
            what = f"{len(way.breaks)} way-points to stop at"
            raise InputError(what, remedy=f"{MOST_STOPS} at most; --profile optimal follows a dense path in one go")
        else:
            course = _joined(way, [_move(bounds, way, k, profile) for k in range(len(way.breaks) - 1)])
    except InfeasibleError as why:
        return Retimed(model, scene, profile, way, bounds.limits, str(why), why.where)
    return _result(bounds, way, course, rate, profile)


def _check(profile: str, speed: float, blend: float | None, rate: float, grid: int, jerk: Any) -> None:
    blended = blend is not None and profile != "optimal"
    wrong = [
        (profile not in PROFILES, f"no profile {shown(profile)}", f"one of {', '.join(PROFILES)}"),
        (not 0.0 < speed <= 1.0, f"speed is {100 * speed:g} %", "more than 0 %, at most 100 % of the velocity limits"),
        (blend is not None and not 0.0 <= blend < np.inf, f"blend is {blend}", "0 or more"),
        (blended, f"--blend does not go with {profile}", "it stops at way-points"),
        (jerk is not None and profile == "trapezoid", "a trapezoid has no limit of jerk", "--profile scurve"),
        (not 0.0 < rate < np.inf, f"rate is {rate:g}", "rows per second, positive"),
        (not 10 <= grid <= MOST_GRID, f"a grid of {grid} intervals", f"10 to {MOST_GRID}"),
    ]
    for holds, what, remedy in wrong:
        if holds:
            raise InputError(what, remedy=remedy)


def _check_range(model: Model, path: Path, grid: int) -> None:
    """Raise if a joint leaves its range."""
    least, largest = coordinate_ranges(model)
    s = path.grid(grid)
    q = path.at(s, path.pieces(s, np.searchsorted(path.stops[1:-1], s)))[0]
    beyond = np.maximum(least - q, q - largest) - PASSED * np.maximum(1.0, np.abs(q))
    beyond[:, least > largest] = 0.0
    if beyond.max(initial=0.0) > 0.0:
        k, i = np.unravel_index(int(beyond.argmax()), beyond.shape)
        limit, unit = float((least if q[k, i] < least[i] else largest)[i]), _units(model, i)[0]
        over, at = float(abs(q[k, i] - limit)), float(s[k])
        why = (
            f"{model.joint_names[i]} is at {q[k, i]:.6g} {unit} {_place(path, at)}, {over:.4g} {unit} beyond its limit"
        )
        raise InfeasibleError(f"{why} of {limit:g} {unit}", model, path, at, int(i), over, unit)


def _units(model: Model, i: Any) -> tuple[str, str]:
    return ("m", "N") if model.independent[i].kind == "prismatic" else ("rad", "N m")


def _place(path: Path, s: float) -> str:
    row = float(path.row(s))
    below = int(row + 1e-6)
    return f"at row {below}" if abs(row - round(row)) < 1e-6 else f"between rows {below} and {below + 1}"


def _fastest(along: Along) -> tuple[Floats, Floats]:
    """Return what is kept of limits (6, N, n) so that none is passed in between, and x (N + 1,) of the fastest pass."""
    x, before, settled = np.full(len(along.s), 0.01), np.inf, not along.bounds.bent
    kept = np.ones((JERK, len(along.steps), along.bounds.model.n))
    for _ in range(_ROUNDS):
        intervals = Intervals(along.rows(x, kept), along.steps, along.most(kept))
        if (free := np.isinf(intervals.p).all(axis=(1, 2))).any():
            raise _free(along.path, float(along.s[int(free.argmax())]))
        found, stuck = intervals.fastest()
        if stuck is not None:
            why = _stuck(along, stuck)
            if why.where["missing"] or x.max() < 1e-15:
                raise why
            x = x / 16.0  # friction that grows with speed is less at a lower one
            continue
        x, duration = found, _course(along, x).duration
        settled, before = settled or abs(duration - before) <= 1e-5 * duration, duration
        if settled:
            used = along.uses(x)
            if used.max() <= 1.0 + _NEAR:
                break
            kept = np.where(used > 1.0 + _ROUNDING, kept / (np.maximum(used, 1.0) * (1.0 + 10.0 * _ROUNDING)), kept)
    return kept, x


def _free(path: Path, s: float) -> InputError:
    what = f"nothing limits the acceleration of what moves {_place(path, s)}"
    return InputError(what, remedy="--acceleration A; the description gives no effort, the scene no motor")


def _course(along: Along, x: Floats, wait: float = 0.0) -> Course:
    """Return the course of a pass; between two legs it waits for so long, and for what the path's table says."""
    speed, u = np.sqrt(x), np.append(np.diff(x) / (2.0 * along.steps), 0.0)
    lasts, stops = 2.0 * along.steps / (speed[1:] + speed[:-1]), np.flatnonzero(along.still)
    rests = along.path.dwell.copy()
    rests[1:-1] += wait
    lasts = np.insert(lasts, stops, rests)
    leg = np.insert(along.leg, stops, np.maximum(np.arange(len(stops)) - 1, 0))  # each stop ends one, but for the first
    # each stop is twice among the knots: where the rest begins, and where it ends, but for the last
    s, speed = (np.insert(each, stops, each[stops])[:-1] for each in (along.s, speed))
    u = np.insert(u, stops, 0.0)[:-1]
    return Course(lasts, s, speed, u, np.zeros(len(u)), leg)


def _joined(path: Path, moves: list[Course]) -> Course:
    """Return moves from stop to stop one after another, and the waiting at the stops."""
    rest = np.zeros(1)
    first = Course(path.dwell[:1], path.stops[:1], rest, rest, rest, np.zeros(1, dtype=int))
    for move, wait in zip(moves, path.dwell[1:], strict=True):
        move.lasts[-1] = wait
    return Course(*(np.concatenate(parts) for parts in zip(first, *moves, strict=True)))


def _uses(bounds: Bounds, path: Path, course: Course, time: Floats, k: NDArray[np.int64]) -> Floats:
    """Return (7, ..., n) what a course uses of each limit at these times."""
    q, qd, qdd, qddd = course.states(path, time, k)
    return np.concatenate((bounds.uses(q, qd, qdd), (np.abs(qddd) / bounds.limits[JERK])[None]))


def _slack(used: Floats) -> float:
    """Return how many times slower a motion would keep its limits if torques grew with accelerations alone."""
    most = used.reshape(len(LIMITS), -1).max(axis=1, initial=0.0)
    most[[ACCELERATION, EFFORT, MOTOR_TORQUE, GEAR]] **= 0.5
    most[JERK] **= 1.0 / 3.0
    return float(most.max())


def _stuck(along: Along, k: int) -> InfeasibleError:
    """Return why no pass leads through interval k: the joint that cannot stand or creep on the path, if one cannot."""
    bounds, model, path = along.bounds, along.bounds.model, along.path
    families, zero = [EFFORT, MOTOR_TORQUE, GEAR], np.zeros_like(along.q)
    s = np.stack((along.s[:-1], along.s[1:]))
    for verb, slow in (("stand still", zero), ("creep against friction", zero + SLOWEST * along.way)):
        values, limits = bounds.values(along.q, slow, zero)
        used = (np.abs(values) / limits)[families]
        if used.max() > 1.0:
            which, end, at, i = (int(each) for each in np.unravel_index(int(used.argmax()), used.shape))
            share, needs, unit = float(used.max()), abs(float(values[EFFORT, end, at, i])), _units(model, i)[1]
            what, missing = LIMITS[families[which]], needs - needs / share
            why = f"{model.joint_names[i]} needs {needs:.6g} {unit} to {verb} {_place(path, s[end, at])}, and its limit"
            why += f" of {what} bears {needs / share:.6g} {unit}: {missing:.4g} {unit} are missing"
            return InfeasibleError(why, model, path, s[end, at], i, missing, unit)
    which, end, i = (int(each) for each in np.unravel_index(int(used[:, :, k].argmax()), used[:, :, k].shape))
    why = f"no speed keeps all limits {_place(path, along.s[k])}; the nearest to its own is {model.joint_names[i]}, "
    why += f"which uses {100.0 * used[which, end, k, i]:.3g} % of its limit of {LIMITS[families[which]]} at rest"
    return InfeasibleError(why, model, path, along.s[k], i, 0.0, _units(model, i)[1])


def _within_jerk(along: Along, kept: Floats, x: Floats) -> Course:
    """Return a course within the limits of jerk: the moving average of the fastest pass under limits that are lowered
    where it passes them, over the time that makes the shortest motion."""
    bounds, path, jerk = along.bounds, along.path, along.bounds.limits[JERK]
    first = _course(along, x)
    fastest = np.abs(first.states(path, *first.fine())[2]).max(axis=(0, 1))
    lone = 0.25 * np.cbrt(8.0 * fastest * first.duration**2 / jerk)  # where nothing else limits the motion
    width, best, shortest, since = 4.0 * float(np.minimum(fastest / jerk, lone).max()), first, np.inf, 0
    rests = np.flatnonzero(along.still) + np.arange(len(path.stops))
    while since < _TRIED and width > 0.0:
        width, softer, since = 0.5 * width, kept, since + 1
        limits = bounds.limits.copy()
        softest = np.minimum(fastest, width * jerk)
        limits[ACCELERATION] = np.minimum(limits[ACCELERATION], np.maximum(softest, 1e-9 * softest.max()))
        along.bounds = replace(bounds, limits=limits)
        for _ in range(_SOFTER):
            found, stuck = Intervals(along.rows(x, softer), along.steps, along.most(softer)).fastest()
            if stuck is not None:
                break
            x = found
            hard = _course(along, x, width)
            soft = hard.averaged(width)
            used = _uses(bounds, path, soft, *soft.fine(2))
            if (duration := soft.duration * max(1.0, _slack(used))) < shortest:
                shortest, best, since = duration, soft, 0
            used = used.max(axis=1)
            used[ACCELERATION] = np.maximum(used[ACCELERATION], used[JERK])
            begin = soft.knot(hard.time[:-1])
            end = np.clip(np.searchsorted(soft.time, hard.time[1:] + width), begin + 1, len(soft.lasts) - 1)
            over = np.maximum.reduceat(used[:JERK], np.column_stack((begin, end)).ravel(), axis=1)[:, ::2]
            softer = softer / np.delete(np.maximum(over, 1.0), rests, axis=1)
    return best


def _move(bounds: Bounds, path: Path, k: int, profile: str) -> Course:
    """Return the move along a straight piece: speed grows evenly, stays, falls; with the largest acceleration, up to
    that given, at which torques and motors keep their limits, and slower where they do not at any.

    Source: Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots (2008), 3.2 and 3.4; an
    S-curve is the moving average of a trapezoid, over the time of its jerk.
    """
    from scipy.optimize import brentq

    length, way = float(path.breaks[k + 1] - path.breaks[k]), np.abs(path.c[1, k])
    with np.errstate(divide="ignore"):
        fast, sharp, jerk = (float((each / way).min()) for each in (bounds.speed, *bounds.limits[[ACCELERATION, JERK]]))

    def course(a: float, v: float) -> Course:
        j = jerk
        if profile == "scurve" and np.isinf(j):
            j = a * a / (RAMP * min(v, float(np.sqrt(length * a / (1.0 + RAMP)))))
        # the acceleration is reached, and the speed lasts as long as the jerk, at least
        a = min(a, float(np.cbrt(0.5 * j * j * length)))
        v = min(v, 0.5 * a * (float(np.hypot(a / j, 2.0 * np.sqrt(length / a))) - a / j))
        a = min(a, float(np.sqrt(v * j)))
        rise = v / a
        lasts = np.array([rise, max(length / v - rise, 0.0), rise, 0.0])
        s = path.breaks[k] + np.array([0.0, 0.5 * v * rise, length - 0.5 * v * rise, length])
        u, leg = np.array([a, 0.0, -a, 0.0]), np.full(4, k)
        return Course(lasts, s, np.array([0.0, v, v, 0.0]), u, np.zeros(4), leg).averaged(a / j)

    def slack(a: float, v: float) -> float:
        one = course(a, v)
        return float(_uses(bounds, path, one, *one.fine(64))[EFFORT:JERK].max()) - 1.0

    if not np.isfinite(sharp) and not np.isfinite(bounds.limits[EFFORT]).any() and not bounds.trains:
        raise _free(path, float(path.breaks[k]))
    high, v = (sharp, fast) if np.isfinite(sharp) else (1e8 * length, min(fast, 1e4 * length))
    if slack(high, v) <= 0.0:
        return course(high, v)
    low, slowest = 1e-12 * high, 1e-6 * v
    while v > slowest and slack(low, v) > 0.0:
        v *= 0.7
    if v <= slowest:
        raise _stuck(Along(bounds, path, np.linspace(path.breaks[k], path.breaks[k + 1], 200)), 0)
    return course(float(np.exp(brentq(lambda e: slack(np.exp(e), v), np.log(low), np.log(high), xtol=1e-10))), v)


def _settled(bounds: Bounds, path: Path, course: Course, rate: float) -> tuple[Course, Floats, Floats]:
    """Return the course, slower by what its limits are passed by, times of rows, and what they use of limits; raise if
    that does not end."""
    slack = np.inf
    for turn in range(1, 100):
        samples = max(int(np.ceil(course.duration * rate - 1e-9)) + 1, 2)
        if samples > MOST_SAMPLES:
            what = f"the motion takes {course.duration:.6g} s, {float(samples):.6g} rows"
            raise InputError(what, remedy=f"--rate of fewer rows per second, {MOST_SAMPLES} at most")
        time = np.linspace(0.0, course.duration, samples)
        used = _uses(bounds, path, course, time, course.knot(time))
        slack = max(_slack(used), _slack(_uses(bounds, path, course, *course.fine())))
        if slack <= 1.0 + PASSED / 4.0:
            return course, time, used
        course = course.slower(1.0 + turn * (slack - 1.0) + _ROUNDING)  # torques may hardly depend on the time
    what = f"a limit is passed by {100 * (slack - 1.0):.2g} % between points of the grid"
    raise InputError(what, remedy="--grid of more intervals")


def _result(bounds: Bounds, path: Path, course: Course, rate: float, profile: str) -> Retimed:
    """Sample a course, and say what binds."""
    names, n = bounds.model.joint_names, bounds.model.n
    course, time, used = _settled(bounds, path, course, rate)
    k = course.knot(time)
    q, qd, qdd, _ = course.states(path, time, k)
    tau = bounds.values(q, qd, qdd)[0][EFFORT]
    flat = np.ascontiguousarray(used.transpose(1, 0, 2).reshape(len(time), -1))
    leads = np.where(flat.max(axis=1) < BINDS, -1, first_of_ties(flat))
    shares = [Binding(names[f % n], LIMITS[f // n], float((leads == f).mean())) for f in range(flat.shape[1])]
    binding = ranked((one for one in shares if one.share_of_time > 0.0), lambda one: one.share_of_time)
    use = [{LIMITS[f]: float(used[f, :, i].max()) for f in np.flatnonzero(used[:, :, i].any(axis=1))} for i in range(n)]
    return Retimed(
        bounds.model,
        bounds.scene,
        profile,
        path,
        bounds.limits,
        time=time,
        q=q,
        qd=qd,
        qdd=qdd,
        tau=tau,
        row=path.row(course.at(time, k)[0]),
        binding=tuple(binding),
        joints=tuple(map(JointUse, names, use)),
        used=used,
        warnings=tuple(_continuous(bounds, qd, qdd, tau)),
    )


def _continuous(bounds: Bounds, qd: Floats, qdd: Floats, tau: Floats) -> Iterator[str]:
    """Yield what is said of motors whose RMS torque is above their continuous curves, if the motion is repeated."""
    for i, train in bounds.trains:
        torque = motor_torque(train, load_torque(train, tau[:, i], qdd[:, i]), qd[:, i], qdd[:, i])
        rms, mean = float(np.sqrt(np.mean(torque**2))), float(np.mean(np.abs(train.gear * qd[:, i])))
        if rms > (may := float(allowed(train.motor.continuous, mean))):
            what = f"{bounds.model.joint_names[i]}: if this is repeated, its motor's RMS torque of {rms:.4g} N m"
            yield f"{what} is above the {may:.4g} N m of its continuous curve (a dwell, or --speed, lessens it)"
