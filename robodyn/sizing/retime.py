"""A path in the shortest time that a robot's limits allow, or as drives go from point to point: `robodyn retime`.

1. `path.py` reads way-points and leads a curve through them.
2. `along.py` says what limits speed and acceleration along it, by the recursion and the motors' data sheets.
3. `reachability.py` finds the fastest pass of lines; here these are taken anew about each pass until it stays, then
   limits are checked exactly between grid points, and lowered where they are passed, until none is.
4. A limit of jerk is kept as drives do: a moving average of the place on the path, over some time.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, NamedTuple

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
    SLOWEST,
    Along,
    Bounds,
    PerJoint,
    bounds_of,
    check_supported,
)
from robodyn.sizing.path import Path, lines, read_path, spline
from robodyn.sizing.reachability import Intervals
from robodyn.support.floats import Floats, first_of_ties, ranked
from robodyn.support.wording import shown

PROFILES = ("optimal", "trapezoid", "scurve")
GRID, RATE = 2000, 250.0
MOST_GRID, MOST_SAMPLES = 50_000, 2_000_000
FINE = 10
"""Parts of each interval of the grid at whose ends limits are checked."""
PASSED, BINDS = 1e-9, 0.995
"""Of a limit: what it may be passed by, and from where on it is said to bind."""
RAMP = 0.25
"""Of the time of speeding up: that over which an S-curve's acceleration grows, where no jerk is given."""
_ROUNDS, _SAME, _ROUNDING = 40, 1e-9, 1e-12
_TRIED, _SOFTER = 2, 4
"""Widths of moving averages that are tried behind the best, and how often accelerations are lowered for each."""
MOST_STOPS = 500
"""Way-points from stop to stop; a path of more is followed in one go."""


class Course(NamedTuple):
    """s(t) of polynomials of the third degree: when K of them begin, and the last ends (K + 1,) [s]; s, sd, sdd there,
    sddd (K,), and the piece of the path that each is on. `u[k]` is sdd after knot k; the last is not used."""

    time: Floats
    s: Floats
    speed: Floats
    u: Floats
    jerk: Floats
    piece: NDArray[np.int64]

    def at(self, time: Floats, k: NDArray[np.int64]) -> tuple[Floats, Floats, Floats, Floats]:
        """Return s and its derivatives at these times, by polynomials k."""
        t, j = time - self.time[k], self.jerk[k]
        s = self.s[k] + t * (self.speed[k] + t * (self.u[k] / 2.0 + t * (j / 6.0)))
        sd = self.speed[k] + t * (self.u[k] + t * (j / 2.0))
        return s, np.where(sd > _ROUNDING * self.speed.max(), sd, 0.0), self.u[k] + j * t, j

    def knot(self, time: Floats) -> NDArray[np.int64]:
        """Return by which polynomials these times are."""
        return np.clip(np.searchsorted(self.time, time, side="right") - 1, 0, len(self.jerk) - 1)

    def slower(self, factor: float) -> Course:
        """Return the same in `factor` times the time."""
        f = 1.0 / factor
        return Course(factor * self.time, self.s, f * self.speed, f * f * self.u, f * f * f * self.jerk, self.piece)

    def states(self, path: Path, time: Floats, k: NDArray[np.int64]) -> tuple[Floats, Floats, Floats, Floats]:
        """Return q, qd, qdd and qddd (..., n) at these times, by polynomials k."""
        s, sd, u, j = self.at(time, k)
        q, first, second, third = path.at(s, np.where(self.piece[k] < 0, path.pieces(s), self.piece[k]))
        sd, u, j = (each[..., None] for each in (sd, u, j))
        return q, first * sd, first * u + second * sd * sd, first * j + 3.0 * second * sd * u + third * sd**3

    def fine(self, parts: int = FINE) -> tuple[Floats, NDArray[np.int64]]:
        """Return times (parts + 1, K) in all polynomials, and the numbers of these."""
        time = self.time[:-1] + _inside(self.speed, parts) * np.diff(self.time)
        return time, np.broadcast_to(np.arange(len(self.jerk)), time.shape)

    def averaged(self, width: float) -> Course:
        """Return the moving average of s over this time, of a course without jerk that begins and ends at rest, which
        takes it longer: `sdd(t) = (sd(t) - sd(t - width)) / width`; the same where the width is 0."""
        if width <= 0.0:
            return self
        knots = np.sort(np.concatenate((self.time, self.time + width)))
        knots = knots[np.append(True, np.diff(knots) > 1e-7 * width)]  # those that rounding alone parts are one
        now, then = (np.interp(knots - late, self.time, self.speed) for late in (0.0, width))
        u, steps = (now - then) / width, np.diff(knots)
        jerk = np.diff(u) / steps
        speed = np.concatenate(([0.0], np.cumsum(0.5 * steps * (u[1:] + u[:-1])))).clip(0.0)
        ways = steps * (speed[:-1] + steps * (u[:-1] / 2.0 + steps * jerk / 6.0))
        s = self.s[0] + np.concatenate(([0.0], np.cumsum(ways)))
        piece = self.piece[:1] if (self.piece == self.piece[0]).all() else np.array([-1])
        return Course(knots, s, speed, u, jerk, np.repeat(piece, len(jerk)))


def _inside(speed: Floats, parts: int) -> Floats:
    """Return (parts + 1, K) parts of intervals from one end to the other, or nearly: there a joint may turn back, and
    only a robot at rest is at both sides of that."""
    found = np.repeat(np.linspace(0.0, 1.0, parts + 1)[:, None], len(speed) - 1, axis=1)
    found[0, speed[:-1] > 0.0] = 1e-9
    found[-1, speed[1:] > 0.0] = 1.0 - 1e-9
    return found


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
    refuse_others(model, scene)
    check_supported(model, scene)
    _check(profile, speed, blend, rate, grid, jerk)
    bounds = bounds_of(model, scene, acceleration, jerk, speed)
    points = read_path(path, model, scene, **reading)
    exact = profile == "optimal" and blend is None
    way = spline(points) if exact else lines(points, blend or 0.0, stopping=profile != "optimal")
    try:
        _check_range(model, way, grid)
        if profile == "optimal":
            along = Along(bounds, way, way.grid(max(grid, len(way.breaks) - 1)))
            kept, x = _fastest(along)
            jerky = np.isfinite(bounds.limits[JERK]).any()
            course = _within_jerk(along, kept, x) if jerky else _joined(way, _stretches(along, x))
        elif len(way.breaks) > MOST_STOPS:
            what = f"{len(way.breaks)} way-points to stop at"
            raise InputError(what, remedy=f"{MOST_STOPS} at most; --profile optimal follows a dense path in one go")
        else:
            moves = [_move(bounds, way, k, profile) for k in range(len(way.breaks) - 1)]
            course = _joined(way, moves)
        course = _settled(bounds, way, course, Course.fine)[0]
    except InfeasibleError as why:
        return Retimed(model, scene, profile, way, bounds.limits, str(why), why.where)
    return _result(bounds, way, course, rate, profile)


def _check(profile: str, speed: float, blend: float | None, rate: float, grid: int, jerk: Any) -> None:
    wrong = [
        (profile not in PROFILES, f"no profile {shown(profile)}", f"one of {', '.join(PROFILES)}"),
        (not 0.0 < speed <= 1.0, f"speed is {100 * speed:g} %", "more than 0 %, at most 100 % of the velocity limits"),
        (blend is not None and not 0.0 <= blend < np.inf, f"blend is {blend}", "0 or more"),
        (
            blend is not None and profile != "optimal",
            f"--blend does not go with {profile}",
            "it stops at way-points",
        ),
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
    q = path.at(s, path.pieces(s))[0]
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
    n, x, before, settled = len(along.steps), np.full(len(along.s), 0.01), np.inf, False
    kept = np.ones((JERK, n, along.bounds.model.n))
    for _ in range(_ROUNDS):
        intervals = Intervals(along.rows(x, kept), along.steps, along.most(kept))
        if (free := np.isinf(intervals.p).all(axis=(1, 2))).any():
            raise _free(along.path, float(along.s[int(free.argmax())]))
        found = intervals.fastest()
        if found.stuck is not None:
            why = _stuck(along, found.stuck)
            if why.where["missing"] or x.max() < 1e-15:
                raise why
            x = x / 16.0  # friction that grows with speed is less at a lower one
            continue
        x = found.x
        course = _whole(along, x)
        used = along.bounds.uses(*course.states(along.path, *course.fine())[:3]).max(axis=1)  # (6, N, n)
        duration = float(course.time[-1])
        if used.max() <= 1.0 + 100.0 * _ROUNDING and (settled or abs(duration - before) <= _SAME * duration):
            break
        settled, before = settled or abs(duration - before) <= 1e-5 * duration, duration
        if settled:
            kept = np.where(used > 1.0 + _ROUNDING, kept / (np.maximum(used, 1.0) * (1.0 + 10.0 * _ROUNDING)), kept)
    return kept, x


def _pass(along: Along, x: Floats, kept: Floats) -> Floats:
    found = Intervals(along.rows(x, kept), along.steps, along.most(kept)).fastest()
    if found.stuck is not None:
        raise _stuck(along, found.stuck)
    return found.x


def _free(path: Path, s: float) -> InputError:
    what = f"nothing limits the acceleration of what moves {_place(path, s)}"
    return InputError(what, remedy="--acceleration A; the description gives no effort, the scene no motor")


def _whole(along: Along, x: Floats) -> Course:
    """Return the course of a pass, without waiting."""
    speed, u = np.sqrt(x), np.diff(x) / (2.0 * along.steps)
    time = np.concatenate(([0.0], np.cumsum(2.0 * along.steps / (speed[1:] + speed[:-1]))))
    return Course(time, along.s, speed, np.append(u, 0.0), np.zeros(len(u)), along.piece)


def _stretches(along: Along, x: Floats) -> list[Course]:
    """Return the courses of a pass from stop to stop."""
    whole, found = _whole(along, x), []
    for a, b in pairwise(np.flatnonzero(along.still).tolist()):
        time, s, speed, u = (each[a : b + 1] for each in (whole.time, whole.s, whole.speed, whole.u))
        found.append(Course(time - time[0], s, speed, u, whole.jerk[a:b], whole.piece[a:b]))
    return found


def _joined(path: Path, stretches: list[Course]) -> Course:
    """Return courses from stop to stop one after another, and the waiting at the stops."""
    parts, now = list[Course](), 0.0
    for k, (s, wait) in enumerate(zip(path.stops, path.dwell, strict=True)):
        if wait > 0.0:
            piece = path.pieces(np.array([s]))
            rest = np.zeros(2)
            parts.append(Course(now + np.array((0.0, wait)), np.full(2, s), rest, rest, rest[:1], piece))
            now += float(wait)
        if k < len(stretches):
            parts.append(stretches[k]._replace(time=stretches[k].time + now))
            now = float(parts[-1].time[-1])
    knots = [np.concatenate([*(each[i][:-1] for each in parts), parts[-1][i][-1:]]) for i in range(4)]
    return Course(*knots, *(np.concatenate([each[i] for each in parts]) for i in (4, 5)))


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


def _settled(
    bounds: Bounds, path: Path, course: Course, instants: Callable[[Course], tuple[Floats, NDArray[np.int64]]]
) -> tuple[Course, Floats]:
    """Return the course, slower by what its limits are passed by at some instants, and its use of limits there; raise
    if that does not end."""
    slack = np.inf
    for turn in range(1, 100):
        used = _uses(bounds, path, course, *instants(course))
        if (slack := _slack(used)) <= 1.0 + PASSED / 4.0:
            return course, used
        course = course.slower(1.0 + turn * (slack - 1.0) + _ROUNDING)  # torques may hardly depend on the time
    what = f"a limit is passed by {100 * (slack - 1.0):.2g} % between points of the grid"
    raise InputError(what, remedy="--grid of more intervals")


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
    first = _joined(path, _stretches(along, x))
    fastest = np.abs(first.states(path, *first.fine())[2]).max(axis=(0, 1))
    lone = 0.25 * np.cbrt(8.0 * fastest * first.time[-1] ** 2 / jerk)  # where nothing else limits the motion
    width, best, shortest, since = 4.0 * float(np.minimum(fastest / jerk, lone).max()), first, np.inf, 0
    while since < _TRIED and width > 0.0:
        width, softer, since = 0.5 * width, kept, since + 1
        limits = bounds.limits.copy()
        softest = np.minimum(fastest, width * jerk)
        limits[ACCELERATION] = np.minimum(limits[ACCELERATION], np.maximum(softest, 1e-9 * softest.max()))
        along.bounds = replace(bounds, limits=limits)
        for _ in range(_SOFTER):
            try:
                x = _pass(along, x, softer)
            except InfeasibleError:
                break
            over = np.ones_like(kept)
            stretches, stops = _stretches(along, x), np.flatnonzero(along.still)
            averaged = [each.averaged(width) for each in stretches]
            for (a, b), each, soft in zip(pairwise(stops.tolist()), stretches, averaged, strict=True):
                time, k = soft.fine(2)
                used = _uses(bounds, path, soft, time, k).max(axis=1)
                used[ACCELERATION] = np.maximum(used[ACCELERATION], used[JERK])
                begin = np.clip(np.searchsorted(soft.time, each.time[:-1], side="right") - 1, 0, used.shape[1] - 2)
                end = np.clip(np.searchsorted(soft.time, each.time[1:] + width), begin + 1, used.shape[1] - 1)
                places = np.column_stack((begin, end)).ravel()
                over[:, a:b] = np.maximum(np.maximum.reduceat(used[:JERK], places, axis=1)[:, ::2], 1.0)
            course = _joined(path, averaged)
            duration = float(course.time[-1]) * max(1.0, _slack(_uses(bounds, path, course, *course.fine(2))))
            if duration < shortest:
                shortest, best, since = duration, course, 0
            softer = softer / over
    return best


def _move(bounds: Bounds, path: Path, k: int, profile: str) -> Course:
    """Return the move along a straight piece: speed grows evenly, stays, falls; with the largest acceleration, up to
    that given, at which torques and motors keep their limits, and slower where they do not at any.

    Source: Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots (2008), 3.2 and 3.4; an
    S-curve is the moving average of a trapezoid, over the time of its jerk.
    """
    length, way = float(path.breaks[k + 1] - path.breaks[k]), np.abs(path.c[1, k])
    with np.errstate(divide="ignore"):
        fast, sharp, j = (float((each / way).min()) for each in (bounds.speed, *bounds.limits[[ACCELERATION, JERK]]))

    def course(a: float, v: float) -> Course:
        ramp, given = RAMP if profile == "scurve" else 0.0, np.isfinite(j)
        if given:  # the acceleration is reached, and the speed lasts as long as the jerk, at least
            a = min(a, float(np.cbrt(0.5 * j * j * length)))
            v = min(v, 0.5 * a * (float(np.hypot(a / j, 2.0 * np.sqrt(length / a))) - a / j))
            a = min(a, float(np.sqrt(v * j)))
        else:
            v = min(v, float(np.sqrt(length * a / (1.0 + ramp))))
        rise = v / a
        time = np.cumsum([0.0, rise, max(length / v - rise, 0.0), rise])
        s = path.breaks[k] + np.array([0.0, 0.5 * v * rise, length - 0.5 * v * rise, length])
        u = np.array([a, 0.0, -a, 0.0])
        one = Course(time, s, np.array([0.0, v, v, 0.0]), u, np.zeros(3), np.full(3, k))
        return one.averaged(a / j if given else ramp * rise)

    def keeps(a: float, v: float) -> bool:
        one = course(a, v)
        return bool(_uses(bounds, path, one, *one.fine(64))[EFFORT:JERK].max() <= 1.0)

    if not np.isfinite(sharp) and not np.isfinite(bounds.limits[EFFORT]).any() and not bounds.trains:
        raise _free(path, float(path.breaks[k]))
    high, v = (sharp, fast) if np.isfinite(sharp) else (1e8 * length, min(fast, 1e4 * length))
    if keeps(high, v):
        return course(high, v)
    low, slowest = 1e-12 * high, 1e-6 * v
    while v > slowest and not keeps(low, v):
        v *= 0.7
    if v <= slowest:
        raise _stuck(Along(bounds, path, np.linspace(path.breaks[k], path.breaks[k + 1], 200)), 0)
    while high > low * (1.0 + 1e-10):
        middle = float(np.sqrt(low * high)) if high > 2.0 * low else 0.5 * (low + high)
        low, high = (middle, high) if keeps(middle, v) else (low, middle)
    return course(low, v)


def _result(bounds: Bounds, path: Path, course: Course, rate: float, profile: str) -> Retimed:
    """Sample a course, and say what binds."""
    names, n = bounds.model.joint_names, bounds.model.n

    def rows(course: Course) -> tuple[Floats, NDArray[np.int64]]:
        samples = max(int(np.ceil(course.time[-1] * rate - 1e-9)) + 1, 2)
        if samples > MOST_SAMPLES:
            what = f"the motion takes {course.time[-1]:.6g} s, {float(samples):.6g} rows"
            raise InputError(what, remedy=f"--rate of fewer rows per second, {MOST_SAMPLES} at most")
        time = np.linspace(0.0, course.time[-1], samples)
        return time, course.knot(time)

    course, used = _settled(bounds, path, course, rows)
    time, k = rows(course)
    q, qd, qdd, _ = course.states(path, time, k)
    tau = bounds.values(q, qd, qdd)[0][EFFORT]
    flat = np.ascontiguousarray(used.transpose(1, 0, 2).reshape(len(time), -1))
    leads = np.where(flat.max(axis=1) < BINDS, -1, first_of_ties(flat))
    shares = [Binding(names[f % n], LIMITS[f // n], float((leads == f).mean())) for f in range(flat.shape[1])]
    binding = ranked((one for one in shares if one.share_of_time > 0.0), lambda one: one.share_of_time)
    use = [{LIMITS[f]: float(used[f, :, i].max()) for f in np.flatnonzero(used[:, :, i].any(axis=1))} for i in range(n)]
    warnings = tuple(_continuous(bounds, qd, qdd, tau))
    at: dict[str, Any] = {
        "time": time,
        "q": q,
        "qd": qd,
        "qdd": qdd,
        "tau": tau,
        "row": path.row(course.at(time, k)[0]),
    }
    said: dict[str, Any] = {
        "binding": tuple(binding),
        "joints": tuple(map(JointUse, names, use)),
        "used": used,
        "warnings": warnings,
    }
    return Retimed(bounds.model, bounds.scene, profile, path, bounds.limits, **at, **said)


def _continuous(bounds: Bounds, qd: Floats, qdd: Floats, tau: Floats) -> Iterator[str]:
    """Yield what is said of motors whose RMS torque is above their continuous curves, if the motion is repeated."""
    for i, train in bounds.trains:
        torque = motor_torque(train, load_torque(train, tau[:, i], qdd[:, i]), qd[:, i], qdd[:, i])
        rms, mean = float(np.sqrt(np.mean(torque**2))), float(np.mean(np.abs(train.gear * qd[:, i])))
        if rms > (may := float(allowed(train.motor.continuous, mean))):
            what = f"{bounds.model.joint_names[i]}: if this is repeated, its motor's RMS torque of {rms:.4g} N m"
            yield f"{what} is above the {may:.4g} N m of its continuous curve (a dwell, or --speed, lessens it)"
