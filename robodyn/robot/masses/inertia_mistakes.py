"""What a declared inertial was meant to be: one row of a table for each way in which its numbers go wrong.

Nothing here judges; `robodyn.robot.masses.mistake_posterior` does by the shapes, `robodyn.checks.bodies.causes` by the
mirror twin too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations, permutations, product

import numpy as np

from robodyn.robot.urdf.parts import INERTIA
from robodyn.solids.inertia.laws import parallel_axis, rotation_law, symmetric
from robodyn.support.floats import Floats

UPPER = (0, 0, 0, 1, 1, 2), (0, 1, 2, 1, 2, 2)
"""Where ixx, ixy, ixz, iyy, iyz, izz are in the matrix."""
_MOMENTS, PRODUCTS = (0, 3, 5), (1, 2, 4)
_ORDERS = {
    "ixx iyy izz ixy ixz iyz (MuJoCo's fullinertia)": (0, 3, 4, 1, 5, 2),
    "ixx iyy izz iyz ixz ixy (Voigt's)": (0, 5, 4, 1, 3, 2),
    "ixx ixy iyy ixz iyz izz (a triangle by columns)": (0, 1, 3, 2, 4, 5),
}
"""Where the entries ixx, ixy, ixz, iyy, iyz, izz stand in each order."""
_DECADES = tuple(k for k in range(-6, 7) if k)
_SIGNS = (1.0, 0.15)
_AXES, _DIAGONAL, _ORDER, _PRODUCT_ORDER, _DECADE = 0.15, 0.1, 0.3, 0.1, 0.05


@dataclass(frozen=True, eq=False)
class Given:
    """What a link says.

    Attributes:
        mass: kg.
        c: (3,) centre of mass from the link's origin, in the axes of the inertial [m].
        R: (3, 3) the inertial's axes in the link's.
        entries: ixx, ixy, ixz, iyy, iyz, izz [kg m^2].
        copy: (3, 3) the tensor of the mirror twin as it stands, if it has one, in the axes of the inertial.
    """

    mass: float
    c: Floats
    R: Floats
    entries: tuple[float, ...]
    copy: Floats | None = None

    @property
    def tensor(self) -> Floats:
        """(3, 3) a new array [kg m^2]."""
        return symmetric(self.entries)

    @property
    def steiner(self) -> Floats:
        """m (|c|^2 1 - c c^T)."""
        return parallel_axis(np.zeros((3, 3)), self.mass, self.c)


@dataclass(frozen=True, eq=False)
class Mistake:
    """One way in which a tensor goes wrong.

    Attributes:
        code: of the rule that documents it.
        weight: how often it happens, beside the others.
        common: whether it is asked of a link without a twin: of the others there is one for nearly every tensor.
    """

    code: str
    what: str
    weight: float
    common: bool = True


Row = tuple[Mistake, tuple[int, ...], tuple[float, ...]]
"""A mistake whose correction takes the entries from these places, times these factors."""


def _rows() -> Iterator[Row]:
    """Yield the mistakes of signs, orders, decades and axes."""
    kept, ones = tuple(range(6)), (1.0,) * 6
    for count in (3, 2, 1):
        for flipped in combinations(PRODUCTS, count):
            what = f"the products of inertia ({', '.join(INERTIA[k] for k in flipped)}) have the wrong sign"
            factors = tuple(-1.0 if k in flipped else 1.0 for k in kept)
            yield Mistake("RD306", what, _SIGNS[count < 3]), kept, factors
    for name, places in _ORDERS.items():
        yield Mistake("RD310", f"the entries are in the order {name}", _ORDER), places, ones
    for a, b, c in permutations(PRODUCTS):
        if (a, b, c) != PRODUCTS:
            what = f"the products of inertia are in another order: {INERTIA[a]} {INERTIA[b]} {INERTIA[c]}"
            yield Mistake("RD310", what, _PRODUCT_ORDER), (0, a, b, 3, c, 5), ones
    for place in kept:
        for k in _DECADES:
            what = f"{INERTIA[place]} is {10.0**-k:g} times what it was meant to be"
            factors = tuple(10.0**k if place == other else 1.0 for other in kept)
            yield Mistake("RD311", what, _DECADE, place in _MOMENTS), kept, factors
    for order in permutations(range(3)):
        if order != (0, 1, 2):
            names = " ".join("xyz"[i] for i in order)
            where = np.empty((3, 3), dtype=int)
            where[UPPER] = where.T[UPPER] = kept
            turned = tuple(where[np.ix_(order, order)][UPPER].tolist())
            yield Mistake("RD312", f"the axes are permuted: x y z should be {names}", _AXES), turned, ones
            x, y, z = (_MOMENTS[i] for i in order)
            what = f"the moments of inertia are permuted: ixx iyy izz belong to {names}"
            yield Mistake("RD312", what, _DIAGONAL), (x, 1, 2, y, 4, z), ones


_TABLE = tuple(_rows())
_MISTAKES = tuple(mistake for mistake, _, _ in _TABLE)
_WHOLE = tuple(replace(mistake, weight=_SIGNS[0]) for mistake in _MISTAKES)
"""The same where all products have the other sign."""
_PLACES = np.array([places for _, places, _ in _TABLE])
_FACTORS = np.array([factors for _, _, factors in _TABLE])
_FLIPPED = _FACTORS[:, list(PRODUCTS)] < 0.0
"""Which of the products a row gives the other sign: asked of those that are not zero."""

ORIGIN = Mistake("RD307", "the tensor is taken about the link's origin, not the centre of mass", 1.0)
_AGAIN = "the parallel-axis term is {} a tensor that is about the centre of mass already"
SUBTRACTED = Mistake("RD308", _AGAIN.format("subtracted from"), 0.7)
TWICE = Mistake("RD308", _AGAIN.format("added twice to"), 0.3)
TURNED = Mistake("RD309", "the tensor is in the link's axes: the rpy of the inertial is not applied to it", 1.0)
NINE = "a matrix of nine entries, row by row, is read as six: iyy holds iyx, iyz holds iyy and izz holds iyz"
COPIED = "the tensor is a copy of its mirror twin's, which is not reflected"
_STEINER = (ORIGIN, 1.0), (SUBTRACTED, -1.0), (TWICE, 2.0)


def corrections(given: Given) -> tuple[list[Mistake], Floats]:
    """Return the mistakes that a tensor may have, and (k, 6) the entries that each would have spoiled [kg m^2]."""
    entries = np.array(given.entries)
    flips = _FLIPPED & (entries[list(PRODUCTS)] != 0.0)
    kept = (flips == _FLIPPED).all(axis=1)
    whole = _FLIPPED.any(axis=1) & (flips.sum(axis=1) == np.count_nonzero(entries[list(PRODUCTS)]))
    mistakes = [(_WHOLE if of_all else _MISTAKES)[k] for k, of_all in enumerate(whole.tolist()) if kept[k]]
    rows = [(_FACTORS * entries[_PLACES])[kept]]
    if given.c.any():
        term = given.steiner[UPPER]
        mistakes += [mistake for mistake, _ in _STEINER]
        rows.append(np.array([entries - times * term for _, times in _STEINER]))
    if np.abs(given.R - np.eye(3)).max() > 1e-6:
        mistakes.append(TURNED)
        rows.append(rotation_law(given.tensor, given.R.T)[UPPER][None])
    return mistakes, np.concatenate(rows)


def tensors(entries: Floats) -> Floats:
    """Return (k, 3, 3) the matrices of (k, 6) entries."""
    xx, xy, xz, yy, yz, zz = entries.T
    return np.stack((np.stack((xx, xy, xz), -1), np.stack((xy, yy, yz), -1), np.stack((xz, yz, zz), -1)), -2)


def nine_as_six(given: Given) -> bool:
    """Return whether a matrix of nine entries, row by row, is read as six: ixy stands twice, then iyy."""
    e = given.entries
    return e[1] == e[3] and e[0] > 0.0 and e[4] > 0.0 and e[3] < e[4]


def copied(given: Given) -> bool:
    """Return whether it is the tensor of the mirror twin, not reflected."""
    if given.copy is None:
        return False
    return bool(np.abs(given.tensor - given.copy).max() <= 1e-6 * np.abs(given.copy).max())


_MASSES = {"kg": 1.0, "g": 1e-3, "mg": 1e-6, "lb": 0.45359237, "t": 1e3}
_LENGTHS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": 0.0254}
_SYSTEMS = {
    **{("kg", "m"): 1.0, ("kg", "mm"): 1.0, ("kg", "cm"): 0.3, ("g", "m"): 1.0, ("g", "mm"): 1.0, ("g", "cm"): 0.3},
    **{("lb", "in"): 0.3, ("t", "mm"): 0.3, ("t", "m"): 0.1, ("mg", "m"): 0.1},
}
"""How often units of mass and length are met together in files of CAD systems, beside each other."""
_PARTS = {(0,): 1.0, (1,): 1.0, (2,): 1.0, (0, 2): 1.0, (0, 1, 2): 0.6, (0, 1): 0.1, (1, 2): 0.1}
"""How often mass (0), centre of mass (1) and inertia (2) are left in their unit."""
_CONVERTED_TWICE, _INCHES, _EXPONENT = 0.5, 0.1, 0.05
_DIGITS = 6

Factors = tuple[float, float, float]
QUANTITIES = ("mass", "centre of mass", "inertia")


@dataclass(frozen=True)
class Units:
    """What is too large, by which factors, and in which units it may therefore be.

    Attributes:
        factors: of mass, centre of mass and inertia; below 1 it is too small.
        readings: units that have these factors, each in words: "g", "g and g mm^2".
        weight: how often they are met, beside the others.
    """

    factors: Factors
    readings: tuple[str, ...]
    weight: float

    @property
    def wrong(self) -> tuple[int, ...]:
        """Which of `QUANTITIES` are wrong."""
        return tuple(k for k, factor in enumerate(self.factors) if factor != 1.0)

    @property
    def what(self) -> str:
        """What is wrong, in words: "the mass is 1000 times what the shapes suggest: g for kg?"."""
        amounts = []
        for k in self.wrong:
            factor = self.factors[k]
            times = f"{factor:g} times" if factor > 1.0 else f"1/{1.0 / factor:g} of"
            amounts.append(f"the {QUANTITIES[k]} is {times}")
        return f"{', '.join(amounts)} what the shapes suggest: {' or '.join(self.readings)}?"


def _systems() -> Iterator[tuple[Factors, str, float]]:
    """Yield every set of quantities that may be left in one unit of mass and one of length."""
    for (mass, long), often in _SYSTEMS.items():
        names = mass, long, f"{mass} {long}^2"
        kg, m = _MASSES[mass], _LENGTHS[long]
        sizes = [float(f"{size:.{_DIGITS}g}") for size in (1.0 / kg, 1.0 / m, 1.0 / (kg * m**2))]
        for kept in product((False, True), repeat=3):
            mass_by, centre_by, inertia_by = (1.0 if one else size for one, size in zip(kept, sizes, strict=True))
            factors = mass_by, centre_by, inertia_by
            wrong = tuple(k for k, factor in enumerate(factors) if factor != 1.0)
            if wrong:
                yield factors, " and ".join(names[k] for k in wrong), often * _PARTS[wrong]
    for factor in (1e-3, 1e-6, 1e-9):
        yield (1.0, 1.0, factor), "converted a second time, or a mesh in other units", _CONVERTED_TWICE
    for factor in (0.01, 0.1, 10.0, 100.0):
        yield (1.0, 1.0, factor), "a slipped exponent", _EXPONENT
    yield (1.0, 25.4, 1.0), "mm for in", _INCHES


def _table() -> tuple[Units, ...]:
    found: dict[Factors, Units] = {}
    for factors, reading, weight in _systems():
        known = found.get(factors, Units(factors, (), 0.0))
        readings = dict.fromkeys((*known.readings, reading))
        found[factors] = Units(factors, tuple(readings), known.weight + weight)
    return tuple(found.values())


UNITS = _table()
_ALIKE, _LITTLE = 2e-3, 0.02


def raised(given: Given) -> bool:
    """Return whether the tensor is nearly a multiple of the identity: its moments were raised to a floor."""
    xx, xy, xz, yy, yz, zz = given.entries
    most, products = max(xx, yy, zz), max(abs(xy), abs(xz), abs(yz))
    return most - min(xx, yy, zz) <= _ALIKE * most and products <= _LITTLE * most


def made_up(given: Given) -> bool:
    """Return whether the tensor was raised to a floor, or mass and moments have one digit each and there are no
    products: such numbers are a stand-in, and are in no other unit."""
    xx, xy, xz, yy, yz, zz = given.entries
    short = not (xy or xz or yz) and all(float(f"{value:.0e}") == value for value in (given.mass, xx, yy, zz))
    return short or raised(given)
