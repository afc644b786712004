"""Machine code and the arrays that it runs over."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.run.llvm.team import LINE
from robodyn.programs.run.team import the_team

Fields = tuple[int, int, int, int, bool]
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
            pitch: bytes from one gathered column to the next.
            step: samples that a thread takes at a time; block: that it gathers.
        """
        self._samples = samples
        self._flags = array("B", bytes(-(-samples // block) * block // 8))
        each = -(-samples // (threads * block)) * block
        parts = range(0, samples, each)
        self._threads = len(parts)
        self._begin = array("q", (0, *parts))
        self._common, self._fields = self._begin[:], array("q", chain.from_iterable(fields))
        table = -(-rows // LINE) * 8 * LINE
        room = table + rows * pitch
        self._rooms = np.empty(self._threads * room, np.uint8)
        rooms = int(self._rooms.__array_interface__["data"][0])
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
