"""Reading tables: the formats agree, the two CSV readers agree, and every bad input is one clear line."""

from __future__ import annotations

import io
import subprocess
import sys
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from helpers.whole_tables import read_trajectory

from robodyn.errors import TrajectoryError
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.read import from_arrays, open_trajectory
from robodyn.trajectory.reading import Reading

ARM = Signals((Signal("a", "angle"), Signal("b", "length")))
SMALL, LARGE = 1 << 60, -1
HEADER = "time,q_a,q_b,qd_a,qd_b,qdd_a,qdd_b\n"


@pytest.fixture(params=[SMALL, LARGE], ids=["plain", "polars"])
def either_path(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robodyn.trajectory.readers.csv_table.LARGE", request.param)


def numbers(rows: int = 5) -> np.ndarray:
    return np.column_stack((np.arange(rows) / 7.0, np.random.default_rng(0).normal(size=(rows, 6)) * 1e-3))


def text(values: np.ndarray, header: str = HEADER, mark: str = ",", end: str = "\n") -> str:
    lines = [mark.join(map(repr, row)) for row in values.tolist()]
    return end.join([header.strip().replace(",", mark), *lines, ""])


def read(folder: Path, content: str | bytes, signals: Signals = ARM, name: str = "t.csv", **options: object) -> object:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    extra = options.pop("extra", ())
    return read_trajectory(path, signals, extra=extra, reading=Reading(**options))


@pytest.mark.usefixtures("either_path")
@pytest.mark.parametrize(
    "content",
    [
        *(text(numbers(), mark=mark) for mark in (",", ";", "\t", " ", "   ", " , ")),
        text(numbers(), end="\r\n"),
        text(numbers()).rstrip("\n"),
        text(numbers()).replace("\n", "\n\n"),
        text(numbers()) + "\n \n\r\n",
        *(before + text(numbers()) for before in ("\ufeff", "# ", "\n\n")),
        text(numbers(), '"time","q_a","q_b","qd_a","qd_b","qdd_a","qdd_b"'),
    ],
    ids=range(14),
)
def test_dialects(tmp_path: Path, content: str) -> None:
    result = read(tmp_path, content)
    np.testing.assert_array_equal(np.column_stack((result.time, result.q, result.qd, result.qdd)), numbers())
    assert (result.derivation, result.first_row) == (None, 1)


@pytest.mark.parametrize("kind", ["columns.npz", "matrices.npz", "t.parquet", "t.pq", "arrays"])
def test_formats_agree(tmp_path: Path, kind: str) -> None:
    v = numbers(20)
    path = tmp_path / kind
    names = HEADER.strip().split(",")
    if kind == "columns.npz":
        np.savez(path, **{name: v[:, i] for i, name in enumerate(names)})
    elif kind == "matrices.npz":
        np.savez_compressed(path, time=v[:, 0], q=v[:, 1:3], qd=v[:, 3:5], qdd=v[:, 5:7])
    elif kind != "arrays":
        pl.DataFrame({name: v[:, i] for i, name in enumerate(names)}).write_parquet(path)
    if kind == "arrays":
        result = from_arrays(ARM, v[:, 0], v[:, 1:3], v[:, 3:5], v[:, 5:7])
    else:
        result = read_trajectory(path, ARM)
    np.testing.assert_array_equal(np.column_stack((result.time, result.q, result.qd, result.qdd)), v)


@pytest.mark.parametrize("dtype", ["float32", "int8", "uint16", "int64", "float64"])
@pytest.mark.parametrize("suffix", ["npz", "parquet"])
def test_other_number_types(tmp_path: Path, dtype: str, suffix: str) -> None:
    columns = {name: np.arange(1, 9).astype(dtype) for name in HEADER.strip().split(",")}
    path = tmp_path / f"t.{suffix}"
    np.savez(path, **columns) if suffix == "npz" else pl.DataFrame(columns).write_parquet(path)
    result = read_trajectory(path, ARM)
    assert result.q.dtype == np.float64
    np.testing.assert_array_equal(result.qdd[:, 1], np.arange(1, 9))


@pytest.mark.usefixtures("either_path")
@pytest.mark.parametrize("ignored", ["", "text", '"quoted"', "nan", "1e999"])
def test_ignored_columns_may_hold_anything(tmp_path: Path, ignored: str) -> None:
    lines = text(numbers()).splitlines()
    content = "\n".join([lines[0] + ",note", *(f"{line},{ignored}" for line in lines[1:])])
    result = read(tmp_path, content, ignore_extra=True)
    np.testing.assert_array_equal(result.qdd, numbers()[:, 5:7])
    assert result.notes == ("columns not used: 'note'",)


ACCEPTED = [
    *("1e5", "+1", ".5", "5.", "-.5e-3", "00012", "1E+5", "1e-400", "9007199254740993", "-0.0"),
    *(" 1.0", "1.0 ", "\t2"),
]
REFUSED = [
    *("1_000", "0x10", "1d5", "1e", "e5", "--1", "+-1", "-", ".", '"1"', "'1'", "1.2.3", "1 2", "true", "null", "1.0f"),
    *("\u0661", "\u00b2", "1\u00a0", "NA", "#N/A", "1j", "1,5", "0b1", "\x00", "1\x00", "pi"),
]
NOT_FINITE = ["nan", "NaN", "-nan", "inf", "-inf", "Infinity", "1e400", "-1e999", "INF"]


@pytest.mark.usefixtures("either_path")
@pytest.mark.parametrize("cell", ACCEPTED)
def test_numbers_accepted(tmp_path: Path, cell: str) -> None:
    result = read(tmp_path, f"time;a;b\n0;{cell};1\n1;0;1\n2;0;3\n", derivatives="central")
    assert result.q[0, 0] == float(cell)


@pytest.mark.usefixtures("either_path")
@pytest.mark.parametrize(
    ("cell", "problem"),
    [(cell, "is not a number") for cell in REFUSED] + [(cell, "is not finite") for cell in NOT_FINITE],
)
def test_numbers_refused(tmp_path: Path, cell: str, problem: str) -> None:
    with pytest.raises(TrajectoryError) as caught:
        read(tmp_path, f"time;a;b\n0;1;1\n1;{cell};1\n2;3;3\n")
    assert f"t.csv:3: column 'a': {cell!r} {problem}".replace("\\", "") in str(caught.value).replace("\\", "")


Q = "time,q_a,q_b\n"
GOOD = "0,1,1\n1,2,1\n"
BAD_TEXT = [
    ("", "t.csv: is empty"),
    ("\n\n \n", "t.csv: is empty"),
    (Q, "t.csv: has no rows"),
    (Q + "\n\n", "t.csv: has no rows"),
    (Q + GOOD, "t.csv: has 2 rows, too few to differentiate"),
    (Q + GOOD + "2,,1\n", "t.csv:4: column 'q_a' is empty"),
    (Q + GOOD + "2, ,1\n", "t.csv:4: column 'q_a' is empty"),
    (Q + GOOD + "2,1,\n", "t.csv:4: column 'q_b' is empty"),
    (Q + GOOD + ",1,1\n", "t.csv:4: column 'time' is empty"),
    (Q + GOOD + "2,x,1\n", "t.csv:4: column 'q_a': 'x' is not a number"),
    (Q + GOOD + "\n\n2,1,x\n", "t.csv:6: column 'q_b': 'x' is not a number"),
    (Q + GOOD + "2,1\n", "t.csv:4: 2 cells where the header names 3 columns"),
    (Q + GOOD + "2\n", "t.csv:4: 1 cell where the header names 3 columns"),
    (Q + GOOD + "2,1,1,1\n", "t.csv:4: 4 cells where the header names 3 columns"),
    (Q + GOOD + "2,1\n3,1,1,1\n", "t.csv:4: 2 cells"),
    (Q + GOOD + "2,1,1,\n", "t.csv:4: 4 cells"),
    (Q + GOOD + "1,1,1\n", "t.csv:4: time 1.0 repeats 1.0 of the row before"),
    (Q + GOOD + "0.5,1,1\n", "t.csv:4: time 0.5 is before 1.0 of the row before"),
    (Q + GOOD + "nan,1,1\n", "t.csv:4: column 'time': 'nan' is not finite"),
    (Q + "\n0,1,1\n\n\n0,1,1\n2,1,1\n", "t.csv:6: time 0.0 repeats"),
    (Q + GOOD + "# note\n", "t.csv:4: 1 cell"),
    (Q + GOOD + "2,1,1 # note\n", "t.csv:4: column 'q_b': '1 # note' is not a number"),
    (Q + "2,1,NaN\n", "t.csv:2: column 'q_b': 'NaN' is not finite"),
    ("0,1,2\n1,2,3\n", "t.csv:1: no header: the first line holds numbers"),
    ("time,q_a\n0,1\n", "t.csv:1: no position of joint 'b'"),
    ("time,q_a,q_b,q_c\n0,1,1,1\n", "t.csv:1: unknown column 'q_c'"),
    ("time,q_a,q_b,q_a\n0,1,1,1\n", "t.csv:1: column 'q_a' appears twice"),
    ("time,q_a,q_b,\n0,1,1,\n", "t.csv:1: column 4 of 4 has no name"),
    ("q_a,q_b\n0,1\n", "t.csv:1: no column of time"),
    ('"time,q_a,q_b\n0,1,1\n', "t.csv:1: the header cannot be read"),
    (b"\xff\xfe" + Q.encode("utf-16-le"), "t.csv:1: is UTF-16 data, not text"),
    (b"time,q_a,q_b\xe9\n0,1,1\n", "t.csv:1: the header is not UTF-8 text"),
    (b"PAR1\x00\x15\x04\x15\n", "t.csv:1: is Parquet data, not text"),
    (b"\x1f\x8b\x08\x00\x00\n", "t.csv:1: is gzip data, not text"),
    (bytes(range(256)) * 4, "t.csv:1: is binary data, not text"),
    (b"a" * (1 << 20), "t.csv:1: a column's name of 1048576 characters"),
    (Q.encode() + b"0,1,1\n" + b"7" * (9 << 20), "t.csv:3: too many bytes in a line, at most 1048576 are read"),
    ("time;q_a;q_b\n0;1,5;2\n", "(write decimals with a point)"),
]


@pytest.mark.usefixtures("either_path")
@pytest.mark.parametrize(("content", "message"), BAD_TEXT, ids=range(len(BAD_TEXT)))
def test_bad_text(tmp_path: Path, content: str | bytes, message: str) -> None:
    with pytest.raises(TrajectoryError) as caught:
        read(tmp_path, content)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def npz(**arrays: object) -> bytes:
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


def parquet(**columns: object) -> bytes:
    stream = io.BytesIO()
    pl.DataFrame(columns).write_parquet(stream)
    return stream.getvalue()


T = np.arange(3.0)
BAD_BINARY = [
    ("t.npz", b"", "t.npz: cannot be read as .npz"),
    ("t.npz", b"PK\x03\x04", "cannot be read as .npz"),
    ("t.npz", npz(time=T, q=np.ones((3, 2)))[:-40], "cannot be read as .npz"),
    ("t.npz", npz(time=T, q=np.ones((3, 2)))[:150], "cannot be read as .npz"),
    ("t.npz", npz(), "no column of time"),
    ("t.npz", npz(time=T, q=np.array([{}, 1, 2], dtype=object)), "Object arrays cannot be loaded"),
    ("t.npz", npz(time=T, q=np.ones((4, 2))), "'q[1]' has 4 rows, 'time' has 3"),
    ("t.npz", npz(time=T, q=np.ones((3, 3))), "unknown column 'q[3]'"),
    ("t.npz", npz(time=T, q=np.ones((3, 1))), "no position of joint 'b'"),
    ("t.npz", npz(time=T, q=np.ones((3, 2, 1))), "array 'q' has shape (3, 2, 1)"),
    ("t.npz", npz(time=T[:, None], q=np.ones((3, 2))), "array 'time' has shape (3, 1)"),
    ("t.npz", npz(time=T, q=np.array([["a", "b"]] * 3)), "array 'q' holds <U1, not numbers"),
    ("t.npz", npz(time=T, q=np.ones((3, 2)) * 1j), "array 'q' holds complex128, not numbers"),
    ("t.npz", npz(time=T, q=np.array([[1, 2], [1, np.nan], [1, 2]])), "row 2: column 'q[2]' is empty or NaN"),
    ("t.npz", npz(time=T[::-1], q=np.ones((3, 2))), "row 2: time 1.0 is before 2.0"),
    ("t.npz", npz(time=T[:0], q=np.ones((0, 2))), "t.npz: has no rows"),
    ("t.parquet", b"", "t.parquet: is not a Parquet file, or is cut short"),
    ("t.parquet", b"PAR1" * 5, "cannot be read as Parquet"),
    ("t.parquet", parquet(time=T, a=T, b=T)[:-9], "is not a Parquet file, or is cut short"),
    ("t.parquet", parquet(time=T, a=["x"] * 3, b=T), "column 'a' holds string, not numbers"),
    (
        "t.parquet",
        parquet(time=T, a=pl.Series(["x"] * 3, dtype=pl.Categorical), b=T),
        "column 'a' holds categorical",
    ),
    ("t.parquet", parquet(time=T, a=[[1.0]] * 3, b=T), "column 'a' holds list, not numbers"),
    ("t.parquet", parquet(time=T, a=[True] * 3, b=T), "column 'a' holds boolean, not numbers"),
    ("t.parquet", parquet(time=T, a=[1.0, None, 2.0], b=T), "row 2: column 'a' is empty or NaN"),
    ("t.parquet", parquet(time=T, a=[1.0, 2.0, np.inf], b=T), "row 3: column 'a' is inf"),
    ("t.parquet", parquet(time=T * 0, a=T, b=T), "row 2: time 0.0 repeats 0.0"),
    ("t.parquet", parquet(time=T[:0], a=T[:0], b=T[:0]), "t.parquet: has no rows"),
    ("t.parquet", parquet(a=T), "no column of time"),
    ("t.xlsx", b"", "unknown type of table by this suffix"),
    ("t", b"", "unknown type of table by this suffix"),
]


@pytest.mark.parametrize(("name", "content", "message"), BAD_BINARY, ids=range(len(BAD_BINARY)))
def test_bad_binary(tmp_path: Path, name: str, content: bytes, message: str) -> None:
    with pytest.raises(TrajectoryError) as caught:
        read(tmp_path, content, name=name)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("suffix", ["csv", "parquet", "npz"])
def test_files_that_cannot_be_opened(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"t.{suffix}"
    with pytest.raises(TrajectoryError, match="cannot be read: no such file"):
        read_trajectory(path, ARM)
    path.mkdir()
    with pytest.raises(TrajectoryError, match="is a directory"):
        read_trajectory(path, ARM)
    with pytest.raises(TrajectoryError, match="null"):
        read_trajectory(f"a\0b.{suffix}", ARM)


def test_unknown_type_and_method(tmp_path: Path) -> None:
    with pytest.raises(TrajectoryError, match="unknown type of table 'xls'"):
        read_trajectory("t.csv", ARM, file_type="xls")
    with pytest.raises(TrajectoryError, match="unknown way to differentiate 'fourier'"):
        read(tmp_path, Q + GOOD, derivatives="fourier")


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ((T, np.ones((3, 1))), "q has shape (3, 1) (it should be (N, 2))"),
        ((T[:, None], np.ones((3, 2))), "time has shape (3, 1)"),
        ((1.0, np.ones((3, 2))), "time has shape ()"),
        ((T, np.ones((4, 2))), "'q[1]' has 4 rows, 'time' has 3"),
        ((T, [["a", "b"]] * 3), "q is not an array of numbers"),
        ((T, np.full((3, 2), np.inf)), "row 1: column 'q[1]' is inf"),
        (([0, 1, 1], np.ones((3, 2))), "row 3: time 1.0 repeats 1.0"),
        (([], np.ones((0, 2))), "has no rows"),
    ],
)
def test_bad_arrays(arrays: tuple[object, object], message: str) -> None:
    with pytest.raises(TrajectoryError) as caught:
        from_arrays(ARM, *arrays)
    assert message in str(caught.value)


PROGRAM = """
import sys
from robodyn.errors import InputError
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.read import open_trajectory
from robodyn.trajectory.reading import Reading
try:
    signals = Signals((Signal("a", "angle"),))
    with open_trajectory(sys.argv[1], signals, file_type="csv", reading=Reading("central")) as reader:
        print(sum(block.q.sum() for block in reader.blocks()))
except InputError as error:
    print(error)
"""


@pytest.mark.parametrize(("path", "name"), [("-", "<stdin>"), ("/dev/stdin", "/dev/stdin")])
@pytest.mark.parametrize(
    ("more", "output"), [("", "7.0"), ("2,1\n", "{}:5: 1 cell where the header names 2 columns (repair the row)")]
)
def test_standard_input_and_pipes(path: str, name: str, more: str, output: str) -> None:
    content = f"t a\n0 1\n1 2\n2 4\n{more}"
    command = [sys.executable, "-c", PROGRAM, path]
    done = subprocess.run(command, input=content, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == output.format(name)


def test_line_of_a_late_row_in_a_large_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robodyn.trajectory.readers.csv_table.LARGE", LARGE)
    rows = [f"{i},{i % 7},1" for i in range(50_000)]
    rows[40_000] += "x"
    with pytest.raises(TrajectoryError, match=r"t.csv:40002: column 'q_b': '1x' is not a number"):
        read(tmp_path, Q + "\n".join(rows))
    rows[40_000], rows[30_000] = "40000,1,1", "29999,1,1"
    with pytest.raises(TrajectoryError, match=r"t.csv:30002: time 29999.0 repeats 29999.0"):
        read(tmp_path, Q + "\n".join(rows))


def test_progress(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text(Q + "".join(f"{i},{i},{i}\n" for i in range(30_000)))
    with open_trajectory(path, ARM, reading=Reading("central"), block_rows=1000) as reader:
        assert reader.columns == ("time", "q_a", "q_b")
        places = [reader.position_bytes for _ in reader.blocks()]
    assert reader.size_bytes == path.stat().st_size == places[-1]
    assert len(places) >= 30
    assert places == sorted(places)
