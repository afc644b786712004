"""Motion in space, for the example trajectories: vectors, quaternions, a free rigid body, attitude from body rates.

Vectors are lists of mpmath numbers and quaternions are (x, y, z, w); both run at the precision of the caller.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

from mpmath import mp, mpf

from helpers.robot_motions import exact

Vector = list[mpf]
DEGREE = 24


@dataclass(frozen=True)
class BaseState:
    """Position and attitude of the base; v and a in the axes of the world, w and wd in those of the base."""

    p: Vector
    attitude: Vector
    v: Vector
    w: Vector
    a: Vector
    wd: Vector


def dot(a: Vector, b: Vector) -> mpf:
    return mp.fdot(a, b)


def cross(a: Vector, b: Vector) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def combine(*terms: tuple[float | mpf, Vector]) -> Vector:
    """The sum of factor * vector over the terms."""
    return [mp.fsum(k * v[i] for k, v in terms) for i in range(len(terms[0][1]))]


def multiply(matrix: list[Vector], v: Vector) -> Vector:
    return [dot(row, v) for row in matrix]


def solve(rows: list[Vector], b: Vector) -> Vector:
    """x of the 3x3 system rows x = b, by cross products (Cramer's rule)."""
    r, s, t = rows
    volume = dot(r, cross(s, t))
    return combine((b[0] / volume, cross(s, t)), (b[1] / volume, cross(t, r)), (b[2] / volume, cross(r, s)))


def hamilton(p: Vector, q: Vector) -> Vector:
    """The quaternion product p q."""
    return [*combine((p[3], q[:3]), (q[3], p[:3]), (1, cross(p[:3], q[:3]))), p[3] * q[3] - dot(p[:3], q[:3])]


def rotate(q: Vector, v: Vector) -> Vector:
    """R v, where the unit quaternion q stands for R."""
    twist = cross(q[:3], v)
    return combine((1, v), (2 * q[3], twist), (2, cross(q[:3], twist)))


def turn(rotation: Vector) -> Vector:
    """The quaternion of a rotation vector."""
    angle = mp.sqrt(dot(rotation, rotation))
    share = mp.sin(angle / 2) / angle if angle else mpf(1) / 2
    return [*(share * x for x in rotation), mp.cos(angle / 2)]


def tumble(inertia: Vector, w: Vector, step: mpf, count: int) -> list[BaseState]:
    """A free rigid body in its principal axes at `count` times, from the identity and the rates w.

    Euler's equations and q' = q w / 2 are polynomial, so each Taylor coefficient follows from those before; DEGREE of
    them leave far less than a rounding of a double in each step.
    """
    zero, q = exact(0, 0, 0), exact(0, 0, 0, 1)
    a, b, c = inertia
    gain = [(b - c) / a, (c - a) / b, (a - b) / c]
    states = []
    for _ in range(count):
        W, Q = [[x] for x in w], [[x] for x in q]
        for k in range(1, DEGREE + 1):
            x, y, z = ([*series[:k]] for series in W)
            spin = [_convolve(y, z), _convolve(z, x), _convolve(x, y)]
            i, j, l, r = Q
            lead = [
                _convolve(r, x) + _convolve(j, z) - _convolve(l, y),
                _convolve(r, y) + _convolve(l, x) - _convolve(i, z),
                _convolve(r, z) + _convolve(i, y) - _convolve(j, x),
                -_convolve(i, x) - _convolve(j, y) - _convolve(l, z),
            ]
            for series, factor, value in zip(W, gain, spin, strict=True):
                series.append(factor * value / k)
            for series, value in zip(Q, lead, strict=True):
                series.append(value / (2 * k))
        states.append(BaseState(zero, q, zero, w, zero, [series[1] for series in W]))
        w, q = ([mp.polyval(series[::-1], step) for series in state] for state in (W, Q))
    return states


def _convolve(a: Vector, b: Vector) -> mpf:
    return mp.fdot(a, b[::-1])


def attitudes(rates: Callable[[mpf], Vector], clock: list[mpf]) -> Iterator[Vector]:
    """The quaternion at each time, from the identity and the body rates w(t) at three Gauss nodes of each interval."""
    attitude, node = exact(0, 0, 0, 1), mp.sqrt(mpf(3) / 20)
    yield attitude
    for start, end in pairwise(clock):
        step, middle = end - start, (start + end) / 2
        samples = [rates(middle + side * node * step) for side in (-1, 0, 1)]
        attitude = hamilton(attitude, turn(_magnus(samples, step)))
        yield attitude


def _magnus(rates: list[Vector], step: mpf) -> Vector:
    """The rotation vector over one step from the body rates at the three Gauss nodes: Magnus expansion of order 6.

    Blanes, Casas and Ros, "Improved high order integrators based on the Magnus expansion", BIT 40 (2000).
    """
    first, middle, last = rates
    a = combine((step, middle))
    b = combine((step * mp.sqrt(15) / 3, last), (-step * mp.sqrt(15) / 3, first))
    c = combine((step * 10 / 3, last), (-step * 20 / 3, middle), (step * 10 / 3, first))
    # Body rates multiply from the right, so every commutator has the sign of -cross.
    ab = cross(b, a)
    d = combine((mpf(-1) / 60, cross(combine((2, c), (1, ab)), a)))
    e = cross(combine((1, b), (1, d)), combine((-20, a), (-1, c), (1, ab)))
    return combine((1, a), (mpf(1) / 12, c), (mpf(1) / 240, e))
