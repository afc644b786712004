"""Exciting motions of the KUKA LWR4+ beside FloBaRoID's search: `cd tests && python -m benchmarks.bench_excitation`.

FloBaRoID (github.com/kjyv/FloBaRoID) needs iDynTree, IPOPT and FCL; it is not called. What it does is done again here,
from its `excitation/` and `configs/kuka_lwr4.yaml`: Fourier series with 3, 3, 4, 4, 5, 6 and 6 harmonics, pulsation 0.3
to 1 rad/s, coefficients from -1 to 1 rad/s, centres within 25 degrees; -log det(Y^T Y + 1e-4 lambda_max I), scaled to
10 at the first motion, plus ten times each the spread of the joints' torques, what these fall short of 25 % of their
limits, and what positions leave of their ranges; limits of position, speed and torque, and torques of 2 % of theirs at
least; 400 trials of Optuna's TPE, then a gradient method from the best. That is SLSQP with 200 iterations here, where
FloBaRoID's file gives IPOPT two. Motions that end beyond a limit are made smaller until they keep it, as FloBaRoID
does.

robodyn's motion has the same period, rows and limits, six harmonics, and beyond them rests at both ends and keeps 5 %
of each range from its limits. Collisions are left out of both: FloBaRoID looks at them, which can only make its motions
smaller. Information is unweighted: log det(Y^T Y) of 43 inertial base parameters in SI units, and with friction and
rotors, at 200 rows per second.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import optuna
from helpers.machine import machine
from helpers.markdown_tables import main, table
from scipy.optimize import minimize

import robodyn
from robodyn.dynamics.plan import plan
from robodyn.dynamics.regressor import INERTIAL
from robodyn.identification.excitation.landscape import programs_of
from robodyn.identification.parameters.base import base_of, random_rows, structural_base

FILE = Path(__file__).parents[1] / "data" / "lwr4.urdf"
HARMONICS = (3, 3, 4, 4, 5, 6, 6)
RATE, SAMPLES = 200.0, 160
"""Rows per second, and samples of a period in FloBaRoID's search (it has all rows, which changes little)."""
TRIALS = 400
LEAST_TORQUE, WANTED_TORQUE, TOLERANCE = 0.02, 0.25, 0.01
HEAD = ("search", "period [s]", "seconds", "log det, inertial", "with friction", "condition", "rests at its ends")


class Robot(NamedTuple):
    model: robodyn.Model
    lower: np.ndarray
    upper: np.ndarray
    speed: np.ndarray
    effort: np.ndarray


@cache
def lwr4() -> Robot:
    model = robodyn.load(FILE)
    limits = (
        [getattr(joint, name) for joint in model.independent] for name in ("lower", "upper", "velocity", "effort")
    )
    return Robot(model, *map(np.array, limits))


@cache
def inertial_columns() -> tuple[int, ...]:
    rows, names = random_rows(lwr4().model)
    columns = [k for k, name in enumerate(names) if name.rpartition(".")[2] in INERTIAL]
    return tuple(columns[k] for k in base_of(rows[:, columns], [names[k] for k in columns]).independent)


@cache
def programs():
    model = lwr4().model
    count = len(structural_base(model).names)
    return programs_of(plan(model, robodyn.Scene()), inertial_columns(), count)


def motion(x: np.ndarray, time: np.ndarray) -> np.ndarray:
    """FloBaRoID's series: q = c + sum a_k/(w k) sin(w k t) - b_k/(w k) cos(w k t), with q, qd and qdd (3, N, 7)."""
    w, centre, total = x[0], x[1:8], sum(HARMONICS)
    out, first = np.zeros((3, len(time), 7)), 8
    for j, count in enumerate(HARMONICS):
        a, b = x[first : first + count], x[first + total : first + total + count]
        k = w * np.arange(1, count + 1)
        sine, cosine = np.sin(np.outer(time, k)), np.cos(np.outer(time, k))
        out[0, :, j] = centre[j] + sine @ (a / k) - cosine @ (b / k)
        out[1, :, j], out[2, :, j] = cosine @ a + sine @ b, cosine @ (b * k) - sine @ (a * k)
        first += count
    return out


class Search:
    """FloBaRoID's objective and constraints, each at most zero where they are kept."""

    def __init__(self) -> None:
        self.scale, self.known = 0.0, {}

    def values(self, x: np.ndarray) -> np.ndarray:
        """The objective, then the constraints."""
        if x.tobytes() in self.known:
            return self.known[x.tobytes()]
        robot, samples = lwr4(), np.arange(SAMPLES) * (2 * np.pi / x[0] / SAMPLES)
        q, qd, qdd = motion(x, samples)
        parts, tau = programs().values(np.array([q, qd, qdd]))
        rows = np.zeros((7 * SAMPLES, programs().r))
        for j, (columns, part) in enumerate(zip(programs().shown, parts, strict=True)):
            rows[j * SAMPLES : (j + 1) * SAMPLES, columns] = part * np.sqrt(2 * np.pi / x[0] * RATE / SAMPLES)
        eigenvalues = np.linalg.eigvalsh(rows.T @ rows)
        telling = -np.log(eigenvalues + 1e-4 * eigenvalues[-1]).sum()
        self.scale = self.scale or 10.0 / max(abs(telling), 1.0)
        used = np.abs(tau).max(axis=0) / robot.effort
        f = telling * self.scale
        ranged = ((q.max(axis=0) - q.min(axis=0)) / (robot.upper - robot.lower)).mean()
        f += 10.0 * (used.std() / used.mean() + max(0.0, 1.0 - used.mean() / WANTED_TORQUE) + 1.0 - ranged)
        beyond = [robot.lower - q.min(axis=0), q.max(axis=0) - robot.upper, np.abs(qd).max(axis=0) - robot.speed]
        beyond += [robot.effort * (used - 1.0), robot.effort * (LEAST_TORQUE - used)]
        found = np.concatenate(([f], *beyond))
        self.known = {x.tobytes(): found}
        return found

    def slopes(self, x: np.ndarray) -> np.ndarray:
        """By differences, as FloBaRoID's regressor has them."""
        here = self.values(x).copy()
        out = np.array([(self.values(x + step) - here) / 1e-6 for step in 1e-6 * np.eye(len(x))]).T
        self.known = {x.tobytes(): here}
        return out


def bounds() -> tuple[np.ndarray, np.ndarray]:
    centre, many = np.radians(25.0) * np.ones(7), np.ones(2 * sum(HARMONICS))
    return np.concatenate(([0.3], -centre, -many)), np.concatenate(([1.0], centre, many))


def first() -> np.ndarray:
    series = [0.5 / np.arange(1, count + 1) for count in HARMONICS]
    return np.concatenate(([0.5], np.zeros(7), *series, *series))


def trials(search: Search) -> np.ndarray:
    """The best of the trials: feasible if one is, else the one that is least beyond its limits."""
    low, high = bounds()
    tried: list[tuple[tuple[float, float], np.ndarray]] = []

    def judged(x: np.ndarray) -> tuple[float, list[float]]:
        values = search.values(x)
        worst = float(values[1:].max())
        tried.append(((max(worst, TOLERANCE), float(values[0])), x))
        return float(values[0]), values[1:].tolist()

    judged(first())
    constraints: dict[int, list[float]] = {}

    def objective(trial):
        x = np.array([trial.suggest_float(str(k), *each) for k, each in enumerate(zip(low, high, strict=True))])
        value, constraints[trial.number] = judged(x)
        return value

    warnings.filterwarnings("ignore", module="optuna")
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    sampler = optuna.samplers.TPESampler(seed=0, constraints_func=lambda trial: constraints[trial.number])
    study = optuna.create_study(sampler=sampler)
    study.enqueue_trial({str(k): float(value) for k, value in enumerate(first())})
    study.optimize(objective, n_trials=TRIALS - 1)
    return min(tried, key=lambda each: each[0])[1]


def climbed(search: Search, x: np.ndarray, iterations: int) -> np.ndarray:
    low, high = bounds()
    found = minimize(
        lambda at: search.values(at)[0],
        x,
        jac=lambda at: search.slopes(at)[0],
        bounds=list(zip(low, high, strict=True)),
        constraints={
            "type": "ineq",
            "fun": lambda at: -search.values(at)[1:],
            "jac": lambda at: -search.slopes(at)[1:],
        },
        method="SLSQP",
        options={"maxiter": iterations, "ftol": 1e-9},
    ).x
    return kept(search, np.clip(found, low, high))


def kept(search: Search, x: np.ndarray) -> np.ndarray:
    """The motion, smaller where it exceeds a limit."""
    smaller = x.copy()
    for scale in np.arange(1.0, 0.1, -0.005):
        smaller[8:] = scale * x[8:]
        if search.values(smaller)[1:29].max() <= 1e-9:
            return smaller
    return smaller


def told(whole: np.ndarray) -> tuple[float, float, float]:
    """log det of the inertial base parameters, of all of them, and the condition of the former at unit length."""
    model = lwr4().model
    Y = robodyn.regressor(model, *whole).Y
    groups = (inertial_columns(), structural_base(model).independent)
    one, both = (Y[..., columns].reshape(-1, len(columns)) for columns in groups)
    condition = np.linalg.cond(one / np.linalg.norm(one, axis=0))
    return (*(float(np.linalg.slogdet(rows.T @ rows)[1]) for rows in (one, both)), float(condition))


def row(
    name: str, period: float, seconds: float, at: Callable[[np.ndarray], np.ndarray], rests: str
) -> tuple[str, ...]:
    rows = round(period * RATE)
    one, all_of_them, condition = told(at(np.arange(rows) * (period / rows)))
    return (name, f"{period:.2f}", f"{seconds:.0f}", f"{one:.1f}", f"{all_of_them:.1f}", f"{condition:.1f}", rests)


def ours(period: float, acceleration: float | None) -> tuple[str, ...]:
    begun = time.perf_counter()
    found = robodyn.excite(
        lwr4().model, period=period, harmonics=max(HARMONICS), rate=RATE, max_acceleration=acceleration, noise=[1.0]
    )
    seconds = time.perf_counter() - begun
    check(found.motion)
    name = "robodyn" if acceleration else "robodyn, with its limit of acceleration"
    return row(name, period, seconds, lambda at: found.motion[:, : len(at)], "yes")


def check(whole: np.ndarray) -> None:
    """Raise unless the motion keeps the limits that both searches have."""
    robot, (q, qd, qdd) = lwr4(), whole
    assert (q >= robot.lower - 1e-9).all()
    assert (q <= robot.upper + 1e-9).all()
    assert (np.abs(qd) <= robot.speed + 1e-9).all()
    assert (np.abs(robodyn.inverse_dynamics(robot.model, q, qd, qdd)) <= robot.effort + 1e-9).all()


def report(iterations: int) -> str:
    begun, search = time.perf_counter(), Search()
    x = climbed(search, trials(search), iterations)
    seconds, period = time.perf_counter() - begun, 2 * np.pi / x[0]
    theirs = row("FloBaRoID's", period, seconds, lambda at: motion(x, at), "no")
    return table(HEAD, [theirs, ours(period, 1e3), ours(period, None)]) + "\n" + machine("scipy", "optuna")


if __name__ == "__main__":
    main(report, __doc__, iterations=200)
