"""The interpolating quintic spline, solved for its derivatives at the samples, in an order of sums that never changes.

BLAS and LAPACK add in an order that depends on the processor, on their threads and on where arrays lie in memory. Here
every sum is spelled out, and what makes it quick is that many stretches of the table are solved side by side.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

FEWEST = 7
"""Samples of a spline; through fewer goes one polynomial."""
REACH = 48
"""Samples over which a quintic spline forgets: its influence falls by 0.4306 a sample, to 3e-18 here."""
_LENGTH = 160
"""Samples of a stretch that serve; REACH on either side are there for their sake."""
_BLOCK = 1 << 15
_ADJUGATE = np.array(((1.0, -1.0), (-1.0, 1.0)))[:, :, None]


def spline_rates(gaps: Floats | None, steps: Floats) -> tuple[Floats, Floats]:
    """Return the first and second derivatives (N, c) at N samples of the quintic spline through them, not-a-knot at
    both ends: de Boor (1978), ch. XIII.

    Args:
        gaps: (N - 1,) between the samples' stamps, or None where all are 1; N >= FEWEST.
        steps: (N - 1, c) of the values from each sample to the next.

    Accuracy: as SciPy's `make_interp_spline` or better, on stamps of any spacing. Cutting the table into stretches
    changes nothing above rounding.
    """
    count = len(steps) + 1
    size = min(count, _LENGTH + 2 * REACH)
    start = np.clip(np.arange(0, count, _LENGTH) - REACH, 0, count - size)
    found = np.empty((2, steps.shape[1], count))
    for some in np.array_split(np.arange(len(start)), -(-count // _BLOCK)):
        rows = np.arange(size - 1)[:, None] + start[some]
        factors = _unit_factors(size) if gaps is None else _factors(gaps[rows])
        stretches = np.empty((size - 1, steps.shape[1], len(some)))
        for k, column in enumerate(steps.T):
            stretches[:, k] = column[rows]
        solved = _solve(factors, stretches)
        for k, number in enumerate(some.tolist()):
            serve = slice(number * _LENGTH, min((number + 1) * _LENGTH, count))
            begin = int(start[number])
            found[:, :, serve] = solved[serve.start - begin : serve.stop - begin, :, :, k].transpose(1, 2, 0)
    return found[0].T, found[1].T


class _Factors(NamedTuple):
    """The equations of n samples in S stretches side by side, with all that does not depend on the values.

    Attributes:
        per: (n - 1, S) reciprocals of the gaps.
        tails: beyond the first and the last interior knot.
        down: (k - 1, 2, 2, S) what eliminates each knot from the next one's equations, of k = n - 6 interior knots.
        inverse: (k, 2, 2, S) of the blocks on the diagonal.
        up: (k - 1, 2, 2, S) what couples each knot with the next.
    """

    per: Floats
    tails: tuple[_Tail, _Tail]
    down: Floats
    inverse: Floats
    up: Floats


@lru_cache(maxsize=8)
def _unit_factors(size: int) -> _Factors:
    return _factors(np.ones((size - 1, 1)))


def _factors(gaps: Floats) -> _Factors:
    """Factors of the equations for slope m and curvature M at the interior knots.

    With m and M at both ends each piece is Hermite's quintic. At a knot between gaps a and b the fourth derivatives of
    both sides must agree, then the third:

        [64/a^3 + 64/b^3, 12/b^2 - 12/a^2; 12/b^2 - 12/a^2, 3/a + 3/b] [m, M] + U [m, M]_next + U_before^T [m, M]_before
            = [120 (d_a/a^4 + d_b/b^4), 20 (d_b/b^3 - d_a/a^3)],   U = [56/b^3, -8/b^2; 8/b^2, -1/b]

    which is positive definite, since the spline is the curve of least third derivative: no pivots are needed.
    """
    per = 1.0 / gaps
    tails = _Tail.of(-gaps[2::-1]), _Tail.of(gaps[-3:])
    inner = per[3:-3]
    square, cube = inner * inner, inner * inner * inner
    D = np.zeros((len(gaps) - 5, 2, 2, gaps.shape[1]))
    for row, column, after, before in (
        (0, 0, 64.0 * cube, 64.0 * cube),
        (0, 1, 12.0 * square, -12.0 * square),
        (1, 0, 12.0 * square, -12.0 * square),
        (1, 1, 3.0 * inner, 3.0 * inner),
    ):
        D[:-1, row, column] = after
        D[1:, row, column] += before
    D[0] -= tails[0].matrix
    D[-1] += tails[1].matrix
    U = _matrix(56.0 * cube, -8.0 * square, 8.0 * square, -inner)
    down, inverse = np.empty_like(U), np.empty_like(D)
    for i in range(len(D)):
        if i:
            down[i - 1] = _times(U[i - 1].swapaxes(0, 1), inverse[i - 1])
            D[i] -= _times(down[i - 1], U[i - 1])
        inverse[i] = D[i, ::-1, ::-1].swapaxes(0, 1) * (_ADJUGATE / (D[i, 0, 0] * D[i, 1, 1] - D[i, 0, 1] * D[i, 1, 0]))
    return _Factors(per, tails, down, inverse, U)


def _solve(factors: _Factors, steps: Floats) -> Floats:
    """First and second derivatives (n, 2, c, S) from steps (n - 1, c, S)."""
    per, (near, far), down, inverse, up = factors
    ends = near.about(-steps[2::-1]), far.about(steps[-3:])
    inner = per[3:-3, None]
    solved = np.zeros((len(steps) + 1, 2, *steps.shape[1:]))
    knots = solved[3:-3]
    right = 20.0 * steps[3:-3]
    for _ in range(3):
        right *= inner
    knots[:-1, 1] = right
    knots[1:, 1] -= right
    right *= 6.0 * inner
    knots[:-1, 0] = right
    knots[1:, 0] += right
    knots[0] -= near.right(ends[0])
    knots[-1] += far.right(ends[1])
    for i in range(1, len(knots)):
        knots[i] -= _times(down[i - 1], knots[i - 1])
    knots[-1] = _times(inverse[-1], knots[-1])
    for i in range(len(knots) - 2, -1, -1):
        knots[i] = _times(inverse[i], knots[i] - _times(up[i], knots[i + 1]))
    solved[2::-1] = near.rates(ends[0], knots[0])
    solved[-3:] = far.rates(ends[1], knots[-1])
    return solved


class _Tail(NamedTuple):
    """The last three samples at an end, which are one polynomial with the piece within: no knot is between them.

    Attributes:
        s: (3, S) their times from the outermost interior knot, nearest first; negative before it.
        matrix: (2, 2, S) what they add to that knot's equations, for time that runs outwards.
    """

    s: Floats
    matrix: Floats

    @classmethod
    def of(cls, gaps: Floats) -> _Tail:
        s = _sums(gaps)
        a, b, c = 1.0 / s
        first, second, third = a + b + c, a * b + b * c + c * a, a * b * c
        matrix = _matrix(8.0 * (first * second - third), 4.0 * second, 2.0 * (first * first - second), first)
        return cls(s, matrix)

    def about(self, steps: Floats) -> Floats:
        """Values (3, c, S) from the knot's, by steps that lead outwards."""
        return _sums(steps)

    def right(self, values: Floats) -> Floats:
        """What the values add to the right-hand sides."""
        s = self.s[:, None]
        level, slope, curve = self._through(values / (s * s * s))
        return np.stack((8.0 * (curve * (s[0] + s[1]) - slope), 2.0 * (level - s[0] * (slope - s[1] * curve))))

    def rates(self, values: Floats, knot: Floats) -> Floats:
        """Derivatives (3, 2, c, S) at the samples, from those (2, c, S) at the knot.

        The polynomial is `m s + M s^2/2 + s^3 r(s)` with a parabola r through three values.
        """
        s, (m, M) = self.s[:, None], knot
        r = (values - s * (m + M * (0.5 * s))) / (s * s * s)
        _, slope, curve = self._through(r)
        slope = slope + curve * (2.0 * s - s[0] - s[1])
        first = m + s * (M + s * (3.0 * r + s * slope))
        return np.stack((first, M + s * (6.0 * r + s * (6.0 * slope + s * (2.0 * curve)))), axis=1)

    def _through(self, r: Floats) -> tuple[Floats, Floats, Floats]:
        """Newton's coefficients of the parabola through three values."""
        s = self.s
        slope = (r[1] - r[0]) / (s[1] - s[0])
        return r[0], slope, ((r[2] - r[1]) / (s[2] - s[1]) - slope) / (s[2] - s[0])


def _sums(three: Floats) -> Floats:
    a, b, c = three
    return np.stack((a, a + b, a + b + c))


def _matrix(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """[a, b; c, d] with the rows and columns before the last axis."""
    return np.stack((np.stack((a, b), axis=-2), np.stack((c, d), axis=-2)), axis=-3)


def _times(A: Floats, x: Floats) -> Floats:
    """Products of 2 x 2 matrices (2, 2, S) and (2, c, S)."""
    product: Floats = einsum("ijs,jks->iks", A, x)
    return product
