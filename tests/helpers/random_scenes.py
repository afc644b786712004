"""Random scenes for sweeps: slides and pendulums with tables of forces, and joints that touch their limits."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from helpers.simulated_robots import slide
from helpers.small_robots import built, joint, link
from robodyn.robot.model import Model
from robodyn.scene.scene import Drive, Scene

Floats = NDArray[np.float64]


class Pushed(NamedTuple):
    """A slide of `mass` [kg] that a column pushes, and a duration and step with which to simulate it [s]."""

    model: Model
    scene: Scene
    table: dict[str, Floats]
    duration: float
    step: float
    mass: float


def row_times(rng: np.random.Generator, length: float, step: float) -> Floats:
    """Return times of rows from 0 to `length`: multiples of steps or parts of them, others, bursts, or near misses."""
    kind = rng.integers(5)
    if kind == 0:
        inner = step * np.arange(1.0, length / step) * rng.integers(1, 4)
    elif kind == 1:
        inner = step / rng.integers(2, 9) * np.arange(1.0, 2000.0)
    elif kind == 2:
        inner = rng.uniform(0.0, length, rng.integers(1, 400))
    elif kind == 3:
        inner = rng.uniform(0.0, length) + step * np.cumsum(rng.uniform(1e-4, 0.3, rng.integers(2, 30)))
    else:
        near = step * rng.integers(1, max(int(length / step), 2), 20)
        inner = near * (1.0 + rng.choice([-1.0, 0.0, 1.0], 20) * 10.0 ** rng.uniform(-16, -8, 20))
    inner = np.unique(inner[(inner > 0.0) & (inner < length * (1 - 1e-9))])
    return np.concatenate(([0.0], inner, [length]))


def forces_at(rng: np.random.Generator, time: Floats) -> Floats:
    """Return a force for each row: noise, pulses of equal impulse however short, or steps that stay."""
    kind = rng.integers(3)
    if kind == 0:
        return rng.normal(size=len(time)) * 10.0 ** rng.uniform(-3, 3)
    if kind == 1:
        chosen = rng.random(len(time)) < 0.2
        return np.where(chosen, 1.0 / np.gradient(time), 0.0)
    return np.repeat(rng.normal(size=len(time)), rng.integers(1, 9))[: len(time)]


def pushed_slide(rng: np.random.Generator) -> Pushed:
    """Return a slide in a scene whose table is held or straight between rows, and lasts as long as the motion or on."""
    step = 10.0 ** rng.uniform(-7, -2)
    duration = step * (rng.uniform(3, 300) if rng.random() < 0.5 else rng.integers(3, 300))
    time = row_times(rng, duration * (1.0 if rng.random() < 0.5 else rng.uniform(1.0, 2.0)), step)
    between = ("linear", "hold")[rng.integers(2)]
    scene = Scene(gravity=(0, 0, 0), joint_limits="ignore", drive={"j1": Drive(torque="push")}, between_rows=between)
    mass = float(rng.choice([0.01, 1.0, 50.0]))
    return Pushed(slide(mass), scene, {"time": time, "push": forces_at(rng, time)}, float(duration), step, mass)


def momentum_of(pushed: Pushed) -> tuple[float, float]:
    """Return the speed at the end by the exact sum, and the sum of the sizes of its parts [m/s]."""
    time, force = pushed.table["time"], pushed.table["push"]
    inside = time < pushed.duration
    if pushed.scene.between_rows == "hold":
        ends = np.minimum(np.append(time[1:], np.inf), pushed.duration)
        parts = (force * (ends - time))[inside]
    else:
        last = np.interp(pushed.duration, time, force)
        time, force = np.append(time[inside], pushed.duration), np.append(force[inside], last)
        parts = np.diff(time) * 0.5 * (force[1:] + force[:-1])
        return float(parts.sum()) / pushed.mass, float(
            (np.diff(time) * np.maximum(*np.abs([force[1:], force[:-1]]))).sum()
        ) / pushed.mass
    return float(parts.sum()) / pushed.mass, float(np.abs(parts).sum()) / pushed.mass


def hanging(lower: float, upper: float) -> Model:
    """Return a pendulum of 1 kg on a rod of 1 m, with limits [rad]."""
    hinge = joint("j1", "l0", "l1", "revolute", (0, -1, 0)).replace('lower="-9"', f'lower="{lower!r}"')
    return built(link("l0"), link("l1", 1.0, (0, 0, -1)), hinge.replace('upper="9"', f'upper="{upper!r}"'))


def braked_slide(depth: float) -> tuple[Model, Scene, float, float]:
    """Return a slide that turns `depth` [m] beyond its limit, when it turns, and how long before it is there [s].

    x = 9 + depth - a (t - t_turn)^2 / 2, with t_turn no multiple of any step.
    """
    a, turn = 2.0, 1.03456789
    drive = {"j1": Drive(torque=-a)}
    start = 9.0 + depth - 0.5 * a * turn**2
    scene = Scene(gravity=(0, 0, 0), drive=drive, initial_q={"j1": start}, initial_qd={"j1": a * turn})
    return slide(1.0), scene, turn, float(np.sqrt(2.0 * abs(depth) / a))


class Passing(NamedTuple):
    """A slide with limits that forces of a table push to and fro, and when it first passes one [s], if it does."""

    model: Model
    scene: Scene
    table: dict[str, Floats]
    step: float
    moment: float | None


def passing_of(rng: np.random.Generator) -> Passing:
    """Return a slide whose upper limit is a little below or above the highest place that it comes to."""
    time = np.concatenate(([0.0], np.cumsum(rng.uniform(0.003, 0.3, 12))))
    force = rng.normal(size=13) * 10.0
    q, qd = 0.0, float(rng.normal())
    tops: list[tuple[float, float]] = []
    arcs = []
    for begin, length, a in zip(time, np.diff(time), force, strict=False):
        arcs.append((float(begin), float(length), q, qd, float(a)))
        at = -qd / a
        if a < 0.0 < at < length:
            tops.append((begin + at, q + 0.5 * qd * at))
        q, qd = q + qd * length + 0.5 * a * length**2, qd + a * length
    highest = max([top for _, top in tops] + [arc[2] for arc in arcs] + [q])
    size = max(abs(highest), 1e-3)
    limit = highest - size * float(rng.choice([-1.0, 1.0])) * 10.0 ** float(rng.uniform(-5, -1))
    limit = float(max(limit, 1e-6))
    moments = [begin + t for begin, length, x, v, a in arcs for t in _passed(x, v, a, limit, length)]
    slider = joint("j1", "l0", "l1", "prismatic", (1, 0, 0)).replace('upper="9"', f'upper="{limit!r}"')
    model = built(link("l0"), link("l1", 1.0), slider.replace('lower="-9"', 'lower="-1000"'))
    drive = {"j1": Drive(torque="push")}
    scene = Scene(gravity=(0, 0, 0), drive=drive, between_rows="hold", initial_qd={"j1": arcs[0][3]})
    step = float(10.0 ** rng.uniform(-3, -0.5))
    return Passing(model, scene, {"time": time, "push": force}, step, min(moments, default=None))


def _passed(x: float, v: float, a: float, limit: float, length: float) -> list[float]:
    """Return when x + v t + a t^2 / 2 rises through a limit within [0, length]."""
    root = v * v - 2.0 * a * (x - limit)
    if root < 0.0 or x > limit:
        return []
    below = v + np.sqrt(root)  # the earlier root of a falling arc, the later one of a rising one
    at = 2.0 * (limit - x) / below if below > 0.0 else np.inf
    return [at] if 0.0 <= at <= length else []


class Swung(NamedTuple):
    """A pendulum with limits whose hinge a column drives, the end of its motion (q, qd), and when a limit ends it."""

    model: Model
    scene: Scene
    table: dict[str, Floats]
    end: Floats
    moment: float | None


def swung(rng: np.random.Generator) -> Swung:
    """Return a pendulum with an upper limit near the highest point of a swing, and its motion by SciPy's DOP853."""
    count = int(rng.integers(2, 40))
    time = np.concatenate(([0.0], np.cumsum(10.0 ** rng.uniform(-4, -0.5, count))))
    torque = rng.normal(size=len(time)) * 10.0 ** rng.uniform(-2, 1)
    between = ("linear", "hold")[rng.integers(2)]
    start, speed = float(rng.uniform(-1.0, 1.0)), float(rng.normal())
    arcs = _arcs(time, torque, between == "hold", np.array([start, speed]))
    tops = [top for arc in arcs for top in _tops(*arc)]
    chosen = tops[int(rng.integers(len(tops)))][1]
    limit = max(chosen + float(rng.choice([-1.0, 1.0])) * 10.0 ** float(rng.uniform(-9, -1)), start + 1e-3)
    moment = next((at for arc in arcs if (at := _first_at(*arc, limit)) is not None), None)
    scene = Scene(
        initial_q={"j1": start}, initial_qd={"j1": speed}, drive={"j1": Drive(torque="push")}, between_rows=between
    )
    table = {"time": time, "push": torque}
    return Swung(hanging(-1000.0, float(limit)), scene, table, np.asarray(arcs[-1][2](time[-1])), moment)


Arc = tuple[float, float, Callable[[float], Floats]]


def _arcs(time: Floats, torque: Floats, held: bool, state: Floats) -> list[Arc]:
    """Return from when, until when and how a pendulum of 1 kg at 1 m moves between rows."""
    arcs: list[Arc] = []
    for begin, end, a, b in zip(time[:-1], time[1:], torque[:-1], torque[1:], strict=True):
        slope = 0.0 if held else (b - a) / (end - begin)

        def rates(t: float, y: Floats, begin: float = begin, a: float = a, slope: float = slope) -> list[float]:
            return [y[1], -9.81 * np.sin(y[0]) + a + slope * (t - begin)]

        found = solve_ivp(
            rates, (begin, end), state, "DOP853", rtol=1e-13, atol=1e-14, max_step=0.02, dense_output=True
        )
        arcs.append((float(begin), float(end), found.sol))
        state = found.y[:, -1]
    return arcs


def _turns(begin: float, end: float, at: Callable[[float], Floats]) -> list[float]:
    """Return where an arc changes its direction, with both of its ends."""
    times = np.linspace(begin, end, max(int((end - begin) / 1e-3), 8))
    speeds = at(times)[1]
    inner = [
        brentq(lambda t: at(t)[1], *times[k : k + 2], xtol=1e-15) for k in np.flatnonzero(np.diff(np.sign(speeds)))
    ]
    return [begin, *inner, end]


def _tops(begin: float, end: float, at: Callable[[float], Floats]) -> list[tuple[float, float]]:
    return [(t, float(at(t)[0])) for t in _turns(begin, end, at)]


def _first_at(begin: float, end: float, at: Callable[[float], Floats], limit: float) -> float | None:
    turns = _turns(begin, end, at)
    for low, high in pairwise(turns):
        if at(low)[0] < limit < at(high)[0]:
            return float(brentq(lambda t: at(t)[0] - limit, low, high, xtol=1e-15))
    return None
