"""Processes that die, interruptions, and the progress bar."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path
from threading import Thread

import pytest
from helpers.batch_runs import NAMES, write_motion, write_runs
from helpers.command_line import command
from helpers.processes import on_terminal

from robodyn.cli.options import Call
from robodyn.cli.torques_batch import _setup, jobs_of, worked_here
from robodyn.support.processes import ATTEMPTS


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_runs(tmp_path)
    monkeypatch.chdir(tmp_path)


def setup():
    loads = {"momentum": None, "sizing": None, "reactions": False, "explain": False, "executor": "numpy"}
    return _setup(Call(), "arm.urdf", {**loads, "threads": None})[0]


def kill_writers(name: str, times: int, children: list[subprocess.Popen[bytes]]) -> None:
    """Kill the one process of the pool in the middle of what it writes of this motion, so many times."""
    killed = set[int]()
    while len(killed) < times:
        if list(Path("results").glob(f"*{name}*.part")) and children[-1].pid not in killed:
            killed.add(children[-1].pid)
            os.kill(children[-1].pid, signal.SIGKILL)
        time.sleep(0.001)


@pytest.mark.skipif(os.name != "posix", reason="needs signals")
@pytest.mark.parametrize("deaths", [pytest.param(1, marks=pytest.mark.slow), ATTEMPTS])
def test_a_process_that_dies_is_replaced(deaths: int, children: list[subprocess.Popen[bytes]]) -> None:
    """The job is tried again, and given up after the last attempt; the others are not touched."""
    write_motion(Path("runs/long.csv"), rows=60_000)
    jobs = jobs_of(["runs/one.csv", "runs/long.csv", "runs/two.csv"], "results")
    killer = Thread(target=kill_writers, args=("long", deaths, children), daemon=True)
    killer.start()
    outcomes = dict(worked_here(setup(), jobs, 1))
    killer.join()
    assert [outcomes[number].status for number in (0, 2)] == ["computed", "computed"]
    if deaths == ATTEMPTS:
        died = "runs/long.csv: its process died 2 times, at last by signal 9 (is there enough memory?)"
        assert outcomes[1].error == died
    else:
        assert outcomes[1].status == "computed"
    assert len(children) == 1 + deaths
    assert all(child.returncode is not None for child in children)
    assert not list(Path("results").glob("*.part"))


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="needs process groups")
@pytest.mark.parametrize("whole_group", [True, False])
def test_interrupted(whole_group: bool) -> None:
    """Ctrl-C reaches every process of the terminal, `kill -INT` one; either leaves whole files only."""
    for k in range(4):
        write_motion(Path(f"long/{k}.csv"), rows=60_000)
    call = command("torques", "arm.urdf", "long/*.csv", "--out", "results", "--reactions", "--jobs", "2")
    with subprocess.Popen(
        call, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as child:
        while not list(Path("results").glob("*.part")):
            time.sleep(0.001)
            assert child.poll() is None
        (os.killpg if whole_group else os.kill)(child.pid, signal.SIGINT)
        _, err = child.communicate(timeout=30)
    assert (child.returncode, err.strip()) == (130, "")
    left = sorted(path.name for path in Path("results").iterdir())
    assert not [name for name in left if name.endswith(".part")]
    assert len(left) < 8
    for path in Path("results").glob("*.csv"):
        assert path.read_text().count("\n") == 60_001


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="needs signals")
def test_processes_that_are_ended_the_hard_way_leave_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """As under Windows, where what ends a process lets it clear nothing up."""
    monkeypatch.setattr(subprocess.Popen, "terminate", subprocess.Popen.kill)
    write_motion(Path("long/a.csv"), rows=60_000)
    jobs = jobs_of(["runs/one.csv", "long/a.csv"], "results")
    work = worked_here(setup(), jobs, 2)
    assert next(work)[1].status == "computed"
    while not list(Path("results").rglob("*.part")):
        time.sleep(0.001)
    work.close()
    assert sorted(str(path) for path in Path("results").rglob("*.*")) == [
        "results/runs/one.csv",
        "results/runs/one.json",
    ]


@pytest.mark.slow
def test_progress_on_a_terminal() -> None:
    """A bar with the files that are done and the time left, below the lines; nothing of it where nobody looks."""
    pipes = command("torques", "arm.urdf", "runs/*.csv", "--out", "results", "--executor", "numpy")
    shown, piped = on_terminal(pipes, stdout=False, stderr=True)
    assert "0 of 3 files" in shown
    assert "3 of 3 files" in shown
    assert "0:00:00" in shown
    assert piped.splitlines()[:3] == [f"runs/{x}.csv: 50 samples, 0.49 s -> results/{x}.csv" for x in sorted(NAMES)]
