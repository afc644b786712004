"""Inputs that are wrong: one line that says where and what, exit status 2, and nothing else; rooms have the others."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
from helpers.command_line import ARM, Outcome, motion, run, write_arm

BINARY = bytes(range(256))
GOOD = motion(10)
OLD = b"time,tau_old\n0,1\n"


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_arm(tmp_path)
    (tmp_path / "tau.csv").write_bytes(OLD)
    monkeypatch.chdir(tmp_path)


def refused(outcome: Outcome, pattern: str) -> None:
    """One line of error that the pattern describes, nothing on standard output, no file begun, the old one intact."""
    assert outcome.status == 2
    assert outcome.out == ""
    assert outcome.err.endswith("\n")
    assert len(outcome.err.splitlines()) == 1, outcome.err
    assert "internal error" not in outcome.err
    assert re.match("error: " + pattern, outcome.err), outcome.err
    assert Path("tau.csv").read_bytes() == OLD
    assert not list(Path().glob("*.part"))


def torques(urdf: str = "arm.urdf", trajectory: str = "arm.csv", *options: str, stdin: bytes = b"") -> Outcome:
    return run("torques", urdf, trajectory, "--out", "tau.csv", *options, stdin=stdin)


DESCRIPTIONS: list[tuple[str, str | bytes, str]] = [
    ("cut off", ARM[:400], r"bad.urdf:\d+: malformed XML: .*cut off"),
    ("empty", "", r"bad.urdf:1: the file is empty"),
    ("same name", ARM.replace('"elbow"', '"shoulder"'), r"bad.urdf:\d+: a second joint 'shoulder'"),
]


TABLES: list[tuple[str, str | bytes, str]] = [
    ("NUL in a name", GOOD.replace("q_elbow", "q_el\0bow", 1), r"bad.csv:1: is binary data"),
    ("1e400", GOOD + "1,0,1e400,0,0,0,0\n", r"bad.csv:12: column 'q_elbow': '1e400' is not finite"),
    ("stamps coincide", "t,q1,q2\n0,0,0\n1e-300,1,1\n2e-300,3,0\n", r"bad.csv: row 1: the derivative is not finite"),
    ("torque overflows", GOOD + "1,0,0,0,0,1.7e308,1.7e308\n", r"bad.csv: row 11: tau_shoulder overflows"),
    ("speed overflows", GOOD + "1,0,0,1e300,1e300,0,0\n", r"bad.csv: row 11: tau_shoulder overflows"),
    ("squares overflow", GOOD + "1,0,0,1e80,1e80,0,0\n", r"bad.csv: the loads are finite, .*overflow; the largest is"),
]


CALLS: dict[str, Callable[[str], Outcome]] = {
    "urdf": torques,
    "csv": lambda file: torques(trajectory=file),
    "toml": lambda file: torques("arm.urdf", "arm.csv", "--scene", file),
}
FILES = [
    pytest.param(kind, *case[1:], id=f"{kind}: {case[0]}")
    for kind, cases in (("urdf", DESCRIPTIONS), ("csv", TABLES))
    for case in cases
]


@pytest.mark.parametrize(("kind", "text", "pattern"), FILES)
def test_file(kind: str, text: str | bytes, pattern: str) -> None:
    Path(f"bad.{kind}").write_bytes(text if isinstance(text, bytes) else text.encode())
    refused(CALLS[kind](f"bad.{kind}"), pattern)


def test_what_does_not_fit_the_robot_or_the_table() -> None:
    Path("few.csv").write_text("time,q_shoulder,q_elbow\n0,0,0\n1,0,0\n")
    refused(torques("arm.urdf", "few.csv", "--derivatives", "given"), "few.csv:1: .*'shoulder', 'elbow' is not given")
    Path("stone.urdf").write_text('<robot name="stone"><link name="stone"/></robot>')
    refused(torques("stone.urdf"), "arm.csv:1: unknown columns? 'q_shoulder'")
    Path("wind.toml").write_text('[[wrench]]\nlink = "fore"\nforce = ["fx", 0, 0]')
    refused(CALLS["toml"]("wind.toml"), "arm.csv:1: no column 'fx', which the scene names")
    Path("heavy.toml").write_text('[[payload]]\nlink = "fore"\nmass = 1e308\ncom = [1e10, 0, 0]')
    refused(CALLS["toml"]("heavy.toml"), "arm.csv: row 1: tau_shoulder overflows")


@pytest.mark.parametrize("name", ["missing", "", "nul\0", "folder"])
@pytest.mark.parametrize("kind", CALLS)
def test_name_of_no_file(name: str, kind: str) -> None:
    Path(f"folder.{kind}").mkdir()
    file = name and f"{name}.{kind}"
    refused(CALLS[kind](file), re.escape(file.replace("\0", "\\x00") or "''") + ": ")


@pytest.mark.parametrize(("file", "suffix"), [("arm.urdf", ".urdf"), ("arm.csv", ".csv"), ("calm.toml", ".toml")])
def test_no_permission(file: str, suffix: str) -> None:
    Path("calm.toml").write_text("gravity = [0, 0, 0]")
    real = open

    def guarded(path: object, *args: object, **more: object) -> object:
        if str(path).endswith(suffix):
            raise PermissionError(13, "Permission denied", str(path))
        return real(path, *args, **more)  # type: ignore[call-overload]

    with mock.patch("builtins.open", guarded):
        outcome = torques("arm.urdf", "arm.csv", "--scene", "calm.toml")
    refused(outcome, rf"{re.escape(file)}: .*(?i:permission)")


def test_arrays() -> None:
    np.savez("bad.npz", time=np.arange(3.0), q=np.zeros((2, 2)))
    refused(torques(trajectory="bad.npz"), "bad.npz: .*'time' has 3 rows.* 2")


@pytest.mark.parametrize(("file", "data"), [("bad.parquet", b"PAR1junkPAR1"), ("bad.npz", b"PK\x03\x04junk")])
def test_damaged_table(file: str, data: bytes) -> None:
    Path(file).write_bytes(data)
    refused(torques(trajectory=file), f"{file}: ")


@pytest.mark.parametrize(
    ("data", "pattern"), [(b"", "is empty"), (b"garbage", ".*no column of time"), (BINARY, ".*binary")]
)
def test_rubbish_on_standard_input(data: bytes, pattern: str) -> None:
    refused(torques(trajectory="-", stdin=data), f"<stdin>:.*{pattern}")
    refused(torques(urdf="-", stdin=data), "<stdin>:1: ")
