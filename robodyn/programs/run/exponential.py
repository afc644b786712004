"""The exponential of arrays, step by step as machine code computes it, but for fused multiply-add.

NumPy's own depends on the processor: with AVX-512 it ends in other digits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.run.llvm.functions import EXPONENTIAL, LOG2_E, LOG_2

Numbers = NDArray[np.floating[Any]]


def exponential(x: Numbers, out: Numbers | None = None) -> Numbers:
    """Return exp(x) of float64 or float32, written to `out` if given.

    Accuracy: 1 ulp; 0 and infinity where the result leaves the range of the type.
    """
    y = np.clip(np.asarray(x, dtype=np.float64), -746.0, 710.0)
    power = np.rint(y * LOG2_E)
    rest = (y - power * LOG_2[0]) - power * LOG_2[1]  # the first product is exact
    bend = np.full_like(rest, EXPONENTIAL[-1])
    for coefficient in reversed(EXPONENTIAL[:-1]):
        bend = bend * rest + coefficient
    main = 1.0 + rest
    value = main + (rest * rest * bend + ((1.0 - main) + rest))
    found = np.ldexp(value, np.nan_to_num(power).astype(np.int64)).astype(x.dtype)
    if out is None:
        return found
    out[...] = found
    return out
