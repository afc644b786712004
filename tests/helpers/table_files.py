"""Motions of two joints in Parquet and .npz files, laid out in every way that the formats know."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.read import open_trajectory

Array = NDArray[np.float64]
SIGNALS = Signals((Signal("a", "angle"), Signal("b", "length")))
NAMES = ("time", "q_a", "q_b", "qd_a", "qd_b", "qdd_a", "qdd_b")
ROWS = 1000
ARCHIVES = [
    f"{layout} {method}"
    for layout in ("columns", "matrices", "matrices by columns")
    for method in ("stored", "deflated")
]
LAYOUTS: dict[str, dict[str, object]] = {
    "one group": {},
    "groups of 7": {"row_group_size": 7},
    "groups of 300": {"row_group_size": 300, "data_page_size": 256},
    "second pages": {"data_page_version": "2.0", "compression": "zstd"},
    "no dictionary": {"use_dictionary": False, "compression": "none"},
    "streams of bytes": {"use_dictionary": False, "use_byte_stream_split": True},
}
SOURCES = [*ARCHIVES, *LAYOUTS]


def numbers(rows: int = ROWS) -> Array:
    """Time in steps of 1/8, and random numbers in the columns of q, qd and qdd."""
    values = np.random.default_rng(0).normal(size=(rows, len(NAMES)))
    values[:, 0] = np.arange(rows) / 8.0
    return values


def columns(values: Array) -> dict[str, Array]:
    return dict(zip(NAMES, values.T, strict=True))


def stored(folder: Path, values: Array, source: str) -> Path:
    """The table in a file, in one of the ways of SOURCES."""
    if source in LAYOUTS:
        path = folder / "t.parquet"
        pq.write_table(pa.table(columns(values)), path, **LAYOUTS[source])
        return path
    path = folder / "t.npz"
    save = np.savez_compressed if "deflated" in source else np.savez
    if "matrices" not in source:
        save(path, **columns(values))
        return path
    order = np.asfortranarray if "by columns" in source else np.ascontiguousarray
    save(path, time=values[:, 0], q=order(values[:, 1:3]), qd=order(values[:, 3:5]), qdd=order(values[:, 5:7]))
    return path


def blocks(path: Path, rows: int) -> list[Array]:
    """Everything as it is read, so many rows at a time."""
    with open_trajectory(path, SIGNALS, block_rows=rows) as reader:
        return [np.column_stack((block.time, block.q, block.qd, block.qdd)) for block in reader.blocks()]
