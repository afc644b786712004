"""Units that were mistaken: of meshes, and of masses, tensors and centres of mass."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import exp, isfinite

import numpy as np

from robodyn.checks.bodies.bodies import Body, bodies, share
from robodyn.checks.bodies.repeated import repeated
from robodyn.checks.bodies.shapes import outside, size_of
from robodyn.checks.context import Context
from robodyn.programs.vectors import length, product
from robodyn.support.floats import Floats

_FACTORS = (1e3, 1e6, 1e9)
_LENGTHS = (1e3, 25.4)
_USUAL = (100.0, 5000.0)
"""Mass over the volume of the box [kg/m^3] of nearly all links of published robots."""
_MATTER = 30_000.0
"""No solid is denser [kg/m^3]."""
_AIRY = 5.0
_LIKELY = (50.0, 9000.0)
_TYPICAL, _EACH = (0.2, 3.0), (0.05, 6.0)
"""Second moments over those of the solid box: their geometric mean, and each."""
_ALIKE = 2e-3
_NEAR = 0.1
"""Distance of a centre of mass from the origin, over the size of the box, that a slip has multiplied."""


@dataclass(frozen=True, slots=True)
class Slip:
    """What ("mass", "inertia" or "centre of mass") is too large by a factor; below 1 it is too small."""

    what: str
    factor: float
    units: str

    @property
    def sentence(self) -> str:
        if self.factor > 1:
            return f"the {self.what} is {self.factor:g} times what the shapes suggest: {self.units}"
        return f"the {self.what} is {1 / self.factor:g} times less than the shapes suggest: {self.units}"


def slips(context: Context) -> Mapping[str, Slip]:
    """Return by link the one factor between units that explains what does not fit the shapes.

    Accuracy: none on the robots of example-robot-data; a body of usual density and spread of which one quantity is
    multiplied by a factor is found.
    """
    found = {}
    for name, body in context.once(bodies).items():
        slip = _slip(context, body)
        if slip is not None:
            found[name] = slip
    return found


def judged(context: Context) -> Iterator[Body]:
    """Yield the bodies whose mass matters in their group and that neither a slip of units nor a repetition explains."""
    explained, again = context.once(slips), context.once(repeated)
    for name, body in context.once(bodies).items():
        if name not in explained and name not in again and share(context, body) is not None:
            yield body


def _slip(context: Context, body: Body) -> Slip | None:
    centre = _centre(body)
    if centre is not None or share(context, body) is None or body.box is None:
        return centre
    sides = body.box.hi - body.box.lo
    if not (sides > 0).all():
        return None
    density = body.mass / float(sides.prod())
    spread = _spread(body, sides)
    return _mass(density, spread) or _tensor(body, density, spread)


def _spread(body: Body, sides: Floats) -> Floats | None:
    """Return (3,) the second moments over those of the solid box; None where one is not positive."""
    if body.S is None:
        return None
    spread: Floats = 12 * np.diagonal(body.S) / body.mass / sides**2
    return spread if (spread > 0).all() else None


def _fits(spread: Floats | None) -> bool:
    if spread is None:
        return False
    mean = exp(float(np.log(spread).mean()))
    return _TYPICAL[0] <= mean <= _TYPICAL[1] and bool((_EACH[0] <= spread).all() and (spread <= _EACH[1]).all())


def _mass(density: float, spread: Floats | None) -> Slip | None:
    if spread is None:
        return None
    for factor in _FACTORS[:2]:
        usual = _USUAL[0] <= density / factor <= _USUAL[1]
        if density > _MATTER and usual and (_fits(spread) or _fits(spread * factor)):
            return Slip("mass", factor, "g for kg?" if factor == 1e3 else "mg for kg?")
    if density < _AIRY and _USUAL[0] <= density * 1e3 <= _USUAL[1] and _fits(spread / 1e3):
        return Slip("mass", 1e-3, "t for kg?")
    return None


def _tensor(body: Body, density: float, spread: Floats | None) -> Slip | None:
    if spread is None or not _LIKELY[0] <= density <= _LIKELY[1] or _isotropic(body):
        return None
    for factor in _FACTORS:
        if _fits(spread / factor):
            return Slip("inertia", factor, {1e3: "g m^2", 1e6: "kg mm^2", 1e9: "g mm^2"}[factor] + " for kg m^2?")
        if _fits(spread * factor):
            return Slip("inertia", 1 / factor, "a mesh or a density in other units?")
    return None


def _isotropic(body: Body) -> bool:
    """Return whether the tensor is nearly a multiple of the identity, as those that were made up or raised to a floor
    are."""
    tensor = body.link.tensor
    if tensor is None:
        return True
    xx, xy, xz, yy, yz, zz = tensor
    apart = max(xx, yy, zz) - min(xx, yy, zz), abs(xy), abs(xz), abs(yz)
    return max(apart) <= _ALIKE * max(xx, yy, zz)


def _centre(body: Body) -> Slip | None:
    if body.group is None or not all(map(isfinite, body.c.tolist())):
        return None
    size = size_of(body.group)
    if outside(body.group, body.in_group[0]) <= size:
        return None
    for factor in _LENGTHS:
        c = body.c / factor
        if outside(body.group, product(body.pose.R, c) + body.pose.p) == 0 and length(c) > _NEAR * size:
            return Slip("centre of mass", factor, "mm for m?" if factor == 1e3 else "in other units?")
    return None
