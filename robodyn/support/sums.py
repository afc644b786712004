"""Sums of products over named axes."""

from __future__ import annotations

from typing import Any

import numpy as np


def einsum(subscripts: str, *factors: Any, optimize: bool = False) -> Any:
    """Return `np.einsum`, and zeros where a factor is empty: the sum is over nothing then, or the result is empty, too.

    NumPy 2.4 leaves there what stood in memory, or does not, as the layout of the heap has it.
    """
    found = np.einsum(subscripts, *factors, optimize=optimize)
    if all(map(np.size, factors)):
        return found
    return np.zeros(np.shape(found), np.asarray(found).dtype)[()]
