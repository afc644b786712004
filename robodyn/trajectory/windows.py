"""Least-squares polynomials on windows of doubling length about every sample, by sums that are merged two by two.

The sums of a window are those of its halves, moved to its middle: the fits of all windows of a length cost as much as
those of the shortest, and each depends on its own samples alone, to the last bit, wherever a block begins.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from robodyn.support.floats import Floats

DEGREE = 4
"""The highest degree that is fitted."""
BASES = (4, 5, 6, 7)
WIDEST = 1792
"""Samples of the longest window."""

Place = float | Floats


def lengths(widest: int) -> list[int]:
    """Return the lengths of windows up to `widest`: 4, 5, 6 and 7 times powers of two."""
    doublings = range(max(widest, 1).bit_length())
    return [base << j for j in doublings for base in BASES if base << j <= widest]


@dataclass(frozen=True)
class Fits:
    """The polynomials fitted to all windows of a length.

    Attributes:
        length: samples of a window.
        half: of its duration [s]; `middle`: where the sample `length // 2` lies in it, from -1 to 1.
        factor: rows of the Cholesky factor of the sums of powers; `right`: (degree + 1, windows) what its inverse makes
            of the sums of powers times values.
    """

    length: int
    half: Place
    middle: Place
    factor: tuple[tuple[Place, ...], ...]
    right: tuple[Floats, ...]

    def derivative(self, order: int, at: Place) -> Iterator[tuple[int, Floats, Place]]:
        """Yield the degree, the derivative (windows,) of the polynomial at a place from -1 to 1, and its gain.

        The gain is the standard deviation of the derivative per standard deviation of white noise. Polynomials of all
        degrees are partial sums, since the factor's rows do not depend on those below.
        """
        scale = 1.0 / self.half**order
        found, square = 0.0 * self.right[0], 0.0 * scale
        parts: list[Place] = []
        for k, (row, right) in enumerate(zip(self.factor, self.right, strict=True)):
            part: Place = math.perm(k, order) * at ** (k - order) if k >= order else 0.0
            for value, weight in zip(parts, row, strict=False):
                part = part - weight * value
            part = part / row[k]
            parts.append(part)
            if k >= order:
                found, square = found + part * right, square + part * part
                yield k, found * scale, np.sqrt(square) * scale


@dataclass(frozen=True)
class _Sums:
    """Sums over windows: of powers of the place (9), and of powers times values from the first (5)."""

    length: int
    centre: Place
    half: Place
    powers: tuple[Place, ...]
    moments: tuple[Floats, ...]


def fits(time: Floats | None, values: Floats, turns: Floats | None, widest: int) -> Iterator[Fits]:
    """Yield the fits of all windows of a length, from the shortest on; window i begins at sample i.

    Args:
        time: (N,) s, or None for samples a unit apart; values: (N,); turns: (N,) whole turns of 2 pi that they are
            ahead by, None for none.

    Accuracy: a second derivative is that of rational arithmetic to 1e-9 of the largest.
    """

    def rise(far: int, count: int) -> Floats:
        """Return how much each value is exceeded by the one `far` samples later."""
        found = values[far : far + count] - values[:count]
        return found if turns is None else found - 2.0 * math.pi * (turns[far : far + count] - turns[:count])

    known: dict[int, _Sums] = {}
    for length in lengths(min(widest, len(values))):
        count = len(values) + 1 - length
        if length in BASES:
            sums = _direct(time, [rise(j, count) for j in range(length)])
        else:
            sums = _merged(time, rise(length // 2, count), known.pop(length // 2))
        known[length] = sums
        yield _fitted(time, sums)


def _direct(time: Floats | None, values: list[Floats]) -> _Sums:
    """Return the sums of windows, of whose first, second ... samples the values are given."""
    length, count = len(values), len(values[0])
    centre, half = _place(time, length, count)
    powers: list[Place] = [0.0] * (2 * DEGREE + 1)
    moments = [np.zeros(count) for _ in range(DEGREE + 1)]
    for j, value in enumerate(values):
        at: Place = ((float(j) if time is None else time[j : j + count]) - centre) / half
        power: Place = 1.0
        for k in range(2 * DEGREE + 1):
            powers[k] = powers[k] + power
            if k <= DEGREE:
                moments[k] = moments[k] + power * value
            power = power * at
    return _Sums(length, centre, half, tuple(powers), tuple(moments))


def _merged(time: Floats | None, rise: Floats, part: _Sums) -> _Sums:
    """Return the sums of windows twice as long, whose second halves begin with values higher by `rise`."""
    n, count = part.length, len(rise)
    centre, half = _place(time, 2 * n, count)
    powers: list[Place] = [0.0] * (2 * DEGREE + 1)
    moments = [np.zeros(count) for _ in range(DEGREE + 1)]
    for begin in (0, n):
        own = slice(begin, begin + count)
        sums = [_cut(each, own) for each in part.powers]
        of_values = [each[own] + (rise * sums[k] if begin else 0.0) for k, each in enumerate(part.moments)]
        start = 0.0 if time is not None else float(begin)
        stretch = _cut(part.half, own) / half
        shift = (_cut(part.centre, own) + start - centre) / half
        stretches, shifts = _powers(stretch), _powers(shift)
        for k in range(2 * DEGREE + 1):
            for m in range(k + 1):
                weight = math.comb(k, m) * stretches[m] * shifts[k - m]
                powers[k] = powers[k] + weight * sums[m]
                if k <= DEGREE:
                    moments[k] = moments[k] + weight * of_values[m]
    return _Sums(2 * n, centre, half, tuple(powers), tuple(moments))


def _powers(x: Place) -> list[Place]:
    found: list[Place] = [1.0]
    for _ in range(2 * DEGREE):
        found.append(found[-1] * x)
    return found


def _place(time: Floats | None, length: int, count: int) -> tuple[Place, Place]:
    """Return the middle and the half of the duration of windows."""
    if time is None:
        return 0.5 * (length - 1), 0.5 * (length - 1)
    first, last = time[:count], time[length - 1 : length - 1 + count]
    return 0.5 * (first + last), 0.5 * (last - first)


def _cut(values: Place, own: slice) -> Place:
    return values[own] if isinstance(values, np.ndarray) else values


def _fitted(time: Floats | None, sums: _Sums) -> Fits:
    n = sums.length
    rows: list[tuple[Place, ...]] = []
    right: list[Floats] = []
    for i in range(min(DEGREE, n - 2) + 1):
        row: list[Place] = []
        for j in range(i + 1):
            entry = sums.powers[i + j]
            for k in range(j):
                entry = entry - row[k] * (rows[j][k] if j < i else row[k])
            row.append(np.sqrt(entry) if j == i else entry / rows[j][j])
        moment = sums.moments[i]
        for k in range(i):
            moment = moment - row[k] * right[k]
        rows.append(tuple(row))
        right.append(moment / row[i])
    count = len(sums.moments[0])
    sample: Place = float(n // 2) if time is None else time[n // 2 : n // 2 + count]
    return Fits(n, sums.half, (sample - sums.centre) / sums.half, tuple(rows), tuple(right))
