"""Which mistake explains a declared inertial, weighed by the link's own shapes.

Every hypothesis, "it is right", "its mass is in g", says what was meant, which is as probable as right declarations
are that are as far from the solid of the shapes; Bayes' rule makes probabilities of it. Beside the mistakes stand
hypotheses that explain nothing: a factor that belongs to no unit, any of 1e-6 to 1e9 alike, and numbers that have
nothing to do with the link. So a factor of 16.7 is not called 25.4, whether shapes tell them apart or not.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, permutations, product
from math import hypot, inf, log, pi

import numpy as np

from robodyn.programs import vectors
from robodyn.programs.vectors import IDENTITY, length
from robodyn.robot.urdf.parts import INERTIA
from robodyn.solids.inertia.laws import parallel_axis, rotation_law, symmetric
from robodyn.support.floats import Floats, ranked

UPPER = (0, 0, 0, 1, 1, 2), (0, 1, 2, 1, 2, 2)
"""Where ixx, ixy, ixz, iyy, iyz, izz are in the matrix."""
_MOMENTS, PRODUCTS = (0, 3, 5), (1, 2, 4)
_ORDERS = {
    "ixx iyy izz ixy ixz iyz (MuJoCo's fullinertia)": (0, 3, 4, 1, 5, 2),
    "ixx iyy izz iyz ixz ixy (Voigt's)": (0, 5, 4, 1, 3, 2),
    "ixx ixy iyy ixz iyz izz (a triangle by columns)": (0, 1, 3, 2, 4, 5),
}
"""Where the entries ixx, ixy, ixz, iyy, iyz, izz stand in each order."""
NINE = "a matrix of nine entries, row by row, is read as six: iyy holds iyx, iyz holds iyy and izz holds iyz"
COPIED = "the tensor is a copy of its mirror twin's, which is not reflected"
_MASSES = {"kg": 1.0, "g": 1e-3, "mg": 1e-6, "lb": 0.45359237, "t": 1e3}
_LENGTHS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": 0.0254}
_SYSTEMS = {
    **{("kg", "m"): 1.0, ("kg", "mm"): 1.0, ("kg", "cm"): 0.3, ("g", "m"): 1.0, ("g", "mm"): 1.0, ("g", "cm"): 0.3},
    **{("lb", "in"): 0.3, ("t", "mm"): 0.3, ("t", "m"): 0.1, ("mg", "m"): 0.1},
}
"""How often units of mass and length are met together in files of CAD systems, beside each other."""
_PARTS = {(0,): 1.0, (1,): 1.0, (2,): 1.0, (0, 2): 1.0, (0, 1, 2): 0.6, (0, 1): 0.1, (1, 2): 0.1}
"""How often mass (0), centre of mass (1) and inertia (2) are left in their unit."""
QUANTITIES = ("mass", "centre of mass", "inertia")
_ALIKE, _LITTLE = 2e-3, 0.02

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
_IMPOSSIBLE, _MOST_FORM = -15.0, 40.0
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
_RANGE, _STEP = 35.0, 0.1
"""Of logarithms of a factor that belongs to no unit."""
_FAR = np.exp(np.arange(_STEP, 14.0, _STEP))
"""Factors of a centre of mass that is too far from the origin; one that is too near is never seen."""
_SO_FAR = np.log(_RANGE / _FAR.size) - 3.0 * np.log(_FAR)


@dataclass(frozen=True, eq=False)
class Given:
    """What a link says: mass [kg]; c (3,), centre of mass from the link's origin, in the axes of the inertial [m]; R
    (3, 3), these in the link's; entries ixx, ixy, ixz, iyy, iyz, izz [kg m^2]."""

    mass: float
    c: Floats
    R: Floats
    entries: tuple[float, ...]

    @property
    def tensor(self) -> Floats:
        """(3, 3) a new array [kg m^2]."""
        return symmetric(self.entries)

    @property
    def steiner(self) -> Floats:
        """m (|c|^2 1 - c c^T)."""
        return parallel_axis(np.zeros((3, 3)), self.mass, self.c)

    @property
    def raised(self) -> bool:
        """Whether the tensor is nearly a multiple of the identity: its moments were raised to a floor."""
        xx, xy, xz, yy, yz, zz = self.entries
        most, products = max(xx, yy, zz), max(abs(xy), abs(xz), abs(yz))
        return most - min(xx, yy, zz) <= _ALIKE * most and products <= _LITTLE * most

    @property
    def made_up(self) -> bool:
        """Whether the tensor is a stand-in, in no other unit: raised to a floor, or of one digit each and without
        products."""
        xx, xy, xz, yy, yz, zz = self.entries
        short = not (xy or xz or yz) and all(float(f"{value:.0e}") == value for value in (self.mass, xx, yy, zz))
        return short or self.raised

    @property
    def nine_as_six(self) -> bool:
        """Whether a matrix of nine entries, row by row, is read as six: ixy stands twice, then iyy."""
        e = self.entries
        return e[1] == e[3] and e[0] > 0.0 and e[4] > 0.0 and e[3] < e[4]


@dataclass(frozen=True, eq=False)
class Mistake:
    """One way in which an inertial goes wrong.

    Attributes:
        code: of the rule that documents it.
        weight: how often it happens, beside the others.
        common: whether it is asked of a link without a twin: of the others there is one for nearly every tensor.
        factors: of units, by which mass, centre of mass and inertia are too large.
    """

    code: str
    what: str
    weight: float
    common: bool = True
    factors: tuple[float, float, float] | None = None

    @property
    def wrong(self) -> tuple[int, ...]:
        """Which of `QUANTITIES` are in other units."""
        return tuple(k for k, factor in enumerate(self.factors or ()) if factor != 1.0)


def _reordered() -> Iterator[tuple[Mistake, tuple[int, ...], tuple[float, ...]]]:
    """Yield the mistakes of orders, decades and axes, whose correction takes the entries from places, times factors."""
    kept, ones = tuple(range(6)), (1.0,) * 6
    for name, places in _ORDERS.items():
        yield Mistake("RD310", f"the entries are in the order {name}", 0.3), places, ones
    for a, b, c in permutations(PRODUCTS):
        if (a, b, c) != PRODUCTS:
            what = f"the products of inertia are in another order: {INERTIA[a]} {INERTIA[b]} {INERTIA[c]}"
            yield Mistake("RD310", what, 0.1), (0, a, b, 3, c, 5), ones
    for place, k in product(kept, (*range(-6, 0), *range(1, 7))):
        what = f"{INERTIA[place]} is {10.0**-k:g} times what it was meant to be"
        factors = tuple(10.0**k if place == other else 1.0 for other in kept)
        yield Mistake("RD311", what, 0.05, place in _MOMENTS), kept, factors
    for order in permutations(range(3)):
        if order != (0, 1, 2):
            names = " ".join("xyz"[i] for i in order)
            turned = tuple(symmetric(kept)[np.ix_(order, order)][UPPER].astype(int).tolist())
            yield Mistake("RD312", f"the axes are permuted: x y z should be {names}", 0.15), turned, ones
            x, y, z = (_MOMENTS[i] for i in order)
            what = f"the moments of inertia are permuted: ixx iyy izz belong to {names}"
            yield Mistake("RD312", what, 0.1), (x, 1, 2, y, 4, z), ones


_REORDERED = tuple(_reordered())
_PLACES = np.array([places for _, places, _ in _REORDERED])
_FACTORS = np.array([factors for _, _, factors in _REORDERED])
_AGAIN = "the parallel-axis term is {} a tensor that is about the centre of mass already"
_STEINER = (
    (Mistake("RD307", "the tensor is taken about the link's origin, not the centre of mass", 1.0), 1.0),
    (Mistake("RD308", _AGAIN.format("subtracted from"), 0.7), -1.0),
    (Mistake("RD308", _AGAIN.format("added twice to"), 0.3), 2.0),
)
_TURNED = Mistake("RD309", "the tensor is in the link's axes: the rpy of the inertial is not applied to it", 1.0)


def corrections(given: Given) -> tuple[list[Mistake], Floats]:
    """Return the mistakes that a tensor may have, and (k, 3, 3) the tensors that each would have spoiled [kg m^2]."""
    entries, mistakes, rows = np.array(given.entries), list[Mistake](), list[Floats]()
    products = [k for k in PRODUCTS if entries[k]]
    for count in range(len(products), 0, -1):
        for flipped in combinations(products, count):
            what = f"the products of inertia ({', '.join(INERTIA[k] for k in flipped)}) have the wrong sign"
            mistakes.append(Mistake("RD306", what, 1.0 if count == len(products) else 0.15))
            rows.append(np.array([-value if k in flipped else value for k, value in enumerate(given.entries)]))
    mistakes += [mistake for mistake, _, _ in _REORDERED]
    rows += [*(_FACTORS * entries[_PLACES])]
    if given.c.any():
        mistakes += [mistake for mistake, _ in _STEINER]
        rows += [entries - times * given.steiner[UPPER] for _, times in _STEINER]
    if np.abs(given.R - np.eye(3)).max() > 1e-6:
        mistakes.append(_TURNED)
        rows.append(rotation_law(given.tensor, given.R.T)[UPPER])
    xx, xy, xz, yy, yz, zz = np.array(rows).T
    return mistakes, np.stack([np.stack(row, -1) for row in ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))], -2)


def _units() -> Iterator[Mistake]:
    """Yield the units that have the same factors as one: "the mass is 1000 times what the shapes suggest: g?"."""
    found: defaultdict[tuple[float, float, float], dict[str, float]] = defaultdict(
        lambda: defaultdict(float)
    )  # the weight of each reading
    for (mass, long), often in _SYSTEMS.items():
        names = mass, long, f"{mass} {long}^2"
        kg, m = _MASSES[mass], _LENGTHS[long]
        a, b, c = (float(f"{size:.6g}") for size in (1.0 / kg, 1.0 / m, 1.0 / (kg * m**2)))
        for factors in product((a, 1.0), (b, 1.0), (c, 1.0)):
            wrong = tuple(k for k, factor in enumerate(factors) if factor != 1.0)
            if wrong:
                found[factors][" and ".join(names[k] for k in wrong)] += often * _PARTS[wrong]
    for factor in (1e-3, 1e-6, 1e-9):
        found[1.0, 1.0, factor]["converted a second time, or a mesh in other units"] += 0.5
    for factor in (0.01, 0.1, 10.0, 100.0):
        found[1.0, 1.0, factor]["a slipped exponent"] += 0.05
    found[1.0, 25.4, 1.0]["mm for in"] += 0.1
    for factors, readings in found.items():
        amounts = [
            f"the {name} is " + (f"{factor:g} times" if factor > 1.0 else f"1/{1.0 / factor:g} of")
            for name, factor in zip(QUANTITIES, factors, strict=True)
            if factor != 1.0
        ]
        what = f"{', '.join(amounts)} what the shapes suggest: {' or '.join(readings)}?"
        yield Mistake("RD305", what, sum(readings.values()), factors=factors)


UNITS = tuple(_units())
_BY = np.array([(1.0, 1.0, 1.0), *(units.factors for units in UNITS)])
"""By how much mass, centre of mass and inertia are too large: of what is right, and of the units."""


@dataclass(frozen=True, eq=False)
class Uniform:
    """What shapes of one density are: volume [m^3], its centre c (3,) [m], S (3, 3) second moments about it by the mass
    [m^2]."""

    volume: float
    c: Floats
    S: Floats

    @cached_property
    def spread(self) -> float:
        """tr(S), the radius of gyration squared [m^2]."""
        return float(np.trace(self.S))

    def along(self, R: Floats) -> Uniform:
        """Return it in the axes R (3, 3) of its frame."""
        return Uniform(self.volume, vectors.product(R.T, self.c), vectors.product(R.T, self.S, R))

    def inertia(self, mass: float) -> Floats:
        """(3, 3) about its centre, of a mass [kg m^2]."""
        I: Floats = mass * (self.spread * IDENTITY - self.S)
        return I

    def apart(self, I: Floats, mass: float) -> float:
        """Return |I - I_shapes| / |I_shapes| at the same mass, in Frobenius' norm."""
        return relative(I, self.inertia(mass))


def relative(I: Floats, right: Floats) -> float:
    """Return |I - right| / |right| in Frobenius' norm."""
    return float(length(I - right) / length(right))


def inertia_distance(I: Floats, mass: Floats, shapes: Uniform) -> tuple[Floats, Floats]:
    """Return (k,) how far tensors (k, 3, 3) of masses (k,) are from the solid: the logarithm of the radius of gyration
    squared over the solid's; and the square of the distance of the second moments, each by their sum, in the solid's
    own measure, infinite of a tensor that no body can have."""
    sums = np.trace(I, axis1=1, axis2=2) / 2.0
    form = shapes.S / shapes.spread
    with np.errstate(all="ignore"):
        second = IDENTITY - I / sums[:, None, None]
        size = np.log(sums / mass / shapes.spread)
        measured = np.linalg.inv(form + _THIN * IDENTITY) @ (second - form)
        squares = np.maximum((measured * np.swapaxes(measured, 1, 2)).sum(axis=(1, 2)), 0.0)
        possible = (sums > 0.0) & np.isfinite(size) & np.isfinite(second).all(axis=(1, 2))
        possible[possible] = np.linalg.eigvalsh(second[possible])[:, 0] > -_NEGATIVE
    return np.where(possible, size, 0.0), np.where(possible, squares, inf)


def _normal(squares: Floats, deviation: Floats | float, count: int) -> Floats:
    """Return the logarithms of a normal distribution of vectors of so many numbers, by the squares of their lengths."""
    found: Floats = -0.5 * squares / deviation**2 - count * np.log(deviation * (2.0 * pi) ** 0.5)
    return found


def _mixed(mixture: Mixture, *parts: tuple[Floats, int]) -> Floats:
    """Return the logarithms of a mixture of normal distributions of vectors, by squared lengths (k,) and sizes."""
    shares, *deviations = np.array(mixture).T[:, :, None]
    found = np.log(shares)
    for (squares, count), deviation in zip(parts, deviations, strict=True):
        found = found + _normal(squares, deviation, count)
    return np.asarray(np.logaddexp.reduce(found, axis=0))


@dataclass(frozen=True, eq=False)
class Cause:
    """A mistake, and what was meant if it is that, in the axes of the inertial: mass [kg], c (3,) [m], I (3, 3) about c
    [kg m^2], which is |I - I_shapes| / |I_shapes| `apart` from the shapes, in Frobenius' norm."""

    mistake: Mistake
    probability: float
    mass: float
    c: Floats
    I: Floats
    apart: float

    @property
    def what(self) -> str:
        return self.mistake.what


@dataclass(frozen=True, eq=False)
class Posterior:
    """The verdict of the shapes: the probability that the declaration, which is |I - I_shapes| / |I_shapes| `apart`
    from them, is `right`, and the mistakes that it may be, the most probable first."""

    right: float
    causes: tuple[Cause, ...]
    apart: float

    @cached_property
    def named(self) -> tuple[Cause, ...]:
        """The causes of one kind that explain it alone, with their corrections, the most probable first; or nothing."""
        kinds = [(one.mistake.code, one.mistake.factors) for one in self.causes]
        sums = [
            sum(one.probability for one, its in zip(self.causes, kinds, strict=True) if its == kind) for kind in kinds
        ]
        found = tuple(one for one, whole in zip(self.causes, sums, strict=True) if whole >= NAMED)
        agrees = found and (found[0].mistake.factors or found[0].apart <= min(_AGREES, self.apart / 2.0))
        return found if agrees else ()

    @property
    def either(self) -> tuple[Cause, ...]:
        """Causes of which one explains it, where they do so together and none alone."""
        return () if self.named or sum(one.probability for one in self.causes) < NAMED else self.causes

    @property
    def units(self) -> bool:
        """Whether units explain it: one set of them, or one of several."""
        told = self.named or self.either
        return bool(told) and all(one.mistake.factors for one in told)


def mistake_posterior(given: Given, shapes: Uniform) -> Posterior:
    """Return which mistake explains what a link says, of positive mass and finite; its shapes in the inertial's axes.

    Accuracy: of what is named of 20 kinds of mistakes planted in healthy links of ten robots that the distributions
        were not measured on, at most 2 % have another name.
    """
    tensors, meant = corrections(given)
    mistakes, first = (*UNITS, *tensors), len(_BY)
    mass = np.concatenate((given.mass / _BY[:, 0], np.full(len(tensors), given.mass)))
    c = np.concatenate((given.c / _BY[:, 1:2], np.tile(given.c, (len(tensors), 1))))
    I = np.concatenate((given.tensor / _BY[:, 2, None, None], meant))
    size, form = inertia_distance(I, mass, shapes)
    density = (np.log(mass / shapes.volume / _USUAL) ** 2, 1)
    place = (((c - shapes.c) ** 2).sum(axis=1) / shapes.spread, 3)
    odds = [log(_SLIP * one.weight) if one.common and not (one.factors and given.made_up) else -inf for one in mistakes]
    found = np.array((0.0, *odds)) + _mixed(FORM[:-1], (size**2, 1), (form, 5))
    found[1:first] += (_mixed(DENSITY[:-1], density) + _mixed(PLACE[:-1], place))[1:first] - 3.0 * np.log(_BY[1:, 1])
    beside = float(_mixed(DENSITY, density)[0]), float(_mixed(PLACE, place)[0])
    found[0] = _mixed(FORM, (size[:1] ** 2, 1), (form[:1], 5))[0] + sum(beside)
    # All six numbers have to agree where a term of the same size was subtracted, and much less is left than was meant.
    lengths = np.sqrt((I**2).sum(axis=(1, 2)))
    found[first:] += sum(beside) + 6.0 * np.minimum(np.log(lengths[0] / lengths[first:]), 0.0)
    others = _unexplained(given, shapes, float(size[0]), float(form[0]), *beside)
    right, *probable = np.exp(found - np.logaddexp.reduce((*found, *others))).tolist()
    causes = [
        Cause(mistake, probability, float(mass[k]), c[k], I[k], shapes.apart(I[k], float(mass[k])))
        for k, (mistake, probability) in enumerate(zip(mistakes, probable, strict=True), 1)
        if probability >= LISTED
    ]
    causes = ranked(causes, lambda one: one.probability) if causes else causes
    return Posterior(right, tuple(causes), shapes.apart(I[0], given.mass))


def _unexplained(given: Given, shapes: Uniform, size: float, form: float, density: float, place: float) -> Floats:
    """Return the logarithms of what explains nothing: factors of the tensor, of mass and tensor, of the mass, and of
    the centre; a tensor, a centre (Cauchy's distribution in space) and both that have nothing to do with the link."""
    away = -2.0 * log(1.0 + float(((given.c - shapes.c) ** 2).sum() / shapes.spread) / 4.0) - log(8.0 * pi**2)
    other, formed, by_factors = _IMPOSSIBLE, -inf, np.zeros(0)
    if form < inf:
        sizes, forms = (np.array([size**2]), 1), (np.array([form]), 5)
        other = float(_normal(sizes[0], 3.0, 1)[0] + _normal(np.minimum(forms[0], _MOST_FORM), 1.5, 5)[0])
        formed = float(_mixed(FORM, sizes, forms)[0])
        any_size = _mixed([(share, of_form) for share, _, of_form in FORM[:-1]], forms)[0]
        mass = np.array([(size + log(given.mass / shapes.volume / _USUAL)) ** 2])
        by_mass = [(share, hypot(of_size, DENSITY[0][1]), of_form) for share, of_size, of_form in FORM[:-1]]
        away_by = (((given.c / _FAR[:, None] - shapes.c) ** 2).sum(axis=1) / shapes.spread, 3)
        far = np.logaddexp.reduce(_mixed(PLACE[1:-1], away_by) + _SO_FAR)
        rows = density + place + any_size, place + formed, place + _mixed(by_mass, (mass, 1), forms)[0]
        by_factors = np.log(_FACTOR / _RANGE) + np.array((*rows, density + formed + far))
    unlike = log(_UNLIKE)
    others = density + np.array((unlike + place + other, unlike + away + formed, 2.0 * unlike + away + other))
    return np.concatenate((by_factors, others))
