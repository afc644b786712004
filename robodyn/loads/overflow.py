"""Loads beyond what floating point holds."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robodyn.errors import InputError

REMEDY = "are masses, lengths, times and the motion in SI units?"


def check_loads(loads: NDArray[np.float64], names: Sequence[str], first_row: int, file: str | None) -> None:
    """Raise if a load of some sample is not finite.

    Args:
        loads: (N, k), column by column of `names`; sample 0 is the data row `first_row`.

    Raises:
        InputError: naming the first row and its load.
    """
    if not np.isfinite(loads).all():
        row, column = np.argwhere(~np.isfinite(loads))[0]
        raise InputError(f"row {first_row + row}: {names[column]} overflows", remedy=REMEDY, file=file)


def check_figures(figures: Iterable[ArrayLike], peaks: ArrayLike, file: str | None) -> None:
    """Raise if a power, a square or an integral over the motion is not finite though the loads were."""
    if not all(np.isfinite(values).all() for values in figures):
        largest = float(np.abs(peaks).max(initial=0.0))
        what = f"the loads are finite, their squares or powers overflow; the largest is {largest:.3g}"
        raise InputError(what, remedy=REMEDY, file=file)
