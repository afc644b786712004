"""Sums of products over named axes, and lengths of columns."""

from __future__ import annotations

from typing import Any

import numpy as np

from robodyn.support.floats import Floats


def einsum(subscripts: str, *factors: Any, optimize: bool = False) -> Any:
    """Return `np.einsum`, and zeros where a factor is empty: the sum is over nothing then, or the result is empty, too.

    NumPy 2.4 leaves there what stood in memory, or does not, as the layout of the heap has it.
    """
    found = np.einsum(subscripts, *factors, optimize=optimize)
    if all(map(np.size, factors)):
        return found
    return np.zeros(np.shape(found), np.asarray(found).dtype)[()]


def unit_columns(A: Floats) -> tuple[Floats, Floats]:
    """Return A (k, p) with columns at unit length, and their lengths (p,); 1 of those that are zero."""
    lengths = np.sqrt(einsum("ij,ij->j", A, A))
    lengths = np.where(lengths > 0.0, lengths, 1.0)
    return A / lengths, lengths
