"""The GitHub action, the pre-commit hooks and what else the documentation gives repositories: their files against what
reads them, and run."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit
from xml.etree import ElementTree
from zipfile import ZipFile

import pytest
import yaml
from helpers import command_line
from helpers.clean_arm import FAMILIES, IDENTITY, arm
from helpers.command_line import command
from helpers.git_repository import committed
from helpers.schemas import ACTION, SARIF, json_schema
from jsonschema import Draft7Validator

ROOT = Path(__file__).parent.parent.parent
FOLDER = ROOT / ".github" / "actions" / "check"


@pytest.fixture
def runner(tmp_path: Path) -> Any:
    """The script in a folder with three robots, with `robodyn` and a `gh` on its path, which writes down its calls."""
    (tmp_path / "bin").mkdir()
    interpreter, option, code = command()
    calls = tmp_path / "calls"
    comments = f'case "$*" in *--paginate*) echo $EARLIER;; *) echo "$*" >> {calls}; cat >> {calls};; esac'
    programs = {
        "robodyn": f"echo robodyn >> {calls}\nexec '{interpreter}' {option} '{code}' \"$@\"",
        "gh": f'[ -z "$FORK" ] || exit 1\n{comments}',
    }
    for name, text in programs.items():
        start = tmp_path / "bin" / name
        start.write_text(f"#!/bin/sh\n{text}\n")
        start.chmod(0o755)
    work = tmp_path / "work"
    (work / "more robots").mkdir(parents=True)
    (work / "clean.urdf").write_text(arm())
    (work / "warned.urdf").write_text(arm(upper=IDENTITY))
    (work / "more robots" / "bad.urdf").write_text(arm(shoulder="0 0 0"))

    def run(**variables: str) -> tuple[int, list[str], dict[str, str]]:
        written = {name: str(tmp_path / name) for name in ("GITHUB_OUTPUT", "GITHUB_STEP_SUMMARY", "ROBODYN_SARIF")}
        path = f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}"
        environment = {**os.environ, **written, **variables, "PATH": path}
        script = [sys.executable, str(FOLDER / "check.py")]
        done = subprocess.run(script, cwd=work, env=environment, capture_output=True, text=True, check=False)
        assert "Traceback" not in done.stderr
        files = {**written, "calls": str(calls)}
        texts = {name: Path(file).read_text() for name, file in files.items() if os.path.exists(file)}
        calls.unlink()
        return done.returncode, done.stdout.splitlines(), texts

    return run


def test_everything_below_the_folder(runner: Any) -> None:
    """By one run of the check."""
    status, lines, written = runner(ROBODYN_OPTIONS=f"--select {','.join(FAMILIES)}")
    assert status == 1
    assert [line.split(",")[0] for line in lines] == ["::error file=more robots/bad.urdf", "::warning file=warned.urdf"]
    assert written["GITHUB_OUTPUT"] == "status=1\n"
    assert written["calls"] == "robodyn\n"
    assert written["GITHUB_STEP_SUMMARY"].startswith("### robodyn check\n```text\n    1 error    RD501 zero-axis\n")
    document = json.loads(written["ROBODYN_SARIF"])
    Draft7Validator(json_schema(SARIF)).validate(document)
    assert len(document["runs"][0]["results"]) == 2


@pytest.mark.parametrize(
    ("files", "options", "status"),
    [
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


def test_a_pull_request_is_told_how_its_dynamics_differ(runner: Any, tmp_path: Path) -> None:
    """In the same run; no more than told, also with --strict; in the comment that is there, and in words that are no
    Markdown; a fork's token may not."""
    work = tmp_path / "work"
    base = committed(work)
    asked = {"ROBODYN_FILES": "clean.urdf", "ROBODYN_OPTIONS": "--strict", "ROBODYN_BASE": base, "ROBODYN_NUMBER": "7"}
    asked |= {"ROBODYN_COMMENT": "true", "GITHUB_REPOSITORY": "a/b"}
    status, _, written = runner(**asked)
    assert (status, written["calls"]) == (0, "robodyn\n"), "nothing has changed, and there is no comment"
    (work / "clean.urdf").write_text(arm().replace('"shoulder"', '"```@you"'))
    status, lines, written = runner(**asked)
    assert status == 0
    assert lines[0].startswith("::warning file=clean.urdf,")
    assert "```@you' here (they stand in one place)" in written["GITHUB_STEP_SUMMARY"]
    first, call, body = written["calls"].splitlines()
    assert (first, call) == ("robodyn", "api --silent --method POST repos/a/b/issues/7/comments --input -")
    text = json.loads(body)["body"]
    assert text.startswith("<!-- robodyn check -->\n### Dynamics against the base\n````text\nclean.urdf: ")
    assert text.endswith("\n````\n")
    (work / "clean.urdf").write_text(arm())
    _, _, written = runner(**asked, EARLIER="41")
    assert "--method PATCH repos/a/b/issues/comments/41 --input" in written["calls"]
    assert "The dynamics are those of the base." in written["calls"]
    status, lines, _ = runner(**asked, FORK="1")
    assert (status, lines[0].split("::")[1]) == (0, "notice title=robodyn")
    status, lines, _ = runner(**{**asked, "ROBODYN_BASE": "f" * 40})
    assert (status, lines) == (
        0,
        [f"::notice title=robodyn::the dynamics are not compared: git cannot fetch {'f' * 40}"],
    )


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
    install, check, upload = action["runs"]["steps"]
    script = (FOLDER / "check.py").read_text()
    assert {*re.findall(r'"(ROBODYN_\w+)"', script)} == {*check["env"]} - {"GH_TOKEN"}
    assert "${{" not in install["run"] + check["run"]
    assert upload["uses"].startswith("github/codeql-action/upload-sarif@")
    (file,) = re.findall(r"format\(.*\)", upload["with"]["sarif_file"])
    assert file in check["env"]["ROBODYN_SARIF"]


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


TUTORIAL = (ROOT / "docs" / "tutorials" / "lint_in_ci.md").read_text()


def block(language: str) -> str:
    return re.findall(rf"```{language}\n(.*?)```", TUTORIAL, re.DOTALL)[0]


def test_the_workflow_and_the_badges_of_the_tutorial(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Inputs are those of the action, permissions what it asks for; badges name the workflow, and a number that is in
    the JSON."""
    flow = yaml.safe_load(block("yaml"))
    _, use = flow["jobs"]["check"]["steps"]
    action = yaml.safe_load((FOLDER / "action.yml").read_text())
    assert {*use["with"]} <= {*action["inputs"]}
    assert use["uses"].partition("@")[0].endswith(FOLDER.relative_to(ROOT).as_posix())
    granted = {name for name, right in flow["permissions"].items() if right == "write"}
    assert granted == {*re.findall(r"needs `([-a-z]+)` write", str(action["inputs"]))}
    workflow, shield = block("markdown").splitlines()
    assert workflow.count("actions/workflows/robodyn.yml") == 2
    assert ".github/workflows/robodyn.yml" in TUTORIAL
    query = parse_qs(urlsplit(re.findall(r"\((.*)\)", shield)[0]).query)
    (told,) = query["query"]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "warned.urdf").write_text(arm(upper=IDENTITY))
    assert command_line.run("check", "warned.urdf", "--also", "json=robodyn.json").status == 0
    found: Any = json.loads((tmp_path / Path(query["url"][0]).name).read_text())
    for key in told.removeprefix("$.").split("."):
        found = found[key]
    assert found == 1


AMENT = """
set(AMENT_TEST_RESULTS_DIR "${CMAKE_BINARY_DIR}/test_results")
function(ament_add_test name)
  cmake_parse_arguments(ARG "" "RESULT_FILE;WORKING_DIRECTORY" "COMMAND" ${ARGN})
  add_test(NAME ${name} COMMAND ${ARG_COMMAND} WORKING_DIRECTORY ${ARG_WORKING_DIRECTORY})
endfunction()
"""
"""What the snippet uses of ament_cmake_test."""


@pytest.mark.skipif(shutil.which("ctest") is None, reason="there is no CMake")
@pytest.mark.parametrize("sound", [True, False])
def test_the_function_of_cmake_for_colcon_test(runner: Any, tmp_path: Path, sound: bool) -> None:
    (tmp_path / "work" / "urdf").mkdir()
    (tmp_path / "work" / "urdf" / "arm.urdf").write_text(arm() if sound else arm(upper=IDENTITY))
    (tmp_path / "work" / "ament_cmake_testConfig.cmake").write_text(AMENT)
    head = "cmake_minimum_required(VERSION 3.18)\nproject(arm NONE)\ninclude(CTest)\n"
    (tmp_path / "work" / "CMakeLists.txt").write_text(head + block("cmake"))
    environment = {**os.environ, "PATH": f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}"}
    build = str(tmp_path / "build")
    configure = ["cmake", "-S", ".", "-B", build, "-Dament_cmake_test_DIR=."]
    subprocess.run(configure, cwd=tmp_path / "work", env=environment, check=True, capture_output=True)
    done = subprocess.run(["ctest"], cwd=build, env=environment, check=False, capture_output=True, text=True)
    assert (done.returncode == 0) == sound, done.stdout
    (suite,) = ElementTree.parse(f"{build}/test_results/arm/robodyn_check.xunit.xml").getroot()
    assert (suite.get("name"), suite.get("failures")) == ("urdf/arm.urdf", "0" if sound else "1")
