"""Random scenes for sweeps: slides and pendulums with tables of forces, and joints that touch their limits."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
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
        sizes = np.abs(parts)
    else:
        last = np.interp(pushed.duration, time, force)
        time, force = np.append(time[inside], pushed.duration), np.append(force[inside], last)
        parts = np.diff(time) * 0.5 * (force[1:] + force[:-1])
        sizes = np.diff(time) * np.maximum(*np.abs([force[1:], force[:-1]]))
    return float(parts.sum()) / pushed.mass, float(sizes.sum()) / pushed.mass


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
    parts = [*_monotone_parts(time, torque, between == "hold", (start, speed))]
    chosen = float(parts[int(rng.integers(len(parts)))].high)
    limit = max(chosen + float(rng.choice([-1.0, 1.0])) * 10.0 ** float(rng.uniform(-9, -1)), start + 1e-3)
    passed = next((part for part in parts if part.low < limit < part.high), None)
    moment = passed and float(brentq(lambda t: passed.at(t)[0] - limit, passed.begin, passed.end, xtol=1e-15))
    scene = Scene(
        initial_q={"j1": start}, initial_qd={"j1": speed}, drive={"j1": Drive(torque="push")}, between_rows=between
    )
    table = {"time": time, "push": torque}
    return Swung(hanging(-1000.0, float(limit)), scene, table, parts[-1].at(time[-1]), moment)


class _Part(NamedTuple):
    """A part of a motion in which an angle grows or falls, from `low` to `high`; `at` returns it and its rate."""

    begin: float
    end: float
    low: float
    high: float
    at: Callable[[float], Floats]


def _monotone_parts(time: Floats, torque: Floats, held: bool, state: Iterable[float]) -> Iterator[_Part]:
    """Yield how a pendulum of 1 kg at 1 m moves between rows."""
    for begin, end, a, b in zip(time[:-1], time[1:], torque[:-1], torque[1:], strict=True):
        slope = 0.0 if held else (b - a) / (end - begin)

        def rates(t: float, y: Floats, begin: float = begin, a: float = a, slope: float = slope) -> list[float]:
            return [y[1], -9.81 * np.sin(y[0]) + a + slope * (t - begin)]

        how = {"rtol": 1e-13, "atol": 1e-14, "max_step": 0.02, "dense_output": True, "events": lambda _, y: y[1]}
        found = solve_ivp(rates, (begin, end), state, "DOP853", **how)
        for low, high in pairwise([begin, *found.t_events[0], end]):
            yield _Part(float(low), float(high), float(found.sol(low)[0]), float(found.sol(high)[0]), found.sol)
        state = found.y[:, -1]
