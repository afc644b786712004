"""What a tensor is measured against: the laws of bodies, the link's shapes, and its mirror twin."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property, partial

import numpy as np

from robodyn.checks.bodies.masses import Tensor, principal_moments
from robodyn.checks.bodies.shapes import own_box
from robodyn.checks.bodies.uniform import shaped
from robodyn.checks.bodies.weighed import given
from robodyn.checks.context import Context
from robodyn.checks.mirror.pairs import Pair, link_inertia, reflected
from robodyn.programs.vectors import product
from robodyn.robot.masses.slips import UPPER, Given
from robodyn.robot.masses.weighing import apart as from_shapes
from robodyn.robot.urdf.view import LinkView
from robodyn.solids.inertia.laws import second_moments, symmetric
from robodyn.support.floats import Floats

DIFFERENT = 0.10
"""How far a tensor may be from its twin's mirror image before something is wrong, relative to its largest entry."""
SAME = 0.02
"""How near a correction must come to the twin's mirror image."""
_BEYOND = 1.05
"""A second moment this many times the most that the link's shapes allow is beyond them."""
_MARGIN = 1e-9


class Symptom(Enum):
    """How a wrong tensor shows, and what shows that a correction is right."""

    IMPOSSIBLE = "no body can have this tensor, but one can have the corrected one"
    NO_IMAGE = "corrected, it is the mirror image of its twin's"


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a tensor is measured against, in the axes of the inertial.

    Attributes:
        possible: whether a body can have a tensor, by the thresholds of RD206 and RD207.
        image: the mirror image of the twin's tensor, scaled to this link's mass; None without a twin to believe.
        bound: finds `most`.
    """

    possible: Callable[[Floats], bool]
    image: Floats | None = None
    bound: Callable[[], Floats | None] = lambda: None

    @cached_property
    def most(self) -> Floats | None:
        """(3,) the most that the second moments can be in the box around the link's shapes; None where a shape of it is
        not known."""
        return self.bound()

    def symptom(self, I: Floats) -> Symptom | None:
        """Return what is wrong with the tensor; None if nothing is seen."""
        if not self.possible(I):
            return Symptom.IMPOSSIBLE
        if self.image is not None and apart(I, self.image) > DIFFERENT:
            return Symptom.NO_IMAGE
        return None

    def explains(self, I: Floats) -> bool:
        """Return whether nothing is left to explain about a corrected tensor."""
        if self.image is not None and apart(I, self.image) > SAME:
            return False
        return self.possible(I) and self.allows(I)

    def allows(self, I: Floats, now: Floats | None = None) -> bool:
        """Return whether mass inside the link's shapes may have a tensor; or one that goes no farther beyond them than
        it does now."""
        if self.most is None:
            return True
        most = _BEYOND * self.most if now is None else np.maximum(_BEYOND * self.most, _second(now))
        return bool((_second(I) <= most).all())


def evidence_of(context: Context, link: LinkView, given: Given, twin: Pair | None) -> tuple[Evidence, Given]:
    """Return the evidence on a link's tensor, and what is given of the link with its twin's tensor, if it has one."""
    limits = context.thresholds

    def possible(I: Floats) -> bool:
        if clearly_possible(*I[UPPER].tolist()):
            return True
        small, middle, large = principal_moments(tuple(I[UPPER].tolist()))
        return small > limits.positive_definite * large and small + middle >= (1 - limits.triangle) * large

    evidence = Evidence(possible, bound=partial(_most, context, link, given))
    if twin is None or twin.left.inertial is None or not twin.left.inertial.mass > 0:
        return evidence, given
    _, I = reflected(twin, twin.left.inertial)
    if not possible(I):
        return evidence, given
    scale = given.mass / twin.left.inertial.mass
    image, copy = (product(given.R.T, tensor, given.R) for tensor in (I, link_inertia(twin.left.inertial)[1]))
    return replace(evidence, image=scale * image), replace(given, copy=copy)


def _most(context: Context, link: LinkView, given: Given) -> Floats | None:
    """Return m (hi - c)(c - lo), the bound of Bhatia and Davis along each axis; 0 of a centre that is outside."""
    box = own_box(context, link, given.R)
    if box is None:
        return None
    most: Floats = given.mass * np.maximum(box.hi - given.c, 0.0) * np.maximum(given.c - box.lo, 0.0)
    return most


def leads_away(context: Context, link: LinkView, correction: Tensor | None) -> bool:
    """Return whether the entries of a correction are farther from the inertia of the link's shapes than those that it
    has."""
    said, shapes = given(link), {} if context.tree_or_none is None else context.once(shaped)
    if correction is None or said is None or link.name not in shapes:
        return False
    solid = shapes[link.name].solid.along(said.R)
    now, then = (from_shapes(I, said.mass, solid) for I in (said.tensor, symmetric(correction)))
    return now < then


def clearly_possible(xx: float, xy: float, xz: float, yy: float, yz: float, zz: float) -> bool:
    """Return whether the second moments are positive definite by a margin, by Sylvester's criterion; False may be
    unclear."""
    half = (xx + yy + zz) / 2.0
    a, b, c = half - xx, half - yy, half - zz
    minor = a * b - xy * xy
    determinant = c * minor - a * yz * yz - b * xz * xz - 2.0 * xy * xz * yz
    return bool(a > 0.0 and minor > _MARGIN * half**2 and determinant > _MARGIN * half**3)


def _second(I: Floats) -> Floats:
    return np.diagonal(second_moments(I))


def apart(I: Floats, other: Floats) -> float:
    return float(np.abs(I - other).max() / max(np.abs(I).max(), np.abs(other).max()))
