"""The installed command ends as Python itself would, imports little, and is completed by shells."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from helpers.command_line import ROBOTS, run, shown
from helpers.sampled import sampled

STARTED = {"fine": ("inertia", str(ROBOTS / "meshes" / "hub.stl")), "wrong": ("inertia", "no_such.stl")}


def started(function: str, *arguments: str, before: str = "", after: str = "") -> subprocess.CompletedProcess[str]:
    code = f"{before}\nfrom robodyn.cli.{function} import {function}\n{after}\n{function}()"
    return subprocess.run([sys.executable, "-I", "-c", code, *arguments], capture_output=True, text=True, check=False)


@pytest.mark.parametrize("call", [pytest.param("fine", marks=pytest.mark.slow), "wrong"])
def test_as_main(call):
    mine, plain = started("start", *STARTED[call]), started("main", *STARTED[call])
    assert (mine.returncode, mine.stdout, mine.stderr) == (plain.returncode, plain.stdout, plain.stderr)
    assert mine.stdout or mine.stderr


def test_what_is_registered_for_the_end_is_done_and_memory_is_not_taken_apart():
    before = "import atexit; atexit.register(print, 'registered')\n"
    before += "class Thing:\n    def __del__(self, say=print): say('gone')\nthing = Thing()"
    assert started("start", "--version", before=before).stdout.endswith("\nregistered\n")


def test_threads_are_waited_for():
    late = "import threading, time; threading.Thread(target=lambda: (time.sleep(0.3), print('late'))).start()"
    assert "late\n" in started("start", "--version", after=late).stdout


@pytest.mark.parametrize("isolated", [pytest.param(False, marks=pytest.mark.slow), True])
def test_as_a_module_of_a_checkout(isolated, tmp_path):
    """Also where it is not installed, with the libraries that it needs in the path."""
    root = Path(__file__).parents[2]
    call = [sys.executable, "-m", "robodyn", *STARTED["fine"]]
    if isolated:  # no site, thus no installation: neither of robodyn.cli nor of its version
        libraries = {str(Path(module.__file__).parents[1]) for module in map(import_module, ("numpy", "click"))}
        call[1:1] = ["-S"]
        path = os.pathsep.join([str(root), *sorted(libraries)])
    else:
        path = str(root)
    variables = {**os.environ, "PYTHONPATH": path}
    done = subprocess.run(call, capture_output=True, text=True, check=False, cwd=tmp_path, env=variables)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == run(*STARTED["fine"]).out


@pytest.mark.parametrize(("value", "shown"), [("1", True), pytest.param("0", False, marks=pytest.mark.slow)])
def test_a_traceback_is_shown_on_request(value, shown, monkeypatch):
    monkeypatch.setenv("ROBODYN_TRACEBACK", value)
    wrong = started("start", *STARTED["wrong"])
    assert wrong.stderr.startswith("Traceback (most recent call last):") == shown
    assert wrong.stderr.splitlines()[-1] == "error: no_such.stl: there is no such file (check the name)"
    broken = "from robodyn.cli import info\ninfo.overview = lambda *_, **__: 1 / 0"
    internal = started("start", "info", str(ROBOTS / "scara.urdf"), before=broken)
    assert internal.returncode == 2
    assert ("\nZeroDivisionError: division by zero\n" in internal.stderr) == shown
    assert "error: internal error at " in internal.stderr.splitlines()[-1]


PROBE = """
import os, signal, sys
sys.path.insert(0, {here!r})
left = [{count}]
def hook(event, _):
    if event == "import":
        left[0] -= 1
        if not left[0]:
            os.kill(os.getpid(), signal.SIGINT)
from robodyn.cli.start import start
sys.addaudithook(hook)
start()
"""
"""Interrupts itself when so many modules have been asked for."""


@pytest.mark.skipif(os.name != "posix", reason="needs signals")
@pytest.mark.parametrize("count", sampled([1, *range(8, 60, 7), *range(60, 1200, 90)], 6))
def test_an_interrupt_while_modules_load(count: int) -> None:
    code = PROBE.format(count=count, here=str(Path(__file__).parent))
    call = [sys.executable, "-I", "-c", code, "torques", str(ROBOTS / "scara.urdf"), str(ROBOTS / "none.csv")]
    done = subprocess.run(call, capture_output=True, text=True, check=False)
    assert "Traceback" not in done.stderr
    assert "internal error" not in done.stderr
    assert done.returncode == 130 or (done.returncode == 2 and count > 300)
    assert done.returncode == 2 or not done.stderr.strip()


HEAVY = (
    *("polars", "pyarrow", "scipy", "rich", "llvmlite", "yourdfpy", "trimesh"),
    *("sympy", "matplotlib", "pandas", "numpy.ma"),
)
SCARA = (str(ROBOTS / "scara.urdf"), str(ROBOTS / "scara_pick_and_place.csv"))
OURS = 90
"""Modules of robodyn that one job may import. Most are small, 0.2 ms each from cached bytecode."""
MESH_OURS = 45
"""As many for one mesh."""
BEYOND = 40
"""Modules that are neither ours nor come with `import numpy, click`: expat, csv, threads, json, dataclasses."""


def imported(code: str, *arguments: str) -> set[str]:
    """The modules that are loaded after some code, in an interpreter of its own."""
    show = "import sys, json, atexit; atexit.register(lambda: print(json.dumps(sorted(sys.modules)), file=sys.stderr))"
    call = [sys.executable, "-I", "-c", f"{show}\n{code}", *arguments]
    done = subprocess.run(call, capture_output=True, check=True, text=True)
    return set(json.loads(done.stderr))


@pytest.fixture(scope="module")
def modules(tmp_path_factory: pytest.TempPathFactory) -> set[str]:
    out = tmp_path_factory.mktemp("out") / "tau.csv"
    call = ("torques", *SCARA, "--out", str(out))
    found = imported("from robodyn.cli.main import main; main()", *call)
    assert out.exists()
    return found


def test_no_heavy_import_for_a_small_table(modules: set[str]) -> None:
    assert not modules & set(HEAVY)


def test_number_of_imports(modules: set[str]) -> None:
    before = imported("import numpy, click")
    ours = {name for name in modules if name.partition(".")[0] == "robodyn"}
    assert len(ours) <= OURS, sorted(ours)
    assert len(modules - before - ours) <= BEYOND, sorted(modules - before - ours)


def test_nothing_of_error_bars_where_nothing_is_uncertain(modules: set[str]) -> None:
    assert [name for name in modules if "uncertain" in name or "varia" in name or "covariance" in name] == []


def test_commands_are_imported_only_when_they_are_listed() -> None:
    listed, version = (imported("from robodyn.cli.main import main; main()", each) for each in ("--help", "--version"))
    assert not listed & {"polars", "scipy", "rich"}
    assert "robodyn.cli.torques" in listed
    assert not version & {"robodyn.cli.torques", "numpy"}


def inertia_imports(*options: str) -> set[str]:
    """The modules that one mesh takes."""
    return imported(
        "from robodyn.cli.main import main; main()", "inertia", str(ROBOTS / "meshes" / "hub.stl"), *options
    )


def test_a_mesh_imports_what_it_is_asked() -> None:
    asked = inertia_imports()
    plain = inertia_imports("--no-symmetry", "--no-tessellation")
    assert not asked & set(HEAVY)
    assert {name.rpartition(".")[2] for name in asked - plain} >= {"symmetry", "tessellation", "columns"}
    ours = {name for name in plain if name.partition(".")[0] == "robodyn"}
    assert not ours & {
        "robodyn.solids.mesh.symmetry_search",
        "robodyn.solids.mesh.repair",
        "robodyn.programs.run.runner",
        "robodyn.robot.model",
    }
    assert len(ours) <= MESH_OURS, sorted(ours)


@pytest.mark.parametrize(
    ("shell", "part"),
    [("bash", "complete -o nosort -F _robodyn_completion"), ("zsh", "#compdef robodyn"), ("fish", "complete ")],
)
def test_script(shell: str, part: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if shell == "bash" and shutil.which("bash") is None:
        pytest.skip("click asks bash for its version")
    monkeypatch.setenv("_ROBODYN_COMPLETE", f"{shell}_source")
    text = shown()
    assert part in text


@pytest.mark.parametrize(
    ("words", "completed"),
    [
        ("robodyn in", ["plain,inertia", "plain,info"]),
        ("robodyn check --package-path mod", ["dir,mod"]),
        ("robodyn zebra --f", []),
        ("robodyn linearize robots/puma.urdf --eq", ["plain,--equilibrium"]),
        ("robodyn export robots/puma.urdf --to ca", ["plain,casadi"]),
    ],
)
def test_words(words: str, completed: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROBOTS.parent)
    monkeypatch.setenv("_ROBODYN_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(words.count(" ")))
    text = shown()
    assert text.split() == completed
