"""Machine code over arrays, and threads that stand by to share it: called within a microsecond while awake."""

from __future__ import annotations

import atexit
import ctypes
import os
from array import array
from collections.abc import Sequence
from ctypes import c_int32, c_int64, c_void_p
from functools import cache
from itertools import chain
from threading import Event, Lock, Thread

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.run.llvm.build import built
from robodyn.programs.run.llvm.machine import Function, host
from robodyn.programs.run.llvm.team import CALLS, LINE, SIZE, team

LOOKS = 5_000
"""Looks for the next call, some 0.2 milliseconds, before a thread sleeps; to wake takes some 0.05."""
PATIENCE = 500
"""Looks for the end of other threads' work, some 20 microseconds, before a rest."""


class Team:
    """Threads of this process that work together on one job at a time.

    A call while another is under way does its job alone: both find their cores busy anyway.
    """

    def __init__(self) -> None:
        self._memory = array("q", bytes(8 * SIZE))
        self._members: list[_Member] = []
        self._busy = Lock()

    def __call__(self, job: int, threads: int) -> None:
        """Has the caller and up to `threads - 1` others work on a job until it is done.

        Args:
            job: the address of what `run.llvm.team` calls a job; each of the threads calls its function with its own
                number, 0 of the caller.
        """
        if threads == 1 or not self._busy.acquire(blocking=False):
            nobody = array("q", bytes(8 * SIZE))
            _lead(nobody, job)
            return
        try:
            while len(self._members) < threads - 1:
                self._members.append(_Member(self._memory, self._busy, len(self._members) + 1))
            for member in self._members[: threads - 1]:
                member.call()
            _lead(self._memory, job)
        finally:
            self._busy.release()

    def leave(self) -> None:
        """Ends the threads."""
        for member in self._members:
            member.end()
        self._members.clear()


class _Member:
    """A thread of a team; it looks out for calls for a while after each, then sleeps until it is woken."""

    def __init__(self, memory: array[int], busy: Lock, number: int) -> None:
        self._memory, self._busy, self._number = memory, busy, number
        self._awake, self._asleep, self._ends = Event(), False, False
        self._stand_by = _function("stand_by", c_void_p, c_int64, c_int64, c_int64)
        self._thread = Thread(target=self._live, args=(memory[CALLS],), name=f"robodyn-{number}", daemon=True)
        self._thread.start()

    def call(self) -> None:
        """Wakes it if it sleeps."""
        if self._asleep:
            self._awake.set()

    def end(self) -> None:
        self._ends = True
        self._awake.set()
        self._thread.join()

    def _live(self, seen: int) -> None:
        while not self._ends:
            seen = self._stand_by(self._memory.buffer_info()[0], self._number, seen, LOOKS)
            self._sleep()

    def _sleep(self) -> None:
        self._asleep = True
        # Somebody who saw it awake may be about to call.
        if not self._busy.locked():
            self._awake.wait()
        self._awake.clear()
        self._asleep = False


def the_team() -> Team:
    """This process's; a fork, another process, has its own."""
    return _team_of(os.getpid())


@cache
def _team_of(process: int) -> Team:
    formed = Team()
    atexit.register(lambda: formed.leave() if os.getpid() == process else None)
    return formed


def _lead(memory: array[int], job: int) -> None:
    """Opens a job to a team."""
    leads = _function("lead", c_void_p, c_void_p, c_int64, c_void_p, c_int32)
    leads(memory.buffer_info()[0], job, PATIENCE, *_rest())


@cache
def _rest() -> tuple[int, int]:
    """Return the address of a function that rests, and for how long."""
    windows = os.name == "nt"
    library = ctypes.CDLL("kernel32" if windows else None)
    return ctypes.cast(library.Sleep if windows else library.usleep, c_void_p).value or 0, 0 if windows else 20


@cache
def _function(name: str, *arguments: type) -> Function:
    return built(name, "team", lambda: team(host().triple), *arguments)


Fields = tuple[int, int, int, int, int, bool, bool]
"""Of an array, as `robodyn.programs.run.llvm.driver.FIELDS` names them."""


class Job:
    """A run of machine code over all samples of some arrays, which may be repeated as what they hold changes."""

    def __init__(
        self,
        functions: tuple[int, int],
        fields: Sequence[Fields],
        rows: int,
        pitch: int,
        step: int,
        block: int,
        samples: int,
        threads: int,
    ) -> None:
        """
        Args:
            functions: addresses of the driver and of the kernel.
            fields: of the arrays, which the caller keeps; the last is written to.
            rows: columns of all of them.
            pitch: bytes from one gathered column to the next; whole lines of the cache.
            step: samples that a thread takes at a time; block: that it gathers.
        """
        self._samples = samples
        self._flags = array("B", bytes(-(-samples // block) * block // 8))
        each = -(-samples // (threads * block)) * block
        parts = range(0, samples, each)
        self._threads = len(parts)
        self._begin = array("q", (0, *parts))
        self._common, self._fields = self._begin[:], array("q", chain.from_iterable(fields))
        table = -(-2 * rows // LINE) * 8 * LINE
        room = table + rows * pitch
        self._rooms = np.empty(self._threads * room + 8 * LINE, np.uint8)
        rooms = int(self._rooms.__array_interface__["data"][0])
        rooms += -rooms % (8 * LINE)
        places = (*functions, _place(self._fields), rooms, _place(self._flags), _place(self._common))
        numbers = len(fields), room, table, pitch, step, block, samples, each, self._threads
        self._job = array("q", (*places, *numbers))

    def __call__(self) -> bool:
        """Run; whether a sample is flagged."""
        self._common[:] = self._begin
        the_team()(_place(self._job), self._threads)
        return bool(self._common[0])

    def flagged(self) -> NDArray[np.int64]:
        """Return the samples that are flagged; every run writes all flags anew."""
        flags = np.unpackbits(np.frombuffer(self._flags, np.uint8), bitorder="little")
        found: NDArray[np.int64] = np.flatnonzero(flags[: self._samples])
        return found


def _place(numbers: array[int]) -> int:
    return numbers.buffer_info()[0]
