"""Which slip explains a declared inertial, weighed by the link's own shapes.

Every hypothesis, "it is right", "its mass is in g", "its tensor is about the link's origin", says what was meant, which
is as probable as right declarations are that are as far from the solid of the shapes. Bayes' rule makes probabilities
of it. Beside the slips stand hypotheses that explain nothing: a factor that belongs to no unit, any of 1e-6 to 1e9
alike, and numbers that have nothing to do with the link. So a factor of 16.7 is not called 25.4: where the shapes tell
them apart it is not near enough, and where they do not, any factor near it is as good.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import inf, log

import numpy as np

from robodyn.programs.vectors import length
from robodyn.robot.masses.likeness import (
    DENSITY,
    FORM,
    PLACE,
    Likeness,
    Uniform,
    anything,
    anywhere,
    dense,
    distance,
    formed,
    free_mass,
    free_size,
    likeness,
    log_sum,
    placed,
)
from robodyn.robot.masses.slips import Given, Slip, corrections, tensors
from robodyn.robot.masses.units import FACTORS, UNITS, WEIGHTS, Units, made_up
from robodyn.support.floats import Floats, ranked

NAMED = 0.9
"""Probability from which a cause is named."""
LISTED = 0.03
"""Probability from which it is one of those that it may be."""
DOUBTED = 0.1
"""Probability of being right below which it is said what it may be."""
_AGREES = 0.2
"""How far a corrected tensor may be from that of the shapes, and not more than half as far as the declared one."""
_SLIP, _FACTOR, _UNLIKE = 0.0015, 0.001, 0.0025
"""How often a slip of weight 1, a factor of no unit, and numbers of another body are met, beside right ones."""
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
    """A slip, and what was meant if that is the one.

    Attributes:
        code: of the rule that documents it.
        what: what went wrong, in words.
        probability: of this one.
        mass, c, I: what was meant, in the axes of the inertial; [kg], (3,) [m], (3, 3) about c [kg m^2].
        apart: |I - I_shapes| / |I_shapes| of what was meant, in Frobenius' norm.
        units: what is in which units; None of other slips.
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
class Weighed:
    """The verdict of the shapes.

    Attributes:
        right: the probability that the declaration is right.
        causes: the slips that it may be, the most probable first.
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


def weigh(given: Given, shapes: Uniform) -> Weighed:
    """Return which slip explains what a link says.

    Args:
        given: of positive mass, and finite.
        shapes: in the axes of the inertial.

    Accuracy: of what is named of 20 kinds of slips planted in healthy links of ten robots that the distributions were
        not measured on, at most 2 % have another name.
    """
    slips, entries = corrections(given)
    I = np.concatenate((given.tensor[None], tensors(entries)))
    like = likeness(I, given.mass, shapes)
    density = float(dense(np.array([given.mass]), shapes)[0])
    place = float(placed(given.c[None], shapes)[0])
    units = _of_units(given, shapes, like, density + place)
    wrong = (
        np.array([_rarity(slip) for slip in slips]) + density + place + formed(like.size[1:], like.form[1:], FORM[:-1])
    )
    wrong = np.where(like.possible[1:], wrong + _chance(I), -np.inf)
    rest = np.concatenate((_unlike(given, shapes, like, density, place), _no_unit(given, shapes, like, density, place)))
    whole = float(log_sum(np.concatenate((units, wrong, rest))))
    probable, slipped = np.exp(units - whole), np.exp(wrong - whole)
    found = [_left_in(given, shapes, UNITS[k], float(probable[_OF_UNITS][k])) for k in _listed(probable[_OF_UNITS])]
    for k in _listed(slipped):
        apart_so = apart(I[k + 1], given.mass, shapes)
        found.append(Cause(slips[k].code, slips[k].what, float(slipped[k]), given.mass, given.c, I[k + 1], apart_so))
    causes = ranked(found, lambda one: one.probability) if found else ()
    return Weighed(float(probable[0]), tuple(causes), apart(I[0], given.mass, shapes))


@cache
def _rarity(slip: Slip) -> float:
    """Return the logarithm of how often a slip is met."""
    return log(_SLIP * slip.weight) if slip.common else -inf


def _listed(probable: Floats) -> list[int]:
    """Return which are probable enough to be listed."""
    return np.flatnonzero(probable >= LISTED).tolist()


def apart(I: Floats, mass: float, shapes: Uniform) -> float:
    """Return |I - I_shapes| / |I_shapes| at the same mass, in Frobenius' norm."""
    own = shapes.inertia(mass)
    return float(length(I - own)) / float(length(own))


def _left_in(given: Given, shapes: Uniform, units: Units, probability: float) -> Cause:
    m, c, I = units.factors
    mass, tensor = given.mass / m, given.tensor / I
    return Cause("RD305", units.what, probability, mass, given.c / c, tensor, apart(tensor, mass, shapes), units)


def _of_units(given: Given, shapes: Uniform, like: Likeness, beside: float) -> Floats:
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


def _no_unit(given: Given, shapes: Uniform, like: Likeness, density: float, place: float) -> Floats:
    """Return those of a factor of the tensor, of mass and tensor, of the mass, and of the centre, each of any size."""
    if not like.possible[0]:
        return np.full(1, -np.inf)
    size, form, prior = like.size[:1], like.form[:1], np.log(_FACTOR / _RANGE)
    beside, any_size = formed(size, form)[0], free_size(form, FORM[:-1])[0]
    far = placed(given.c / _FAR[:, None], shapes, PLACE[1:-1]) + _SO_FAR
    by_mass = free_mass(given.mass, size, form, shapes)[0]
    found: Floats = prior + np.array(
        (density + place + any_size, place + beside, place + by_mass, density + beside + float(log_sum(far)))
    )
    return found


def _unlike(given: Given, shapes: Uniform, like: Likeness, density: float, place: float) -> Floats:
    """Return those of a tensor, of a centre and of both that have nothing to do with the link."""
    formed_so = formed(like.size[:1], like.form[:1])[0] if like.possible[0] else -np.inf
    other, away = anything(like), anywhere(float(distance(given.c, shapes)))
    found: Floats = density + np.array(
        (np.log(_UNLIKE) + place + other, np.log(_UNLIKE) + away + formed_so, 2 * np.log(_UNLIKE) + away + other)
    )
    return found
