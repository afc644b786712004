"""A program on arrays of every layout, for tests of the compiled executor."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.lib.stride_tricks import as_strided

from robodyn.programs.program import trace
from robodyn.programs.run.compiled_blocks import CompiledBlocks
from robodyn.programs.vectors import cos, exp, sign, sin

WIDTHS = {"a": 3, "b": 2, "unread": 4}


def _outputs(tape):
    a, b = ([tape.input(source, i) for i in range(WIDTHS[source])] for source in "ab")
    s = sin(a[0]) * b[0] + cos(a[0]) * b[1]
    return [s, (a[2] * a[2] + 1.0).sqrt() / (b[1] * b[1] + 0.3), a[0], exp(-b[0] * b[0]) - a[2] * s, 2.5, sign(a[2])]


PROGRAM = trace(_outputs)


@cache
def ready(dtype=np.float64):
    return CompiledBlocks(PROGRAM, WIDTHS, dtype)


def state(samples, dtype=np.float64):
    """Contiguous columns; in some samples an angle is too large for the executor, infinite or nan."""
    rng = np.random.default_rng(samples)
    arrays = {name: np.asfortranarray(rng.uniform(-3, 3, (samples, width)), dtype) for name, width in WIDTHS.items()}
    arrays["a"][3::101, 0] = rng.choice([1e9, np.inf, np.nan], len(arrays["a"][3::101]))
    return arrays


def expected(arrays, dtype=np.float64):
    """What one thread makes of contiguous columns."""
    columns = {name: np.asfortranarray(values, dtype) for name, values in arrays.items()}
    return ready(dtype)(columns, len(columns["a"]))


def in_bytes(x, offset, step):
    """The numbers of x, `offset` bytes from where a number may lie, columns `step` bytes apart."""
    raw = np.zeros(offset + step * x.shape[1] + 64, np.uint8)
    first = -raw.ctypes.data % 64 + offset
    out = as_strided(raw[first : first + 8].view(x.dtype), x.shape, (x.itemsize, step))
    out[...] = x
    return out


LAYOUTS = {
    "rows": np.ascontiguousarray,
    "columns": np.asfortranarray,
    "every third row": lambda x: np.repeat(x, 3, axis=0)[::3],
    "backwards": lambda x: np.asfortranarray(x[::-1])[::-1],
    "both backwards": lambda x: np.ascontiguousarray(x[::-1, ::-1])[::-1, ::-1],
    "part of a table": lambda x: np.hstack((x, x, x))[:, x.shape[1] : 2 * x.shape[1]],
    "whole pages apart": lambda x: in_bytes(x, 0, -(-x.nbytes // 4096) * 4096),
    "unaligned": lambda x: in_bytes(x, 3, x.itemsize * len(x) + 40),
    "other bytes first": lambda x: x.astype(x.dtype.newbyteorder()),
    "fewer bits": lambda x: x.astype(np.float32),
}
