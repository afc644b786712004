"""Numbers -> lines of CSV: shortest text that reads back the same, the same from both writers."""

from __future__ import annotations

from collections.abc import Iterator
from io import BytesIO

import numpy as np

from robodyn.trajectory.table import FloatArray

LARGE = 150_000
"""Cells above which importing polars (0.1 s) costs less than writing without it."""

PARTS = 4
"""Parts of a block that are written at once."""


def lines_plain(values: FloatArray) -> bytes:
    """Rows of values (N, k) as lines of CSV, without polars."""
    return "".join(",".join(map(shortest, row)) + "\n" for row in values.tolist()).encode()


def lines_fast(values: FloatArray) -> Iterator[bytes]:
    """Rows of values (N, k) as lines of CSV, through polars: it works on so few rows in one thread only."""
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(PARTS) as pool:
        yield from pool.map(_lines, np.array_split(values, PARTS))


def _lines(values: FloatArray) -> bytes:
    import polars as pl

    text = BytesIO()
    frame = pl.DataFrame({str(i): values[:, i] for i in range(values.shape[1])})
    frame.write_csv(text, include_header=False)
    return text.getvalue()


def shortest(value: float) -> str:
    """The shortest decimal that reads back as `value`, in the notation of polars: 0.00001, 1.5e-7, 1e+16, NaN."""
    text = repr(value)
    mantissa, mark, exponent = text.partition("e")
    if not mark:
        return "NaN" if text == "nan" else text
    power = int(exponent)
    if power == -5:
        sign = "-" if value < 0 else ""
        return f"{sign}0.0000{mantissa.lstrip('-').replace('.', '')}"
    return f"{mantissa}e{power:+d}"
