"""Every option that writes, against everything that a command reads: no input is written over, under no name.

The calls are made of click's parameters: a command or an option that is new is tried, or has to be listed here.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import click
import pytest
from helpers.command_line import ROBOTS, motion, refused, run, write_arm
from helpers.sampled import sampled

from robodyn.cli.main import COMMANDS
from robodyn.cli.options import Output, Parsed

ARGUMENTS = {
    "torques": ["arm.urdf", "arm.csv"],
    "simulate": ["arm.urdf", "--duration", "0.01"],
    "inertia": ["box.obj"],
    "check": ["arm.urdf"],
    "fbd": ["arm.urdf"],
    "equations": ["arm.urdf"],
    "derive": ["arm.urdf"],
    "envelope": ["arm.urdf"],
    "linearize": ["arm.urdf"],
    "export": ["arm.urdf", "--to", "c"],
    "convert": ["arm.urdf", "--to", "mjcf", "--out", "arm.xml"],
    "retime": ["arm.urdf", "arm.csv"],
    "excite": ["arm.urdf"],
    "identify": ["arm.urdf", "log.csv"],
    "info": ["arm.urdf"],
    "view": ["arm.urdf", "arm.csv"],
    "diff": ["arm.urdf", "arm.urdf"],
    "size": ["arm.urdf", "arm.csv", "--catalog", "motors.csv"],
    "accuracy": ["arm.urdf", "arm.csv"],
    "scene init": ["arm.urdf"],
}
"""The least that each command needs."""
READ = {
    "--scene": "scene.toml",
    "--traj": "arm.csv",
    "--trajectory": "arm.csv",
    "--config": "settings.toml",
    "--baseline": "base.json",
    "--validate": "log.csv",
    "--map": "map.toml",
    "--catalog": "motors.csv",
    "--gears": "gears.csv",
    "--box": "box.toml",
}
BESIDE = {"fbd": {"--traj": ["--time", "0"]}}
"""What else an option asks for."""
SUFFIX = {
    "a table": ".csv",
    "an archive": ".npz",
    "a report": ".md",
    "a calibrated description": ".urdf",
    "a scene that was identified": ".toml",
    "a scene of chosen motors": ".toml",
    "a covariance": ".json",
    "source code": ".c",
    "a converted description": ".xml",
    "a list of findings": ".sarif",
}
SAID = {"--also": "sarif="}
"""What an option asks for before the name of its file."""
RESULTS = (
    "torques arm.urdf arm.csv --out tau.csv --report tau.md",
    "check arm.urdf --baseline new.json --write-baseline",
    "torques arm.urdf arm.csv --out tau.npz --report tau.html",
    "torques arm.urdf arm.csv --out tau.parquet",
    "export arm.urdf --to c --out arm.c",
    "convert arm.urdf --to mjcf --out arm.xml",
    "linearize arm.urdf --out linear.npz",
    "size arm.urdf arm.csv --catalog motors.csv --gears gears.csv --scene-out chosen.toml",
    "fbd arm.urdf --svg drawings",
    "check arm.urdf --also sarif=found.sarif --also text=found.txt --also junit=found.xml --also short=short.txt",
)


def _commands() -> Iterator[tuple[str, click.Command]]:
    for name in COMMANDS:
        command = import_module(f"robodyn.cli.{name}").command
        inner = command.commands if isinstance(command, click.Group) else {}
        yield from {f"{name} {each}": one for each, one in inner.items()}.items() or [(name, command)]


FILES = {name: [p for p in command.params if isinstance(p.type, Parsed) and p.type.name == "file"]
         for name, command in _commands()}  # fmt: skip
WRITING = {name: [p for p in params if isinstance(p.type, Output)] for name, params in FILES.items()}
CASES = [
    (name, output.opts[0], reading.opts[0])
    for name, params in FILES.items()
    for output in WRITING[name]
    for reading in params
    if not isinstance(reading.type, Output)
]


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_arm(tmp_path)
    monkeypatch.chdir(tmp_path)
    Path("log.csv").write_text(motion(10))
    Path("box.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    for name in ("motors.csv", "gears.csv"):
        Path(name).write_bytes((ROBOTS / "catalogue" / name).read_bytes())
    Path("scene.toml").write_text("gravity = [0, 0, -9.81]\n")
    Path("settings.toml").write_text("[tool.robodyn.check]\nignore = []\n")
    Path("robodyn.toml").write_text("[tool.robodyn.check]\nignore = []\n")
    Path("box.toml").write_text("elbow = [0.0, 0.5]\n")
    Path("map.toml").write_text('q_elbow = "q_elbow"\n')
    Path("base.json").write_text('{"robodyn_baseline": 1, "findings": []}')


def everything() -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in Path().iterdir() if path.is_file()}


def call(name: str, reading: str, place: str | None = None) -> tuple[list[str], str]:
    """The words of a call in which something is read, by default from the usual place, and what."""
    words = [*ARGUMENTS[name]]
    if not reading.startswith("-"):
        return words, {"urdf": words[0], "urdfs": words[0], "files": words[0]}.get(reading, words[-1])
    extra = BESIDE.get(name, {}).get(reading, [])
    return [*words, reading, place or READ[reading], *extra], place or READ[reading]


def test_every_command_is_tried() -> None:
    assert {name for name, params in WRITING.items() if params} <= ARGUMENTS.keys()
    assert {param.type.kind for params in WRITING.values() for param in params} == SUFFIX.keys()  # type: ignore[attr-defined]
    assert len(CASES) > 30


WAYS = ("name", "spelled", "symlink", "hardlink")
TRIED = [(*case, way, (k + n) % 4) for k, case in enumerate(CASES) for n, way in enumerate(WAYS)]


@pytest.mark.parametrize(
    ("name", "output", "reading", "way"),
    [pytest.param(*case, marks=[pytest.mark.slow] * bool(k)) for *case, k in TRIED],
)
def test_an_output_that_is_read(name: str, output: str, reading: str, way: str) -> None:
    words, source = call(name, reading)
    kind = next(p.type.kind for p in WRITING[name] if p.opts[0] == output)  # type: ignore[attr-defined]
    place = "other" + SUFFIX[kind]
    if way == "symlink":
        os.symlink(source, place)
    elif way == "hardlink":
        os.link(source, place)
    else:  # under its own name, and with the suffix that the output needs
        os.rename(source, place)
        words = [place if word == source else word for word in words]
        place = f".//./{place}" if way == "spelled" else place
    before = everything()
    outcome = run(*name.split(), *words, output, SAID.get(output, "") + place)
    assert everything() == before
    refused(outcome, "")
    assert "overwrite an input" in outcome.err or "already" in outcome.err, outcome.err


@pytest.mark.parametrize(("name", "output"), dict.fromkeys((name, output) for name, output, _ in CASES))
@pytest.mark.parametrize("content", [b'<robot name="r"/>', b"\x00\xff"])
def test_an_output_that_somebody_else_wrote(name: str, output: str, content: bytes) -> None:
    kind = next(p.type.kind for p in WRITING[name] if p.opts[0] == output)  # type: ignore[attr-defined]
    place = Path("old" + SUFFIX[kind])
    place.write_bytes(content)
    outcome = run(*name.split(), *ARGUMENTS[name], output, SAID.get(output, "") + str(place))
    assert place.read_bytes() == content
    refused(outcome, f"{place}: ")
    assert "already" in outcome.err, outcome.err


@pytest.mark.parametrize("place", ["robodyn.toml", "arm.csv", "./arm.urdf", "link.urdf"])
def test_a_baseline_that_is_none(place: str) -> None:
    os.symlink("arm.urdf", "link.urdf")
    before = everything()
    outcome = run("check", "arm.urdf", "--config", "settings.toml", "--baseline", place, "--write-baseline")
    assert everything() == before
    assert (outcome.status, outcome.err.count("\n")) == (2, 1)


@pytest.mark.parametrize("call", sampled(RESULTS, 4))
def test_results_are_written_anew(call: str) -> None:
    """Whatever the first run has written, the second may replace."""
    for _ in range(2):
        outcome = run(*call.split())
        assert outcome.status == 0, outcome.err


def test_two_outputs_of_one_name() -> None:
    words = ("torques", "arm.urdf", "arm.csv", "--out", "new.csv", "--example")
    assert "already" in run(*words).err
    outcome = run("torques", "arm.urdf", "new.csv", "--out", "./new.csv", "--example")
    assert "overwrite an input" in outcome.err
    assert not Path("new.csv").exists()


def test_a_batch_beside_its_messages() -> None:
    """The document of `a.json` would have its name."""
    point = '{"joint_names": ["shoulder", "elbow"], "points": [{"positions": [0, 0], "time_from_start": {"sec": %d}}]}'
    for name in ("a", "b"):
        Path(f"{name}.json").write_text(point % 1)
    before = everything()
    outcome = run("torques", "arm.urdf", "a.json", "b.json", "--out", ".")
    assert everything() == before
    assert "overwrite an input" in outcome.err
