"""NumPy archives: one 1-D array per column, or matrices `q`, `qd`, `qdd` in coordinate order beside `time`."""

from __future__ import annotations

import os
import zipfile
import zlib

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.trajectory.array_table import ArrayTable
from robodyn.trajectory.columns import matrix_column
from robodyn.trajectory.table import FloatArray

_MATRICES = ("q", "qd", "qdd")
_DAMAGE = (
    ValueError,
    KeyError,
    TypeError,
    EOFError,
    MemoryError,
    OverflowError,
    SyntaxError,
    RuntimeError,
    OSError,
    zipfile.BadZipFile,
    zlib.error,
)
"""All that `zipfile` and `numpy.load` raise on damaged archives."""


def read_npz(path: str) -> ArrayTable:
    """The table in an `.npz` archive; its arrays are held in memory. Pickled objects are never loaded.

    Raises:
        TrajectoryError: the archive is damaged, or an array is not a column (or matrix q, qd, qdd) of numbers.
        OSError: the file cannot be opened.
    """
    columns: dict[str, FloatArray] = {}
    with open(path, "rb") as stream:
        try:
            with np.load(stream, allow_pickle=False) as arrays:
                for name in arrays.files if hasattr(arrays, "files") else _refuse_single():
                    columns |= _columns(name, arrays[name], path)
        except TrajectoryError:
            raise
        except _DAMAGE as error:
            first = str(error).strip().partition("\n")[0] or type(error).__name__
            raise TrajectoryError(f"cannot be read as .npz: {first}", remedy="write it again", file=path) from None
    return ArrayTable(path, columns, os.stat(path).st_size)


def _refuse_single() -> list[str]:
    raise ValueError("a single array, not an archive")


def _columns(name: str, array: object, file: str) -> dict[str, FloatArray]:
    if not isinstance(array, np.ndarray) or array.dtype.kind not in "fiu":
        kind = array.dtype if isinstance(array, np.ndarray) else "bytes"
        raise TrajectoryError(f"array {name!r} holds {kind}, not numbers", remedy="store float64", file=file)
    if array.ndim == 2 and name in _MATRICES:
        return {matrix_column(name, i): np.asarray(array[:, i], np.float64) for i in range(array.shape[1])}
    if array.ndim != 1:
        remedy = "give one 1-D array per column, or time (N,) and matrices q, qd, qdd (N, n)"
        raise TrajectoryError(f"array {name!r} has shape {array.shape}", remedy=remedy, file=file)
    return {name: np.asarray(array, np.float64)}
