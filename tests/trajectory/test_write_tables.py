"""Writing tables: whole or not at all, the same text from both writers, numbers that read back bit by bit."""

from __future__ import annotations

import errno
import os
import resource
import subprocess
import sys
from pathlib import Path
from threading import Thread

import numpy as np
import polars as pl
import pytest
from helpers.whole_tables import read_trajectory
from hypothesis import given
from hypothesis import strategies as st

from robodyn.errors import InputError
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.reading import Reading
from robodyn.trajectory.write import (
    GROUP_ROWS,
    CsvWriter,
    NpzWriter,
    ParquetWriter,
    Writer,
    lines_fast,
    lines_plain,
    open_writer,
)

SUFFIXES = ["csv", "parquet", "npz"]
FORMATS = {"csv": CsvWriter, "parquet": ParquetWriter, "npz": NpzWriter}


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


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_no_rows(tmp_path: Path, suffix: str) -> None:
    with open_writer(tmp_path / f"t.{suffix}", ["a"]):
        pass
    if suffix == "csv":
        assert (tmp_path / "t.csv").read_text() == "time,a\n"
    elif suffix == "npz":
        assert np.load(tmp_path / "t.npz")["a"].shape == (0,)
    else:
        assert pl.read_parquet(tmp_path / "t.parquet").shape == (0, 2)


def test_header_quotes_names_with_commas(tmp_path: Path) -> None:
    with open_writer(tmp_path / "t.csv", ["tau_a,b"]) as writer:
        writer.write(np.zeros(1), np.zeros((1, 1)))
    assert (tmp_path / "t.csv").read_text() == 'time,"tau_a,b"\n0.0,0.0\n'


@given(st.lists(st.floats(), min_size=1, max_size=20))
def test_both_writers_give_the_same_text(values: list[float]) -> None:
    column = np.array(values)[:, None]
    assert lines_plain(column) == b"".join(lines_fast(column))


def test_notations() -> None:
    values = [1e-5, -1.25e-5, 1.5e-7, 1e15, 1e16, -1e22, 0.1, -0.0, np.nan, np.inf, 5e-324, 0.0001]
    text = "0.00001 -0.0000125 1.5e-7 1000000000000000.0 1e+16 -1e+22 0.1 -0.0 NaN inf 5e-324 0.0001"
    assert lines_plain(np.array(values)[:, None]).decode().split() == text.split()


def test_large_tables_go_through_polars(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, limit in (("small.csv", 10**9), ("large.csv", 10)):
        monkeypatch.setattr("robodyn.trajectory.write.LARGE", limit)
        with open_writer(tmp_path / name, ["a", "b"]) as writer:
            fill(writer)
    assert (tmp_path / "small.csv").read_bytes() == (tmp_path / "large.csv").read_bytes()


class Interrupted(BaseException):
    """Stands for Ctrl-C."""


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("old", [None, b"old"])
@pytest.mark.parametrize("failure", [ValueError, Interrupted])
def test_an_error_in_between_leaves_nothing(
    tmp_path: Path, suffix: str, old: bytes | None, failure: type[BaseException]
) -> None:
    path = tmp_path / f"t.{suffix}"
    if old:
        path.write_bytes(old)

    def stop_half_way() -> None:
        with open_writer(path, ["a", "b"]) as writer:
            fill(writer)
            raise failure

    with pytest.raises(failure):
        stop_half_way()
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
@pytest.mark.parametrize("old", [None, b"old"])
@pytest.mark.parametrize("step", ["begin", "add", "end"])
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


PROGRAM = """
import resource, sys
import numpy as np
from robodyn.errors import InputError
from robodyn.trajectory.write import open_writer
resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
try:
    with open_writer(sys.argv[1], ["a", "b"]) as writer:
        for i in range(50):
            writer.write(np.random.rand(40), np.random.rand(40, 2))
except InputError as error:
    print(error)
"""


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_file_that_may_not_grow(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"t.{suffix}"
    path.write_bytes(b"old")
    done = subprocess.run([sys.executable, "-B", "-c", PROGRAM, str(path)], capture_output=True, text=True, check=True)
    assert done.stdout.startswith(f"{path}: cannot be written: ")
    assert "file too large" in done.stdout
    assert done.stdout.count("\n") == 1
    assert done.stderr == ""
    assert [p.read_bytes() for p in tmp_path.iterdir()] == [b"old"]
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] != 2000


def test_places_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "file").touch()
    for path, message in (
        (tmp_path / "missing" / "t.csv", "cannot be written: no such file or directory"),
        (tmp_path / "folder.csv", "cannot be written: is a directory"),
        (tmp_path / "file" / "t.csv", "cannot be written: not a directory"),
    ):
        with pytest.raises(InputError, match=message), open_writer(path, ["a"]):
            pass
    for path, message in ((tmp_path / "t.xlsx", "by this suffix"), (tmp_path / "t", "by this suffix")):
        with pytest.raises(InputError, match=message), open_writer(path, ["a"]):
            pass
    wrong = pytest.raises(InputError, match="column 'time' would be written twice")
    with wrong, open_writer(tmp_path / "t.csv", ["a", "time"]):
        pass


def test_shapes_that_do_not_fit(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="do not fit"), open_writer(tmp_path / "t.csv", ["a"]) as writer:
        writer.write(np.zeros(3), np.zeros((3, 2)))
    assert not list(tmp_path.iterdir())
