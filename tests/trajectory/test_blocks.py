"""Block by block or at once: the same samples, in bounded memory; the row nearest to a time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest
from helpers.motions import Pieces, waves
from helpers.oracles import robot
from helpers.whole_tables import read_trajectory
from numpy.typing import NDArray

from robodyn.errors import TrajectoryError
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.derivatives.standstill import REACH
from robodyn.trajectory.read import open_trajectory
from robodyn.trajectory.reader import TrajectoryReader, row_at
from robodyn.trajectory.readers.table import ArrayTable
from robodyn.trajectory.reading import Reading
from robodyn.trajectory.write import open_writer

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
QUICK = [("csv", mode, *how) for how in (DISTURBED[0], DISTURBED[-1]) for mode in ("auto",)]
CASES = [("csv", mode, *how) for how in DISTURBED for mode in MODES]
CASES += [(suffix, mode, *how) for suffix in ("parquet", "npz") for mode, how in zip(MODES, DISTURBED, strict=True)]
"""Of files that are not text, which are read as numbers at once, each method and each disturbance once."""


@pytest.mark.parametrize(
    ("suffix", "mode", "jitter", "noise"),
    [pytest.param(*case, marks=[pytest.mark.slow] * (case not in QUICK)) for case in CASES],
)
def test_blocks_change_nothing(tmp_path: Path, suffix: str, mode: str, jitter: float, noise: float) -> None:
    """The bound: 3e-11 of the largest derivative."""
    path = write(tmp_path / f"t.{suffix}", motion(2500, jitter=jitter, noise=noise))
    whole = read_trajectory(path, SIGNALS, reading=Reading(mode))  # type: ignore[arg-type]
    with open_trajectory(path, SIGNALS, reading=Reading(mode), block_rows=300) as reader:  # type: ignore[arg-type]
        blocks = list(reader.blocks())
    assert len(blocks) >= 9
    assert all(len(block) <= 300 for block in blocks)
    assert [block.first_row for block in blocks] == [1 + sum(map(len, blocks[:i])) for i in range(len(blocks))]
    assert {block.derivation for block in blocks} == {whole.derivation}
    for name in ("time", "q"):
        np.testing.assert_array_equal(np.concatenate([getattr(block, name) for block in blocks]), getattr(whole, name))
    for name in ("qd", "qdd"):
        found = np.concatenate([getattr(block, name) for block in blocks])
        difference = np.abs(found - getattr(whole, name)).max(axis=0)
        assert (difference <= 3e-11 * np.abs(getattr(whole, name)).max()).all()


@pytest.mark.parametrize("rows", [7, 50])
def test_blocks_shorter_than_the_halo(tmp_path: Path, rows: int) -> None:
    path = write(tmp_path / "t.npz", motion(300))
    whole = read_trajectory(path, SIGNALS)
    with open_trajectory(path, SIGNALS, block_rows=rows) as reader:
        qdd = np.concatenate([block.qdd for block in reader.blocks()])
    assert np.abs(qdd - whole.qdd).max() <= 1e-12 * np.abs(whole.qdd).max()


def test_a_reader_can_be_read_twice(tmp_path: Path) -> None:
    for suffix in ("csv", "parquet", "npz"):
        path = write(tmp_path / f"t.{suffix}", motion(500))
        with open_trajectory(path, SIGNALS, block_rows=100) as reader:
            first, second = list(reader.blocks()), list(reader.blocks())
        assert [block.qdd.tobytes() for block in first] == [block.qdd.tobytes() for block in second]


class CountingTable(ArrayTable):
    """Counts the rows that it has handed out."""

    handed_out = 0

    def blocks(self, columns: Sequence[int], rows: int) -> Iterator[Array]:
        for block in super().blocks(columns, rows):
            self.handed_out += len(block)
            yield block


BOUNDS = [("auto", 0.0, REACH), ("central", 0.0, REACH), ("auto", 1e-5, 1798)]


@pytest.mark.parametrize(("mode", "noise", "halo"), BOUNDS)
def test_rows_in_flight_are_bounded(mode: str, noise: float, halo: int) -> None:
    """The reader is ahead of what it has delivered by one block and the halo at most, however long the table is."""
    table = CountingTable(None, motion(6_000, noise=noise))
    reader = TrajectoryReader(table, SIGNALS, reading=Reading(mode), block_rows=500)  # type: ignore[arg-type]
    delivered, ahead = 0, []
    for block in reader.blocks():
        ahead.append(table.handed_out - delivered)
        delivered += len(block)
    assert delivered == 6_000
    assert max(ahead) <= 1000 + halo


def test_the_method_does_not_depend_on_blocks(tmp_path: Path) -> None:
    """Rest first, then a noisy motion: the method is chosen from all of the file, not from its first block."""
    t = np.arange(18_000) / 1000
    q = np.round(np.where(t < 12, 0.0, np.sin(t - 12)), 5)
    path = write(tmp_path / "t.csv", {"time": t, "q_a": q})
    one = Signals((Signal("a", "angle"),))
    with open_trajectory(path, one, block_rows=1000) as reader:
        first = next(iter(reader.blocks()))
    assert first.derivation is not None
    assert first.derivation.acceleration.startswith("local polynomials")
    assert first.derivation == read_trajectory(path, one).derivation


def test_errors_in_late_blocks_name_the_line(tmp_path: Path) -> None:
    path = write(tmp_path / "t.csv", motion(2500))
    lines = path.read_text().splitlines()
    lines[2000] = lines[1999]
    path.write_text("\n".join(lines))
    with (
        open_trajectory(path, SIGNALS, block_rows=100) as reader,
        pytest.raises(TrajectoryError, match=r"t\.csv:2001: time \S+ repeats"),
    ):
        list(reader.blocks())


def pieces(lengths):
    table = Pieces(waves(robot("scara"), np.arange(10) * 0.5), lengths)
    table.file = "table.csv"
    return table


@pytest.mark.parametrize("lengths", [[10], [1] * 10, [4, 5, 1]])
@pytest.mark.parametrize(("time", "row"), [(0.0, 0), (0.24, 0), (0.25, 0), (0.26, 1), (1.5, 3), (2.1, 4), (4.5, 9)])
def test_the_nearest_row(lengths, time, row):
    table = pieces(lengths)
    found = row_at(table, time)
    assert (len(found), found.first_row) == (1, row + 1)
    for name in ("time", "q", "qd", "qdd"):
        assert np.array_equal(getattr(found, name)[0], getattr(table.trajectory, name)[row])


@pytest.mark.parametrize("lengths", [[10], [3, 7]])
@pytest.mark.parametrize("time", [-0.1, 4.6, float("nan"), float("inf")])
def test_outside_the_motion(lengths, time):
    with pytest.raises(TrajectoryError, match=r"outside the motion \(it lasts from 0 s to 4\.5 s\)"):
        row_at(pieces(lengths), time)
