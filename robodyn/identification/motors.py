"""What motors of joints, and motors of coupled joints, add to torques: friction and rotors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from robodyn.programs.vectors import product
from robodyn.support.floats import Floats

PARAMETERS = ("viscous", "coulomb", "offset", "stribeck", "rotor")
"""Of a motor. `coulomb` and `offset` are half the difference and half the sum of friction forwards and backwards, which
no motion tells from a torque sensor's offset; `stribeck` is the torque of breakaway."""


@dataclass(frozen=True, eq=False)
class Motor:
    """A motor that turns with a sum of joints' rates, s = direction . qd, and drives them with torques alike.

    Attributes:
        name: of the joint, or of the motor of several joints.
        direction: (n,).
        scale: largest |s| of the motion [rad/s].
        stribeck: speeds at which Stribeck's excess may decay, which are compared [rad/s].
    """

    name: str
    direction: Floats
    scale: float
    stribeck: tuple[float, ...] = ()

    @property
    def atoms(self) -> tuple[str, ...]:
        """The names of the columns that are filtered, of which those of the parameters are sums."""
        decaying = (f"{kind}@{speed:.17g}" for speed in self.stribeck for kind in ("sign", "square"))
        return ("viscous", "sign", "square", "rotor", *decaying)

    def columns(self, qd: Floats, qdd: Floats, slip_speed: float) -> Iterator[Floats]:
        """Yield (k,) the column of each atom: s, sign(s), sign(s)^2, its acceleration, signs times exp(-(s / v)^2)."""
        speed = product(qd, self.direction)
        sign = speed / np.sqrt(speed * speed + slip_speed * slip_speed) if slip_speed else np.sign(speed)
        yield from (speed, sign, sign * sign, product(qdd, self.direction))
        for each in self.stribeck:
            decay = np.exp(-((speed / each) ** 2))
            yield from (sign * decay, sign * sign * decay)

    def shape(self, stribeck: float | None) -> Floats:
        """Return (atoms, parameters) which sums of atoms are the columns of `parameters`.

        Args:
            stribeck: speed of Stribeck's excess, one of those to be compared; None: without.
        """
        names = self.atoms
        found = np.zeros((len(names), 4 if stribeck is None else 5))
        found[names.index("viscous"), 0] = found[names.index("sign"), 1] = found[names.index("square"), 2] = 1.0
        found[names.index("rotor"), -1] = 1.0
        if stribeck is not None:
            sign, square = (names.index(f"{kind}@{stribeck:.17g}") for kind in ("sign", "square"))
            found[sign, 1] = found[square, 2] = -1.0
            found[sign, 3] = 1.0
        return found

    def parameters(self, stribeck: float | None) -> tuple[str, ...]:
        """Return the names of the parameters."""
        kinds = [kind for kind in PARAMETERS if kind != "stribeck" or stribeck is not None]
        return tuple(f"{self.name}.{kind}" for kind in kinds)
