"""A satellite in free space that turns its solar arrays, for the example trajectory."""

from __future__ import annotations

from dataclasses import dataclass

from mpmath import mp, mpf

from helpers.free_motions import BaseState, Vector, combine, cross, dot, multiply, rotate, solve
from helpers.robot_motions import State, exact


@dataclass(frozen=True)
class Satellite:
    """A bus (mass, centre of mass c, inertia rows about c) with two arrays that turn about y.

    Each array has the mass `panel`, the principal moments `panel_inertia` and its centre of mass on the axis of its
    hinge, `arm` to either side.
    """

    mass: mpf
    c: Vector
    inertia: list[Vector]
    panel: mpf
    panel_inertia: Vector
    arm: mpf

    @property
    def centre(self) -> Vector:
        """The centre of mass of the whole in bus axes; turning the arrays does not move it."""
        return combine((self.mass / (self.mass + 2 * self.panel), self.c))

    def inertia_about_centre(self, angles: Vector) -> list[Vector]:
        """Rows of the inertia of the whole about its centre of mass, bus axes."""
        total = _with_offset(self.inertia, self.mass, combine((1, self.c), (-1, self.centre)))
        for side, angle in zip((1, -1), angles, strict=True):
            hub = [mpf(0), side * self.arm, mpf(0)]
            panel = _with_offset(_about_y(self.panel_inertia, angle), self.panel, combine((1, hub), (-1, self.centre)))
            total = [combine((1, row), (1, extra)) for row, extra in zip(total, panel, strict=True)]
        return total

    def rates(self, arrays: list[State]) -> tuple[Vector, Vector]:
        """Body rates and accelerations (w, wd) of the bus that keep the angular momentum I w + y Iyy sum(qd) zero."""
        inertia = self.inertia_about_centre([q for q, _, _ in arrays])
        spin, push = (self.panel_inertia[1] * mp.fsum(state[k] for state in arrays) for k in (1, 2))
        w = solve(inertia, [mpf(0), -spin, mpf(0)])
        change = multiply(self._inertia_rate(arrays), w)
        return w, solve(inertia, [-change[0], -push - change[1], -change[2]])

    def _inertia_rate(self, arrays: list[State]) -> list[Vector]:
        """d/dt of `inertia_about_centre`: only the difference Izz - Ixx of the arrays turns."""
        difference = self.panel_inertia[2] - self.panel_inertia[0]
        s = mp.fsum(difference * qd * mp.sin(2 * q) for q, qd, _ in arrays)
        c = mp.fsum(difference * qd * mp.cos(2 * q) for q, qd, _ in arrays)
        return [[s, mpf(0), c], exact(0, 0, 0), [c, mpf(0), -s]]

    def state(self, attitude: Vector, arrays: list[State]) -> BaseState:
        """The bus at this attitude: the centre of mass of the whole stays where it was, the origin moves around it."""
        w, wd = self.rates(arrays)
        c = self.centre
        spin = cross(w, c)
        p = combine((1, c), (-1, rotate(attitude, c)))
        v = combine((-1, rotate(attitude, spin)))
        a = combine((-1, rotate(attitude, combine((1, cross(wd, c)), (1, cross(w, spin))))))
        return BaseState(p, attitude, v, w, a, wd)


def _with_offset(inertia: list[Vector], mass: mpf, r: Vector) -> list[Vector]:
    """Parallel axis theorem: I + m (r.r 1 - r r^T)."""
    square = dot(r, r)
    return [[inertia[i][j] + mass * (square * (i == j) - r[i] * r[j]) for j in range(3)] for i in range(3)]


def _about_y(moments: Vector, angle: mpf) -> list[Vector]:
    """R diag(moments) R^T for a turn about y."""
    s, c = mp.sin(angle), mp.cos(angle)
    x, y, z = moments
    off = (z - x) * s * c
    return [[x * c * c + z * s * s, mpf(0), off], [mpf(0), y, mpf(0)], [off, mpf(0), x * s * s + z * c * c]]
