"""Writing tables, whole or not at all, in bounded memory; Parquet and .npz in every layout, and damaged."""

from __future__ import annotations

import errno
import gc
import io
import os
import sys
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path
from threading import Thread

import numpy as np
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from helpers.whole_tables import read_trajectory
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from robodyn.errors import InputError, TrajectoryError
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.options import Reading
from robodyn.trajectory.read import open_table, open_trajectory
from robodyn.trajectory.write import FORMATS, GROUP_ROWS, Writer, lines_fast, lines_plain, open_writer

SUFFIXES = ["csv", "parquet", "npz"]


def fill(writer: Writer, blocks: int = 3) -> None:
    for i in range(blocks):
        writer.write(np.arange(4.0) + 4 * i, np.full((4, 2), i / 3))


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_round_trip(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"t.{suffix}"
    values = np.random.default_rng(0).normal(size=(50, 2)) * 10.0 ** np.arange(-25, 25)[:, None]
    with open_writer(path, ["q_a", "q_b"]) as writer:
        for i in range(0, 50, 20):
            writer.write(np.arange(i, min(i + 20, 50)) / 7, values[i : i + 20])
    result = read_trajectory(path, Signals((Signal("a", "angle"), Signal("b", "length"))), reading=Reading("central"))
    np.testing.assert_array_equal(result.q, values)
    np.testing.assert_array_equal(result.time, np.arange(50) / 7)
    assert os.listdir(tmp_path) == [path.name]
    with open_writer(path, ["tau_a,b"]):
        pass
    empty = {"csv": lambda: path.read_text() == 'time,"tau_a,b"\n', "npz": lambda: not np.load(path)["time"].shape[0]}
    assert empty.get(suffix, lambda: pl.read_parquet(path).shape == (0, 2))()
    with pytest.raises(ValueError, match="do not fit"), open_writer(path, ["a"]) as writer:
        writer.write(np.zeros(3), np.zeros((3, 2)))


@given(st.lists(st.floats(), min_size=1, max_size=20))
def test_both_writers_give_the_same_text(values: list[float]) -> None:
    column = np.array(values)[:, None]
    assert lines_plain(column) == b"".join(lines_fast(column))


def test_notations_of_small_and_large_tables(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    values = [1e-5, -1.25e-5, 1.5e-7, 1e15, 1e16, -1e22, 0.1, -0.0, np.nan, np.inf, 5e-324, 0.0001]
    text = "0.00001 -0.0000125 1.5e-7 1000000000000000.0 1e+16 -1e+22 0.1 -0.0 NaN inf 5e-324 0.0001"
    for limit in (10**9, 10):
        monkeypatch.setattr("robodyn.trajectory.write.LARGE", limit)
        with open_writer(tmp_path / "t.csv", ["a"]) as writer:
            writer.write(np.arange(12.0), np.array(values)[:, None])
        lines = (tmp_path / "t.csv").read_text().splitlines()
        assert [line.partition(",")[2] for line in lines] == ["a", *text.split()]


class Interrupted(BaseException):
    """Stands for Ctrl-C."""


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize(("old", "failure"), [(None, ValueError), (b"old", Interrupted)])
def test_an_error_in_between_leaves_nothing(
    tmp_path: Path, suffix: str, old: bytes | None, failure: type[BaseException], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / f"t.{suffix}"
    if old:
        path.write_bytes(old)

    def stop_half_way() -> None:
        with open_writer(path, ["a", "b"]) as writer:
            fill(writer)
            raise failure

    raised: list[object] = []
    monkeypatch.setattr(sys, "unraisablehook", raised.append)
    with pytest.raises(failure):
        stop_half_way()
    gc.collect(0)
    assert not raised, "what libraries do when their objects go away"
    assert [p.read_bytes() for p in tmp_path.iterdir()] == ([old] if old else [])


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no named pipes")
def test_a_table_that_was_given_up_does_not_reach_a_pipe_as_whole(tmp_path: Path) -> None:
    path, found = tmp_path / "t.parquet", list[bytes]()
    os.mkfifo(path)
    reader = Thread(target=lambda: found.append(path.read_bytes()))
    reader.start()

    def stop_half_way() -> None:
        with open_writer(path, ["a", "b"]) as writer:
            writer.write(np.arange(float(GROUP_ROWS)), np.zeros((GROUP_ROWS, 2)))
            fill(writer)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stop_half_way()
    reader.join()
    assert found[0].startswith(b"PAR1")
    with pytest.raises(pl.exceptions.ComputeError):
        pl.read_parquet(found[0])


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize(("step", "old"), [("begin", None), ("add", b"old"), ("end", b"old")])
def test_a_full_disk_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str, old: bytes | None, step: str
) -> None:
    path = tmp_path / f"t.{suffix}"
    if old:
        path.write_bytes(old)

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(FORMATS[suffix], step, full)
    with pytest.raises(InputError) as caught, open_writer(path, ["a", "b"]) as writer:
        fill(writer)
    assert str(caught.value) == f"{path}: cannot be written: no space left on device (nothing was written)"
    assert [p.read_bytes() for p in tmp_path.iterdir()] == ([old] if old else [])


def test_places_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "file").touch()
    for path, message in (
        (tmp_path / "missing" / "t.csv", "cannot be written: no such file or directory"),
        (tmp_path / "folder.csv", "cannot be written: is a directory"),
        (tmp_path / "file" / "t.csv", "cannot be written: not a directory"),
        (tmp_path / "t.xlsx", "by this suffix"),
        (tmp_path / "t", "by this suffix"),
    ):
        with pytest.raises(InputError, match=message), open_writer(path, ["a"]):
            pass
    wrong = pytest.raises(InputError, match="column 'time' would be written twice")
    with wrong, open_writer(tmp_path / "t.csv", ["a", "time"]):
        pass


Array = NDArray[np.float64]
SIGNALS = Signals((Signal("a", "angle"), Signal("b", "length")))
NAMES = ("time", "q_a", "q_b", "qd_a", "qd_b", "qdd_a", "qdd_b")
ROWS = 1000
ARCHIVES = ["columns stored", "columns deflated", "matrices stored", "matrices by columns deflated"]
LAYOUTS: dict[str, dict[str, object]] = {
    "one group": {},
    "groups of 7": {"row_group_size": 7},
    "second pages": {"row_group_size": 300, "data_page_version": "2.0", "compression": "zstd"},
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


@pytest.mark.parametrize("source", SOURCES)
def test_layouts(tmp_path: Path, source: str) -> None:
    """Pieces are consecutive rows, as many as asked for, in different places, and from both halves of the table."""
    path = stored(tmp_path, numbers(), source)
    for rows in (128, 5000):
        found = blocks(path, rows)
        assert max(map(len, found)) <= rows
        np.testing.assert_array_equal(np.concatenate(found), numbers())
    table = open_table(path)
    chosen = [i for i, name in enumerate(table.names) if name in ("time", "qd_b", "qd[2]")]
    for count in (1, 16):
        pieces = table.pieces(chosen, count, 20)
        starts = [int(piece[0, 0] * 8.0) for piece in pieces]
        assert len(set(starts)) == len(starts) == count
        assert count == 1 or min(starts) < ROWS / 2 <= max(starts)
        for start, piece in zip(starts, pieces, strict=True):
            np.testing.assert_array_equal(piece, numbers()[start : start + 20, [0, 4]])
    table.close()


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


@pytest.mark.parametrize("source", [ARCHIVES[0], ARCHIVES[3]])
def test_a_check_sum_that_does_not_fit(tmp_path: Path, source: str) -> None:
    """Numbers that are read to the end are compared with it, whatever the size of blocks."""
    path = stored(tmp_path, numbers(), source)
    data = bytearray(path.read_bytes())
    data[data.rindex(b"PK\x01\x02") + 16] ^= 1
    path.write_bytes(data)
    for rows in (1000, 7):
        with pytest.raises(TrajectoryError, match=r"cannot be read as .npz: Bad CRC-32 for file 'qdd(_b)?.npy'"):
            blocks(path, rows)


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


@pytest.mark.parametrize("suffix", ["npz", "parquet"])
def test_writing_holds_a_part(tmp_path: Path, suffix: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robodyn.trajectory.write.GROUP_ROWS", 1000)
    most = []
    for rows in (3_000, 9_000):
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
    np.testing.assert_array_equal(np.concatenate(blocks(tmp_path / f"t.{suffix}", 10_000)), numbers(9_000))


def test_row_groups(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Blocks are gathered to groups of a size that readers like; null is impossible, NaN stays."""
    monkeypatch.setattr("robodyn.trajectory.write.GROUP_ROWS", 1000)
    with open_writer(tmp_path / "t.parquet", ["a"]) as writer:
        for start in range(0, 1200, 100):
            writer.write(np.arange(start, start + 100.0), np.full((100, 1), np.nan if start else 1.0))
    file = pq.ParquetFile(tmp_path / "t.parquet")
    assert [file.metadata.row_group(i).num_rows for i in range(file.num_row_groups)] == [1000, 200]
    assert [field.nullable for field in file.schema_arrow] == [False, False]
    frame = pl.read_parquet(tmp_path / "t.parquet")
    assert frame["time"].to_numpy().tobytes() == np.arange(1200, dtype=np.float64).tobytes()
    assert (frame["a"].null_count(), frame["a"].is_nan().sum()) == (0, 1100)


def test_an_archive_is_that_of_savez(tmp_path: Path) -> None:
    with open_writer(tmp_path / "ours.npz", NAMES[1:]) as writer:
        for start in range(0, ROWS, 300):
            writer.write(numbers()[start : start + 300, 0], numbers()[start : start + 300, 1:])
    stream = io.BytesIO()
    np.savez(stream, **columns(numbers()))
    assert (tmp_path / "ours.npz").read_bytes() == stream.getvalue()
