"""Calls on all cores, by processes that are replaced when they die and end when their results are no longer wanted."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from queue import Empty, Queue
from threading import Thread
from traceback import format_exc
from typing import Any, Generic, NamedTuple, TypeVar

from robodyn.errors import InputError
from robodyn.support.children import start_python
from robodyn.support.threads import processes

ATTEMPTS = 2
"""Processes that may die of one call before it is given up."""
_ENDED = object()
"""What comes in place of an answer when a process has ended."""
R = TypeVar("R")


class Death(NamedTuple):
    """A call of which the processes died, the last with this status; less than 0 of the signal that ended it."""

    status: int

    def __str__(self) -> str:
        how = f"signal {-self.status}" if self.status < 0 else f"status {self.status}"
        return f"its process died {ATTEMPTS} times, at last by {how} (is there enough memory?)"


class _Raised(NamedTuple):
    error: Exception
    trace: str


class _Worker(Generic[R]):
    """A process, and the number of the call that it works on; its answers are put into a queue as (worker, answer)."""

    def __init__(self, work: Callable[..., R], answers: Queue[Any]) -> None:
        self.number = -1
        self.process = start_python(f"{__name__}:serve")
        self._answers = answers
        self._reader = Thread(target=self._read, daemon=True)
        self._reader.start()
        self.send(work)

    def send(self, what: Any) -> None:
        """Give what to do, arguments of a call, or None to end; that the process has died its end will tell."""
        assert self.process.stdin is not None
        with suppress(OSError):
            pickle.dump(what, self.process.stdin)
            self.process.stdin.flush()

    def _read(self) -> None:
        assert self.process.stdout is not None
        with suppress(EOFError, OSError, ValueError, pickle.UnpicklingError):
            while True:
                self._answers.put((self, pickle.load(self.process.stdout)))
        self._answers.put((self, _ENDED))

    def end(self) -> int:
        """Let the process clear up and end; return its status."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        try:
            self.process.wait(5.0)  # to clear up
        except subprocess.TimeoutExpired:
            self.process.kill()
        status = self.process.wait()
        self._reader.join()
        with suppress(OSError):
            self.process.stdin.close()
        self.process.stdout.close()
        return status


@contextmanager
def delayed_interruption() -> Iterator[None]:
    """Let an interruption, which a terminal sends to all processes, wait; those that are started meanwhile never get
    one."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def in_processes(
    work: Callable[..., R],
    calls: Sequence[tuple[Any, ...]],
    count: int,
    clear: Callable[[int], None] = lambda _: None,
) -> Generator[tuple[int, R | Death], None, None]:
    """Yield the number of each of some calls with what `work(*call)` returned, as they are done by so many processes.

    What `work` raises is raised here. When the iterator is closed early, by an interruption for example, the processes
    are asked to end. `clear` gets the number of a call whose process may have ended before it could clear up.
    """
    waiting = deque(range(len(calls)))
    attempts = [0] * len(calls)
    answers: Queue[Any] = Queue()
    workers: set[_Worker[R]] = set()

    def give(worker: _Worker[R]) -> None:
        worker.number = waiting.popleft()
        attempts[worker.number] += 1
        worker.send(calls[worker.number])

    def end(worker: _Worker[R]) -> int:
        status = worker.end()
        clear(worker.number)
        return status

    def begin() -> None:
        while waiting and len(workers) < count:
            with delayed_interruption():
                worker = _Worker(work, answers)
                workers.add(worker)
            give(worker)

    try:
        while waiting or workers:
            begin()
            try:
                worker, found = answers.get(timeout=1.0)  # Windows cannot interrupt it
            except Empty:
                continue
            if worker not in workers:
                continue  # it has ended, as it was told to
            number = worker.number
            if isinstance(found, _Raised):
                raise found.error from RuntimeError(found.trace)
            if found is _ENDED:
                workers.remove(worker)
                status = end(worker)
                if attempts[number] == ATTEMPTS:
                    yield number, Death(status)
                else:
                    waiting.appendleft(number)
                continue
            yield number, found
            if waiting:
                give(worker)
            else:
                workers.remove(worker)
                worker.send(None)
                end(worker)
    finally:
        for worker in workers:
            worker.process.terminate()
        for worker in workers:
            end(worker)


def each_in_a_process(work: Callable[..., R], calls: Sequence[tuple[Any, ...]]) -> Iterator[R | InputError]:
    """Yield `work(*call)` of every call, in their order, on all cores; an error of a call that processes died of."""
    found: dict[int, R | InputError] = {}
    with closing(in_processes(work, calls, processes(len(calls)))) as done:
        for number in range(len(calls)):
            while number not in found:
                other, outcome = next(done)
                found[other] = InputError(str(outcome)) if isinstance(outcome, Death) else outcome
            yield found.pop(number)


def serve() -> None:
    """Answer the calls of `in_processes` until there are no more; what is called has its standard output on standard
    error."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that half-written files are removed
    calls, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    with open(os.devnull, "rb") as nothing:
        os.dup2(nothing.fileno(), 0)
    os.dup2(2, 1)
    try:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        work = pickle.load(calls)
        while (call := pickle.load(calls)) is not None:
            try:
                found = work(*call)
            except Exception as error:
                found = _Raised(error, f"in a process of its own:\n{format_exc()}")
            pickle.dump(found, answers)
            answers.flush()
    except (EOFError, BrokenPipeError):
        pass  # the other end has gone
