"""Stamps that count from a distant origin: times are relative to the first, exactly, the given ones are kept."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl
import pytest
from helpers.whole_tables import read_trajectory

from robodyn.errors import TrajectoryError
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.read import open_trajectory
from robodyn.trajectory.reader import row_at
from robodyn.trajectory.reading import Reading

ONE = Signals((Signal("a", "angle"),))
START = 1_700_000_000_123_456_789
"""Nanoseconds since 1970; a double is a multiple of 256 of them."""
STEPS = np.cumsum(np.random.default_rng(0).integers(900_000, 1_100_000, 200))
STAMPS = [START + int(step) for step in STEPS]
TIME = np.array([step - int(STEPS[0]) for step in STEPS.tolist()]) / 1e9
Q = np.sin(TIME)


def csv(path: Path, names: str, cells: list[str]) -> Path:
    path.write_text(
        "\n".join([f"{names},q_a", *(f"{cell},{q!r}" for cell, q in zip(cells, Q.tolist(), strict=True)), ""])
    )
    return path


def tables(folder: Path) -> list[tuple[Path, Reading]]:
    """The same stamps in every form that holds them."""
    whole = [f"{stamp}" for stamp in STAMPS]
    ints = np.array(STAMPS)
    parts = [divmod(stamp, 10**9) for stamp in STAMPS]
    pl.DataFrame({"time": ints, "q_a": Q}).write_parquet(folder / "t.parquet")
    np.savez(folder / "t.npz", time=ints, q_a=Q)
    np.savez(folder / "pair.npz", sec=np.array([s for s, _ in parts]), nanosec=np.array([n for _, n in parts]), q_a=Q)
    told = Reading("central", time_unit="ns")
    return [
        (csv(folder / "echo.csv", "%time", whole), Reading("central")),
        (csv(folder / "ns.csv", "time [ns]", whole), Reading("central")),
        (csv(folder / "pair.csv", "stamp.sec,stamp.nanosec", [f"{s},{n}" for s, n in parts]), Reading("central")),
        (csv(folder / "s.csv", "__time", [f"{s}.{n:09d}" for s, n in parts]), Reading("central")),
        (folder / "t.parquet", told),
        (folder / "t.npz", told),
        (folder / "pair.npz", Reading("central")),
    ]


@pytest.mark.parametrize("large", [1 << 60, -1], ids=["lines", "polars"])
def test_times_are_exact_in_every_form(large: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """To the bit those of the differences; through doubles they would be off by up to 128 ns."""
    monkeypatch.setattr("robodyn.trajectory.readers.csv_table.LARGE", large)
    for path, reading in tables(tmp_path):
        found = read_trajectory(path, ONE, reading=reading)
        np.testing.assert_array_equal(found.time, TIME, err_msg=path.name)
        assert found.origin == STAMPS[0] / 10**9
    rough = np.array(STAMPS, float) / 1e9
    assert np.abs(rough - rough[0] - TIME).max() > 5e-8


def test_given_stamps_are_kept_as_they_were(tmp_path: Path) -> None:
    for path, reading in tables(tmp_path):
        with open_trajectory(path, ONE, reading=reading, block_rows=64) as reader:
            given = np.concatenate([block.given_time for block in reader.blocks()])
        seconds = path.stem in ("pair", "s")
        expected = np.array([stamp / 10**9 if seconds else float(stamp) for stamp in STAMPS])
        np.testing.assert_array_equal(given, expected, err_msg=path.name)


def test_milliseconds_are_kept_for_output(tmp_path: Path) -> None:
    path = csv(tmp_path / "t.csv", "time_ms", [f"{1e3 * time!r}" for time in TIME.tolist()])
    found = read_trajectory(path, ONE, reading=Reading("central"))
    assert np.allclose(found.time, TIME, atol=1e-15)
    np.testing.assert_array_equal(found.given_time, 1e3 * TIME)


@pytest.mark.parametrize(
    ("row", "message"),
    [
        (f"{STAMPS[-1]},0", r"t.csv:202: time 0\.\d+ s after the first stamp repeats 0\.\d+ of the row before"),
        ("soon,0", "t.csv:202: column '%time': 'soon' is not a number"),
        ("1_800_000_000_000_000_000,0", "t.csv:202: column '%time': '1_800_000_000_000_000_000' is not a number"),
        (",0", "t.csv:202: column '%time' is empty"),
    ],
)
@pytest.mark.parametrize("large", [1 << 60, -1], ids=["lines", "polars"])
def test_bad_stamps_are_told_with_their_line(
    row: str, message: str, large: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("robodyn.trajectory.readers.csv_table.LARGE", large)
    path = csv(tmp_path / "t.csv", "%time", [f"{stamp}" for stamp in STAMPS])
    path.write_text(f"{path.read_text()}{row}\n")
    with pytest.raises(TrajectoryError, match=message):
        read_trajectory(path, ONE, reading=Reading("central"))


def test_a_row_is_found_by_the_time_since_the_first(tmp_path: Path) -> None:
    path, reading = tables(tmp_path)[0]
    with open_trajectory(path, ONE, reading=reading) as reader:
        assert row_at(reader, 0.1).time[0] == TIME[np.abs(TIME - 0.1).argmin()]
    with (
        open_trajectory(path, ONE, reading=reading) as reader,
        pytest.raises(TrajectoryError, match="it lasts from 0 s"),
    ):
        row_at(reader, START / 1e9)
