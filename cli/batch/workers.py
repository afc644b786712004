"""Jobs on all cores of this machine, by processes that are replaced when they die, or on a Dask cluster."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from functools import partial
from importlib import import_module
from typing import Any

from robodyn.cli.batch.jobs import Job, Setup
from robodyn.cli.batch.work import failed, run_job
from robodyn.errors import InputError
from robodyn.loads.many import Outcome
from robodyn.support.extras import need
from robodyn.support.files import remove_abandoned
from robodyn.support.processes import Death, in_processes


def worked_here(setup: Setup, jobs: Sequence[Job], count: int) -> Iterator[tuple[int, Outcome]]:
    """Yield (number, outcome) of every job as they are done, by `count` processes.

    When the iterator is closed early, by an interruption for example, processes remove what they have half-written.
    """

    def clear(number: int) -> None:
        """Remove what the process has not: killed, or under Windows, it cannot."""
        for path in (jobs[number].table, jobs[number].document):
            remove_abandoned(path)

    with closing(in_processes(partial(_run_quietly, setup), [(job,) for job in jobs], count, clear)) as work:
        for number, found in work:
            job = jobs[number]
            yield number, failed(job, f"{job.name}: {found}") if isinstance(found, Death) else found


def _run_quietly(setup: Setup, job: Job) -> Outcome:
    warnings.simplefilter("ignore")
    return run_job(setup, job)


PATIENCE = 10
"""Seconds within which the scheduler must answer."""


def worked_there(
    setup: Setup, jobs: Sequence[Job], address: str, say: Callable[[str], None]
) -> Iterator[tuple[int, Outcome]]:
    """Yield (number, outcome) of every job as they are done, by the workers of the cluster at this address.

    The workers need robodyn of this version, and the files of this machine under the same names. The scheduler gives
    the jobs of a worker that dies to others; since files appear whole, a job that was done twice leaves what it leaves
    when it is done once. When the iterator is closed early, jobs that have not begun are cancelled.

    Args:
        address: of the scheduler, such as tcp://10.0.0.1:8786.
        say: called with a line where there is no worker yet.

    Raises:
        InputError: Dask is not installed, or there is no scheduler at the address.
    """
    need("clusters of Dask", "distributed")
    distributed: Any = import_module("distributed")
    try:
        client = distributed.Client(address, timeout=PATIENCE)
    except (OSError, ValueError, TypeError) as error:
        what = f"no Dask scheduler answers: {' '.join(str(error).split()) or type(error).__name__}"
        raise InputError(what, remedy="an address is like tcp://10.0.0.1:8786", file=address) from None
    with client:
        if not client.scheduler_info(n_workers=-1)["workers"]:
            say(f"{address} has no workers yet; waiting for them")
        futures = [client.submit(run_job, setup, job, pure=False) for job in jobs]
        numbers = {future: number for number, future in enumerate(futures)}
        try:
            for future in distributed.as_completed(futures):
                number = numbers[future]
                try:
                    outcome = future.result()
                except Exception as problem:
                    outcome = failed(jobs[number], _why(jobs[number], problem))
                yield number, outcome
        finally:
            client.cancel(futures)


def _why(job: Job, problem: BaseException) -> str:
    name = type(problem).__name__
    if name == "KilledWorker":
        return f"{job.name}: every worker that it was given to died (is there enough memory?)"
    if isinstance(problem, ModuleNotFoundError):
        return f"{job.name}: {problem} on the worker (install robodyn there)"
    if name.endswith("CancelledError"):
        return f"{job.name}: the scheduler went away (the same command again goes on with what is not finished)"
    return f"{job.name}: {name}: {problem}"
