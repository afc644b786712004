"""Bodies fixed to each other as one body."""

from __future__ import annotations

from collections.abc import Iterable
from math import fsum

import numpy as np

from robodyn.errors import InputError
from robodyn.inertia.exact import exact, fraction
from robodyn.inertia.properties import MassProperties
from robodyn.spatial import ZERO, Array

Pose = tuple[Array, Array]
"""Rotation (3, 3) and origin (3,) [m] of a frame in another."""


def composite(parts: Iterable[tuple[MassProperties, Pose]]) -> MassProperties:
    """The mass properties of bodies at given poses, in the frame in which these are given.

    m = sum m_i, c = sum m_i c_i / m, S_c = sum (S_i + m_i (c_i - c)(c_i - c)^T): the rotation law and the parallel axis
    theorem. A part of negative mass is a hole. Volumes and surfaces are added where all are known.

    Method: sums of fractions from the floats that are given, rounded once at the end.

    Raises:
        InputError: masses that are not all zero add up to zero; a rotation is not orthogonal.

    Accuracy: `com` correctly rounded and S_c + S_low within 2^-106, entry by entry: the same to the last bit in every
        order of the parts, and wherever the origin is.
    """
    given = tuple(parts)
    placed = [(fraction(body.mass), *body.carried(R, p)) for body, (R, p) in given]
    m = sum(mass for mass, _, _ in placed)
    if not m and any(mass for mass, _, _ in placed):
        raise InputError("the masses of the parts add up to zero: they have no centre of mass")
    first = sum((mass * centre for mass, centre, _ in placed), exact(ZERO))
    c = first / m if m else first
    S = exact(np.zeros((3, 3)))
    for mass, centre, S_i in placed:
        S = S + S_i + mass * np.outer(centre - c, centre - c)
    return MassProperties(m, c, S, _sum([body.volume for body, _ in given]), _sum([body.area for body, _ in given]))


def _sum(numbers: list[float | None]) -> float | None:
    known = [number for number in numbers if number is not None]
    return fsum(known) if len(known) == len(numbers) else None
