"""The union of bodies with curved faces, against exact moments of what they have in common."""

from __future__ import annotations

from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from helpers.convex_solids import ball, common_moments, moments, rod
from helpers.mesh_oracle import deviation, rational_moments
from helpers.mesh_samples import box, moved
from helpers.repaired_meshes import repaired, taken
from helpers.sampled import sampled

from robodyn.solids.mesh.integrals import integrate

EPS = 2.0**-53
BALL = ball(70, 1.0)
PAIRS = {
    "balls": (BALL, ball(60, 0.8, (0.9, 0.3, -0.2))),
    "a ball on a rod": (BALL, rod(24, 0.4, 0.4, 5.0)),
    "crossing rods": (rod(24, 0.5, 0.5, 4.0, axis=0), rod(20, 0.3, 0.3, 3.0, axis=1)),
    "rods of one size": (rod(24, 0.5, 0.5, 4.0, axis=0), rod(24, 0.5, 0.5, 4.0, axis=1)),
    "a cone in a ball": (rod(30, 0.9, 0.2, 2.5), BALL),
    "a ball that barely dips in": (BALL, ball(60, 0.8, (1.7, 0.1, 0.05))),
    "rods that overlap by a hair": (rod(24, 0.5, 0.5, 2.0), moved(rod(24, 0.5, 0.5, 2.0), (0, 0, 2 - 2.0**-14))),
}


@cache
def united(pair):
    """The exact moments of the union about the origin."""
    one, other = PAIRS[pair]
    parts = zip(moments(one), moments(other), common_moments(one, other), strict=True)
    return tuple(a + b - c for a, b, c in parts)


@pytest.mark.parametrize("away", [0.0, 1024.0])
@pytest.mark.parametrize("pair", sampled(PAIRS, 3))
def test_moments_of_the_union(pair, away):
    shift = away * np.array((1.0, -2.0, 0.5))
    V, first, S = united(pair)
    found = repaired(*(body + shift for body in PAIRS[pair]))
    assert taken(found) == [("union", 2)]
    assert found.quadrature is None
    whole = integrate(found.triangles)
    r = np.array([Fraction(x) for x in (whole.reference - shift).tolist()])
    slack = 4 * EPS * (1 + away / 8)
    assert slack < 1e-12
    assert deviation(whole.volume, V) <= slack
    assert deviation(whole.S, S - np.outer(first, r) - np.outer(r, first) + V * np.outer(r, r)) <= slack


def test_the_reference_itself():
    cube = box((2, 2, 2)) + 1.0
    assert common_moments(cube, cube + 1.0)[0] == 1
    assert common_moments(cube, moved(cube, (2, 0, 0)))[0] == 0
    assert common_moments(cube, cube)[0] == 8
    for body in PAIRS["a ball on a rod"]:
        for mine, theirs in zip(moments(body), rational_moments(body, (0, 0, 0)), strict=True):
            assert np.array_equal(mine, theirs)
        assert common_moments(body, body)[0] == moments(body)[0]
