"""Tables of 19 columns read and written in blocks, against the raw library with the whole table at once.

    cd tests && python -m benchmarks.bench_tables [--rows N] [--turns N] [--write FILE]

robodyn reads a trajectory of six joints (time, q, qd, qdd) to the end and writes a table of 19 columns block by block.
The raw library of Parquet and CSV is polars (to NumPy arrays and from them), that of .npz NumPy. Both run in one
process with the same threads and take turns, and the medians count; a tenth of the rows shows what starting costs.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from statistics import median

import numpy as np
import polars as pl
from benchmarks.timing import in_turns
from helpers.machine import machine
from helpers.markdown_tables import main, table

from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.read import BLOCK_ROWS, open_trajectory
from robodyn.trajectory.write import open_writer

Arrays = dict[str, np.ndarray]
Act = Callable[[], object]
JOINTS = [f"joint{i}" for i in range(6)]
SIGNALS = Signals(tuple(Signal(name, "angle") for name in JOINTS))
HEAD = ("table", "rows x columns", "robodyn", "raw library", "ratio")


def motion(rows: range, joints: Sequence[str] = JOINTS) -> Arrays:
    """Sines of 1 ms steps with full digits: time, and q, qd and qdd of every joint, within 0.3 rad."""
    t = np.array(rows) * 1e-3
    w = {name: 0.3 + 0.11 * i for i, name in enumerate(joints)}
    columns = {"time": t}
    columns |= {f"q_{name}": 0.3 * np.sin(k * t) for name, k in w.items()}
    columns |= {f"qd_{name}": 0.3 * k * np.cos(k * t) for name, k in w.items()}
    columns |= {f"qdd_{name}": -0.3 * k * k * np.sin(k * t) for name, k in w.items()}
    return columns


def matrices(columns: Arrays) -> Arrays:
    """The same motion as time and matrices q, qd and qdd."""
    parts = {kind: [columns[f"{kind}_{name}"] for name in JOINTS] for kind in ("q", "qd", "qdd")}
    return {"time": columns["time"], **{kind: np.column_stack(part) for kind, part in parts.items()}}


def read_blocks(path: Path) -> int:
    with open_trajectory(path, SIGNALS) as reader:
        return sum(len(block) for block in reader.blocks())


def write_blocks(path: Path, names: list[str], time: np.ndarray, values: np.ndarray) -> None:
    with open_writer(path, names) as writer:
        for start in range(0, len(time), BLOCK_ROWS):
            block = slice(start, start + BLOCK_ROWS)
            writer.write(time[block], values[block])


def arrays_of(frame: pl.DataFrame) -> Arrays:
    return {column.name: column.cast(pl.Float64).to_numpy() for column in frame}


def load(path: Path) -> Arrays:
    with np.load(path) as archive:
        return dict(archive)


def seconds(act: Act, written: Path) -> float:
    """Seconds that it takes, once what was written before is removed."""
    for path in written.iterdir():
        path.unlink()
    start = time.perf_counter()
    act()
    return time.perf_counter() - start


def cases(columns: Arrays, folder: Path) -> Mapping[str, tuple[Act, Act]]:
    """Pairs of what robodyn does and what the raw library does, by the title of the row; the files are made here."""
    source = {kind: folder / f"in.{kind}" for kind in ("parquet", "npz", "csv")}
    target = {kind: folder / "written" / f"out.{kind}" for kind in source}
    frame, square = pl.DataFrame(columns), folder / "matrices.npz"
    frame.write_parquet(source["parquet"])
    frame.write_csv(source["csv"])
    np.savez(source["npz"], **columns)
    np.savez(square, **matrices(columns))

    time, names = columns["time"], list(columns)[1:]
    values = np.array([columns[name] for name in names]).T

    def reading(path: Path, raw: Act) -> tuple[Act, Act]:
        return lambda: read_blocks(path), raw

    def writing(kind: str, raw: Callable[[Path], object]) -> tuple[Act, Act]:
        return lambda: write_blocks(target[kind], names, time, values), lambda: raw(target[kind])

    return {
        "Parquet, read": reading(source["parquet"], lambda: arrays_of(pl.read_parquet(source["parquet"]))),
        ".npz of columns, read": reading(source["npz"], lambda: load(source["npz"])),
        ".npz of matrices, read": reading(square, lambda: load(square)),
        "CSV, read": reading(source["csv"], lambda: arrays_of(pl.read_csv(source["csv"]))),
        "Parquet, written": writing("parquet", lambda path: pl.DataFrame(columns).write_parquet(path)),
        ".npz, written": writing("npz", lambda path: np.savez(path, **columns)),
        "CSV, written": writing("csv", lambda path: pl.DataFrame(columns).write_csv(path)),
    }


def measured(rows: int, turns: int) -> list[tuple[str, ...]]:
    """The rows of the report for one length of table."""
    columns, shown = motion(range(rows)), []
    with tempfile.TemporaryDirectory() as folder:
        written = Path(folder) / "written"
        written.mkdir()
        for title, acts in cases(columns, Path(folder)).items():
            found = in_turns({k: partial(seconds, act, written) for k, act in enumerate(acts)}, turns)
            mine, theirs = (median(each) for each in found.values())
            times = (f"{1e3 * mine:.0f} ms", f"{1e3 * theirs:.0f} ms", f"{mine / theirs:.2f}")
            shown.append((title, f"{rows} x {len(columns)}", *times))
    return shown


def report(rows: int, turns: int) -> str:
    return table(HEAD, [*measured(rows, turns), *measured(rows // 10, turns)]) + "\n" + machine("polars", "pyarrow")


if __name__ == "__main__":
    main(report, __doc__, rows=2_000_000, turns=7)
