"""`robodyn bench`: what it prints, and how it refuses."""

from __future__ import annotations

import io
import json
import re
import sys
from pathlib import Path

import click
import pytest
from helpers.command_line import ARM, ROBOTS, Outcome, run
from helpers.compiled_programs import needs_compiler
from helpers.peers import needs_peers

from robodyn.cli import bench

SCARA = str(ROBOTS / "scara.urdf")
FEW = ("--samples", "20")
TOP = [
    *("robot", "joints", "gravity", "samples", "threads", "operations", "operations_at_rest", "trace", "executors"),
    *("copying", "whole", "effects", "programs", "peers", "problem"),
]
TIMING = ["least", "median", "runs"]


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def refused(outcome: Outcome, pattern: str) -> None:
    assert (outcome.status, outcome.out) == (2, "")
    assert len(outcome.err.splitlines()) == 1, outcome.err
    assert "internal error" not in outcome.err
    assert re.match("error: " + pattern, outcome.err), outcome.err


def test_text() -> None:
    outcome = run("bench", SCARA, *FEW)
    assert (outcome.status, outcome.err) == (0, "")
    parts = outcome.out.split("\n\n")
    titles = [part.splitlines()[0].partition(",")[0] for part in parts[:-1]]
    assert titles == ["scara: 3 joints", "Torques", "Effects", "Other programs"]
    assert parts[-1].startswith("Times are the shortest of several runs in turn; ")


@needs_peers
@needs_compiler
def test_json() -> None:
    outcome = run("bench", SCARA, *FEW, "--threads", "2", "--peers", "--format", "json")
    assert (outcome.status, outcome.err) == (0, "")
    found = json.loads(outcome.out)
    assert list(found) == TOP
    assert (found["robot"], found["joints"], found["samples"], found["threads"]) == ("scara", 3, 20, 2)
    assert list(found["trace"]) == TIMING
    assert [each["name"] for each in found["executors"]] == ["numpy", "compiled", "compiled float32"]
    assert [each["name"] for each in found["effects"]] == ["gravity", "inertia", "coriolis"]
    assert all(list(each["without"]) == TIMING for each in found["effects"])
    assert [each["name"] for each in found["programs"]] == [
        *("torques and joint wrenches", "bias forces", "mass matrix", "energy and losses", "momentum laws"),
    ]
    assert [each["name"].split()[0].strip(",") for each in found["peers"]["peers"]] == [
        *("Pinocchio", "Pinocchio", "MuJoCo", "Drake"),
    ]
    assert found["problem"] is None


@pytest.mark.slow
def test_scene_and_gravity_count() -> None:
    puma = str(ROBOTS / "puma560.urdf")
    scene = ("--scene", str(ROBOTS / "puma560_motors.toml"))
    plain, motors, weightless = (
        json.loads(run("bench", puma, *FEW, *more, "--format", "json").out)
        for more in ((), scene, (*scene, "--gravity", "0,0,0"))
    )
    assert plain["operations"] < motors["operations"] > weightless["operations"]
    assert weightless["gravity"] == [0.0, 0.0, 0.0]
    assert "gravity" not in [each["name"] for each in weightless["effects"]]


def test_a_moving_base() -> None:
    scene = ("--scene", str(ROBOTS / "rigid_body.toml"))
    outcome = run("bench", str(ROBOTS / "rigid_body.urdf"), *FEW, *scene, "--peers")
    assert outcome.status == 0
    assert outcome.out.startswith("rigid_body: 6 joints, 20 samples, gravity (0, 0, 0) m/s^2\n")
    assert outcome.out.count("does not take part: a joint floats") == 3


def test_standard_input() -> None:
    outcome = run("bench", "-", *FEW, stdin=ARM.encode())
    assert outcome.status == 0
    assert outcome.out.startswith("arm: 2 joints, 20 samples")


CALLS: list[tuple[tuple[str, ...], str]] = [
    ((), r"missing argument 'URDF' \(try: robodyn bench --help\)"),
    ((SCARA, "more"), r"got unexpected extra argument \(more\)"),
    ((SCARA, "--sample", "3"), r"no such option '--sample'; did you mean '--samples'\? \(try: robodyn bench --help\)"),
    ((SCARA, "--samples", "0"), r"invalid value for '--samples': 0 is less than 1"),
    ((SCARA, "--samples", "-5"), r"invalid value for '--samples': -5 is less than 1"),
    ((SCARA, "--samples", "many"), r"invalid value for '--samples': 'many' is no whole number"),
    ((SCARA, "--samples", "1000000000000"), r"1000000000000 samples of 3 joints take 288000 GB \(--samples \d+ or"),
    ((SCARA, "--threads", "0"), r"invalid value for '--threads': 0 is less than 1"),
    ((SCARA, "--format", "xml"), r"invalid value for '--format': 'xml' is not one of 'text', 'json'"),
    ((SCARA, "--gravity", "1,2"), r"invalid value for '--gravity': '1,2' is not three finite numbers"),
    ((SCARA, "--scene", "no.toml"), r"no\.toml: "),
    (("no.urdf",), r"no\.urdf: there is no such file"),
    (("-", "--peers"), r"--peers reads the description again: name its file \(try: robodyn bench --help\)"),
    (("-", "--scene", "-"), r"<stdin>: standard input is asked for twice"),
    ((str(ROBOTS / "composite.urdf"),), r".*composite\.urdf: nothing can move: the robot has no joint that moves"),
    ((str(ROBOTS / "puma.urdf"), *FEW, "--gravity", "0,0,1.7e308"), r"the torques of some samples overflow \("),
]


@pytest.mark.parametrize(("call", "pattern"), CALLS, ids=[" ".join(call[-2:]) or "none" for call, _ in CALLS])
def test_wrong_calls(call: tuple[str, ...], pattern: str) -> None:
    refused(run("bench", *call), pattern)


def test_a_wrong_description_and_a_wrong_scene() -> None:
    Path("bad.urdf").write_text(ARM[:400])
    refused(run("bench", "bad.urdf"), r"bad\.urdf:\d+: malformed XML")
    Path("arm.urdf").write_text(ARM)
    Path("bad.toml").write_text("[friction]\nelbw = {viscous = 1}")
    refused(run("bench", "arm.urdf", "--scene", "bad.toml"), r"bad\.toml: .*no joint 'elbw'.*did you mean 'elbow'")


def test_interrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(bench, "bench", stopped)
    outcome = run("bench", SCARA)
    assert (outcome.status, outcome.out, outcome.err.strip()) == (130, "", "")


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_terminal_is_told_what_is_measured(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    bench.command.main([SCARA, *FEW], standalone_mode=False)
    written = terminal.getvalue()
    assert written.startswith("\r\x1b[Kmeasuring: executors\r\x1b[Kmeasuring: effects\r")
    assert written.endswith("\r\x1b[K")
    assert "\n" not in written
    assert "measuring" not in capsys.readouterr().out


def test_help() -> None:
    outcome = run("bench", "--help")
    assert (outcome.status, outcome.err) == (0, "")
    assert outcome.out.startswith("Usage: robodyn bench [OPTIONS] URDF\n")
    assert "\n    robodyn bench robots/puma560.urdf --scene robots/puma560_motors.toml --peers\n" in outcome.out
    options = [option for option in bench.command.params if isinstance(option, click.Option)]
    assert all(option.help for option in options)
