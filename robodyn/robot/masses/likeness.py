"""How far right declarations are from the uniform solids that their shapes are, as probabilities.

Compared are the density, the distance of the centres, and the size and form of the second moments. Each is as far off
as the sum of a few normal distributions says, which was measured on 321 different links of 24 published robots
(example-robot-data, icub-models); the other half of the robots is left to judge by.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from math import hypot, log, pi

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.vectors import IDENTITY, product
from robodyn.support.floats import Floats

Truths = NDArray[np.bool_]
Mixture = tuple[tuple[float, ...], ...]

FORM = ((0.01, 0.02, 3e-4), (0.02, 0.02, 0.01), (0.37, 0.15, 0.12), (0.45, 0.6, 0.45), (0.15, 1.3, 1.5))
"""Shares, and deviations of the logarithm of the size and of each of five numbers of the form."""
PLACE = ((0.05, 0.003), (0.50, 0.12), (0.40, 0.45), (0.05, 1.5))
"""Shares, and deviations of each coordinate of the centre, over the radius of gyration."""
DENSITY = ((0.93, 0.8), (0.07, 1.6))
"""Shares, and deviations of the logarithm. The last of each is of links that their shapes do not show."""
_USUAL = 1780.0
"""Median of mass over the volume of the shapes [kg/m^3]."""
_THIN = 0.03
"""Second moments of a shape below this part of their sum count as that much: what is thin is as thick as a casing."""
_NEGATIVE = 2e-3
"""A second moment below zero by this part of their sum is none of a body."""


@dataclass(frozen=True, eq=False)
class Uniform:
    """What shapes are if they are of one density.

    Attributes:
        volume: m^3. c: (3,) its centre [m]. S: (3, 3) second moments about it, by the mass [m^2].
    """

    volume: float
    c: Floats
    S: Floats

    @cached_property
    def spread(self) -> float:
        """tr(S), the radius of gyration squared [m^2]."""
        return float(np.trace(self.S))

    def along(self, R: Floats) -> Uniform:
        """Return it in the axes R (3, 3) of its frame."""
        return Uniform(self.volume, product(R.T, self.c), product(R.T, self.S, R))

    def inertia(self, mass: float) -> Floats:
        """(3, 3) about its centre, of a mass [kg m^2]."""
        I: Floats = mass * (self.spread * IDENTITY - self.S)
        return I


@dataclass(frozen=True, eq=False)
class Likeness:
    """How like a solid the tensors of several hypotheses are.

    Attributes:
        size: (k,) logarithm of the radius of gyration squared over the solid's.
        form: (k,) square of the distance of the second moments, each by their sum, in the solid's own measure.
        possible: (k,) whether a body can have the tensor.
    """

    size: Floats
    form: Floats
    possible: Truths


def likeness(I: Floats, mass: float, shapes: Uniform) -> Likeness:
    """Return how like the solid tensors (k, 3, 3) are, of one mass."""
    sums = np.trace(I, axis1=1, axis2=2) / 2.0
    form = shapes.S / shapes.spread
    with np.errstate(all="ignore"):
        second = IDENTITY - I / sums[:, None, None]
        size = np.log(sums / mass / shapes.spread)
        measured = _times(_inverse(form + _THIN * IDENTITY), second - form)
        form = np.maximum((measured * np.swapaxes(measured, 1, 2)).sum(axis=(1, 2)), 0.0)
        possible = (sums > 0.0) & np.isfinite(size) & _positive(second + _NEGATIVE * IDENTITY)
    return Likeness(np.where(possible, size, 0.0), np.where(possible, form, 0.0), possible)


def _inverse(S: Floats) -> Floats:
    """Return the inverse of a symmetric positive definite matrix (3, 3), by its cofactors."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = S.tolist()
    a, b, c = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    d, e, f = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    found: Floats = np.array(((a, b, c), (b, d, e), (c, e, f))) / (xx * a + xy * b + xz * c)
    return found


def _times(P: Floats, X: Floats) -> Floats:
    """Return P X for (k, 3, 3) matrices X, in the same order of operations everywhere."""
    found: Floats = (P[None, :, :, None] * X[:, None, :, :]).sum(axis=2)
    return found


def _positive(S: Floats) -> Truths:
    """Return whether (k, 3, 3) symmetric matrices are positive definite, by Sylvester's criterion."""
    xx, xy, xz, yy, yz, zz = (S[:, i, j] for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)))
    minor = xx * yy - xy * xy
    whole: Truths = (xx > 0.0) & (minor > 0.0) & (zz * minor - xx * yz * yz - yy * xz * xz + 2.0 * xy * xz * yz > 0.0)
    return whole


def formed(size: Floats, form: Floats, mixture: Mixture = FORM) -> Floats:
    """Return the logarithms of the probabilities of sizes and forms."""
    return _mixed(mixture, (1, 5), (size**2, form))


def free_size(form: Floats, mixture: Mixture) -> Floats:
    """Return the logarithms of the probabilities of forms whose sizes are by any factor off: their integral over it."""
    return log_sum([log(share) + _normal(form, f, 5) for share, _, f in mixture])


def free_mass(mass: float, size: Floats, form: Floats, shapes: Uniform) -> Floats:
    """Return the logarithms of the probabilities of a mass that is by any factor off: their integral over it."""
    sums = (size + log(mass / shapes.volume / _USUAL)) ** 2
    usual = DENSITY[0][1]
    return log_sum([log(share) + _normal(sums, hypot(s, usual), 1) + _normal(form, f, 5) for share, s, f in FORM[:-1]])


def spread(squares: Floats, mixture: Mixture, count: int) -> Floats:
    """Return the logarithms of the probabilities of vectors of so many numbers, by the squares of their lengths."""
    return _mixed(mixture, (count,), (squares,))


def _mixed(mixture: Mixture, counts: tuple[int, ...], squares: tuple[Floats, ...]) -> Floats:
    """Return the logarithms of sums of normal distributions, by squares (k,) of vectors of so many numbers each."""
    constants, halves = _terms(mixture, counts)
    logarithms = constants
    for half, square in zip(halves, squares, strict=True):
        logarithms = logarithms - half * square
    return log_sum(logarithms)


@cache
def _terms(mixture: Mixture, counts: tuple[int, ...]) -> tuple[Floats, list[Floats]]:
    """Return the logarithms of the shares over the normal distributions' integrals, and 1 / (2 deviation^2); as
    columns."""
    shares, *deviations = np.array(mixture).T[:, :, None]
    roots = (2.0 * pi) ** 0.5
    widths = sum((n * np.log(one * roots) for n, one in zip(counts, deviations, strict=True)), np.zeros((1, 1)))
    return np.log(shares) - widths, [0.5 / one**2 for one in deviations]


def placed(centre: Floats, shapes: Uniform, mixture: Mixture = PLACE) -> Floats:
    """Return the logarithms of the probabilities of centres (k, 3) [m]."""
    return spread(distance(centre, shapes), mixture, 3)


def distance(centre: Floats, shapes: Uniform) -> Floats:
    """Return the squares of the distances (k,) of centres, over the radius of gyration squared."""
    squares: Floats = ((centre - shapes.c) ** 2).sum(axis=-1) / shapes.spread
    return squares


def dense(mass: Floats, shapes: Uniform, mixture: Mixture = DENSITY) -> Floats:
    """Return the logarithms of the probabilities of masses (k,) [kg]."""
    return spread(np.log(mass / shapes.volume / _USUAL) ** 2, mixture, 1)


def anywhere(squares: float) -> float:
    """Return the logarithm of the probability of a centre that has nothing to do with the solid: Cauchy's, in space."""
    return -2.0 * log(1.0 + squares / 4.0) - log(8.0 * pi**2)


def anything(found: Likeness) -> float:
    """Return the logarithm of the probability of a tensor that has nothing to do with the solid, or is none at all."""
    if not found.possible[0]:
        return _IMPOSSIBLE
    return float(_normal(found.size[:1] ** 2, 3.0, 1)[0] + _normal(np.minimum(found.form[:1], _FARTHEST), 1.5, 5)[0])


_IMPOSSIBLE, _FARTHEST, _LEAST_LOG = -15.0, 40.0, -1e300


def _normal(squares: Floats, deviation: float, count: int) -> Floats:
    found: Floats = -0.5 * squares / deviation**2 - count * log(deviation * (2.0 * pi) ** 0.5)
    return found


def log_sum(logarithms: Sequence[Floats] | Floats) -> Floats:
    """Return the logarithm of the sum of exponentials along the first axis."""
    given = np.asarray(logarithms)
    most = np.maximum(given.max(axis=0), _LEAST_LOG)
    found: Floats = most + np.log(np.exp(given - most).sum(axis=0))
    return found
