"""Damaged and random tables: the readers raise TrajectoryError or read, and the two CSV readers agree."""

from __future__ import annotations

import io
from functools import cache
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from helpers.whole_tables import read_trajectory
from hypothesis import given
from hypothesis import strategies as st

from robodyn.errors import TrajectoryError
from robodyn.trajectory.columns.signals import Signal, Signals

SIGNALS = Signals((Signal("a", "continuous"), Signal("b", "length")))
FREE = Signals((Signal("base", "floating"),))
TRICKY = [b"\n", b",", b"\r", b"\r\n\r\n", b"_", b"nan", b"1e999", b'"', b"\xff\xff\xff\x7f", b"\0", b" ", b";", b"-"]

edits = st.lists(
    st.tuples(
        st.sampled_from(["set", "cut", "insert", "end"]),
        st.integers(0, 1 << 16),
        st.one_of(st.binary(min_size=1, max_size=6), st.sampled_from(TRICKY)),
    ),
    min_size=1,
    max_size=4,
)


@cache
def table(suffix: str) -> bytes:
    time = np.arange(40) / 100
    columns = {"time": time, "q_a": np.sin(time), "q_b": np.cos(time)}
    stream = io.BytesIO()
    if suffix == "npz":
        np.savez(stream, **columns)
    elif suffix == "parquet":
        pl.DataFrame(columns).write_parquet(stream)
    else:
        pl.DataFrame(columns).write_csv(stream)
    return stream.getvalue()


def damage(data: bytes, changes: list[tuple[str, int, bytes]]) -> bytes:
    for kind, place, part in changes:
        i = place % max(1, len(data))
        if kind == "end":
            data = data[:i]
        else:
            skipped = {"set": len(part), "cut": 3 * len(part), "insert": 0}[kind]
            data = data[:i] + (b"" if kind == "cut" else part) + data[i + skipped :]
    return data


def outcome(path: Path, signals: Signals = SIGNALS) -> str | bytes:
    try:
        result = read_trajectory(path, signals)
    except TrajectoryError as error:
        return str(error)
    assert np.isfinite(result.qdd).all()
    return result.q.tobytes()


@given(edits)
def test_damaged_csv(tmp_path: Path, changes: list[tuple[str, int, bytes]]) -> None:
    check_both(tmp_path, damage(table("csv"), changes), SIGNALS)


@given(st.binary(max_size=200))
def test_random_bytes(tmp_path: Path, data: bytes) -> None:
    check_both(tmp_path, data, SIGNALS)


HEADERS = ["time,q_a,q_b", "time;q_a;q_b", "time\tq_a\tq_b", "time q_a q_b", "t,base_x,base_wz", "t,base_vy"]
cells = st.one_of(
    st.floats().map(repr),
    st.integers(-9, 9).map(str),
    st.sampled_from(["", " ", "1_0", "0x1", "+1", "1e5", " 2", "3 ", "\t4", "nan", "x", '"5"', "1e400", ".5", "5."]),
)


@given(
    st.sampled_from(
        ["time,q_a,q_b", "time;q_a;q_b", "time\tq_a\tq_b", "time q_a q_b", "t,base_x,base_qw", "t,base_wz"]
    ),
    st.lists(st.tuples(st.floats(0, 1e-3), st.lists(cells, min_size=1, max_size=3)), max_size=8),
    st.sampled_from(["\n", "\r\n", "\n\n"]),
)
def test_random_tables(tmp_path: Path, header: str, rows: list[tuple[float, list[str]]], end: str) -> None:
    mark = next(mark for mark in ",;\t " if mark in header)
    lines = [mark.join([repr(i + jitter), *cells]) for i, (jitter, cells) in enumerate(rows)]
    check_both(tmp_path, end.join([header, *lines]).encode(), FREE if "base" in header else SIGNALS)


def check_both(folder: Path, data: bytes, signals: Signals) -> None:
    path = folder / "t.csv"
    path.write_bytes(data)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("robodyn.trajectory.readers.csv_table.LARGE", 1 << 60)
        plain = outcome(path, signals)
        patch.setattr("robodyn.trajectory.readers.csv_table.LARGE", -1)
        assert outcome(path, signals) == plain


@given(edits)
def test_damaged_npz(tmp_path: Path, changes: list[tuple[str, int, bytes]]) -> None:
    path = tmp_path / "t.npz"
    path.write_bytes(damage(table("npz"), changes))
    outcome(path)


@given(edits)
def test_damaged_parquet(tmp_path: Path, changes: list[tuple[str, int, bytes]]) -> None:
    data = table("parquet")
    path = tmp_path / "t.parquet"
    path.write_bytes(data[:4] + damage(data[4:-8], changes) + data[-8:])
    outcome(path)
