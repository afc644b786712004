"""The LLVM function that feeds a kernel: block after block of samples, from and to arrays of any layout."""

from __future__ import annotations

from collections.abc import Sequence

from robodyn.programs.run.llvm.code import BYTES, SUFFIXES
from robodyn.programs.run.llvm.copies_text import COPIES, VALID
from robodyn.programs.run.llvm.driver_text import BLOCK, HOME, TEXT

FIELDS = ("address", "homes", "sample_stride", "column_stride", "columns", "direct", "stream")
"""What the driver is told of an array, in 64 bits each.

`homes`: of each column the place among the kernel's; strides in bytes; `direct`: 1 where the kernel may work on
contiguous columns themselves; `stream`: 1 where results are copied to contiguous columns past the caches.
"""

POINTERS = ("kernel", "arrays", "rooms", "flags", "common", "address", "homes")
NUMBERS = ("count", "room_bytes", "table_bytes", "pitch", "step", "size", "samples", "each", "parts")
JOB = ("kernel", "arrays", "rooms", "flags", "common", *NUMBERS)
"""What a job is, in 64 bits each, in this order."""

AHEAD = 512
"""Bytes from the numbers in use to those called for, where columns are read as they lie."""


def driver(scalar: str, lanes: int) -> str:
    """Return the LLVM IR of `i64 share(job, me)`: thread `me`'s part of a job.

    Runs a kernel of `robodyn.programs.run.llvm.kernel`, at the address `kernel`, over samples in blocks of `size`, a
    multiple of 16. The `samples` are in `parts` of `each`. A thread takes the next `step` samples of its own part, a
    multiple of `size`, until none is left, then of the others': none depends on another that began late. `common` is a
    number that is not 0 in the end if any sample is flagged, and after it the next sample of each part.
    Of the `count` arrays (`FIELDS`), the last is the result. Columns are handed to the kernel where they lie if they
    are contiguous and the block is a whole number of groups; else they are gathered into rows of the thread's own room,
    `pitch` bytes apart after a table of `table_bytes`, and results are scattered from there. What the kernel calls for
    is `AHEAD` in the same column, or for arrays that are gathered a part of the next block. A result that several
    columns share is computed once, and copied.

    Args:
        scalar: "double" or "float".
        lanes: samples in a group.
    """
    names = {
        "scalar": scalar,
        "suffix": SUFFIXES[scalar],
        "bytes": BYTES[scalar],
        "ahead": AHEAD,
        "lanes": lanes,
        "lanes_less_one": lanes - 1,
        "array_bytes": 8 * len(FIELDS),
        "vector": f"<{lanes} x {scalar}>",
        "integers": f"<{lanes} x i64>",
        "pointers": f"<{lanes} x ptr>",
        "mask": f"<{lanes} x i1>",
        "numbers": f"<{', '.join(f'i64 {k}' for k in range(lanes))}>",
    }
    array, job = _loaded("array", FIELDS), _loaded("job", JOB)
    return (COPIES + TEXT).format(**names, array=array, job=job, block=BLOCK, home=HOME, valid=VALID.format(**names))


def _loaded(struct: str, fields: Sequence[str]) -> str:
    """Loads what a struct of 64-bit fields holds."""
    lines = []
    for k, name in enumerate(fields):
        lines.append(f"  %{name}_at = getelementptr i64, ptr %{struct}, i64 {k}")
        lines.append(f"  %{name} = load {'ptr' if name in POINTERS else 'i64'}, ptr %{name}_at")
    return "\n".join(lines)
