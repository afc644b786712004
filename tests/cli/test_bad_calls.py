"""Calls that are wrong: one line with what to do about it, exit status 2."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import click
import pytest
from helpers.command_line import Outcome, run, spawn, write_arm

from robodyn.cli.main import COMMANDS
from robodyn.loads import torques as loads

ARM = ("torques", "arm.urdf", "arm.csv")


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_arm(tmp_path)
    monkeypatch.chdir(tmp_path)


CALLS: list[tuple[tuple[str, ...], str]] = [
    (("torqes",), "there is no command 'torqes'; did you mean 'torques'? (try: robodyn --help)"),
    (
        ("zebra",),
        "there is no command 'zebra'; commands: 'torques', 'simulate', 'inertia', 'check', 'fbd', "
        "'equations', 'linearize', 'export', ... (15 in all) (try: robodyn --help)",
    ),
    (("--verson",), "no such option '--verson'; did you mean '--version'? (try: robodyn --help)"),
    (("torques",), "missing argument 'URDF' (try: robodyn torques --help)"),
    (("torques", "arm.urdf"), "missing argument 'TRAJECTORY...' (try: robodyn torques --help)"),
    ((*ARM, "more.csv"), "many trajectories need --out FOLDER for their results (try: robodyn torques --help)"),
    ((*ARM, "--gravty", "0,0,0"), "no such option '--gravty'; did you mean '--gravity'? (try: robodyn torques --help)"),
    ((*ARM, "--reactions"), "--reactions goes to a file, and --out names none (try: robodyn torques --help"),
    ((*ARM, "--gravity"), "option '--gravity' requires an argument"),
    ((*ARM, "--format", "xml"), "invalid value for '--format': 'xml' is not one of 'text', 'json'"),
    (
        (*ARM, "--derivatives", "magic"),
        "invalid value for '--derivatives': 'magic' is not one of 'auto', 'anew', 'given', ",
    ),
    ((*ARM, "--out", "tau.xlsx"), "tau.xlsx: unknown type of table by this suffix (name it .csv, .parquet or .npz)"),
    ((*ARM, "--out", ""), "'': unknown type of table by this suffix"),
    ((*ARM, "--out", "arm.csv"), "arm.csv: the output would overwrite an input (give --out another name)"),
    ((*ARM, "--out", "./arm.urdf"), "./arm.urdf: the output would overwrite an input"),
]


def refused(outcome: Outcome, line: str) -> None:
    assert (outcome.status, outcome.out) == (2, "")
    assert len(outcome.err.splitlines()) == 1, outcome.err
    assert outcome.err.startswith(f"error: {line}"), outcome.err


@pytest.mark.parametrize(("call", "line"), CALLS, ids=[" ".join(call) for call, _ in CALLS])
def test_call(call: tuple[str, ...], line: str) -> None:
    refused(run(*call), line)


@pytest.mark.parametrize("vector", ["1,2", "1,2,3,4", "a,b,c", "nan,0,0", "1e400,0,0", "", "1_0,0,0", "0 0 9"])
def test_vector(vector: str) -> None:
    refused(run(*ARM, "--gravity", vector), f"invalid value for '--gravity': {vector!r} is not three finite numbers")


def test_gravity_beyond_what_can_be_computed() -> None:
    refused(run(*ARM, "--gravity", "0,0,1e308"), "arm.csv: row 1: base_fx overflows")


def test_the_same_in_a_process_of_its_own(tmp_path: Path) -> None:
    refused(spawn("torques", "arm.urdf", "no.csv", cwd=tmp_path), "no.csv: cannot be read: no such file")
    refused(spawn(*ARM, "--fromat", "json", cwd=tmp_path), "no such option '--fromat'; did you mean '--format'?")


def test_a_fault_of_the_program_is_one_line_too(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object, **__: object) -> None:
        raise RuntimeError("two\nlines \x1b[31m")

    monkeypatch.setattr(loads, "torques", broken)
    outcome = run(*ARM)
    refused(outcome, "internal error at test_bad_calls.py:")
    assert "RuntimeError: two lines \\x1b[31m (please report this line" in outcome.err


def test_memory_that_runs_out(monkeypatch: pytest.MonkeyPatch) -> None:
    def greedy(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr(loads, "torques", greedy)
    refused(run(*ARM), "out of memory")


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, click.Abort])
def test_interrupted(interruption: type[BaseException], monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(*_: object, **__: object) -> None:
        raise interruption

    monkeypatch.setattr(loads, "torques", stopped)
    outcome = run(*ARM, "--out", "tau.csv")
    assert (outcome.status, outcome.out, outcome.err.strip()) == (130, "", "")
    assert sorted(path.name for path in Path().iterdir()) == ["arm.csv", "arm.urdf"]


HELP: list[tuple[tuple[str, ...], str]] = [
    (("--help",), "Usage: robodyn [OPTIONS]"),
    ((), "Usage: robodyn [OPTIONS]"),
    (("torques", "-h"), "Usage: robodyn torques [OPTIONS] URDF TRAJECTORY..."),
]


@pytest.mark.parametrize(("call", "start"), HELP)
def test_help_has_an_example(call: tuple[str, ...], start: str) -> None:
    outcome = run(*call)
    assert (outcome.status, outcome.err) == (0, "")
    assert outcome.out.startswith(start)
    assert "\n    robodyn torques robots/scara.urdf robots/scara_pick_and_place.csv --out tau.csv\n" in outcome.out


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_says_what_it_is_for(name: str) -> None:
    options = [each for each in import_module(f"robodyn.cli.{name}").command.params if isinstance(each, click.Option)]
    assert [each.name for each in options if not each.help] == []


def test_version() -> None:
    from importlib.metadata import version

    assert run("--version") == Outcome(0, f"robodyn {version('robodyn')}\n", "")
