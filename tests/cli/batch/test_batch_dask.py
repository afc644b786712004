"""The same on a Dask cluster: results equal to the bit, and what cannot be done there in words."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.batch_runs import batch, in_turn, listing, write_runs
from helpers.command_line import run

from robodyn.cli import torques_batch
from robodyn.cli import torques_batch as cluster
from robodyn.cli.torques_batch import jobs_of

distributed = pytest.importorskip("distributed")


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
