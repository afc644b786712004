"""The installed command ends as Python itself would."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from helpers.command_line import ROBOTS

CALLS = {
    "fine": ("inertia", str(ROBOTS / "meshes" / "hub.stl")),
    "findings": ("check", str(ROBOTS / "scara.urdf"), "--strict", "--select", "ALL"),
    "wrong": ("inertia", "no_such.stl"),
    "no command": ("nothing",),
    "version": ("--version",),
}


def run(function: str, *arguments: str, before: str = "", after: str = "") -> subprocess.CompletedProcess[str]:
    code = f"{before}\nfrom robodyn.cli.{function} import {function}\n{after}\n{function}()"
    return subprocess.run([sys.executable, "-I", "-c", code, *arguments], capture_output=True, text=True, check=False)


def test_it_is_the_entry_point():
    assert '\nrobodyn = "robodyn.cli.start:start"\n' in (Path(__file__).parents[2] / "pyproject.toml").read_text()


@pytest.mark.parametrize("call", CALLS)
def test_as_main(call):
    mine, plain = run("start", *CALLS[call]), run("main", *CALLS[call])
    assert (mine.returncode, mine.stdout, mine.stderr) == (plain.returncode, plain.stdout, plain.stderr)
    assert mine.stdout or mine.stderr


def test_what_is_registered_for_the_end_is_done():
    before = "import atexit; atexit.register(print, 'registered')"
    assert run("start", "--version", before=before).stdout.endswith("registered\n")


def test_threads_are_waited_for():
    late = "import threading, time; threading.Thread(target=lambda: (time.sleep(0.3), print('late'))).start()"
    assert run("start", "--version", after=late).stdout.endswith("late\n")


def test_output_that_cannot_be_written():
    with open("/dev/full", "w") as full:
        code = "from robodyn.cli.start import start; start()"
        call = [sys.executable, "-I", "-c", code, "--version"]
        done = subprocess.run(call, stdout=full, stderr=subprocess.PIPE, check=False)
    assert done.returncode != 0
    assert b"Traceback" not in done.stderr


def test_memory_is_not_taken_apart():
    left = "class Thing:\n    def __del__(self, say=print): say('gone')\nthing = Thing()"
    assert "gone" in run("main", "--version", before=left).stdout
    assert "gone" not in run("start", "--version", before=left).stdout


@pytest.mark.parametrize("isolated", [False, True])
def test_as_a_module_of_a_checkout(isolated, tmp_path):
    """Also where it is not installed, with the libraries that it needs in the path."""
    root = Path(__file__).parents[2]
    call = [sys.executable, "-m", "robodyn", *CALLS["fine"]]
    if isolated:  # no site, thus no installation: neither of robodyn.cli nor of its version
        libraries = {str(Path(module.__file__).parents[1]) for module in map(import_module, ("numpy", "click"))}
        call[1:1] = ["-S"]
        path = os.pathsep.join([str(root), *sorted(libraries)])
    else:
        path = str(root)
    variables = {**os.environ, "PYTHONPATH": path}
    done = subprocess.run(call, capture_output=True, text=True, check=False, cwd=tmp_path, env=variables)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == run("main", *CALLS["fine"]).stdout


@pytest.mark.parametrize(("value", "shown"), [("1", True), ("0", False), ("", False)])
def test_a_traceback_is_shown_on_request(value, shown, monkeypatch):
    monkeypatch.setenv("ROBODYN_TRACEBACK", value)
    wrong = run("start", *CALLS["wrong"])
    assert wrong.stderr.startswith("Traceback (most recent call last):") == shown
    assert wrong.stderr.splitlines()[-1] == "error: no_such.stl: there is no such file (check the name)"
    broken = "from robodyn.cli import info\ninfo.overview = lambda *_, **__: 1 / 0"
    internal = run("start", "info", str(ROBOTS / "scara.urdf"), before=broken)
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
@pytest.mark.parametrize("count", [*range(1, 60, 7), *range(60, 1200, 90)])
def test_an_interrupt_while_modules_load(count: int) -> None:
    code = PROBE.format(count=count, here=str(Path(__file__).parent))
    call = [sys.executable, "-I", "-c", code, "torques", str(ROBOTS / "scara.urdf"), str(ROBOTS / "none.csv")]
    done = subprocess.run(call, capture_output=True, text=True, check=False)
    assert "Traceback" not in done.stderr
    assert "internal error" not in done.stderr
    assert done.returncode == 130 or (done.returncode == 2 and count > 300)
    assert done.returncode == 2 or not done.stderr.strip()


@pytest.mark.skipif(os.name != "posix", reason="needs signals")
def test_an_interrupt_that_a_callback_swallows() -> None:
    swallowed = "import os, signal\nclass Thing:\n    def __del__(self): os.kill(os.getpid(), signal.SIGINT)\n"
    after = "import time\nfrom robodyn.cli import main\n"
    after += "main.Commands.list_commands = lambda *_: [Thing()] and time.sleep(5) or list(main.COMMANDS)"
    done = run("start", "--help", before=swallowed, after=after)
    assert (done.returncode, done.stderr.strip()) == (130, "")
