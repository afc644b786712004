"""Inputs that never end, or that hold far more than they weigh, are refused."""

from __future__ import annotations

import os
import zipfile
from contextlib import suppress
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
from helpers.command_line import refused, run, write_arm

from robodyn.support.input_file import VARIABLE
from robodyn.trajectory.formats import table

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs devices and pipes")
SIMULATE = ("--duration", "0.01", "--step", "0.005")
CALLS = [
    ("check", "x.urdf"),
    ("torques", "arm.urdf", "arm.csv", "--scene", "x.toml"),
    ("simulate", "arm.urdf", "--scene", "x.toml", *SIMULATE),
    ("inertia", "x.stl", "--type", "stl"),
]


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_arm(tmp_path)
    monkeypatch.chdir(tmp_path)


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
