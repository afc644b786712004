"""Which mistake explains a declared inertial, weighed by the link's own shapes.

Every hypothesis, "it is right", "its mass is in g", "its tensor is about the link's origin", says what was meant, which
is as probable as right declarations are that are as far from the solid of the shapes. Bayes' rule makes probabilities
of it. Beside the mistakes stand hypotheses that explain nothing: a factor that belongs to no unit, any of 1e-6 to 1e9
alike, and numbers that have nothing to do with the link. So a factor of 16.7 is not called 25.4: where the shapes tell
them apart it is not near enough, and where they do not, any factor near it is as good.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from math import hypot, inf, log, pi

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.vectors import IDENTITY, length, product
from robodyn.robot.masses.inertia_mistakes import (
    FACTORS,
    UNITS,
    WEIGHTS,
    Given,
    Mistake,
    Units,
    corrections,
    made_up,
    tensors,
)
from robodyn.support.floats import Floats, ranked

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
class InertiaDistance:
    """How like a solid the tensors of several hypotheses are.

    Attributes:
        size: (k,) logarithm of the radius of gyration squared over the solid's.
        form: (k,) square of the distance of the second moments, each by their sum, in the solid's own measure.
        possible: (k,) whether a body can have the tensor.
    """

    size: Floats
    form: Floats
    possible: Truths


def inertia_distance(I: Floats, mass: float, shapes: Uniform) -> InertiaDistance:
    """Return how like the solid tensors (k, 3, 3) are, of one mass."""
    sums = np.trace(I, axis1=1, axis2=2) / 2.0
    form = shapes.S / shapes.spread
    with np.errstate(all="ignore"):
        second = IDENTITY - I / sums[:, None, None]
        size = np.log(sums / mass / shapes.spread)
        measured = np.linalg.inv(form + _THIN * IDENTITY) @ (second - form)
        form = np.maximum((measured * np.swapaxes(measured, 1, 2)).sum(axis=(1, 2)), 0.0)
        possible = (sums > 0.0) & np.isfinite(size) & np.isfinite(second).all(axis=(1, 2))
        possible[possible] = np.linalg.eigvalsh(second[possible])[:, 0] > -_NEGATIVE
    return InertiaDistance(np.where(possible, size, 0.0), np.where(possible, form, 0.0), possible)


def formed(size: Floats, form: Floats, mixture: Mixture = FORM) -> Floats:
    """Return the logarithms of the probabilities of sizes and forms."""
    return _mixed(mixture, (1, 5), (size**2, form))


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


def anything(found: InertiaDistance) -> float:
    """Return the logarithm of the probability of a tensor that has nothing to do with the solid, or is none at all."""
    if not found.possible[0]:
        return _IMPOSSIBLE
    return float(_normal(found.size[:1] ** 2, 3.0, 1)[0] + _normal(np.minimum(found.form[:1], _MOST_FORM), 1.5, 5)[0])


_IMPOSSIBLE, _MOST_FORM, _LEAST_LOG = -15.0, 40.0, -1e300


def _normal(squares: Floats, deviation: float, count: int) -> Floats:
    found: Floats = -0.5 * squares / deviation**2 - count * log(deviation * (2.0 * pi) ** 0.5)
    return found


def log_sum(logarithms: Sequence[Floats] | Floats) -> Floats:
    """Return the logarithm of the sum of exponentials along the first axis."""
    given = np.asarray(logarithms)
    most = np.maximum(given.max(axis=0), _LEAST_LOG)
    found: Floats = most + np.log(np.exp(given - most).sum(axis=0))
    return found


NAMED = 0.9
"""Probability from which a cause is named."""
LISTED = 0.03
"""Probability from which it is one of those that it may be."""
DOUBTED = 0.1
"""Probability of being right below which it is said what it may be."""
_AGREES = 0.2
"""How far a corrected tensor may be from that of the shapes, and not more than half as far as the declared one."""
_SLIP, _FACTOR, _UNLIKE = 0.0015, 0.001, 0.0025
"""How often a mistake of weight 1, a factor of no unit, and numbers of another body are met, beside right ones."""
_FACTORS = np.concatenate((np.ones((1, 3)), FACTORS))
"""Of mass, centre of mass and inertia: what is right, and the units."""
_LOGS = np.log(_FACTORS)
_PRIORS = np.log(np.concatenate(((1.0,), _SLIP * WEIGHTS)))
_RANGE = 35.0
"""Of logarithms of a factor that belongs to no unit."""
_STEP = 0.1
_FAR = np.exp(np.arange(_STEP, 14.0, _STEP))
"""Factors of a centre of mass that is too far from the origin; one that is too near is never seen."""
_SO_FAR = np.log(_RANGE / _FAR.size) - 3.0 * np.log(_FAR)
_OF_UNITS = slice(1, 1 + len(UNITS))


@dataclass(frozen=True, eq=False)
class Cause:
    """A mistake, and what was meant if that is the one.

    Attributes:
        code: of the rule that documents it.
        what: what went wrong, in words.
        probability: of this one.
        mass, c, I: what was meant, in the axes of the inertial; [kg], (3,) [m], (3, 3) about c [kg m^2].
        apart: |I - I_shapes| / |I_shapes| of what was meant, in Frobenius' norm.
        units: what is in which units; None of other mistakes.
    """

    code: str
    what: str
    probability: float
    mass: float
    c: Floats
    I: Floats
    apart: float
    units: Units | None = None

    @property
    def kind(self) -> str:
        """What two causes share that are one: the rule, and of units the factors."""
        return self.code if self.units is None else f"{self.code} {self.units.factors}"


@dataclass(frozen=True, eq=False)
class Posterior:
    """The verdict of the shapes.

    Attributes:
        right: the probability that the declaration is right.
        causes: the mistakes that it may be, the most probable first.
        apart: |I - I_shapes| / |I_shapes| of the declaration.
    """

    right: float
    causes: tuple[Cause, ...]
    apart: float

    @property
    def named(self) -> tuple[Cause, ...]:
        """The causes of one kind that explain it alone, with their corrections, the most probable first; or nothing."""
        sums: dict[str, float] = {}
        for one in self.causes:
            sums[one.kind] = sums.get(one.kind, 0.0) + one.probability
        found = [one for one in self.causes if sums[one.kind] >= NAMED]
        return tuple(found) if found and (found[0].units or found[0].apart <= min(_AGREES, self.apart / 2.0)) else ()

    @property
    def either(self) -> tuple[Cause, ...]:
        """Causes of which one explains it, where they do so together and none alone."""
        return () if self.named or sum(one.probability for one in self.causes) < NAMED else self.causes

    @property
    def units(self) -> bool:
        """Whether units explain it: one set of them, or one of several."""
        told = self.named or self.either
        return bool(told) and all(one.units for one in told)


def mistake_posterior(given: Given, shapes: Uniform) -> Posterior:
    """Return which mistake explains what a link says.

    Args:
        given: of positive mass, and finite.
        shapes: in the axes of the inertial.

    Accuracy: of what is named of 20 kinds of mistakes planted in healthy links of ten robots that the distributions
        were not measured on, at most 2 % have another name.
    """
    mistakes, entries = corrections(given)
    I = np.concatenate((given.tensor[None], tensors(entries)))
    like = inertia_distance(I, given.mass, shapes)
    density = float(dense(np.array([given.mass]), shapes)[0])
    place = float(placed(given.c[None], shapes)[0])
    units = _of_units(given, shapes, like, density + place)
    wrong = (
        np.array([log_prior(mistake) for mistake in mistakes])
        + density
        + place
        + formed(like.size[1:], like.form[1:], FORM[:-1])
    )
    wrong = np.where(like.possible[1:], wrong + _chance(I), -np.inf)
    rest = np.concatenate((_unlike(given, shapes, like, density, place), _no_unit(given, shapes, like, density, place)))
    whole = float(log_sum(np.concatenate((units, wrong, rest))))
    probable, slipped = np.exp(units - whole), np.exp(wrong - whole)
    found = []
    left = probable[_OF_UNITS]
    for k in np.flatnonzero(left >= LISTED).tolist():
        by_mass, by_centre, by_inertia = UNITS[k].factors
        mass, c, meant = given.mass / by_mass, given.c / by_centre, given.tensor / by_inertia
        apart_so = apart(meant, mass, shapes)
        found.append(Cause("RD305", UNITS[k].what, float(left[k]), mass, c, meant, apart_so, UNITS[k]))
    for k in np.flatnonzero(slipped >= LISTED).tolist():
        code, what, apart_so = mistakes[k].code, mistakes[k].what, apart(I[k + 1], given.mass, shapes)
        found.append(Cause(code, what, float(slipped[k]), given.mass, given.c, I[k + 1], apart_so))
    causes = ranked(found, lambda one: one.probability) if found else ()
    return Posterior(float(probable[0]), tuple(causes), apart(I[0], given.mass, shapes))


@cache
def log_prior(mistake: Mistake) -> float:
    """Return the logarithm of how often a mistake is met."""
    return log(_SLIP * mistake.weight) if mistake.common else -inf


def apart(I: Floats, mass: float, shapes: Uniform) -> float:
    """Return |I - I_shapes| / |I_shapes| at the same mass, in Frobenius' norm."""
    own = shapes.inertia(mass)
    return float(length(I - own)) / float(length(own))


def _of_units(given: Given, shapes: Uniform, like: InertiaDistance, beside: float) -> Floats:
    """Return the logarithms of how probable `_FACTORS` make what is given, and their priors.

    Args:
        beside: that of mass and centre of what is right.
    """
    if not like.possible[0]:
        return np.full(len(_LOGS), -np.inf)
    right = beside + formed(like.size[:1], like.form[:1])[0]
    if made_up(given):
        return np.array((right, *[-np.inf] * len(UNITS)))
    sizes = like.size[0] - _LOGS[:, 2] + _LOGS[:, 0]
    found: Floats = _PRIORS + formed(sizes, np.full(len(sizes), like.form[0]), FORM[:-1]) - 3.0 * _LOGS[:, 1]
    found += dense(given.mass / _FACTORS[:, 0], shapes, DENSITY[:-1])
    found += placed(given.c / _FACTORS[:, 1:2], shapes, PLACE[:-1])
    found[0] = right
    return found


def _chance(I: Floats) -> Floats:
    """Return the logarithms of how improbable it is that a tensor is much smaller than what was meant, where a term of
    the same size was subtracted: all six numbers have to agree."""
    sizes = np.sqrt((I**2).sum(axis=(1, 2)))
    found: Floats = 6.0 * np.minimum(np.log(sizes[0] / sizes[1:]), 0.0)
    return found


def _no_unit(given: Given, shapes: Uniform, like: InertiaDistance, density: float, place: float) -> Floats:
    """Return those of a factor of the tensor, of mass and tensor, of the mass, and of the centre, each of any size."""
    if not like.possible[0]:
        return np.full(1, -np.inf)
    size, form, prior = like.size[:1], like.form[:1], np.log(_FACTOR / _RANGE)
    beside, any_size = (
        formed(size, form)[0],
        log_sum([log(share) + _normal(form, f, 5) for share, _, f in FORM[:-1]])[0],
    )
    far = placed(given.c / _FAR[:, None], shapes, PLACE[1:-1]) + _SO_FAR
    by_mass = free_mass(given.mass, size, form, shapes)[0]
    found: Floats = prior + np.array(
        (density + place + any_size, place + beside, place + by_mass, density + beside + float(log_sum(far)))
    )
    return found


def _unlike(given: Given, shapes: Uniform, like: InertiaDistance, density: float, place: float) -> Floats:
    """Return those of a tensor, of a centre and of both that have nothing to do with the link."""
    formed_so = formed(like.size[:1], like.form[:1])[0] if like.possible[0] else -np.inf
    other, away = anything(like), anywhere(float(distance(given.c, shapes)))
    found: Floats = density + np.array(
        (np.log(_UNLIKE) + place + other, np.log(_UNLIKE) + away + formed_so, 2 * np.log(_UNLIKE) + away + other)
    )
    return found
