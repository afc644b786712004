"""Inputs that never end, or that hold far more than they weigh, are refused."""

from __future__ import annotations

import os
import zipfile
from contextlib import suppress
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
from helpers.command_line import run, write_arm

from robodyn.robot.urdf import xacro
from robodyn.support import input_file
from robodyn.trajectory import table

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs devices and pipes")
SIMULATE = ("--duration", "0.01", "--step", "0.005")
CALLS = [
    ("check", "x.urdf"),
    ("info", "x.urdf"),
    ("torques", "arm.urdf", "arm.csv", "--scene", "x.toml"),
    ("simulate", "arm.urdf", "--scene", "x.toml", *SIMULATE),
    ("check", "arm.urdf", "--config", "x.toml"),
    ("check", "arm.urdf", "--baseline", "x.json"),
    ("torques", "arm.urdf", "x.csv"),
    ("torques", "arm.urdf", "x.npz"),
    ("torques", "arm.urdf", "x.parquet"),
    ("inertia", "x.stl"),
    ("inertia", "x.obj"),
    ("inertia", "x.glb"),
]
EACH = pytest.mark.parametrize("call", CALLS, ids=" ".join)


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_arm(tmp_path)
    monkeypatch.chdir(tmp_path)


def refused(call: tuple[str, ...], words: str) -> None:
    outcome = run(*call)
    assert outcome.status == 2
    assert outcome.err.count("\n") == 1
    name = next(part for part in call if part.startswith("x."))
    assert outcome.err.startswith(f"error: {name}: "), outcome.err
    assert words in outcome.err


def name_of(call: tuple[str, ...]) -> str:
    return next(part for part in call if part.startswith("x."))


@EACH
def test_a_link_to_an_endless_device(call: tuple[str, ...]) -> None:
    os.symlink("/dev/zero", name_of(call))
    refused(call, "is a device, not a file")


@EACH
def test_a_pipe_that_nobody_writes_to(call: tuple[str, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(input_file, "PATIENCE", 0.01)
    os.mkfifo(name_of(call))
    refused(call, "nobody has written to")


@EACH
def test_a_pipe_without_end(call: tuple[str, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(input_file, "MOST", 5000)
    monkeypatch.setattr(input_file, "MOST_PIPED", 5000)
    os.mkfifo(name_of(call))

    def write() -> None:
        with suppress(BrokenPipeError), open(name_of(call), "wb", buffering=0) as stream:
            while True:
                stream.write(b"0" * 5000)

    writer = Thread(target=write, daemon=True)
    writer.start()
    outcome = run(*call)
    writer.join(5.0)
    assert not writer.is_alive()
    assert outcome.status == 2
    assert outcome.err.count("\n") == 1
    assert outcome.err.startswith(f"error: {name_of(call)}: "), outcome.err


def test_a_pipe_that_ends_is_read() -> None:
    os.mkfifo("x.urdf")
    Thread(target=lambda: Path("x.urdf").write_bytes(Path("arm.urdf").read_bytes()), daemon=True).start()
    assert run("info", "x.urdf").status == 0


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
    refused(("torques", "arm.urdf", f"x.{kind}"), "bytes that hold 12000")


@pytest.mark.parametrize("expression", ["9**9**9", "[0] * 9**12"])
def test_an_expression_of_xacro_without_end(expression: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(xacro, "PATIENCE", 1.0)
    text = f'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="a${{{expression}}}"/></robot>'
    Path("x.xacro").write_text(text)
    refused(("info", "x.xacro"), "xacro cannot expand it")
