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
from functools import cached_property
from math import hypot, inf, log, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.vectors import IDENTITY, length, product
from robodyn.robot.masses.inertia_mistakes import UNITS, Given, Units, corrections, made_up, tensors
from robodyn.support.floats import Floats, ranked

Mixture = Sequence[tuple[float, ...]]
"""Normal distributions: the share of each, and its deviation of every vector."""

FORM = ((0.01, 0.02, 3e-4), (0.02, 0.02, 0.01), (0.37, 0.15, 0.12), (0.45, 0.6, 0.45), (0.15, 1.3, 1.5))
"""Of the logarithm of the size, and of five numbers of the form."""
PLACE = ((0.05, 0.003), (0.50, 0.12), (0.40, 0.45), (0.05, 1.5))
"""Of the centre, over the radius of gyration."""
DENSITY = ((0.93, 0.8), (0.07, 1.6))
"""Of the logarithm. The last of each is of links that their shapes do not show."""
_USUAL = 1780.0
"""Median of mass over the volume of the shapes [kg/m^3]."""
_THIN = 0.03
"""Second moments of a shape below this part of their sum count as that much: what is thin is as thick as a casing."""
_NEGATIVE = 2e-3
"""A second moment below zero by this part of their sum is none of a body."""
_IMPOSSIBLE, _MOST_FORM, _LEAST_LOG = -15.0, 40.0, -1e300


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


class InertiaDistance(NamedTuple):
    """How like a solid the tensors of several hypotheses are.

    Attributes:
        size: (k,) logarithm of the radius of gyration squared over the solid's.
        form: (k,) square of the distance of the second moments, each by their sum, in the solid's own measure.
        possible: (k,) whether a body can have the tensor.
    """

    size: Floats
    form: Floats
    possible: NDArray[np.bool_]


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


def log_sum(logarithms: Floats) -> Floats:
    """Return the logarithm of the sum of exponentials along the first axis."""
    most = np.maximum(logarithms.max(axis=0), _LEAST_LOG)
    found: Floats = most + np.log(np.exp(logarithms - most).sum(axis=0))
    return found


def _normal(squares: Floats, deviation: Floats | float, count: int) -> Floats:
    """Return the logarithms of a normal distribution of vectors of so many numbers, by the squares of their lengths."""
    found: Floats = -0.5 * squares / deviation**2 - count * np.log(deviation * (2.0 * pi) ** 0.5)
    return found


def _mixed(mixture: Mixture, *vectors: tuple[Floats, int]) -> Floats:
    """Return the logarithms of a mixture of normal distributions of vectors: the squares (k,) of each one's length, and
    how many numbers it has."""
    shares, *deviations = np.array(mixture).T[:, :, None]
    found = np.log(shares)
    for (squares, count), deviation in zip(vectors, deviations, strict=True):
        found = found + _normal(squares, deviation, count)
    return log_sum(found)


def _formed(size: Floats, form: Floats, mixture: Mixture = FORM) -> Floats:
    return _mixed(mixture, (size**2, 1), (form, 5))


def _placed(centre: Floats, shapes: Uniform, mixture: Mixture = PLACE) -> Floats:
    return _mixed(mixture, (_from_centre(centre, shapes), 3))


def _from_centre(centre: Floats, shapes: Uniform) -> Floats:
    """Return the squares of the distances (k,) of centres (k, 3), over the radius of gyration squared."""
    squares: Floats = ((centre - shapes.c) ** 2).sum(axis=-1) / shapes.spread
    return squares


def _dense(mass: Floats, shapes: Uniform, mixture: Mixture = DENSITY) -> Floats:
    return _mixed(mixture, (np.log(mass / shapes.volume / _USUAL) ** 2, 1))


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
_FACTORS = np.array([(1.0, 1.0, 1.0), *(units.factors for units in UNITS)])
"""Of mass, centre of mass and inertia: what is right, and the units."""
_LOGS = np.log(_FACTORS)
_PRIORS = np.log([1.0, *(_SLIP * units.weight for units in UNITS)])
_RANGE = 35.0
"""Of logarithms of a factor that belongs to no unit."""
_STEP = 0.1
_FAR = np.exp(np.arange(_STEP, 14.0, _STEP))
"""Factors of a centre of mass that is too far from the origin; one that is too near is never seen."""
_SO_FAR = np.log(_RANGE / _FAR.size) - 3.0 * np.log(_FAR)


@dataclass(frozen=True, eq=False)
class Cause:
    """A mistake, and what was meant if that is the one.

    Attributes:
        code: of the rule that documents it.
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
        """What causes share that are one."""
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
    density = float(_dense(np.array([given.mass]), shapes)[0])
    place = float(_placed(given.c[None], shapes)[0])
    units = _of_units(given, shapes, like, density + place)
    priors = np.array([log(_SLIP * mistake.weight) if mistake.common else -inf for mistake in mistakes])
    # All six numbers have to agree where a term of the same size was subtracted, and much less is left than was meant.
    lengths = np.sqrt((I**2).sum(axis=(1, 2)))
    chance = 6.0 * np.minimum(np.log(lengths[0] / lengths[1:]), 0.0)
    wrong = priors + density + place + _formed(like.size[1:], like.form[1:], FORM[:-1]) + chance
    wrong = np.where(like.possible[1:], wrong, -np.inf)
    whole = float(log_sum(np.concatenate((units, wrong, _unexplained(given, shapes, like, density, place)))))
    right, *probable = np.exp(units - whole).tolist()
    found = []
    for one, probability in zip(UNITS, probable, strict=True):
        if probability >= LISTED:
            by_mass, by_centre, by_inertia = one.factors
            mass, c, meant = given.mass / by_mass, given.c / by_centre, given.tensor / by_inertia
            found.append(Cause("RD305", one.what, probability, mass, c, meant, apart(meant, mass, shapes), one))
    for mistake, probability, meant in zip(mistakes, np.exp(wrong - whole).tolist(), I[1:], strict=True):
        if probability >= LISTED:
            off = apart(meant, given.mass, shapes)
            found.append(Cause(mistake.code, mistake.what, probability, given.mass, given.c, meant, off))
    causes = ranked(found, lambda one: one.probability) if found else ()
    return Posterior(right, tuple(causes), apart(I[0], given.mass, shapes))


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
    right = beside + _formed(like.size[:1], like.form[:1])[0]
    if made_up(given):
        return np.array((right, *[-np.inf] * len(UNITS)))
    sizes = like.size[0] - _LOGS[:, 2] + _LOGS[:, 0]
    found: Floats = _PRIORS + _formed(sizes, np.full(len(sizes), like.form[0]), FORM[:-1]) - 3.0 * _LOGS[:, 1]
    found += _dense(given.mass / _FACTORS[:, 0], shapes, DENSITY[:-1])
    found += _placed(given.c / _FACTORS[:, 1:2], shapes, PLACE[:-1])
    found[0] = right
    return found


def _unexplained(given: Given, shapes: Uniform, like: InertiaDistance, density: float, place: float) -> Floats:
    """Return the logarithms of what explains nothing.

    A factor of the tensor, of mass and tensor, of the mass, and of the centre, each of any size; and a tensor, a centre
    (Cauchy's distribution in space) and both that have nothing to do with the link.
    """
    away = -2.0 * log(1.0 + float(_from_centre(given.c, shapes)) / 4.0) - log(8.0 * pi**2)
    other, formed, by_factors = _IMPOSSIBLE, -inf, np.zeros(0)
    if like.possible[0]:
        size, form = like.size[:1], like.form[:1]
        other = float(_normal(size**2, 3.0, 1)[0] + _normal(np.minimum(form, _MOST_FORM), 1.5, 5)[0])
        formed = float(_formed(size, form)[0])
        any_size = _mixed([(share, of_form) for share, _, of_form in FORM[:-1]], (form, 5))[0]
        mass = (size + log(given.mass / shapes.volume / _USUAL)) ** 2
        by_mass = [(share, hypot(of_size, DENSITY[0][1]), of_form) for share, of_size, of_form in FORM[:-1]]
        far = log_sum(_placed(given.c / _FAR[:, None], shapes, PLACE[1:-1]) + _SO_FAR)
        by_factors = np.log(_FACTOR / _RANGE) + np.array(
            (
                density + place + any_size,
                place + formed,
                place + _mixed(by_mass, (mass, 1), (form, 5))[0],
                density + formed + far,
            )
        )
    unlike = log(_UNLIKE)
    others = density + np.array((unlike + place + other, unlike + away + formed, 2.0 * unlike + away + other))
    return np.concatenate((by_factors, others))
