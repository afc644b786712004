"""A folder with the arm and several motions of it, and what `robodyn torques` makes of them."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import polars as pl

from helpers.command_line import ARM, Outcome, run
from robodyn.cli.torques_batch import Job, Setup, run_job
from robodyn.loads.many import Outcome as Result

NAMES = ("one", "two", "three")


def write_motion(path: Path, rows: int = 50, speed: float = 1.0) -> None:
    """A swing of both joints, as CSV or Parquet."""
    t = np.arange(rows) / 100.0
    w = speed * np.array([1.0, 2.0])
    columns = {"time": t}
    for k, name in enumerate(("shoulder", "elbow")):
        columns[f"q_{name}"] = 0.1 * np.sin(w[k] * t)
        columns[f"qd_{name}"] = 0.1 * w[k] * np.cos(w[k] * t)
        columns[f"qdd_{name}"] = -0.1 * w[k] ** 2 * np.sin(w[k] * t)
    table = pl.DataFrame(columns)
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".parquet":
        table.write_parquet(path)
    else:
        table.write_csv(path)


def write_runs(folder: Path, suffix: str = ".csv") -> None:
    """`arm.urdf` and three motions in `runs`, each faster than the one before."""
    (folder / "arm.urdf").write_text(ARM)
    for k, name in enumerate(NAMES, 1):
        write_motion(folder / "runs" / f"{name}{suffix}", speed=float(k))


def batch(*more: str, pattern: str = "runs/*.csv", out: str = "results/") -> Outcome:
    """`robodyn torques arm.urdf PATTERN --out OUT` with more options, by two processes."""
    return run("torques", "arm.urdf", pattern, "--out", out, "--jobs", "2", *more)


def in_turn(setup: Setup, jobs: Sequence[Job], count: int) -> Iterator[tuple[int, Result]]:
    """What processes do, done in this one."""
    for number, job in enumerate(jobs):
        yield number, run_job(setup, job)


def listing(folder: Path) -> dict[str, bytes]:
    """What is in a folder, below it included."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def document(path: Path) -> dict[str, object]:
    """A JSON document without what says where it is from."""
    found: dict[str, object] = json.loads(path.read_text())
    found.pop("inputs", None)
    return found
