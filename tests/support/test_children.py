"""Processes that robodyn starts find nothing in the current folder, and one place starts them."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.command_line import ROBOTS, motion, write_arm

from robodyn.support.children import run_program

ROOT = Path(__file__).parents[2]
HOSTILE = "import os; open(os.path.join({folder!r}, 'canary'), 'a').write(__name__ + chr(10))\n"
NAMES = (
    *("json", "struct", "numpy", "yaml", "xacro", "site", "pickle", "ast", "click", "signal"),
    *("subprocess", "trimesh"),
)
PACKAGES = ("multiprocessing", "importlib", "encodings", "concurrent", "robodyn", "xml")
ASK = """
import json, os, sys
{before}
from robodyn.support.children import start_python
with start_python("helpers.processed:path_and_flags") as child:
    print(child.communicate()[0].decode())
"""


def test_every_python_that_is_started_is_isolated() -> None:
    """Ruff sees to it that no other file starts processes: see `banned-api` in pyproject.toml."""
    text = (ROOT / "robodyn" / "support" / "children.py").read_text()
    assert text.count("sys.executable") == 1
    assert '["-I", ' in text


@pytest.fixture
def hostile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with modules that write a canary when they are imported, beside descriptions and motions."""
    code = HOSTILE.format(folder=str(tmp_path))
    for name in NAMES:
        (tmp_path / f"{name}.py").write_text(code)
    for name in PACKAGES:
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text(code)
    write_arm(tmp_path)
    head = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    (tmp_path / "values.yaml").write_text("a: 1\n")
    body = "<link name=\"a${xacro.load_yaml('values.yaml').a}\"/></robot>"
    (tmp_path / "r.xacro").write_text(head + body)
    for name in ("a", "b", "c"):
        (tmp_path / f"{name}.csv").write_text(motion(20))
    (tmp_path / "many").mkdir()
    for k in range(6):
        text = (ROBOTS / "puma560.urdf").read_text()
        (tmp_path / "many" / f"{k}.urdf").write_text(text.replace("</robot>", f"<!--{'x' * 100_000}--></robot>"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


CALLS = {
    "check r.xacro": 0,
    "check r.xacro --trust-xacro": 0,
    "check many": 0,
    "doctor": None,  # it tells what is missing here
    "torques arm.urdf a.csv b.csv c.csv --out results": 0,
}


SLOW = {"doctor", "check r.xacro --trust-xacro", "check many", "torques arm.urdf a.csv b.csv c.csv --out results"}


@pytest.mark.parametrize("call", [pytest.param(call, marks=pytest.mark.slow if call in SLOW else ()) for call in CALLS])
def test_modules_beside_the_files_are_not_imported(hostile: Path, call: str) -> None:
    script = Path(sys.executable).with_name("robodyn")
    done = subprocess.run([script, *call.split()], capture_output=True, text=True, check=False)
    assert not (hostile / "canary").exists(), (hostile / "canary").read_text()
    assert done.returncode == CALLS[call] or CALLS[call] is None, done.stderr


@pytest.mark.slow
def test_nor_are_they_by_python_m(hostile: Path) -> None:
    """But for those that Python itself imports before robodyn, runpy and what it needs."""
    shutil.rmtree(hostile / "robodyn")  # this one is asked for
    for name in ("importlib", "encodings"):
        shutil.rmtree(hostile / name)
    (hostile / "site.py").unlink()
    done = subprocess.run(
        [sys.executable, "-m", "robodyn", "check", "r.xacro"], text=True, capture_output=True, check=False
    )
    assert not (hostile / "canary").exists(), (hostile / "canary").read_text()
    assert done.returncode == 0, done.stderr


def test_git_of_the_current_folder_is_not_run(hostile: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (hostile / "git").write_text(f"#!/bin/sh\ntouch {hostile}/canary\n")
    (hostile / "git").chmod(0o755)
    monkeypatch.setenv("PATH", os.pathsep.join(("", ".", os.environ["PATH"])))
    if shutil.which("git", path=os.environ["PATH"].partition(f"{os.pathsep}.{os.pathsep}")[2]):
        assert run_program("git", "--version", folder=str(hostile)).stdout.startswith(b"git version")
    with pytest.raises(FileNotFoundError):
        run_program("no-such-program", folder=str(hostile))
    assert not (hostile / "canary").exists()


def children_of(before: str, folder: Path, *flags: str, **variables: str) -> dict[str, object]:
    code = ASK.format(before=before)
    done = subprocess.run(
        [sys.executable, *flags, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT / "tests"), **variables},
    )
    return json.loads(done.stdout)


def test_the_path_is_that_of_the_parent_without_the_current_folder(tmp_path: Path) -> None:
    """PYTHONPATH and what the parent has added count; '', '.' and the folder by its name do not."""
    (tmp_path / "more").mkdir()
    before = f"sys.path[:0] = ['', '.', os.getcwd(), {str(tmp_path / 'more')!r}]"
    child = children_of(before, tmp_path)
    assert child["isolated"]
    path = child["path"]
    assert isinstance(path, list)
    assert path[0] == str(tmp_path / "more")
    assert str(ROOT / "tests") in path
    assert not {"", ".", str(tmp_path)} & set(path)


def test_of_a_checkout_that_is_the_current_folder_only_robodyn_is_imported(tmp_path: Path) -> None:
    """By `python -m robodyn` there, though another robodyn is installed."""
    for name in ("robodyn", "cli"):
        shutil.copytree(ROOT / name, tmp_path / name)
    assert children_of("", tmp_path)["robodyn"] == str(tmp_path / "robodyn" / "__init__.py")
    (tmp_path / "r.xacro").write_text('<robot name="${1 + 1}" xmlns:xacro="x"><link name="a"/></robot>')
    for name in ("json", "numpy"):
        (tmp_path / f"{name}.py").write_text(HOSTILE.format(folder=str(tmp_path)))
    call = [sys.executable, "-m", "robodyn", "info", "r.xacro"]
    done = subprocess.run(call, text=True, capture_output=True, check=False, cwd=tmp_path)
    assert (done.returncode, done.stdout.splitlines()[0]) == (0, "r.xacro (expanded): robot '2'"), done.stderr
    assert not (tmp_path / "canary").exists()


@pytest.mark.slow
def test_an_installation_of_this_user_works(tmp_path: Path) -> None:
    """With a .pth file there, as an editable one has."""
    base = tmp_path / "base"
    code = "import site; print(site.getusersitepackages())"
    variables = {**os.environ, "PYTHONUSERBASE": str(base)}
    asked = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=variables)
    folder = Path(asked.stdout.strip())
    folder.mkdir(parents=True)
    (folder / "hook.pth").write_text(f"{ROOT / 'tests'}\nimport sys; sys.hooked = True\n")
    before = "import site; site.ENABLE_USER_SITE = True"
    assert children_of(before, tmp_path, PYTHONUSERBASE=str(base))["hooked"]
