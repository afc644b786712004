"""Jobs on the workers of a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from typing import Any

from robodyn.cli.batch.jobs import Job, Setup
from robodyn.cli.batch.work import failed, run_job
from robodyn.errors import InputError
from robodyn.loads.many import Outcome

PATIENCE = 10
"""Seconds within which the scheduler must answer."""


def worked_there(
    setup: Setup, jobs: Sequence[Job], address: str, say: Callable[[str], None]
) -> Iterator[tuple[int, Outcome]]:
    """(number, outcome) of every job as they are done, by the workers of the cluster at this address.

    The workers need robodyn of this version, and the files of this machine under the same names. The scheduler gives
    the jobs of a worker that dies to others; since files appear whole, a job that was done twice leaves what it leaves
    when it is done once. When the iterator is closed early, jobs that have not begun are cancelled.

    Args:
        address: of the scheduler, such as tcp://10.0.0.1:8786.
        say: is told that there is no worker yet.

    Raises:
        InputError: Dask is not installed, or there is no scheduler at the address.
    """
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        raise InputError("--dask needs Dask", remedy="pip install 'robodyn[dask]'") from None
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
