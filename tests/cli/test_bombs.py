"""Small files that ask for much and inputs that never end: one line, within a minute of processor and 500 MB."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
from helpers.bombs import FEWER, MOST, TABLES, TOML, WAIVERS, Bounded, Command, bounded_commands, write_bomb
from helpers.command_line import refused, run, write_arm
from helpers.sampled import sampled

from robodyn.support.input_file import VARIABLE
from robodyn.trajectory.formats import table

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs limits of the system, devices and pipes")
COUNTED = {"values.yaml", "documents.yaml", "records.mcap", "lines.csv", "publishers.json", "values.json"}
"""What is refused only after much of it is counted: by default beyond fewer, some under `slow` beyond the usual."""
USES = [(name, use) for use in ("scene", "settings", "map") for name in TOML]
OFTEN = [pytest.param(*each, marks=[pytest.mark.slow] * (each[1] != "scene" and each[0] != "keys")) for each in USES]


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_arm(tmp_path)
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def bounded() -> Iterator[Command]:
    with bounded_commands() as run:
        yield run


def refused_within_bounds(outcome: Bounded, name: str) -> None:
    assert outcome.status == 2, outcome
    assert outcome.err.count("\n") == 1, outcome.err
    assert outcome.err.startswith(f"error: {name}"), outcome.err
    assert "out of memory" not in outcome.err
    assert outcome.memory < MOST, f"{outcome.memory >> 20} MB: {outcome.err}"


@pytest.mark.parametrize("name", sampled(TABLES, 6))
def test_tables(name: str, bounded: Command) -> None:
    write_bomb(Path(name))
    refused_within_bounds(bounded("torques", "arm.urdf", name, limits=FEWER if name in COUNTED else ""), name)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["values.json", "values.yaml", "lines.csv"])
def test_tables_beyond_the_usual_limits(name: str, bounded: Command) -> None:
    write_bomb(Path(name))
    refused_within_bounds(bounded("torques", "arm.urdf", name), name)


@pytest.mark.parametrize(("name", "use"), sampled(OFTEN, 5))
def test_scenes_and_settings(name: str, use: str, bounded: Command) -> None:
    Path("robodyn.toml" if use == "settings" else "x.toml").write_bytes(TOML[name])
    if use == "settings":
        refused_within_bounds(bounded("check", "arm.urdf"), "")
    else:
        said = {"scene": "x.toml", "map": "invalid value for '--map'"}[use]
        refused_within_bounds(bounded("torques", "arm.urdf", "arm.csv", f"--{use}", "x.toml"), said)


def test_settings_of_others(bounded: Command) -> None:
    """A pyproject.toml that does not name us is none of our business."""
    Path("pyproject.toml").write_bytes(TOML["keys"])
    assert bounded("check", "arm.urdf").status == 0


@pytest.mark.slow
def test_waivers_on_one_line(bounded: Command) -> None:
    """Time grows with their number, not with its square."""
    Path("r.urdf").write_text(WAIVERS)
    outcome = bounded("check", "r.urdf")
    assert outcome.status == 0, outcome.err[:500]
    assert outcome.memory < MOST


SIMULATE = ("--duration", "0.01", "--step", "0.005")
CALLS = [
    ("check", "x.urdf"),
    ("torques", "arm.urdf", "arm.csv", "--scene", "x.toml"),
    ("simulate", "arm.urdf", "--scene", "x.toml", *SIMULATE),
    ("inertia", "x.stl", "--type", "stl"),
]


@pytest.mark.parametrize("call", CALLS, ids=" ".join)
def test_a_pipe_without_end(call: tuple[str, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    """As `<(yes)` of shells, which the user has typed."""
    monkeypatch.setenv(VARIABLE, "file_bytes=5000,stream_bytes=5000")
    reader, writer = os.pipe()

    def write() -> None:
        with suppress(BrokenPipeError), open(writer, "wb", buffering=0) as stream:
            while True:
                stream.write(b"0" * 5000)

    thread = Thread(target=write, daemon=True)
    thread.start()
    outcome = run(*(f"/dev/fd/{reader}" if word.startswith("x.") else word for word in call))
    os.close(reader)
    thread.join(5.0)
    assert not thread.is_alive()
    refused(outcome, "")
    assert "5000" in outcome.err, outcome.err


def test_standard_input_without_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "file_bytes=5000,stream_bytes=5000")
    for call in (("check", "-"), ("torques", "arm.urdf", "arm.csv", "--scene", "-"), ("torques", "arm.urdf", "-")):
        refused(run(*call, stdin=b"0" * 6000), "<stdin>: too many bytes")


def test_a_pipe_that_is_typed_is_read() -> None:
    reader, writer = os.pipe()
    os.write(writer, Path("arm.urdf").read_bytes())
    os.close(writer)
    assert run("info", f"/dev/fd/{reader}").status == 0
    os.close(reader)


@pytest.mark.parametrize("kind", ["npz", "parquet"])
def test_a_table_that_holds_far_more_than_it_weighs(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(table, "_EXPANDED", 1 << 16)
    names = ["time", "q_shoulder", "q_elbow"]
    if kind == "npz":
        with zipfile.ZipFile("x.npz", "w", zipfile.ZIP_DEFLATED) as archive:
            for name in names:
                with archive.open(f"{name}.npy", "w") as stream:
                    np.lib.format.write_array(stream, np.zeros(500_000))
    else:
        import pyarrow as pa
        import pyarrow.parquet as pq

        pq.write_table(pa.table({name: np.zeros(500_000) for name in names}), "x.parquet")
    outcome = run("torques", "arm.urdf", f"x.{kind}")
    refused(outcome, f"x.{kind}:")
    assert "bytes that hold 12000" in outcome.err
