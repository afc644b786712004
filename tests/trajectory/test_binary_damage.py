"""Damaged Parquet and .npz files: told in one line, with what does not fit."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from helpers.table_files import ARCHIVES, SIGNALS, blocks, columns, numbers, stored
from helpers.whole_tables import read_trajectory

from robodyn.errors import TrajectoryError


@pytest.mark.parametrize("source", ARCHIVES)
def test_a_check_sum_that_does_not_fit(tmp_path: Path, source: str) -> None:
    """Numbers that are read to the end are compared with it, whatever the size of blocks."""
    path = stored(tmp_path, numbers(), source)
    data = bytearray(path.read_bytes())
    data[data.rindex(b"PK\x01\x02") + 16] ^= 1
    path.write_bytes(data)
    for rows in (100, 1000, 7):
        with pytest.raises(TrajectoryError, match=r"cannot be read as .npz: Bad CRC-32 for file 'qdd(_b)?.npy'"):
            blocks(path, rows)


@pytest.mark.parametrize("source", ARCHIVES)
def test_a_flipped_bit_in_an_archive_is_told(tmp_path: Path, source: str) -> None:
    """By its check sum, before the last block is handed on."""
    path = stored(tmp_path, numbers(), source)
    data = bytearray(path.read_bytes())
    with zipfile.ZipFile(path) as archive:
        info = archive.infolist()[-1]
    data[info.header_offset + 200 + info.compress_size // 2] ^= 1
    path.write_bytes(data)
    with pytest.raises(TrajectoryError, match=r"cannot be read as .npz: (Bad CRC-32|Error -3)"):
        blocks(path, 100)


def rewritten(path: Path, change: Callable[[bytes], bytes], method: int = zipfile.ZIP_STORED) -> None:
    """The archive with its arrays changed and true check sums."""
    with zipfile.ZipFile(path) as archive:
        members = {name: change(archive.read(name)) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, data in members.items():
            archive.writestr(name, data)


@pytest.mark.parametrize(
    ("change", "method", "message"),
    [
        (lambda data: data[:-8], zipfile.ZIP_STORED, "time.npy holds fewer or more values than it says"),
        (lambda data: data + b"8 bytes.", zipfile.ZIP_DEFLATED, "time.npy holds fewer or more values than it says"),
        (lambda data: data[6:], zipfile.ZIP_STORED, "magic string"),
        (lambda data: data, zipfile.ZIP_BZIP2, "time.npy is compressed by a method that NumPy does not use"),
        (lambda data: data.replace(b"(1000", b"((((("), zipfile.ZIP_STORED, "cannot be read as .npz: "),
    ],
)
def test_arrays_that_are_not_what_they_say(
    tmp_path: Path, change: Callable[[bytes], bytes], method: int, message: str
) -> None:
    path = stored(tmp_path, numbers(), "columns stored")
    rewritten(path, change, method)
    with pytest.raises(TrajectoryError, match=message):
        blocks(path, 100)


def test_a_matrix_without_rows_of_columns_without_end(tmp_path: Path) -> None:
    np.savez(tmp_path / "t.npz", time=np.zeros(0), q=np.zeros((0, 10**12)))
    with pytest.raises(TrajectoryError, match=r"q.npy holds fewer or more values than it says"):
        read_trajectory(tmp_path / "t.npz", SIGNALS)


def test_a_single_array(tmp_path: Path) -> None:
    with (tmp_path / "t.npz").open("wb") as file:
        np.save(file, numbers())
    with pytest.raises(TrajectoryError, match="a single array, not an archive"):
        read_trajectory(tmp_path / "t.npz", SIGNALS)


@pytest.mark.parametrize("rows", [8, -9])
def test_row_groups_that_do_not_add_up(tmp_path: Path, rows: int) -> None:
    """The rows of the last group, 9 in the footer as a zigzag number after the head of field 3, are changed."""
    path = tmp_path / "t.parquet"
    pq.write_table(pa.table(columns(numbers(109))), path, row_group_size=100, store_schema=False)
    data = path.read_bytes()
    place = data.rindex(b"\x16\x12", 0, data.rindex(b"parquet-cpp")) + 1
    path.write_bytes(data[:place] + bytes([2 * rows if rows >= 0 else -2 * rows - 1]) + data[place + 1 :])
    with pytest.raises(TrajectoryError, match=r"t.parquet: cannot be read as Parquet: .* \(write it again\)"):
        read_trajectory(path, SIGNALS)
