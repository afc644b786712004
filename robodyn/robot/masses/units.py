"""Units in which mass, centre of mass and inertia may have been left: kg, g, mg, lb and t with m, mm, cm and in."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from robodyn.robot.masses.slips import Given

_MASSES = {"kg": 1.0, "g": 1e-3, "mg": 1e-6, "lb": 0.45359237, "t": 1e3}
_LENGTHS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": 0.0254}
_SYSTEMS = {
    **{("kg", "m"): 1.0, ("kg", "mm"): 1.0, ("kg", "cm"): 0.3, ("g", "m"): 1.0, ("g", "mm"): 1.0, ("g", "cm"): 0.3},
    **{("lb", "in"): 0.3, ("t", "mm"): 0.3, ("t", "m"): 0.1, ("mg", "m"): 0.1},
}
"""How often units of mass and length are met together in files of CAD systems, beside each other."""
_PARTS = {(0,): 1.0, (1,): 1.0, (2,): 1.0, (0, 2): 1.0, (0, 1, 2): 0.6, (0, 1): 0.1, (1, 2): 0.1}
"""How often mass (0), centre of mass (1) and inertia (2) are left in their unit."""
_AGAIN, _INCHES, _EXPONENT = 0.5, 0.1, 0.05
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
        amounts = [f"the {QUANTITIES[k]} is {_times(self.factors[k])}" for k in self.wrong]
        return f"{', '.join(amounts)} what the shapes suggest: {' or '.join(self.readings)}?"


def _times(factor: float) -> str:
    return f"{factor:g} times" if factor > 1.0 else f"1/{1.0 / factor:g} of"


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
        yield (1.0, 1.0, factor), "converted a second time, or a mesh in other units", _AGAIN
    for factor in (0.01, 0.1, 10.0, 100.0):
        yield (1.0, 1.0, factor), "a slipped exponent", _EXPONENT
    yield (1.0, 25.4, 1.0), "mm for in", _INCHES


def _table() -> tuple[Units, ...]:
    found: dict[Factors, Units] = {}
    for factors, reading, weight in _systems():
        known = found.get(factors)
        readings = known.readings if known else ()
        more = () if reading in readings else (reading,)
        found[factors] = Units(factors, (*readings, *more), weight + (known.weight if known else 0.0))
    return tuple(found.values())


UNITS = _table()
FACTORS = np.array([units.factors for units in UNITS])
"""(k, 3) of mass, centre of mass and inertia."""
WEIGHTS = np.array([units.weight for units in UNITS])

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
