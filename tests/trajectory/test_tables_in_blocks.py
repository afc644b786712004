"""Tables are read and written in blocks: memory does not grow with their length, and files are as libraries write."""

from __future__ import annotations

import gc
import io
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from helpers.table_files import NAMES, ROWS, blocks, columns, numbers

from robodyn.trajectory.write import GROUP_ROWS, open_writer


@pytest.mark.parametrize("suffix", ["npz", "parquet"])
def test_writing_holds_a_part(tmp_path: Path, suffix: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robodyn.trajectory.write.GROUP_ROWS", 1000)
    most = []
    for rows in (10_000, 40_000):
        values, held = numbers(rows), []
        with open_writer(tmp_path / f"t.{suffix}", NAMES[1:]) as writer:
            before = pa.total_allocated_bytes()
            tracemalloc.start()
            for start in range(0, rows, 500):
                writer.write(values[start : start + 500, 0], values[start : start + 500, 1:])
                held.append(pa.total_allocated_bytes() - before)
        most.append(tracemalloc.get_traced_memory()[1] + max(held))
        tracemalloc.stop()
    assert most[1] - most[0] <= 200_000
    np.testing.assert_array_equal(np.concatenate(blocks(tmp_path / f"t.{suffix}", 10_000)), numbers(40_000))


def test_row_groups(tmp_path: Path) -> None:
    """Blocks are gathered to groups of a size that readers like; null is impossible, NaN stays."""
    with open_writer(tmp_path / "t.parquet", ["a"]) as writer:
        for start in range(0, GROUP_ROWS + 5000, 1000):
            writer.write(np.arange(start, start + 1000.0), np.full((1000, 1), np.nan if start else 1.0))
    file = pq.ParquetFile(tmp_path / "t.parquet")
    groups = [file.metadata.row_group(i).num_rows for i in range(file.num_row_groups)]
    assert len(groups) == 2
    assert groups[0] >= GROUP_ROWS
    assert [field.nullable for field in file.schema_arrow] == [False, False]
    frame = pl.read_parquet(tmp_path / "t.parquet")
    assert frame["time"].to_numpy().tobytes() == np.arange(len(frame), dtype=np.float64).tobytes()
    assert frame["a"].null_count() == 0
    assert frame["a"].is_nan().sum() == len(frame) - 1000


def test_an_archive_is_that_of_savez(tmp_path: Path) -> None:
    with open_writer(tmp_path / "ours.npz", NAMES[1:]) as writer:
        for start in range(0, ROWS, 300):
            writer.write(numbers()[start : start + 300, 0], numbers()[start : start + 300, 1:])
    stream = io.BytesIO()
    np.savez(stream, **columns(numbers()))
    assert (tmp_path / "ours.npz").read_bytes() == stream.getvalue()


@pytest.mark.parametrize("suffix", ["csv", "npz", "parquet"])
def test_a_writer_given_up_is_silent(tmp_path: Path, suffix: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """What libraries do when their objects go away raises nothing."""
    gc.freeze()  # what others have left is not looked at
    raised: list[object] = []
    monkeypatch.setattr(sys, "unraisablehook", raised.append)

    def give_up() -> None:
        with open_writer(tmp_path / f"t.{suffix}", NAMES[1:]) as writer:
            writer.write(numbers()[:, 0], numbers()[:, 1:])
            raise KeyError

    with pytest.raises(KeyError):
        give_up()
    gc.collect()
    assert not raised
    assert not list(tmp_path.iterdir())
