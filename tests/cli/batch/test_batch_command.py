"""`robodyn torques` on many trajectories: whole results, restarts, single failures, a summary, a Dask cluster."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from helpers.batch_runs import NAMES, batch, document, in_turn, listing, write_motion, write_runs
from helpers.command_line import command, run

import robodyn
from robodyn.cli import torques_batch
from robodyn.cli.torques_batch import VERSION, Setup, jobs_of, worked_here
from robodyn.support.cache import code_digest
from robodyn.support.libraries import version_of

LINES = [f"runs/{name}.csv: 50 samples, 0.49 s -> results/{name}.csv" for name in sorted(NAMES)]
OTHER = "0.1.0, code 0123456789ab"


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Jobs are worked on in this process, but for the test that wants others."""
    write_runs(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(torques_batch, "worked_here", in_turn)


def test_results_are_those_of_single_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(torques_batch, "worked_here", worked_here)
    outcome = batch("--reactions", "--sizing", "--explain", "--momentum")
    assert (outcome.status, outcome.err) == (0, "")
    lines = outcome.out.splitlines()
    assert lines[:3] == LINES
    assert lines[4] == "arm: 3 files, 3 computed"
    assert outcome.out.endswith("\nNo limit is exceeded.\n")
    how = ("--reactions", "--sizing", "--explain", "--momentum", "--executor", "compiled")
    for name in NAMES[:1]:
        single = run("torques", "arm.urdf", f"runs/{name}.csv", *how, "--out", "tau.csv", "--format", "json")
        assert Path(f"results/{name}.csv").read_bytes() == Path("tau.csv").read_bytes()
        assert document(Path(f"results/{name}.json")) == json.loads(single.out)
    assert len(listing(Path("results"))) == 6


def test_what_is_finished_is_not_computed_again() -> None:
    first = batch("--format", "json")
    made = {path: path.stat().st_mtime_ns for path in Path("results").iterdir()}
    for path in Path("runs").iterdir():
        path.touch()
    again = batch()
    assert [line.partition(" ")[2][:17] for line in again.out.splitlines()[:3]] == ["finished before, "] * 3
    assert {path: path.stat().st_mtime_ns for path in Path("results").iterdir()} == made
    both = [json.loads(first.out), json.loads(batch("--format", "json").out)]
    assert [(x["computed"], x["finished_before"], x["failed"]) for x in both] == [(3, 0, 0), (0, 3, 0)]
    assert both[0]["worst"] == both[1]["worst"]


def test_what_a_killed_process_left_is_removed() -> None:
    os.mkdir("results")
    for name in ("one.csv.0a1b2c3d.part", "one.json.0a1b2c3d.part"):
        Path("results", name).write_text("half")
    batch()
    assert sorted(os.listdir("results")) == sorted(f"{name}.{kind}" for name in NAMES for kind in ("csv", "json"))


@pytest.mark.slow
def test_two_batches_at_once_into_one_folder_are_both_whole() -> None:
    trajectories = [f"runs/{k}.csv" for k in range(20)]
    for name in trajectories:
        shutil.copy("runs/one.csv", name)
    calls = [command("torques", "arm.urdf", *trajectories, "--out", "results/", "--executor", "numpy")] * 2
    both = [subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) for call in calls]
    ended = [(*process.communicate(), process.returncode) for process in both]
    assert [(err, status) for _, err, status in ended] == [("", 0)] * 2
    assert sorted(os.listdir("results")) == sorted(f"{k}.{kind}" for k in range(20) for kind in ("csv", "json"))
    assert len({Path(f"results/{k}.csv").read_bytes() for k in range(20)}) == 1


def statuses(*more: str) -> list[str]:
    return [entry["status"] for entry in json.loads(batch("--format", "json", *more).out)["files"]]


def test_what_has_changed_is_computed_again() -> None:
    """Files in the order of their names: one, three, two."""
    new, old = "computed", "finished before"
    assert statuses() == [new] * 3
    write_motion(Path("runs/three.csv"), speed=9.0)
    assert statuses() == [old, new, old]
    with open("results/one.csv", "a") as stream:
        stream.write("0,0,0\n")
    assert statuses() == [new, old, old]
    Path("results/two.json").write_text(Path("results/two.json").read_text()[:-3])
    assert statuses() == [old, old, new]
    Path("results/two.csv").unlink()
    assert statuses() == [old, old, new]
    assert statuses("--gravity", "0,0,-1") == [new] * 3
    assert statuses("--gravity", "0,0,-1", "--threads", "2") == [old] * 3
    Path("scene.toml").write_text("gravity = [0, 0, -1]\n")
    assert statuses("--scene", "scene.toml") == [new] * 3
    Path("scene.toml").write_text("gravity = [0, 0, -2]\n")
    assert statuses("--scene", "scene.toml") == [new] * 3


def test_what_other_code_has_computed_is_computed_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where its version is the same; on a worker it is told."""
    assert statuses() == ["computed"] * 3
    monkeypatch.setattr(torques_batch, "VERSION", OTHER)
    Path("results/one.csv").unlink()
    line = f"error: runs/one.csv: robodyn {OTHER} works on it, the batch is of robodyn {VERSION} (install"
    assert batch().err.startswith(line)
    monkeypatch.setattr(torques_batch, "Setup", partial(Setup, version=OTHER))
    assert statuses() == ["computed"] * 3
    assert statuses() == ["finished before"] * 3


def test_the_code_is_told_by_every_module_but_those_of_the_command_line(tmp_path: Path) -> None:
    package, copy = Path(robodyn.__file__).parent, tmp_path / "copy"
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("__pycache__", "cli"))
    assert f"{version_of('robodyn')}, code {code_digest(copy)[:12]}" == VERSION
    (copy / "cli").mkdir()
    (copy / "cli" / "torques.py").write_text("changed")
    assert code_digest(copy, without="cli") == code_digest(package, without="cli")
    (copy / "robot" / "model.py").rename(copy / "moved.py")
    assert code_digest(copy, without="cli")[:12] not in VERSION


def test_a_trajectory_that_fails_stops_no_other() -> None:
    Path("runs/odd.csv").write_text("time,q_shoulder\n0,0\n")
    outcome = run("torques", "arm.urdf", *(f"runs/{name}.csv" for name in ("one", "odd", "none", "two")), "--out", "r/")
    assert outcome.status == 2
    assert [line.partition(":")[0] for line in outcome.out.splitlines()[:2]] == ["runs/one.csv", "runs/two.csv"]
    assert "\narm: 4 files, 2 computed, 2 failed\n" in outcome.out
    assert outcome.err.splitlines() == [
        "error: runs/odd.csv:1: no position of joint 'elbow' "
        "(--hold rest keeps joints without columns still; there is 'time', 'q_shoulder')",
        "error: runs/none.csv: cannot be read: no such file or directory",
    ]
    assert sorted(listing(Path("r"))) == ["one.csv", "one.json", "two.csv", "two.json"]


def test_results_of_other_inputs_do_not_stay() -> None:
    """A motion that was good and is broken now has no result; files that are none of ours are left alone."""
    batch()
    Path("results/odd.json").write_text('{"mine": 1}')
    Path("results/odd.csv").write_text("mine")
    for name in ("two", "odd"):
        Path(f"runs/{name}.csv").write_text("time\n")
    assert batch().status == 2
    assert sorted(listing(Path("results"))) == [
        f"{name}.{x}" for name in ("odd", "one", "three") for x in ("csv", "json")
    ]
    assert Path("results/odd.csv").read_text() == "mine"


def test_the_worst_of_each_joint() -> None:
    worst = {joint["name"]: joint for joint in json.loads(batch("--format", "json").out)["worst"]}
    singles = {name: json.loads(Path(f"results/{name}.json").read_text())["joints"] for name in NAMES}
    for k, name in enumerate(("shoulder", "elbow")):
        found = worst[name]
        for key, of in (("peak", "peak"), ("rms", "rms"), ("max_speed", "max_speed")):
            most = max(singles, key=lambda single: abs(singles[single][k][of]))
            assert found[f"{key}_in"] == f"runs/{most}.csv"
            assert abs(found[key]) == abs(singles[most][k][of])
        assert found["level"] is None
    assert worst["elbow"]["max_speed_in"] == "runs/three.csv"


def test_limits() -> None:
    """The elbow turns at 0.2, 0.4 and 0.6 rad/s, the shoulder at half of it."""
    assert batch("--fail-on-limits").status == 0
    text = Path("arm.urdf").read_text()
    Path("arm.urdf").write_text(text.replace('velocity="5"', 'velocity="0.25"'))
    for _ in range(2):
        outcome = batch("--fail-on-limits", "--sizing")
        assert outcome.status == 1
        lines = [line.replace("finished before, ", "") for line in outcome.out.splitlines()]
        assert "runs/two.csv: 50 samples, 0.49 s, LIMITS EXCEEDED: elbow velocity -> results/two.csv" in lines
        assert lines[-1] == "LIMITS EXCEEDED in 2 files"
        assert "over peak" in outcome.out
    assert batch().status == 0


def test_folders_that_differ_are_kept() -> None:
    os.rename("runs", "a")
    write_motion(Path("b/c/one.parquet"))
    outcome = batch(pattern="**/*.[cp]*")
    assert (outcome.status, outcome.err) == (0, "")
    tables = [f"a/{name}.csv" for name in NAMES] + ["b/c/one.parquet"]
    documents = [str(Path(name).with_suffix(".json")) for name in tables]
    assert sorted(listing(Path("results"))) == sorted(tables + documents)


def test_a_name_with_wildcards_may_be_that_of_a_file() -> None:
    os.rename("runs/one.csv", "runs/one[1].csv")
    outcome = run("torques", "arm.urdf", "runs/one[1].csv", "--out", "tau.csv")
    assert "\nwritten: tau.csv, 50 rows of time and 2 columns\n" in outcome.out


def test_results_of_one_name() -> None:
    write_motion(Path("runs/one.parquet"))
    outcome = run("torques", "arm.urdf", "runs/one.csv", "runs/one.parquet", "--out", "r/")
    assert outcome.err.startswith("error: runs/one.parquet: the results of 'runs/one.csv' would have the same name")


@pytest.fixture
def distributed() -> Any:
    return pytest.importorskip("distributed")


def test_a_cluster_gives_what_this_machine_gives(distributed: Any) -> None:
    """To the bit, with failures, and nothing done twice; the workers are threads of this process."""
    Path("runs/odd.csv").write_text("time\n")
    here = batch(out="here/")
    made = {"n_workers": 2, "threads_per_worker": 2, "processes": False, "dashboard_address": None}
    with distributed.LocalCluster(**made, local_directory="scratch") as there:
        call = ("torques", "arm.urdf", "runs/*.csv", "--out", "there/", "--dask", there.scheduler_address)
        outcome, again = run(*call), run(*call)
    assert (outcome.status, outcome.err) == (here.status, here.err)
    assert outcome.out == here.out.replace("here/", "there/")
    assert listing(Path("there")) == listing(Path("here"))
    assert "\narm: 4 files, 3 finished before, 1 failed\n" in again.out


def test_no_scheduler_there(monkeypatch: pytest.MonkeyPatch, distributed: Any) -> None:
    monkeypatch.setattr(torques_batch, "PATIENCE", 0.1)
    outcome = batch("--dask", "tcp://127.0.0.1:9")
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.startswith("error: tcp://127.0.0.1:9: no Dask scheduler answers: ")
    assert outcome.err.endswith("(an address is like tcp://10.0.0.1:8786)\n")
    assert not Path("results").exists()


def test_problems_of_workers_in_words(distributed: Any) -> None:
    (job,) = jobs_of(["runs/one.csv"], "r")
    killed, gone = distributed.scheduler.KilledWorker("task", None, 3), distributed.client.FutureCancelledError
    for problem, words in (
        (killed, "every worker that it was given to died (is there enough memory?)"),
        (ModuleNotFoundError("No robodyn"), "No robodyn on the worker (install robodyn there)"),
        (gone("task", "lost"), "the scheduler went away (the same command again goes on with what is not finished)"),
        (TimeoutError("late"), "TimeoutError: late"),
    ):
        assert torques_batch._why(job, problem) == f"runs/one.csv: {words}"
