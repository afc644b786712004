"""Where the columns of a result go, block by block: to a file, and to a progress bar."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager

from robodyn.cli.progress import watched
from robodyn.loads.torques import Sink
from robodyn.support.read_ahead import behind
from robodyn.trajectory.reader import TrajectoryReader
from robodyn.trajectory.write import open_writer


@contextmanager
def sinks(out: str | None, names: Sequence[str], reader: TrajectoryReader) -> Iterator[list[Sink]]:
    """Functions to call with the time and the columns of each block; a file is there whole when all ends well."""
    with ExitStack() as stack:
        writers: list[Sink] = []
        if out is not None:
            writer = stack.enter_context(open_writer(out, names))
            writers.append(stack.enter_context(behind(writer.write)))
        yield [*writers, stack.enter_context(watched(reader))]
