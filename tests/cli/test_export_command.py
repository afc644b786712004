"""`robodyn export`: what it writes, and how it refuses."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from helpers.command_line import ROBOTS, run

import robodyn
from robodyn.errors import InputError

SCARA, GRIPPER = (str(ROBOTS / f"{name}.urdf") for name in ("scara", "gripper"))


@pytest.mark.parametrize("target", ["c", "numpy", "casadi", "jax", "torch"])
def test_it_writes_what_the_library_returns(target: str, tmp_path: Path) -> None:
    out = tmp_path / "gripper.txt"
    scene = str(ROBOTS / "gripper.toml")
    call = ("export", GRIPPER, "--to", target, "--what", "bias,torques", "--scene", scene)
    written = run(*call, "--out", str(out))
    assert (written.status, written.err) == (0, "")
    assert written.out.startswith(f"written: {out}, ")
    text = robodyn.export(robodyn.load(GRIPPER), target, ["bias", "torques"], scene=robodyn.load_scene(scene))
    assert out.read_text() == text
    assert run(*call).out == text


CALLS = {
    "": "missing option '--to'",
    "--to rust": "invalid value for '--to': 'rust' is not one of 'c', 'numpy', 'jax', 'torch', 'casadi' (try: ",
    "--to c --what torqes": "there is no function 'torqes' to export (did you mean 'torques'?)",
    "--to c --what ,": "there is no function '' to export (functions: ",
    "--to c --out {folder}/no/f.c": "{folder}/no/f.c: cannot be written: no such file or directory (name another file)",
    "--to c --out {folder}": "{folder}: cannot be written: is a directory (name another file)",
    "--to torch --out {folder}/torch.py": "{folder}/torch.py: a module of this name hides torch, which it or what ",
    "--to jax --out {folder}/NumPy.py": "{folder}/NumPy.py: a module of this name hides numpy, which it or what ",
    "--to numpy --out {folder}/math.py": "{folder}/math.py: a module of this name hides math, which it or what ",
    "--to casadi --out {folder}/platform.py": "{folder}/platform.py: a module of this name hides platform, which ",
    "--to c --scene {folder}/loop.toml": "{folder}/loop.toml: the scene closes loops, and this knows only the open ",
}


@pytest.mark.parametrize("call", CALLS)
def test_wrong_calls(call: str, tmp_path: Path) -> None:
    (tmp_path / "loop.toml").write_text('[[loop]]\nname = "pin"\nlink = "spindle"\n')
    outcome = run("export", SCARA, *call.format(folder=tmp_path).split())
    assert (outcome.status, outcome.out) == (2, "")
    assert len(outcome.err.splitlines()) == 1, outcome.err
    assert outcome.err.startswith(f"error: {CALLS[call].format(folder=tmp_path)}"), outcome.err
    assert os.listdir(tmp_path) == ["loop.toml"]


def test_an_output_does_not_overwrite_the_robot(tmp_path: Path) -> None:
    robot = tmp_path / "scara.urdf"
    robot.write_bytes(Path(SCARA).read_bytes())
    outcome = run("export", str(robot), "--to", "c", "--out", str(robot))
    assert (outcome.status, robot.read_bytes()) == (2, Path(SCARA).read_bytes())


def test_wrong_calls_of_the_library() -> None:
    model = robodyn.load(SCARA)
    with pytest.raises(InputError, match="there is no target 'rust' to export"):
        robodyn.export(model, "rust")
    with pytest.raises(InputError, match=r"there is no target \['c'\] to export"):
        robodyn.export(model, ["c"])  # type: ignore[arg-type]
    with pytest.raises(InputError, match="there is no function 'inverse_dynamics' to export"):
        robodyn.export(model, "c", ["inverse_dynamics"])
    for what in (None, [None]):
        with pytest.raises(InputError, match="there is no function None to export"):
            robodyn.export(model, "c", what)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="no function to export is named"):
        robodyn.export(model, "c", [])
    with pytest.raises(InputError, match="scene is no scene but of type dict"):
        robodyn.export(model, "c", scene={})  # type: ignore[arg-type]
    with pytest.raises(InputError, match="nothing can move"):
        robodyn.export(robodyn.load(str(ROBOTS / "composite.urdf")), "c")


def test_an_output_may_be_a_path_object(tmp_path: Path) -> None:
    text = robodyn.export(robodyn.load(SCARA), "numpy", out=tmp_path / "scara.py")
    assert (tmp_path / "scara.py").read_text(encoding="utf-8") == text
