"""What differentiation costs: errors of qdd, and of torques made with it, by method, on clean and on encoder data;
how often error bars of derived accelerations cover the truth, by class of motion, and how wide they are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from helpers.exact_motions import MOTIONS, Array, Rates, course
from helpers.markdown_tables import table
from helpers.markdown_tables import table as markdown
from helpers.oracles import robot
from helpers.read_motions import read

import robodyn
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.read import from_arrays

METHODS = ("`numpy.gradient` twice", "central", "spline", "savgol", "auto")
HEAD = ("method", "sine at 10 ms, qdd: middle", "ends", "encoder at 1 ms, torque: middle", "ends")
FREQUENCIES = np.array([1.0, 0.7, 1.3])
AMPLITUDES = np.array([0.5, 0.4, 0.6])
COUNT = 2 * np.pi / 2**17
"""Step of an encoder of 17 bits [rad]."""


def swing(time):
    """q, qd and qdd of three joints that swing at different frequencies."""
    w = 2 * np.pi * FREQUENCIES
    angle = time[:, None] * w + np.array([0.0, 1.0, 2.0])
    return AMPLITUDES * np.sin(angle), AMPLITUDES * w * np.cos(angle), -AMPLITUDES * w**2 * np.sin(angle)


def derived(method, time, q):
    """qd and qdd by a method of robodyn, or by numpy."""
    if method == METHODS[0]:
        qd = np.gradient(q, time, axis=0)
        return qd, np.gradient(qd, time, axis=0)
    motion = robodyn.motion(robot("puma"), time, q, derivatives=method)
    return motion.qd, motion.qdd


def by_place(off):
    """The largest of errors (N, c) in the middle half of the samples, and of all."""
    rows = off.max(axis=1)
    quarter = len(rows) // 4
    return rows[quarter:-quarter].max(), rows.max()


def on_sine(method):
    """Errors of qdd of sin(2 pi t) at 10 ms [rad/s^2]."""
    time = np.arange(401) * 0.01
    q = np.repeat(np.sin(2 * np.pi * time)[:, None], 3, axis=1)
    return by_place(np.abs(derived(method, time, q)[1] + 4 * np.pi**2 * q))


def on_encoder(method):
    """Errors of the torques of the PUMA [N m] whose positions an encoder reads at 1 ms, and its largest torque."""
    time = np.arange(2001) * 0.001
    q, qd, qdd = swing(time)
    read = np.round(q / COUNT) * COUNT
    model = robot("puma")
    tau = robodyn.inverse_dynamics(model, q, qd, qdd)
    off = robodyn.inverse_dynamics(model, read, *derived(method, time, read)) - tau
    return *by_place(np.abs(off)), np.abs(tau).max()


def two_digits(x):
    return f"{float(f'{x:.2g}'):g}"


def derivatives_table():
    rows = []
    for method in METHODS:
        *torque, largest = on_encoder(method)
        rows.append(
            (
                method if method == METHODS[0] else f"`--derivatives {method}`",
                *(f"{x:.0e} rad/s^2" for x in on_sine(method)),
                *(f"{two_digits(x)} N m" for x in torque),
            )
        )
    return table(HEAD, rows) + f"\nThe largest torque of the arm is {largest:.0f} N m.\n"


ONE = Signals((Signal("a", "angle"),))
KINDS = ("trapezoid", "S-curve, full", "cosine", "minimum jerk", "sines")
NOISES = ("white noise", "15 to 17 bits", "correlated noise", "late stamps", "exact")
RATES = (50, 200, 1000)
SEEDS = range(500, 510)


class Held(NamedTuple):
    """Whether the bar of the largest acceleration holds, the share of rows whose bars do; the bar's width and the error
    of the largest."""

    peak: bool
    rows: float
    width: float
    error: float


def one_joint(kind: str, noise: str, rate: float, seed: int) -> tuple[Array, Array, Rates]:
    """Time (N,) and position (N, 1) as a table has them, and the truth at these rows."""
    rng = np.random.default_rng([seed, list(MOTIONS).index(kind)])
    path = course(kind, rng, [(-2.0, 2.0)], 0.0)
    table = read(path, rng, rate, noise, "none", np.ones(1))
    return table.time, table.q, path.at(table.instants)


def held(kind: str, noise: str, rate: float, seed: int) -> Held:
    """One joint of unit inertia: its largest lies between what is sure and what is possible in a row, as reported."""
    time, q, (_, _, true) = one_joint(kind, noise, rate, seed)
    found, qdd = from_arrays(ONE, time, q), true[:, 0]
    assert found.sampling is not None
    value, bar, size = found.qdd[:, 0], found.sampling.off[:, 0] + 1e-9 * np.abs(qdd).max(), np.abs(qdd).max()
    largest, least, most = (np.abs(value) + sign * bar for sign in (0.0, -1.0, 1.0))
    largest, least, most = largest.max(), least.max(), most.max()
    width = max(most - largest, largest - least)
    off = np.abs(value - qdd) <= bar
    return Held(
        bool(abs(largest - size) <= width), float(np.mean(off)), float(width / size), float(abs(largest - size) / size)
    )


def coverage_table() -> str:
    """Coverage of seeds that nothing was tuned on."""
    rows = []
    for name in KINDS:
        cells = {noise: [held(name, noise, rate, seed) for rate in RATES for seed in SEEDS] for noise in NOISES}
        every = [case for cases in cells.values() for case in cases]
        shares = [f"{100 * np.mean([case.peak for case in cases]):.0f} %" for cases in cells.values()]
        width, error = (100 * np.median([getattr(case, part) for case in every]) for part in ("width", "error"))
        rows.append(
            (name, *shares, f"{100 * np.mean([case.rows for case in every]):.0f} %", f"{width:.2g} %", f"{error:.2g} %")
        )
    head = ("motion", *NOISES, "all rows", "bar", "error")
    return markdown(head, rows, left=(0,))


if __name__ == "__main__":
    print(coverage_table())
