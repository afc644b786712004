"""The GitHub action and the pre-commit hooks: their files against what reads them, and the action's script run."""

from __future__ import annotations

import json
import os
import re
import subprocess
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import pytest
import yaml
from helpers import command_line
from helpers.clean_arm import FAMILIES, IDENTITY, arm
from helpers.command_line import command
from helpers.schemas import ACTION, SARIF, json_schema
from jsonschema import Draft7Validator

ROOT = Path(__file__).parent.parent.parent
FOLDER = ROOT / ".github" / "actions" / "check"


@pytest.fixture
def runner(tmp_path: Path) -> Any:
    """The script in a folder with three robots, with `robodyn` on its path."""
    (tmp_path / "bin").mkdir()
    start = tmp_path / "bin" / "robodyn"
    interpreter, option, code = command()
    start.write_text(f"#!/bin/sh\nexec '{interpreter}' {option} '{code}' \"$@\"\n")
    start.chmod(0o755)
    work = tmp_path / "work"
    (work / "more robots").mkdir(parents=True)
    (work / "clean.urdf").write_text(arm())
    (work / "warned.urdf").write_text(arm(upper=IDENTITY))
    (work / "more robots" / "bad.urdf").write_text(arm(shoulder="0 0 0"))

    def run(**variables: str) -> tuple[int, list[str], dict[str, str]]:
        written = {name: str(tmp_path / name) for name in ("GITHUB_OUTPUT", "GITHUB_STEP_SUMMARY", "ROBODYN_SARIF")}
        path = f"{start.parent}{os.pathsep}{os.environ['PATH']}"
        environment = {**os.environ, **written, **variables, "PATH": path}
        script = ["bash", str(FOLDER / "check.sh")]
        done = subprocess.run(script, cwd=work, env=environment, capture_output=True, text=True, check=False)
        texts = {name: Path(file).read_text() for name, file in written.items() if os.path.exists(file)}
        return done.returncode, done.stdout.splitlines(), texts

    return run


def test_everything_below_the_folder(runner: Any) -> None:
    status, lines, written = runner(ROBODYN_OPTIONS=f"--select {','.join(FAMILIES)}")
    assert status == 1
    assert [line.split(",")[0] for line in lines] == ["::error file=more robots/bad.urdf", "::warning file=warned.urdf"]
    assert written["GITHUB_OUTPUT"] == "status=1\n"
    assert "RD501" in written["GITHUB_STEP_SUMMARY"]
    document = json.loads(written["ROBODYN_SARIF"])
    Draft7Validator(json_schema(SARIF)).validate(document)
    assert len(document["runs"][0]["results"]) == 2


@pytest.mark.parametrize(
    ("files", "options", "status"),
    [
        pytest.param("clean.urdf\nwarned.urdf\n", "--strict", 1, marks=pytest.mark.slow),
        ("*.urdf\n\n  \n", "--strict --ignore RD208", 0),
        ("clean.urdf", "--sctrict", 2),
    ],
)
def test_files_and_options(runner: Any, files: str, options: str, status: int) -> None:
    found, _, written = runner(ROBODYN_FILES=files, ROBODYN_OPTIONS=options, GITHUB_STEP_SUMMARY="")
    assert found == status
    assert written["GITHUB_OUTPUT"] == f"status={status}\n"
    assert ("ROBODYN_SARIF" in written) == (status < 2)


def test_inputs_are_data_and_not_commands(runner: Any, tmp_path: Path) -> None:
    status, _, _ = runner(ROBODYN_FILES="$(touch pwned)\n`touch pwned`; touch pwned", ROBODYN_OPTIONS="; touch pwned")
    assert status == 2
    assert not (tmp_path / "work" / "pwned").exists()


def wheel(folder: Path) -> Path:
    """A distribution with one program, `robodyn`, that says hello."""
    path, about = folder / "robodyn-0.0-py3-none-any.whl", "robodyn-0.0.dist-info"
    files = {
        "hello.py": "def main():\n    print('hello')\n",
        f"{about}/METADATA": "Metadata-Version: 2.1\nName: robodyn\nVersion: 0.0\n",
        f"{about}/WHEEL": "Wheel-Version: 1.0\nGenerator: tests\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
        f"{about}/entry_points.txt": "[console_scripts]\nrobodyn = hello:main\n",
    }
    with ZipFile(path, "w") as archive:
        for name, text in files.items():
            archive.writestr(name, text)
        archive.writestr(f"{about}/RECORD", "".join(f"{name},,\n" for name in (*files, f"{about}/RECORD")))
    return path


@pytest.mark.slow
def test_it_is_installed_in_an_environment_of_its_own(tmp_path: Path) -> None:
    """Also where the Python of the system refuses pip."""
    names = {
        "RUNNER_TEMP": str(tmp_path),
        "GITHUB_PATH": str(tmp_path / "path"),
        "ROBODYN_INSTALL": str(wheel(tmp_path)),
    }
    environment = {**os.environ, **names, "PIP_NO_INDEX": "1"}
    subprocess.run(["bash", str(FOLDER / "install.sh")], env=environment, check=True)
    folder = (tmp_path / "path").read_text().strip()
    said = subprocess.run([os.path.join(folder, "robodyn")], capture_output=True, text=True, check=True).stdout
    assert said == "hello\n"


def test_the_action_is_one() -> None:
    action = yaml.safe_load((FOLDER / "action.yml").read_text())
    Draft7Validator(json_schema(ACTION)).validate(action)
    variables = [key for step in action["runs"]["steps"] for key in step["env"]]
    script = (FOLDER / "check.sh").read_text() + (FOLDER / "install.sh").read_text() + str(action)
    assert all(f"${{{name}" in script for name in variables)
    assert "${{" not in "".join(step["run"] for step in action["runs"]["steps"])


def test_the_hooks_start_commands_that_exist() -> None:
    hooks = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())
    assert [hook["id"] for hook in hooks] == ["robodyn-check", "robodyn-fix"]
    for hook in hooks:
        program, *words = hook["entry"].split()
        assert program == "robodyn"
        assert command_line.run(*words, "--help").status == 0


def test_the_hook_fires() -> None:
    (hook, _) = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())
    names = ["urdf/arm.urdf", "arm.urdf.xacro", "srdf/arm.srdf", "meshes/a.stl", "a.py"]
    assert [name for name in names if re.search(hook["files"], name)] == names[:4]
    assert f"xacro = {json.dumps(hook['additional_dependencies'])}" in (ROOT / "pyproject.toml").read_text()
