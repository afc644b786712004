"""Closed forms of solids against integrals along their outlines, however flat or slender."""

from __future__ import annotations

from itertools import starmap

import mpmath
import numpy as np
import pytest
from helpers.oracles import EPS
from helpers.sampled import sampled

from robodyn.errors import InputError
from robodyn.solids.inertia.solids import box, capsule, cone, cylinder, ellipsoid, sphere, torus

DENSITY = 2700.0
DIGITS = 60
"""mpmath's quadrature stops at an absolute error, and there are lengths of 1e-6 m to the fifth power."""


def _line(start, end):
    """Radius, height and their derivatives along a straight outline, over [0, 1]."""
    (r0, z0), (r1, z1) = start, end
    return lambda t: (r0 + (r1 - r0) * t, z0 + (z1 - z0) * t, r1 - r0, z1 - z0)


def _arc(across, along, centre, first, last):
    """An arc of an ellipse with these semi-axes about a centre (radius, height), from and to these angles."""
    turn = last - first

    def outline(t):
        c, s = mpmath.cos(first + turn * t), mpmath.sin(first + turn * t)
        return centre[0] + across * c, centre[1] + along * s, -across * s * turn, along * c * turn

    return outline


def _cylinder(r, length):
    h = length / 2
    return [_line((0, -h), (r, -h)), _line((r, -h), (r, h)), _line((r, h), (0, h))]


def _cone(r, length):
    h = length / 2
    return [_line((0, -h), (r, -h)), _line((r, -h), (0, h))]


def _sphere(r):
    return [_arc(r, r, (0, 0), -mpmath.pi / 2, mpmath.pi / 2)]


def _capsule(r, length):
    h, right = length / 2, mpmath.pi / 2
    return [_arc(r, r, (0, -h), -right, 0), _line((r, -h), (r, h)), _arc(r, r, (0, h), 0, right)]


def _torus(major, minor):
    return [_arc(minor, minor, (major, 0), 0, 2 * mpmath.pi)]


OUTLINES = {cylinder: _cylinder, cone: _cone, sphere: _sphere, capsule: _capsule, torus: _torus}
SIZES = [
    *((solid, sizes) for solid in (cylinder, cone, capsule) for sizes in [(0.3, 0.7), (0.5, 1e-6), (1e-6, 2.0)]),
    *((sphere, (r,)) for r in (0.4, 1e-6, 1e6)),
    *((torus, sizes) for sizes in [(0.5, 0.2), (0.5, 1e-6), (0.3, 0.3)]),
]


def _revolved(pieces):
    """Volume, area, height of the centre and second moments across and along of what an outline encloses, turned
    about z: integrals of pi r^2 dz, 2 pi r ds, pi r^2 z dz, pi r^4 / 4 dz and pi r^2 z^2 dz along it."""

    def total(integrand):
        return mpmath.fsum(mpmath.quad(lambda t, piece=piece: integrand(*piece(t)), [0, 1]) for piece in pieces)

    volume = total(lambda r, z, dr, dz: mpmath.pi * r**2 * dz)
    area = total(lambda r, z, dr, dz: 2 * mpmath.pi * r * mpmath.hypot(dr, dz))
    centre = total(lambda r, z, dr, dz: mpmath.pi * r**2 * z * dz) / volume
    across = total(lambda r, z, dr, dz: mpmath.pi * r**4 / 4 * dz)
    along = total(lambda r, z, dr, dz: mpmath.pi * r**2 * (z - centre) ** 2 * dz)
    return volume, area, centre, across, along


def _near(found, expected):
    return abs(found - expected) <= 8 * EPS * abs(expected)


@pytest.mark.parametrize(("solid", "sizes"), sampled(starmap(pytest.param, SIZES), 3))
def test_solids_of_revolution(solid, sizes):
    body = solid(*sizes, density=DENSITY)
    with mpmath.workdps(DIGITS):
        volume, area, centre, across, along = _revolved(OUTLINES[solid](*map(mpmath.mpf, sizes)))
        assert _near(body.volume, volume)
        assert _near(body.area, area)
        assert _near(body.mass, DENSITY * volume)
        assert abs(body.com[2] - centre) <= EPS * max(sizes)
        assert _near(body.S_c[0, 0], DENSITY * across)
        assert _near(body.S_c[2, 2], DENSITY * along)
    assert body.S_c[1, 1] == body.S_c[0, 0]
    assert not (body.S_c - np.diag(np.diagonal(body.S_c))).any()
    assert not body.com[:2].any()
    assert _near(body.density, DENSITY)


@pytest.mark.parametrize("axes", [(0.1, 0.2, 0.3), (1.0, 1e-6, 1e-6), (2.0, 2.0, 1e-6)])
def test_ellipsoid(axes):
    """Slices normal to each axis are ellipses of the area pi b c (1 - x^2 / a^2)."""
    body = ellipsoid(*axes, density=DENSITY)
    with mpmath.workdps(DIGITS):
        for k in range(3):
            a, b, c = (mpmath.mpf(axes[(k + i) % 3]) for i in range(3))

            def slices(power, a=a, b=b, c=c):
                return mpmath.quad(lambda t: mpmath.pi * b * c * (1 - (t / a) ** 2) * t**power, [-a, 0, a])

            assert _near(body.volume, slices(0))
            assert _near(body.S_c[k, k], DENSITY * slices(2))


SPHEROIDS = [(0.3, 0.7), (0.3, 0.3), (0.7, 0.3), (1.0, 1e-6), (1e-6, 1.0)]


@pytest.mark.parametrize(("across", "along"), sampled(starmap(pytest.param, SPHEROIDS), 3))
def test_surface_of_spheroids(across, along):
    """Of any order of the axes."""
    with mpmath.workdps(DIGITS):
        right = mpmath.pi / 2
        pieces = [_arc(across, along, (0, 0), -right, 0), _arc(across, along, (0, 0), 0, right)]
        area = _revolved(pieces)[1]
        for order in ((across, across, along), (across, along, across), (along, across, across)):
            assert _near(ellipsoid(*order, mass=1).area, area)


def test_surface_of_an_ellipsoid_of_three_axes():
    a, b, c = 0.5, 0.8, 0.7

    def element(u, t):
        across = (1 - u * u) * ((b * c * mpmath.cos(t)) ** 2 + (a * c * mpmath.sin(t)) ** 2)
        return mpmath.sqrt(across + (a * b * u) ** 2)

    with mpmath.workdps(20):
        area = 8 * mpmath.quad(element, [0, 1], [0, mpmath.pi / 2], method="gauss-legendre")
    assert _near(ellipsoid(a, b, c, mass=1).area, area)


def test_solids_that_are_each_other():
    """Bit for bit or within a few roundings; a ring and a plate."""
    for one, two in (
        (ellipsoid(0.3, 0.3, 0.3, mass=2), sphere(0.3, mass=2)),
        (capsule(0.3, 0.0, mass=2), sphere(0.3, mass=2)),
        (capsule(0.0, 0.7, mass=2), cylinder(0.0, 0.7, mass=2)),
        (cylinder(0.0, 0.7, mass=2), box(0.0, 0.0, 0.7, mass=2)),
        (capsule(0.0, 0.0, mass=2), sphere(0.0, mass=2)),
        (torus(0.0, 0.0, mass=2), cone(0.0, 0.0, mass=2)),
    ):
        assert np.abs(one.S_c - two.S_c).max() <= 4 * EPS * np.abs(two.S_c).max()
        assert abs(one.volume - two.volume) <= 4 * EPS * two.volume
    np.testing.assert_array_equal(torus(0.5, 0.0, mass=2).inertia, np.diag([0.25, 0.25, 0.5]))
    np.testing.assert_array_equal(box(1.0, 2.0, 0.0, mass=12).inertia, np.diag([4.0, 1.0, 5.0]))


@pytest.mark.parametrize("solid", [box, ellipsoid, cylinder, capsule, cone, torus, sphere])
def test_calls_that_are_wrong(solid):
    sizes = (3.0, 2.0, 1.0)[: {box: 3, ellipsoid: 3, sphere: 1}.get(solid, 2)]
    name = solid.__name__
    for neither_or_both in ({}, {"density": 1.0, "mass": 1.0}):
        with pytest.raises(InputError, match=f"a {name} needs either a density or a mass"):
            solid(*sizes, **neither_or_both)
    for bad in (-1.0, np.nan, np.inf):
        with pytest.raises(InputError, match=f"a {name} cannot have the length"):
            solid(*sizes[:-1], bad, mass=1.0)
    with pytest.raises(InputError, match="without volume has no mass"):
        solid(*(0.0 for _ in sizes), density=1.0)
    with pytest.raises(InputError, match=r"tube radius 0\.3 m > 0\.2 m overlaps itself"):
        torus(0.2, 0.3, mass=1)
