"""The same on a Dask cluster: results equal to the bit, every one once, also where a worker dies."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path

import pytest
from helpers.batch_runs import batch, in_turn, listing, write_motion, write_runs
from helpers.command_line import command, run

from robodyn.cli import torques_batch
from robodyn.cli import torques_batch as cluster
from robodyn.cli.torques_batch import jobs_of

distributed = pytest.importorskip("distributed")
FILES = 12


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_runs(tmp_path)
    monkeypatch.chdir(tmp_path)


def test_a_cluster_gives_what_this_machine_gives(monkeypatch: pytest.MonkeyPatch) -> None:
    """With failures, and nothing done twice; the workers are threads of this process."""
    Path("runs/odd.csv").write_text("time\n")
    monkeypatch.setattr(torques_batch, "worked_here", in_turn)
    here = batch(out="here/")
    made = {"n_workers": 2, "threads_per_worker": 2, "processes": False, "dashboard_address": None}
    with distributed.LocalCluster(**made, local_directory="scratch") as there:
        outcome = run("torques", "arm.urdf", "runs/*.csv", "--out", "there/", "--dask", there.scheduler_address)
        again = run("torques", "arm.urdf", "runs/*.csv", "--out", "there/", "--dask", there.scheduler_address)
    assert (outcome.status, outcome.err) == (here.status, here.err)
    assert outcome.out == here.out.replace("here/", "there/")
    assert listing(Path("there")) == listing(Path("here"))
    assert "\narm: 4 files, 3 finished before, 1 failed\n" in again.out


def test_no_scheduler_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "PATIENCE", 0.1)
    outcome = batch("--dask", "tcp://127.0.0.1:9")
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.startswith("error: tcp://127.0.0.1:9: no Dask scheduler answers: ")
    assert outcome.err.endswith("(an address is like tcp://10.0.0.1:8786)\n")
    assert not Path("results").exists()


def test_problems_of_workers_in_words() -> None:
    (job,) = jobs_of(["runs/one.csv"], "r")
    killed = distributed.scheduler.KilledWorker("task", None, 3)
    assert cluster._why(job, killed).startswith("runs/one.csv: every worker that it was given to died")
    assert cluster._why(job, ModuleNotFoundError("No module named 'robodyn'")).endswith("(install robodyn there)")
    gone = cluster._why(job, distributed.client.FutureCancelledError("task", "lost"))
    assert gone.startswith("runs/one.csv: the scheduler went away (the same command again")
    assert cluster._why(job, TimeoutError("late")) == "runs/one.csv: TimeoutError: late"


@pytest.mark.slow
def test_a_worker_that_is_killed_midway() -> None:
    """SIGKILL for one of two worker processes while both have work and some of it is done."""
    for k in range(FILES):
        write_motion(Path(f"long/{k:02}.csv"), rows=20_000, speed=1.0 + k / FILES)
    how = ("torques", "arm.urdf", "long/*.csv", "--reactions", "--sizing")
    here = subprocess.run(command(*how, "--out", "here"), capture_output=True, text=True, check=True)
    made = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(**made, local_directory="scratch") as there, distributed.Client(there) as client:
        pids = list(client.run(os.getpid).values())
        call = command(*how, "--out", "there", "--dask", there.scheduler_address)
        with subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as child:
            while len(list(Path("there").glob("*.json"))) < 4:
                time.sleep(0.002)
                assert child.poll() is None
            os.kill(pids[0], signal.SIGKILL)
            done = len(list(Path("there").glob("*.json")))
            out, err = child.communicate(timeout=120)
        assert pids[0] not in client.run(os.getpid).values()
    assert done < FILES
    assert (child.returncode, err) == (0, "")
    assert f"\narm: {FILES} files, " in out
    assert "failed" not in out
    assert sorted(listing(Path("there"))) == sorted(f"{k:02}.{kind}" for k in range(FILES) for kind in ("csv", "json"))
    assert listing(Path("there")) == listing(Path("here"))
    worst = [text.partition("The worst of each joint")[2] for text in (out, here.stdout)]
    assert worst[0] == worst[1]
