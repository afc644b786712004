"""Jobs on all cores of this machine, by processes that are replaced when they die, or on a Dask cluster."""

from __future__ import annotations

import signal
import sys
import warnings
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from threading import current_thread, main_thread
from typing import Any

from robodyn.cli.batch.jobs import Job, Setup
from robodyn.cli.batch.work import failed, run_job
from robodyn.errors import InputError
from robodyn.loads.many import Outcome
from robodyn.support.extras import need
from robodyn.support.files import remove_abandoned

ATTEMPTS = 2
"""Processes that may die of one job before it is given up."""
_PATIENCE = 5.0
"""Seconds that a process has to clear up before it is killed."""


class _Worker:
    """A process, this end of the pipe to it, and the number of the job that it works on."""

    def __init__(self, setup: Setup) -> None:
        spawn = get_context("spawn")
        self.connection, other = spawn.Pipe()
        self.process = spawn.Process(target=_serve, args=(other, setup), daemon=True)
        with ignore_sigint():
            self.process.start()
        other.close()
        self.number = -1

    def send(self, job: Job | None) -> None:
        """Give a job, or None to end; that the process has died is found out when it should answer."""
        with suppress(OSError):
            self.connection.send(job)

    def end(self, job: Job) -> None:
        """Let the process clear up and end, and remove what it has not: killed, or under Windows, it cannot."""
        self.process.join(_PATIENCE)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()
        self.connection.close()
        for path in (job.table, job.document):
            remove_abandoned(path)


@contextmanager
def ignore_sigint() -> Iterator[None]:
    """Processes that are started meanwhile do not hear interruptions, which the terminal sends to all of them."""
    if current_thread() is not main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def worked_here(setup: Setup, jobs: Sequence[Job], count: int) -> Iterator[tuple[int, Outcome]]:
    """(number, outcome) of every job as they are done, by `count` processes.

    When the iterator is closed early, by an interruption for example, processes remove what they have half-written.
    """
    waiting = deque(range(len(jobs)))
    attempts = [0] * len(jobs)
    workers: dict[Connection, _Worker] = {}

    def give(worker: _Worker) -> None:
        worker.number = waiting.popleft()
        attempts[worker.number] += 1
        worker.send(jobs[worker.number])

    try:
        while waiting or workers:
            while waiting and len(workers) < count:
                worker = _Worker(setup)
                workers[worker.connection] = worker
                give(worker)
            for connection in wait(list(workers)):
                worker = workers[connection]  # type: ignore[index]
                number = worker.number
                try:
                    yield number, worker.connection.recv()
                except (EOFError, OSError):
                    if attempts[number] < ATTEMPTS:
                        waiting.appendleft(number)
                    else:
                        yield number, failed(jobs[number], _death(jobs[number], worker))
                else:
                    if waiting:
                        give(worker)
                        continue
                    worker.send(None)
                del workers[worker.connection]
                worker.end(jobs[number])
    finally:
        for worker in workers.values():
            worker.process.terminate()
        for worker in workers.values():
            worker.end(jobs[worker.number])


def _death(job: Job, worker: _Worker) -> str:
    worker.process.join(_PATIENCE)
    how = f"signal {-code}" if (code := worker.process.exitcode or 0) < 0 else f"status {code}"
    return f"{job.name}: its process died {ATTEMPTS} times, at last by {how} (is there enough memory?)"


def _serve(connection: Connection, setup: Setup) -> None:
    """Work until there is no more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that half-written files are removed
    warnings.simplefilter("ignore")
    try:
        while (job := connection.recv()) is not None:
            connection.send(run_job(setup, job))
    except (EOFError, BrokenPipeError):
        pass  # the other end has gone


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
