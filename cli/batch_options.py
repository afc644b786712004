"""The options of `robodyn torques` for many trajectories."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any

import click

Callback = Callable[..., Any]
_TABLES = (".csv", ".tsv", ".txt", ".dat", ".parquet", ".pq", ".npz")


def BATCH(command: Callback) -> Callback:
    """The options --jobs and --dask."""
    text = "Processes for many trajectories; default: one for each core."
    dask = click.option("--dask", metavar="ADDRESS", help="Compute many trajectories on this Dask cluster instead.")
    return click.option("--jobs", type=click.IntRange(min=1), metavar="N", help=text)(dask(command))


def is_batch(trajectories: Sequence[str], out: str | None, how: dict[str, Any]) -> bool:
    """Whether the trajectories are many: by their number, wildcards, or results that go to a folder.

    The options of `BATCH` are taken out of `how` where they are not.
    """
    wild = any(set("*?[") & set(name) and not os.path.lexists(name) for name in trajectories)
    if len(trajectories) > 1 or wild or (out is not None and _is_folder(out)):
        return True
    for name in ("jobs", "dask"):
        if how.pop(name) is not None:
            what = f"--{name} goes with many trajectories: give several, or --out FOLDER/"
            raise click.UsageError(what, click.get_current_context())
    return False


def _is_folder(out: str) -> bool:
    return out[-1:] in (os.sep, "/") or (os.path.isdir(out) and not out.lower().endswith(_TABLES))
