"""Reading and writing of tables against polars alone, in one run: `python tests/benchmarks/bench_tables.py [ROWS]`.

Prints seconds and the ratio to polars for a table of 19 columns (time, 6 joints with q, qd and qdd) read and 7 columns
written, and for positions only, which are also differentiated.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import polars as pl

from robodyn.trajectory.columns import Signal, Signals
from robodyn.trajectory.read import open_trajectory
from robodyn.trajectory.write import open_writer

JOINTS = 6
SIGNALS = Signals(tuple(Signal(f"joint{i}", "angle") for i in range(JOINTS)))


def make(path: Path, rows: int, quantities: Sequence[str], decimals: int | None = None) -> None:
    """A table of sines of different frequency."""
    t = np.arange(rows) / 1000.0
    columns = {"time": t}
    for i in range(JOINTS):
        angle = 2.0 * np.pi * (0.1 + 0.1 * i) * t
        values = {"q": np.sin(angle), "qd": np.cos(angle), "qdd": -np.sin(angle)}
        columns |= {f"{quantity}_joint{i}": values[quantity] for quantity in quantities}
    frame = pl.DataFrame(columns)
    (frame if decimals is None else frame.select(pl.all().round(decimals))).write_csv(path)


def alone(source: Path, target: Path) -> None:
    """What any program pays that uses polars: read all columns, write time and one column per joint."""
    frame = pl.read_csv(source)
    frame.select(frame.columns[: JOINTS + 1]).write_csv(target)


def ours(source: Path, target: Path) -> None:
    """The same through blocks of this package."""
    with open_trajectory(source, SIGNALS) as reader, open_writer(target, SIGNALS.positions) as writer:
        for block in reader.blocks():
            writer.write(block.time, block.q)


def seconds(act: Callable[[Path, Path], None], source: Path, target: Path) -> float:
    """The shorter of two runs."""
    spent = []
    for _ in range(2):
        start = time.perf_counter()
        act(source, target)
        spent.append(time.perf_counter() - start)
    return min(spent)


def main() -> None:
    rows = int(sys.argv[1]) if len(sys.argv) > 1 else 2_000_000
    cases: list[tuple[str, Sequence[str], int | None]] = [
        ("q, qd, qdd", ("q", "qd", "qdd"), None),
        ("q, clean: spline", ("q",), None),
        ("q, 6 decimals: Savitzky-Golay", ("q",), 6),
    ]
    print(f"{'table of ' + str(rows) + ' rows':32} {'MB':>6} {'polars s':>9} {'robodyn s':>9} {'ratio':>6}")
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in.csv", Path(folder) / "out.csv"
        for name, quantities, decimals in cases:
            make(source, rows, quantities, decimals)
            raw, mine = seconds(alone, source, target), seconds(ours, source, target)
            print(f"{name:32} {source.stat().st_size / 1e6:6.0f} {raw:9.2f} {mine:9.2f} {mine / raw:6.2f}")


if __name__ == "__main__":
    main()
