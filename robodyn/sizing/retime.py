"""A path in the shortest time that a robot's limits allow, or as drives go from point to point: `robodyn retime`.

1. `path.py` reads way-points and leads a curve through them.
2. `along.py` says what limits speed and acceleration along it, by the recursion and the motors' data sheets.
3. `reachability.py` finds the fastest pass of lines; here these are taken anew about each pass until it stays, then
   limits are checked exactly between grid points, and lowered where they are passed, until none is.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robodyn.errors import InputError
from robodyn.loads.sizing import allowed, load_torque, motor_torque
from robodyn.robot.limits import coordinate_ranges
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.sizing.along import (
    ACCELERATION,
    EFFORT,
    GEAR,
    JERK,
    LIMITS,
    MOTOR_TORQUE,
    VELOCITY,
    Along,
    Bounds,
    PerJoint,
    bounds_of,
    check_supported,
)
from robodyn.sizing.path import Path, WayPoints, lines, read_path, spline
from robodyn.sizing.reachability import Intervals
from robodyn.support.floats import Floats, first_of_ties
from robodyn.support.wording import count, shown

Profile = Literal["optimal", "trapezoid", "scurve"]
PROFILES = ("optimal", "trapezoid", "scurve")
GRID, RATE = 2000, 250.0
MOST_GRID, MOST_SAMPLES = 50_000, 2_000_000
FINE = 10
"""Parts of each interval of the grid at whose ends limits are checked."""
PASSED = 1e-9
"""Of a limit: what it may be passed by."""
BINDS = 0.995
"""Of a limit, from which on it is said to bind."""
_ROUNDS, _SAME, _NARROW = 40, 1e-9, 1e-12
RAMP = 0.25
"""Of the time of speeding up that the acceleration of an S-curve takes to grow where no jerk is given, and to fall."""


class Course(NamedTuple):
    """s(t) of polynomials of the third degree: when K of them begin, and the last ends (K + 1,) [s]; s, sd, sdd there,
    sddd (K,), and the piece of the path that each is on."""

    time: Floats
    s: Floats
    speed: Floats
    u: Floats
    jerk: Floats
    piece: NDArray[np.int64]

    def at(self, time: Floats, k: NDArray[np.int64]) -> tuple[Floats, Floats, Floats, Floats]:
        """Return s and its derivatives at these times, by polynomials k."""
        t, j = time - self.time[k], self.jerk[k]
        u = self.u[k] + j * t
        sd = self.speed[k] + t * (self.u[k] + t * (j / 2.0))
        s = self.s[k] + t * (self.speed[k] + t * (self.u[k] / 2.0 + t * (j / 6.0)))
        return s, np.maximum(sd, 0.0), u, j

    def slower(self, factor: float) -> Course:
        """Return the same in `factor` times the time."""
        f = 1.0 / factor
        return Course(factor * self.time, self.s, f * self.speed, f * f * self.u, f * f * f * self.jerk, self.piece)


@dataclass(frozen=True)
class Binding:
    """A limit of a joint, and the share of the time in which it is the one that binds."""

    joint: str
    limit: str
    share_of_time: float


@dataclass(frozen=True)
class JointUse:
    """What a joint uses at most of each of its limits, 1 at the limit, and when [s]; limits that it has not are left
    out."""

    name: str
    use: Mapping[str, float]
    at: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Retimed:
    """A path in time.

    Attributes:
        feasible: whether a motion keeps all limits; if not, `reason` says which joint fails where, and by how much.
        profile: "optimal", "trapezoid" or "scurve"; points: the way-points; grid: intervals of the path.
        time: (N,) [s]; q, qd, qdd, tau: (N, n); row: (N,) where on the path, as rows of its table.
        binding: which limits bind, the most frequent first; joints: what each uses of its limits.
        used: (7, N, n) what is used of each of `LIMITS` at the samples; 0 where there is none.
        most: row, and the largest speed that any limit allows there [1/s of row], of the optimal profile.
        unlimited: the shortest duration without the limits of jerk [s], if there are some.
    """

    model: Model
    scene: Scene
    feasible: bool
    reason: str
    profile: str
    path: Path
    grid: int
    time: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    tau: Floats
    row: Floats
    binding: tuple[Binding, ...]
    joints: tuple[JointUse, ...]
    used: Floats
    limits: Floats
    most: tuple[Floats, Floats]
    unlimited: float | None
    warnings: tuple[str, ...]
    where: Mapping[str, Any] = field(default_factory=dict)

    @property
    def duration(self) -> float:
        return float(self.time[-1]) if len(self.time) else 0.0

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

    def __init__(self, why: str, **where: Any) -> None:
        super().__init__(why)
        self.where = where


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
    refuse_others(model, scene)
    check_supported(model, scene)
    _check(profile, speed, blend, rate, grid, jerk)
    bounds = bounds_of(model, scene, acceleration, jerk, speed)
    points = read_path(path, model, scene, **reading)
    warnings: list[str] = []
    unlimited = None
    if profile != "optimal" or blend is not None:
        way, narrow = lines(points, blend or 0.0, stopping=profile != "optimal")
        if narrow:
            warnings.append(f"{count(narrow, 'corner')} rounded from less than {blend:g}: half of the way to the next")
    else:
        way = spline(points)
    most: tuple[Floats, Floats] = (np.zeros(0), np.zeros(0))
    intervals = 0
    try:
        _check_range(model, way, grid)
        if profile == "optimal":
            along = Along(bounds, way, way.grid(max(grid, len(way.breaks) - 1)))
            course, most = _fastest(along, warnings)
            intervals = len(along.steps)
            if np.isfinite(bounds.jerk).any():
                from robodyn.sizing.jerk import within_jerk

                unlimited = float(course.time[-1])
                course = within_jerk(along, course)
        else:
            course = _point_to_point(bounds, way, points, profile)
    except InfeasibleError as why:
        empty = np.zeros((0, model.n))
        return Retimed(
            *(model, scene, False, str(why), profile, way, intervals, np.zeros(0), empty, empty, empty, empty),
            *(np.zeros(0), (), (), np.zeros((len(LIMITS), 0, model.n)), bounds.limits, most, None, tuple(warnings)),
            why.where,
        )
    return _result(bounds, way, course, rate, profile, intervals, most, unlimited, warnings)


def _check(profile: str, speed: float, blend: float | None, rate: float, grid: int, jerk: Any) -> None:
    wrong = [
        (profile not in PROFILES, f"no profile {shown(profile)}", f"one of {', '.join(PROFILES)}"),
        (not 0.0 < speed <= 1.0, f"speed is {100 * speed:g} %", "more than 0 %, at most 100 % of the velocity limits"),
        (blend is not None and not 0.0 <= blend < np.inf, f"blend is {blend}", "0 or more"),
        (blend is not None and profile != "optimal", f"--blend goes with optimal: {profile} stops at way-points", "-"),
        (jerk is not None and profile == "trapezoid", "a trapezoid has no limit of jerk", "--profile scurve"),
        (not 0.0 < rate < np.inf, f"rate is {rate:g}", "rows per second, positive"),
        (not 10 <= grid <= MOST_GRID, f"a grid of {grid} intervals", f"10 to {MOST_GRID}"),
    ]
    for holds, what, remedy in wrong:
        if holds:
            raise InputError(what, remedy=None if remedy == "-" else remedy)


def _check_range(model: Model, path: Path, grid: int) -> None:
    """Raise if a joint leaves its range."""
    least, largest = coordinate_ranges(model)
    s = path.grid(grid)
    q = path.at(s, path.pieces(s))[0]
    beyond = np.maximum(least - q, q - largest) - 1e-9 * np.maximum(1.0, np.abs(q))
    beyond[:, least > largest] = 0.0
    if beyond.max(initial=0.0) > 0.0:
        k, i = np.unravel_index(int(beyond.argmax()), beyond.shape)
        name, joint = model.joint_names[i], model.independent[i]
        unit, limit = ("m" if joint.kind == "prismatic" else "rad"), (least if q[k, i] < least[i] else largest)[i]
        over = float(abs(q[k, i] - limit))
        why = f"{name} is at {q[k, i]:.6g} {unit} {_place(path, float(s[k]))}, {over:.4g} {unit} beyond its limit"
        raise InfeasibleError(
            f"{why} of {limit:g} {unit}", joint=name, row=float(path.row(s[k])), missing=over, unit=unit
        )


def _place(path: Path, s: float) -> str:
    row = float(path.row(s))
    below = int(row + 1e-6)
    return f"at row {below}" if abs(row - round(row)) < 1e-6 else f"between rows {below} and {below + 1}"


def _fastest(along: Along, warnings: list[str]) -> tuple[Course, tuple[Floats, Floats]]:
    """Return the fastest course; and rows, with the largest speed that any limit allows there."""
    bounds, n = along.bounds, len(along.steps)
    kept = np.ones((JERK, n, bounds.model.n))
    x, before, settled = np.zeros(n + 1), np.inf, not along.bent
    slack = 1.0
    for turn in range(_ROUNDS):
        intervals = Intervals(along.rows(x, kept), along.steps, along.most(kept))
        found = intervals.fastest()
        if found.stuck is not None:
            raise _stuck(along, found.stuck, found.x)
        if turn == 0:
            _check_limited(along, intervals)
        x = found.x
        used = _fine_uses(along, x).max(axis=1)
        worst, duration = float(used.max()), _duration(along, x)
        if worst <= 1.0 + _NARROW * 1e2 and (settled or abs(duration - before) <= _SAME * duration):
            break
        settled = settled or abs(duration - before) <= 1e-5 * duration
        if settled:
            kept = np.where(used > 1.0 + _NARROW, kept / (np.maximum(used, 1.0) * (1.0 + _NARROW * 10)), kept)
        before = duration
    row = along.path.row(along.s)
    with np.errstate(divide="ignore", invalid="ignore"):
        top = np.sqrt(np.where(np.isfinite(intervals.high), intervals.high, np.nan))
    course = _course(along, x)
    for _ in range(60):
        if worst <= 1.0 + PASSED / 2:
            break
        slack *= 1.0 + max(worst - 1.0, PASSED)
        used = _fine_uses(along, x / slack**2).max(axis=1)
        worst = float(used.max())
    else:
        warnings.append(
            f"a limit is passed by {100 * (worst - 1.0):.2g} % between points of the grid: give --grid more"
        )
    return course.slower(slack) if slack > 1.0 else course, (row[:-1], top)


def _duration(along: Along, x: Floats) -> float:
    speed = np.sqrt(x)
    return float((2.0 * along.steps / (speed[1:] + speed[:-1])).sum())


def _fine_uses(along: Along, x: Floats) -> Floats:
    """Return (6, FINE + 1, N, n) what is used of each limit along each interval."""
    part = np.linspace(0.0, 1.0, FINE + 1)[:, None]
    u = np.diff(x) / (2.0 * along.steps)
    s = along.s[:-1] + part * along.steps
    sd = np.sqrt(np.maximum(x[:-1] + part * np.diff(x), 0.0))
    q, first, second, _ = along.path.at(s, np.broadcast_to(along.piece, s.shape))
    qd, qdd = first * sd[..., None], first * u[:, None] + second * (sd * sd)[..., None]
    return along.bounds.uses(q, qd, qdd)[0]


def _course(along: Along, x: Floats) -> Course:
    """Return the course of a pass, and of waiting where it stops."""
    speed = np.sqrt(x)
    steps = 2.0 * along.steps / (speed[1:] + speed[:-1])
    u = np.diff(x) / (2.0 * along.steps)
    s, piece = along.s[:-1], along.piece
    waits = {
        int(np.abs(along.s - at).argmin()): wait for at, wait in zip(along.path.stops, along.path.dwell, strict=True)
    }
    at = np.array([k for k, wait in waits.items() if wait > 0.0], dtype=int)
    dwell = np.array([waits[k] for k in at])
    kind = np.minimum(at, len(u) - 1)
    u, steps = np.insert(u, at, 0.0), np.insert(steps, at, dwell)
    s, piece = np.insert(s, at, along.s[at]), np.insert(piece, at, along.piece[kind])
    v = np.insert(speed[:-1], at, 0.0)
    time = np.concatenate(([0.0], np.cumsum(steps)))
    return Course(time, np.append(s, along.s[-1]), np.append(v, 0.0), np.append(u, 0.0), np.zeros(len(u)), piece)


def _check_limited(along: Along, intervals: Intervals) -> None:
    """Raise if nothing limits the speed or the acceleration of what moves."""
    free = ~np.isfinite(intervals.p).any(axis=2)
    if free.all(axis=1).any():
        where = _place(along.path, float(along.s[int(free.all(axis=1).argmax())]))
        what = f"nothing limits the acceleration of the joints that move {where}"
        raise InputError(what, remedy="--acceleration A; the description gives them no effort, the scene no motor")


def _stuck(along: Along, k: int, x: Floats) -> InfeasibleError:
    """Return why no pass leads through interval k: the joint that cannot even stand there, if one cannot."""
    bounds, model = along.bounds, along.bounds.model
    zero = np.zeros_like(along.ends.q)
    used, tau = bounds.uses(along.ends.q, zero, zero)
    rub = np.abs(along.friction(np.zeros(zero.shape[:2]))[0])
    worst = used[[EFFORT, MOTOR_TORQUE, GEAR]]
    if worst.max() > 1.0:
        which, end, at, i = (int(each) for each in np.unravel_index(int(worst.argmax()), worst.shape))
        what, share = LIMITS[(EFFORT, MOTOR_TORQUE, GEAR)[which]], float(worst[which, end, at, i])
        name, place = model.joint_names[i], _place(along.path, float(along.ends.s[end, at]))
        unit = "N" if model.independent[i].kind == "prismatic" else "N m"
        needs = abs(float(tau[end, at, i]))
        missing = needs - needs / share
        why = f"{name} needs {needs:.6g} {unit} to stand still {place}, and its limit of {what} bears "
        why += f"{needs / share:.6g} {unit}: {missing:.4g} {unit} are missing"
        return InfeasibleError(
            why, joint=name, row=float(along.path.row(along.ends.s[end, at])), missing=missing, unit=unit
        )
    place = _place(along.path, float(along.s[k]))
    share = (np.abs(tau) + rub) / bounds.limits[EFFORT]
    i = int(share[:, k].max(axis=0).argmax())
    name, unit = model.joint_names[i], "N" if model.independent[i].kind == "prismatic" else "N m"
    needs, limit = float(np.abs(tau)[:, k, i].max() + rub[:, k, i].max()), float(bounds.limits[EFFORT, i])
    why = f"no speed keeps all limits {place}: {name} has {limit - needs:.4g} {unit} of {limit:g} left to move with"
    return InfeasibleError(
        why, joint=name, row=float(along.path.row(along.s[k])), missing=max(needs - limit, 0.0), unit=unit
    )


class Move(NamedTuple):
    """A straight move over 1: times of the jerk, of speeding up, and at full speed; and the largest acceleration."""

    ramp: float
    rise: float
    cruise: float
    most: float

    def knots(self) -> tuple[list[float], list[float]]:
        """Return the durations and the jerks of its seven parts, those of trapezoids without jerk."""
        j = self.most / self.ramp if self.ramp > 0.0 else 0.0
        flat = self.rise - 2.0 * self.ramp
        return [self.ramp, flat, self.ramp, self.cruise, self.ramp, flat, self.ramp], [j, 0, -j, 0, -j, 0, j]


def move(length: float, v: float, a: float, j: float | None, ramp: float = 0.0) -> Move:
    """Return the fastest move from rest to rest over a length within speed v, acceleration a and jerk j; without j the
    acceleration takes the share `ramp` of speeding up to grow, and to fall: 0 is a trapezoid.

    Source: Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots (2008), 3.2 and 3.4.
    """
    if j is None:
        mean = a * (1.0 - ramp)  # acceleration while speeding up
        v = min(v, float(np.sqrt(length * mean)))
        rise = v / mean
        return Move(ramp * rise, rise, length / v - rise, a)
    if v * j < a * a:
        a = float(np.sqrt(v * j))
    if v * (v / a + a / j) > length:
        if length >= 2.0 * a**3 / j**2:
            rise = a / (2.0 * j) + float(np.sqrt((a / (2.0 * j)) ** 2 + length / a))
        else:
            a = float(np.cbrt(length * j * j / 2.0))
            rise = 2.0 * a / j
        return Move(a / j, rise, 0.0, a)
    rise = a / j + v / a
    return Move(a / j, rise, length / v - rise, a)


def _of_move(path: Path, k: int, one: Move) -> Course:
    """Return the course of a move along a straight piece."""
    steps, jerks = one.knots()
    time, s, speed, u = [0.0], [float(path.breaks[k])], [0.0], [0.0 if one.ramp > 0.0 else one.most]
    for number, (t, j) in enumerate(zip(steps, jerks, strict=True)):
        begin = u[-1]
        if one.ramp == 0.0:
            begin = (one.most, one.most, one.most, 0.0, -one.most, -one.most, -one.most)[number]
            u[-1] = begin
        time.append(time[-1] + t)
        s.append(s[-1] + t * (speed[-1] + t * (begin / 2.0 + t * j / 6.0)))
        speed.append(speed[-1] + t * (begin + t * j / 2.0))
        u.append(begin + j * t)
    s[-1], speed[-1] = float(path.breaks[k + 1]), 0.0
    parts = (np.array(each) for each in (time, s, np.maximum(speed, 0.0), u, jerks))
    return Course(*parts, np.full(7, k))


def _uses_of(bounds: Bounds, path: Path, courses: list[Course], parts: int) -> Floats:
    """Return (C, 6, n) what courses use at most of each limit, each of their pieces looked at in so many parts."""
    lengths = [len(course.jerk) for course in courses]
    states = []
    for course in courses:
        k = np.repeat(np.arange(len(course.jerk)), parts + 1)
        time = course.time[k] + np.tile(np.linspace(0.0, 1.0, parts + 1), len(course.jerk)) * np.diff(course.time)[k]
        states.append(_states(path, course, time, k)[:3])
    q, qd, qdd = (np.concatenate(each) for each in zip(*states, strict=True))
    used = bounds.uses(q, qd, qdd)[0]
    ends = np.cumsum([0, *(length * (parts + 1) for length in lengths)])[:-1]
    return np.asarray(np.maximum.reduceat(used, ends, axis=1).transpose(1, 0, 2))


def _states(path: Path, course: Course, time: Floats, k: NDArray[np.int64]) -> tuple[Floats, Floats, Floats, Floats]:
    """Return q, qd, qdd and qddd (N, n) at these times, by polynomials k of a course."""
    s, sd, u, j = (each[:, None] for each in course.at(time, k))
    q, first, second, third = path.at(s[:, 0], course.piece[k])
    return q, first * sd, first * u + second * sd * sd, first * j + 3.0 * second * sd * u + third * sd**3


def _point_to_point(bounds: Bounds, path: Path, points: WayPoints, profile: str) -> Course:
    """Return the moves from way-point to way-point, each as quick as limits of speed and acceleration, and torques,
    allow."""
    courses: list[Course] = []
    now = 0.0
    for k in range(len(path.breaks) - 1):
        for wait in path.dwell[k : k + 1] if path.dwell[k] > 0.0 else ():
            rest = np.array((now, now + wait)), np.full(2, path.breaks[k]), np.zeros(2), np.zeros(2), np.zeros(1)
            courses.append(Course(*rest, np.array([min(k, len(path.breaks) - 2)])))
            now += float(wait)
        one = _quickest(bounds, path, k, profile)
        courses.append(one._replace(time=one.time + now))
        now = float(courses[-1].time[-1])
    if path.dwell[-1] > 0.0:
        end, last = np.full(2, path.breaks[-1]), np.array((now, now + path.dwell[-1]))
        courses.append(Course(last, end, np.zeros(2), np.zeros(2), np.zeros(1), np.array([len(path.breaks) - 2])))
    heads = [np.concatenate([each[part][:-1] for each in courses]) for part in range(4)]
    ends = [np.append(head, courses[-1][part][-1]) for part, head in enumerate(heads)]
    return Course(*ends, *(np.concatenate([each[part] for each in courses]) for part in (4, 5)))


def _quickest(bounds: Bounds, path: Path, k: int, profile: str) -> Course:
    """Return the quickest move along piece k of straight lines: with the largest acceleration, up to that given, at
    which torques and motors keep their limits; slower, where they do not at any."""
    length, way = float(path.breaks[k + 1] - path.breaks[k]), np.abs(path.c[1, k])
    with np.errstate(divide="ignore"):
        speed = bounds.velocity.copy()
        for i, _ in bounds.trains:
            speed[i] = min(speed[i], bounds.motor_speed[i])
        v, a, j = (float((each / way).min()) for each in (speed, bounds.acceleration, bounds.jerk))
    sharp = None if profile == "trapezoid" or not np.isfinite(j) else j
    ramp = RAMP if profile == "scurve" else 0.0

    def moves(accelerations: Floats, v: float) -> list[Course]:
        return [_of_move(path, k, move(length, v, float(each), sharp, ramp)) for each in accelerations]

    def worst(accelerations: Floats, v: float, parts: int = 32) -> Floats:
        used = _uses_of(bounds, path, moves(accelerations, v), parts)
        used[:, VELOCITY : ACCELERATION + 1] = 0.0
        return np.asarray(used.max(axis=(1, 2)))

    largest = a if np.isfinite(a) else 1e8 * length
    if np.isfinite(a) and worst(np.array([a]), v, 320)[0] <= 1.0:
        return moves(np.array([a]), v)[0]
    limited = np.isfinite(bounds.effort) | np.isin(np.arange(len(way)), [i for i, _ in bounds.trains])
    if not np.isfinite(a) and not limited.any():
        what = f"nothing limits the acceleration {_place(path, float(path.breaks[k]))}"
        raise InputError(what, remedy="--acceleration A; the description gives no effort, the scene no motor")
    for _ in range(60):
        tried = largest * np.geomspace(1e-12, 1.0, 41)
        good = worst(tried, v) <= 1.0
        if good[0]:
            break
        v = 0.7 * (v if np.isfinite(v) else 1e4 * length)
    else:
        s = np.linspace(path.breaks[k], path.breaks[k + 1], 200)
        raise _stuck(Along(bounds, path, s), 0, np.zeros(0))
    for _ in range(8):
        if good.all():
            break
        first = int(np.argmin(good))
        tried = np.linspace(tried[first - 1], tried[first], 17)
        good = worst(tried, v) <= 1.0
    found = float(tried[-1] if good.all() else tried[max(int(np.argmin(good)) - 1, 0)])
    for _ in range(60):
        over = float(worst(np.array([found]), v, 320)[0])
        if over <= 1.0 + PASSED / 2:
            break
        found *= 1.0 - 2.0 * max(over - 1.0, PASSED)
    return moves(np.array([found]), v)[0]


def _result(
    bounds: Bounds,
    path: Path,
    course: Course,
    rate: float,
    profile: str,
    grid: int,
    most: Any,
    unlimited: float | None,
    warnings: list[str],
) -> Retimed:
    """Sample a course, and say what binds."""
    model, names = bounds.model, bounds.model.joint_names
    limits = np.vstack((bounds.limits, bounds.jerk))
    for _ in range(20):
        samples = int(np.ceil(course.time[-1] * rate - 1e-9)) + 1
        if samples > MOST_SAMPLES:
            what = f"the motion takes {course.time[-1]:.6g} s, {samples} rows"
            raise InputError(what, remedy=f"--rate of fewer rows per second, {MOST_SAMPLES} at most")
        time = np.linspace(0.0, course.time[-1], max(samples, 2))
        k = np.clip(np.searchsorted(course.time, time, side="right") - 1, 0, len(course.jerk) - 1)
        q, qd, qdd, qddd = _states(path, course, time, k)
        qd[[0, -1]] = 0.0
        used, tau = bounds.uses(q, qd, qdd)
        over = float(used.max(initial=0.0))
        if over <= 1.0 + PASSED / 2:
            break
        course = course.slower(1.0 + max(over - 1.0, PASSED))
    used = np.concatenate((used, (np.abs(qddd) / bounds.jerk)[None]))
    s = course.at(time, k)[0]
    flat = np.ascontiguousarray(used.transpose(1, 0, 2).reshape(len(time), -1))
    leads = first_of_ties(flat)
    leads[flat.max(axis=1) < BINDS] = -1
    found = []
    for each in range(flat.shape[1]):
        share = float((leads == each).mean())
        if share > 0.0:
            found.append(Binding(names[each % model.n], LIMITS[each // model.n], share))
    found.sort(key=lambda one: -one.share_of_time)
    joints = []
    for i, name in enumerate(names):
        own = [f for f in range(len(LIMITS)) if used[f, :, i].any() or np.isfinite(limits[f, i])]
        use = {LIMITS[f]: float(used[f, :, i].max()) for f in own}
        joints.append(JointUse(name, use, {LIMITS[f]: float(time[first_of_ties(used[f, None, :, i])[0]]) for f in own}))
    return Retimed(
        *(model, bounds.scene, True, "", profile, path, grid, time, q, qd, qdd, tau, path.row(s)),
        *(
            tuple(found),
            tuple(joints),
            used,
            limits,
            most,
            unlimited,
            (*warnings, *_continuous(bounds, time, qd, qdd, tau)),
        ),
    )


def _continuous(bounds: Bounds, time: Floats, qd: Floats, qdd: Floats, tau: Floats) -> list[str]:
    """Return what is said of motors whose RMS torque is above their continuous curves, if the motion is repeated."""
    lines = []
    for i, train in bounds.trains:
        if train.motor.continuous is None or time[-1] <= 0.0:
            continue
        torque = motor_torque(train, load_torque(train, tau[:, i], qdd[:, i]), qd[:, i], qdd[:, i])
        rms = float(np.sqrt(np.trapezoid(torque * torque, time) / time[-1]))
        mean = float(np.trapezoid(np.abs(train.gear * qd[:, i]), time) / time[-1])
        may = float(allowed(train.motor.continuous, mean))
        if rms > may:
            name = bounds.model.joint_names[i]
            what = (
                f"{name}: repeated without a pause, its motor's RMS torque of {rms:.4g} N m is above the {may:.4g} N m"
            )
            lines.append(f"{what} of its continuous curve (a dwell, or --speed, lessens it)")
    return lines
