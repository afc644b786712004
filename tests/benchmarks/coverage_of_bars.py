"""How often error bars of derived accelerations cover the truth, by class of motion, and how wide they are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from helpers.exact_motions import MOTIONS, Array, Rates, course
from helpers.markdown_tables import table as markdown
from helpers.read_motions import read

from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.read import from_arrays

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
