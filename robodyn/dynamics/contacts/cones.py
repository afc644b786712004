"""The projection onto a circular cone about a normal, and its derivative; for any scalar."""

from __future__ import annotations

from typing import NamedTuple

from robodyn.programs.vectors import Array, Scalar, cross, sign, sqrt

TINY = 1e-300


class Projected(NamedTuple):
    """The nearest point of the cone, and the derivative D = inside 1 + edge u u^T + turn v v^T of that by the point."""

    f: Array
    inside: Scalar
    edge: Scalar
    turn: Scalar
    u: Array
    v: Array


def projected(z: Array, normal: Array, cosine: Scalar, sine: Scalar) -> Projected:
    """Return the projection of z onto the cone |f_t| cos <= f_n sin of half angle atan(mu), mu = sine / cosine.

    The same steps lead to every case: inside, 0, or onto the ray (z . u) u with u = sin e + cos n, e being the
    direction of the tangential part of z. A half space (mu infinite) and a ray (mu = 0) are cones too. Where the
    derivative is not unique it is one of those nearby.
    """
    press = z @ normal
    tangential = z - normal * press
    t = sqrt(tangential @ tangential + TINY)
    inside = _positive(press * sine - t * cosine)
    along = press * cosine + t * sine
    edge = _positive(along) * (1.0 - inside)
    e = tangential / t
    u = e * sine + normal * cosine
    return Projected(z * inside + u * (edge * along), inside, edge, edge * along * sine / t, u, cross(normal, e))


def _positive(x: Scalar) -> Scalar:
    """1 where x > 0, else 0."""
    s = sign(x)
    return 0.5 * (s * (s + 1.0))
