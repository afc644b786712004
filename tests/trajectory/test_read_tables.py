"""Tables: formats and readers agree, blocks change nothing, every bad input is one clear line."""

from __future__ import annotations

import io
import os
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from helpers.motions import Pieces, waves
from helpers.oracles import robot
from helpers.whole_tables import read_trajectory
from numpy.typing import NDArray

from robodyn.errors import TrajectoryError
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.options import Reading
from robodyn.trajectory.read import from_arrays, open_trajectory, row_at
from robodyn.trajectory.write import open_writer

ARM = Signals((Signal("a", "angle"), Signal("b", "length")))
SMALL, LARGE = 1 << 60, -1
HEADER = "time,q_a,q_b,qd_a,qd_b,qdd_a,qdd_b\n"


@pytest.fixture(params=[SMALL, LARGE], ids=["plain", "polars"])
def either_path(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robodyn.trajectory.formats.csv_table.LARGE", request.param)


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


def test_arrays_and_the_other_suffix_of_parquet(tmp_path: Path) -> None:
    v = numbers(20)
    pl.DataFrame(dict(zip(HEADER.strip().split(","), v.T, strict=True))).write_parquet(tmp_path / "t.pq")
    arrays = from_arrays(ARM, v[:, 0], v[:, 1:3], v[:, 3:5], v[:, 5:7])
    for result in (read_trajectory(tmp_path / "t.pq", ARM), arrays):
        np.testing.assert_array_equal(np.column_stack((result.time, result.q, result.qd, result.qdd)), v)


@pytest.mark.parametrize("suffix", ["npz", "parquet"])
def test_other_number_types(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"t.{suffix}"
    for dtype in ("float32", "int8", "uint16", "int64"):
        columns = {name: np.arange(1, 9).astype(dtype) for name in HEADER.strip().split(",")}
        np.savez(path, **columns) if suffix == "npz" else pl.DataFrame(columns).write_parquet(path)
        result = read_trajectory(path, ARM)
        assert result.q.dtype == np.float64
        np.testing.assert_array_equal(result.qdd[:, 1], np.arange(1, 9))


@pytest.mark.usefixtures("either_path")
def test_ignored_columns_may_hold_anything(tmp_path: Path) -> None:
    first, *lines = text(numbers()).splitlines()
    ignored = ("", "text", '"quoted"', "nan", "1e999")
    content = "\n".join([first + ",note", *(f"{line},{cell}" for line, cell in zip(lines, ignored, strict=True))])
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
def test_numbers_accepted_and_refused(tmp_path: Path) -> None:
    for cell in ACCEPTED:
        result = read(tmp_path, f"time;a;b\n0;{cell};1\n1;0;1\n2;0;3\n", derivatives="central")
        assert result.q[0, 0] == float(cell)
    for cell in (*REFUSED, *NOT_FINITE):
        problem = "is not a number" if cell in REFUSED else "is not finite"
        with pytest.raises(TrajectoryError) as caught:
            read(tmp_path, f"time;a;b\n0;1;1\n1;{cell};1\n2;3;3\n")
        assert f"t.csv:3: column 'a': {cell!r} {problem}".replace("\\", "") in str(caught.value).replace("\\", "")


Q = "time,q_a,q_b\n"
GOOD = "0,1,1\n1,2,1\n"
BAD_TEXT = [
    ("", "t.csv: is empty"),
    (Q + "\n\n", "t.csv: has no rows"),
    (Q + GOOD, "t.csv: has 2 rows, too few to differentiate"),
    (Q + GOOD + "2, ,1\n", "t.csv:4: column 'q_a' is empty"),
    (Q + GOOD + "2,1,\n", "t.csv:4: column 'q_b' is empty"),
    (Q + GOOD + ",1,1\n", "t.csv:4: column 'time' is empty"),
    (Q + GOOD + "\n\n2,1,x\n", "t.csv:6: column 'q_b': 'x' is not a number"),
    (Q + GOOD + "2,1\n", "t.csv:4: 2 cells where the header names 3 columns"),
    (Q + GOOD + "2,1\n3,1,1,1\n", "t.csv:4: 2 cells"),
    (Q + GOOD + "2,1,1,\n", "t.csv:4: 4 cells"),
    (Q + GOOD + "1,1,1\n", "t.csv:4: time 1.0 repeats 1.0 of the row before"),
    (Q + GOOD + "0.5,1,1\n", "t.csv:4: time 0.5 is before 1.0 of the row before"),
    (Q + GOOD + "nan,1,1\n", "t.csv:4: column 'time': 'nan' is not finite"),
    (Q + "\n0,1,1\n\n\n0,1,1\n2,1,1\n", "t.csv:6: time 0.0 repeats"),
    (Q + GOOD + "2,1,1 # note\n", "t.csv:4: column 'q_b': '1 # note' is not a number"),
    (Q + "2,1,NaN\n", "t.csv:2: column 'q_b': 'NaN' is not finite"),
    ("0,1,2\n1,2,3\n", "t.csv:1: no header: the first line holds numbers"),
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
    ("t.npz", npz(time=T, q=np.ones((3, 2)))[:-40], "cannot be read as .npz"),
    ("t.npz", npz(), "no column of time"),
    ("t.npz", npz(time=T, q=np.array([{}, 1, 2], dtype=object)), "Object arrays cannot be loaded"),
    ("t.npz", npz(time=T, q=np.ones((4, 2))), "'q[1]' has 4 rows, 'time' has 3"),
    ("t.npz", npz(time=T, q=np.ones((3, 3))), "unknown column 'q[3]'"),
    ("t.npz", npz(time=T, q=np.ones((3, 2, 1))), "array 'q' has shape (3, 2, 1)"),
    ("t.npz", npz(time=T, q=np.array([["a", "b"]] * 3)), "array 'q' holds <U1, not numbers"),
    ("t.npz", npz(time=T, q=np.array([[1, 2], [1, np.nan], [1, 2]])), "row 2: column 'q[2]' is empty or NaN"),
    ("t.npz", npz(time=T[::-1], q=np.ones((3, 2))), "row 2: time 1.0 is before 2.0"),
    ("t.npz", npz(time=T[:0], q=np.ones((0, 2))), "t.npz: has no rows"),
    ("t.parquet", b"", "t.parquet: is not a Parquet file, or is cut short"),
    ("t.parquet", b"PAR1" * 5, "cannot be read as Parquet"),
    ("t.parquet", parquet(time=T, a=T, b=T)[:-9], "is not a Parquet file, or is cut short"),
    ("t.parquet", parquet(time=T, a=["x"] * 3, b=T), "column 'a' holds string, not numbers"),
    ("t.parquet", parquet(time=T, a=[[1.0]] * 3, b=T), "column 'a' holds list, not numbers"),
    ("t.parquet", parquet(time=T, a=[1.0, None, 2.0], b=T), "row 2: column 'a' is empty or NaN"),
    ("t.parquet", parquet(time=T, a=[1.0, 2.0, np.inf], b=T), "row 3: column 'a' is inf"),
    ("t.parquet", parquet(time=T * 0, a=T, b=T), "row 2: time 0.0 repeats 0.0"),
    ("t.parquet", parquet(time=T[:0], a=T[:0], b=T[:0]), "t.parquet: has no rows"),
    ("t.xlsx", b"", "unknown type of table by this suffix"),
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
    with pytest.raises(TrajectoryError, match="unknown way to differentiate 'fourier'"):
        read(tmp_path, Q + GOOD, derivatives="fourier", name="u.csv")


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ((T, np.ones((3, 1))), "q has shape (3, 1) (it should be (N, 2))"),
        ((T[:, None], np.ones((3, 2))), "time has shape (3, 1)"),
        ((T, np.ones((4, 2))), "'q[1]' has 4 rows, 'time' has 3"),
        ((T, [["a", "b"]] * 3), "q is not an array of numbers"),
        ((T, np.full((3, 2), np.inf)), "row 1: column 'q[1]' is inf"),
        (([], np.ones((0, 2))), "has no rows"),
    ],
)
def test_bad_arrays(arrays: tuple[object, object], message: str) -> None:
    with pytest.raises(TrajectoryError) as caught:
        from_arrays(ARM, *arrays)
    assert message in str(caught.value)


def test_a_pipe_of_a_shell() -> None:
    reading, writing = os.pipe()
    os.write(writing, b"t a b\n0 1 0\n1 2 0\n2 4 0\n")
    os.close(writing)
    found = read_trajectory(f"/dev/fd/{reading}", ARM, reading=Reading("central"))
    os.close(reading)
    assert found.q[:, 0].tolist() == [1.0, 2.0, 4.0]


def test_line_of_a_late_row_in_a_large_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robodyn.trajectory.formats.csv_table.LARGE", LARGE)
    rows = [f"{i},{i % 7},1" for i in range(8_000)]
    rows[6_000] += "x"
    with pytest.raises(TrajectoryError, match=r"t.csv:6002: column 'q_b': '1x' is not a number"):
        read(tmp_path, Q + "\n".join(rows))
    rows[6_000], rows[5_000] = "6000,1,1", "4999,1,1"
    (tmp_path / "t.csv").write_text(Q + "\n".join(rows))
    late = pytest.raises(TrajectoryError, match=r"t.csv:5002: time 4999.0 repeats 4999.0")
    with late, open_trajectory(tmp_path / "t.csv", ARM, block_rows=100) as reader:
        list(reader.blocks())


def test_progress(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text(Q + "".join(f"{i},{i},{i}\n" for i in range(400)))
    with open_trajectory(path, ARM, reading=Reading("central"), block_rows=40) as reader:
        places = [reader.position_bytes for _ in reader.blocks()]
    assert reader.size_bytes == path.stat().st_size == places[-1]
    assert len(places) >= 10
    assert places == sorted(places)


Array = NDArray[np.float64]
SIGNALS = Signals((Signal("base", "floating"), Signal("a", "continuous"), Signal("b", "length")))
MODES = ["spline", "savgol", "central", "auto"]


def motion(rows: int, *, jitter: float = 0.0, noise: float = 0.0) -> dict[str, Array]:
    rng = np.random.default_rng(0)
    t = (np.arange(rows) + rng.uniform(-jitter, jitter, rows)) / 200.0
    half = 0.6 * np.sin(t) + 1.3 * t
    columns = {
        "time": t,
        "base_x": np.sin(t),
        "base_qx": np.sin(half) * 0.6,
        "base_qy": np.sin(half) * 0.8,
        "base_qz": 0 * t,
        "base_qw": np.cos(half),
        "q_a": (3 * t + np.sin(2 * t) + np.pi) % (2 * np.pi) - np.pi,
        "q_b": np.cos(3 * t),
    }
    return {name: c + (noise * rng.normal(size=rows) if name != "time" else 0) for name, c in columns.items()}


def write(path: Path, columns: dict[str, Array]) -> Path:
    names = [name for name in columns if name != "time"]
    with open_writer(path, names) as writer:
        writer.write(columns["time"], np.column_stack([columns[name] for name in names]))
    return path


DISTURBED = [(0.2, 1e-5), (0.2, 0.0), (0.0, 1e-5), (0.0, 0.0)]
"""How far stamps are off, of a step, and the noise of positions."""
CASES = [("csv", "auto", *DISTURBED[2]), ("npz", "auto", *DISTURBED[-1])]
SLOW = [("parquet", mode, *how) for mode, how in zip(MODES, DISTURBED, strict=True)]


@pytest.mark.parametrize(
    ("suffix", "mode", "jitter", "noise"), [*CASES, *(pytest.param(*case, marks=pytest.mark.slow) for case in SLOW)]
)
def test_blocks_change_nothing(tmp_path: Path, suffix: str, mode: str, jitter: float, noise: float) -> None:
    """The bound: 3e-11 of the largest derivative."""
    path = write(tmp_path / f"t.{suffix}", motion(900, jitter=jitter, noise=noise))
    whole = read_trajectory(path, SIGNALS, reading=Reading(mode))  # type: ignore[arg-type]
    with open_trajectory(path, SIGNALS, reading=Reading(mode), block_rows=180) as reader:  # type: ignore[arg-type]
        blocks = list(reader.blocks())
    assert len(blocks) >= 5
    assert all(len(block) <= 180 for block in blocks)
    assert [block.first_row for block in blocks] == [1 + sum(map(len, blocks[:i])) for i in range(len(blocks))]
    assert {block.derivation for block in blocks} == {whole.derivation}
    for name in ("time", "q"):
        np.testing.assert_array_equal(np.concatenate([getattr(block, name) for block in blocks]), getattr(whole, name))
    for name in ("qd", "qdd"):
        found = np.concatenate([getattr(block, name) for block in blocks])
        difference = np.abs(found - getattr(whole, name)).max(axis=0)
        assert (difference <= 3e-11 * np.abs(getattr(whole, name)).max()).all()


def test_blocks_shorter_than_the_halo_twice(tmp_path: Path) -> None:
    path = write(tmp_path / "t.parquet", motion(80))
    whole = read_trajectory(path, SIGNALS)
    with open_trajectory(path, SIGNALS, block_rows=7) as reader:
        first, second = (np.concatenate([block.qdd for block in reader.blocks()]) for _ in range(2))
    assert np.abs(first - whole.qdd).max() <= 1e-12 * np.abs(whole.qdd).max()
    assert first.tobytes() == second.tobytes()


def test_the_method_does_not_depend_on_blocks(tmp_path: Path) -> None:
    """Rest first, then a noisy motion: the method is chosen from all of the file, not from its first block."""
    t = np.arange(2_000) / 1000
    q = np.round(np.where(t < 1, 0.0, np.sin(t - 1)), 5)
    path = write(tmp_path / "t.npz", {"time": t, "q_a": q})
    one = Signals((Signal("a", "angle"),))
    with open_trajectory(path, one, block_rows=250) as reader:
        first = next(iter(reader.blocks()))
    assert first.derivation is not None
    assert first.derivation.joints[0].acceleration.startswith("local polynomials")
    assert first.derivation == read_trajectory(path, one).derivation


def test_the_nearest_row():
    table = Pieces(waves(robot("scara"), np.arange(10) * 0.5), [4, 5, 1])
    table.file = "table.csv"
    for time, row in ((0.0, 0), (0.24, 0), (0.25, 0), (0.26, 1), (1.5, 3), (2.1, 4), (4.5, 9)):
        found = row_at(table, time)
        assert (len(found), found.first_row) == (1, row + 1)
        for name in ("time", "q", "qd", "qdd"):
            assert np.array_equal(getattr(found, name)[0], getattr(table.trajectory, name)[row])
    for time in (-0.1, 4.6, float("nan"), float("inf")):
        with pytest.raises(TrajectoryError, match=r"outside the motion \(it lasts from 0 s to 4\.5 s\)"):
            row_at(table, time)
