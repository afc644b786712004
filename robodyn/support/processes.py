"""Calls on all cores, by processes that are replaced when they die and end when their results are no longer wanted."""

from __future__ import annotations

import signal
import sys
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing import get_context, resource_tracker
from multiprocessing.connection import Connection, wait
from traceback import format_exc
from typing import Any, Generic, NamedTuple, TypeVar

ATTEMPTS = 2
"""Processes that may die of one call before it is given up."""
_PATIENCE = 5.0
"""Seconds that a process has to clear up before it is killed."""
R = TypeVar("R")


class Death(NamedTuple):
    """What became of a call of which the processes died.

    Attributes:
        status: with which the last of them ended; less than 0 of the signal that ended it.
    """

    status: int

    def __str__(self) -> str:
        how = f"signal {-self.status}" if self.status < 0 else f"status {self.status}"
        return f"its process died {ATTEMPTS} times, at last by {how} (is there enough memory?)"


class _Raised(NamedTuple):
    """What a call raised, and where."""

    error: Exception
    trace: str


class _Worker(Generic[R]):
    """A process, this end of the pipe to it, and the number of the call that it works on."""

    def __init__(self, work: Callable[..., R], method: str | None) -> None:
        context: Any = get_context(method)
        self.connection, other = context.Pipe()
        self.process = context.Process(target=_serve, args=(other, work), daemon=True)
        self.process.start()
        other.close()
        self.number = -1

    def send(self, arguments: tuple[Any, ...] | None) -> None:
        """Give arguments of a call, or None to end; that the process has died is found out when it should answer."""
        with suppress(OSError):
            self.connection.send(arguments)

    def end(self) -> None:
        """Let the process clear up and end."""
        self.process.join(_PATIENCE)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()
        self.connection.close()


@contextmanager
def delayed_interruption() -> Iterator[None]:
    """Let an interruption wait; processes that are started meanwhile never get one.

    A terminal interrupts all processes, of which only the first is to end the others. That signals are ignored is not
    enough: polars, once imported, handles them itself, and raises KeyboardInterrupt.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # when it starts it lets signals through
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def in_processes(
    work: Callable[..., R],
    calls: Sequence[tuple[Any, ...]],
    count: int,
    method: str | None = None,
    clear: Callable[[int], None] = lambda _: None,
) -> Generator[tuple[int, R | Death], None, None]:
    """Yield the number of each of some calls with what `work(*call)` returned, as they are done.

    When the iterator is closed early, by an interruption for example, the processes are asked to end.

    Args:
        work: what it raises is raised here.
        calls: the arguments of each.
        count: of processes.
        method: by which they are started; see `multiprocessing.get_context`.
        clear: called with the number of a call whose process has ended before it could clear up, perhaps.
    """
    waiting = deque(range(len(calls)))
    attempts = [0] * len(calls)
    workers: dict[Connection, _Worker[R]] = {}

    def give(worker: _Worker[R]) -> None:
        worker.number = waiting.popleft()
        attempts[worker.number] += 1
        worker.send(calls[worker.number])

    def end(worker: _Worker[R]) -> None:
        worker.end()
        clear(worker.number)

    try:
        while waiting or workers:
            while waiting and len(workers) < count:
                with delayed_interruption():
                    worker = _Worker(work, method)
                    workers[worker.connection] = worker
                give(worker)
            for connection in wait(list(workers)):
                worker = workers[connection]  # type: ignore[index]
                number = worker.number
                try:
                    found = worker.connection.recv()
                except (EOFError, OSError):
                    if attempts[number] < ATTEMPTS:
                        waiting.appendleft(number)
                    else:
                        worker.process.join(_PATIENCE)
                        yield number, Death(worker.process.exitcode or 0)
                else:
                    if isinstance(found, _Raised):
                        raise found.error from RuntimeError(found.trace)
                    yield number, found
                    if waiting:
                        give(worker)
                        continue
                    worker.send(None)
                del workers[worker.connection]
                end(worker)
    finally:
        for worker in workers.values():
            worker.process.terminate()
        for worker in workers.values():
            end(worker)


def _serve(connection: Connection, work: Callable[..., Any]) -> None:
    """Work until there is no more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that half-written files are removed
    try:
        while (call := connection.recv()) is not None:
            try:
                found = work(*call)
            except Exception as error:
                found = _Raised(error, f"in a process of its own:\n{format_exc()}")
            connection.send(found)
    except (EOFError, BrokenPipeError):
        pass  # the other end has gone
