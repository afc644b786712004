"""Parquet and .npz: every way to lay out a file reads alike."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from helpers.table_files import NAMES, ROWS, SIGNALS, SOURCES, blocks, columns, numbers, stored
from helpers.whole_tables import read_trajectory

from robodyn.trajectory.read import open_table
from robodyn.trajectory.reading import Reading


@pytest.mark.parametrize("rows", [1, 64, ROWS, 5000])
@pytest.mark.parametrize("source", SOURCES)
def test_layouts(tmp_path: Path, source: str, rows: int) -> None:
    found = blocks(stored(tmp_path, numbers(), source), rows)
    assert max(map(len, found)) <= rows
    np.testing.assert_array_equal(np.concatenate(found), numbers())


@pytest.mark.parametrize("source", SOURCES)
def test_columns_of_blocks_are_contiguous(tmp_path: Path, source: str) -> None:
    table = open_table(stored(tmp_path, numbers(), source))
    assert all(block.T.flags.c_contiguous for block in table.blocks([0, 2, 5], 64))
    table.close()


@pytest.mark.parametrize("count", [1, 3, 16])
@pytest.mark.parametrize("source", SOURCES)
def test_pieces(tmp_path: Path, source: str, count: int) -> None:
    """Consecutive rows, as many as asked for, in different places, and from both halves of the table."""
    table = open_table(stored(tmp_path, numbers(), source))
    chosen = [i for i, name in enumerate(table.names) if name in ("time", "qd_b", "qd[2]")]
    found = table.pieces(chosen, count, 20)
    table.close()
    starts = [int(piece[0, 0] * 8.0) for piece in found]
    assert len(set(starts)) == len(starts) == count
    assert count == 1 or min(starts) < ROWS / 2 <= max(starts)
    for start, piece in zip(starts, found, strict=True):
        np.testing.assert_array_equal(piece, numbers()[start : start + 20, [0, 4]])


@pytest.mark.parametrize("source", SOURCES)
def test_a_short_table_is_one_piece(tmp_path: Path, source: str) -> None:
    table = open_table(stored(tmp_path, numbers(), source))
    (piece,) = table.pieces(range(7), 10, 100)
    table.close()
    np.testing.assert_array_equal(piece, numbers())


def test_a_column_whose_name_begins_others(tmp_path: Path) -> None:
    """To Parquet, `a.vel` may be a part of `a`."""
    names = dict(zip(NAMES, ("time", "a", "b", "a.vel", "b.vel", "a.acc", "b.acc"), strict=True))
    pq.write_table(pa.table({names[name]: v for name, v in columns(numbers()).items()}), tmp_path / "t.parquet")
    np.testing.assert_array_equal(np.concatenate(blocks(tmp_path / "t.parquet", 300)), numbers())


def test_decimals_and_large_integers(tmp_path: Path) -> None:
    large = pl.Series([2**53 + 1, -(2**60), 3])
    pl.DataFrame({"t": [0, 1, 2], "a": large, "b": pl.Series([0.5, 1.25, 2]).cast(pl.Decimal(10, 2))}).write_parquet(
        tmp_path / "t.parquet"
    )
    q = read_trajectory(tmp_path / "t.parquet", SIGNALS, reading=Reading("central")).q
    np.testing.assert_array_equal(q, [[2.0**53, 0.5], [-(2.0**60), 1.25], [3.0, 2.0]])
