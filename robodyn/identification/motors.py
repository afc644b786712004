"""What motors of joints, and motors of coupled joints, add to torques: friction and rotors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from robodyn.programs.vectors import product
from robodyn.support.floats import Floats

PARAMETERS = ("viscous", "coulomb", "offset", "stribeck", "rotor", "load")
"""Of a motor. `coulomb` and `offset` are half the difference and half the sum of friction forwards and backwards, which
no motion tells from a torque sensor's offset; `stribeck` is the torque of breakaway; `load` is the part of the torque
through the gear that is friction."""


@dataclass(frozen=True, eq=False)
class Motor:
    """A motor that turns with a sum of joints' rates, s = direction . qd, and drives them with torques alike.

    Attributes:
        name: of the joint, or of the motor of several joints.
        direction: (n,).
        scale: largest |s| of the motion [rad/s].
        stribeck: speeds at which Stribeck's excess may decay, which are compared [rad/s].
        loaded: whether friction that grows with load is compared; of a joint's own motor alone.
    """

    name: str
    direction: Floats
    scale: float
    stribeck: tuple[float, ...] = ()
    loaded: bool = False

    @property
    def atoms(self) -> tuple[str, ...]:
        """The names of the columns that are filtered, of which those of the parameters are sums."""
        decaying = (f"{kind}@{speed:.17g}" for speed in self.stribeck for kind in ("sign", "square"))
        return ("viscous", "sign", "square", "rotor", *decaying, *(("load",) if self.loaded else ()))

    def sign(self, qd: Floats, slip_speed: float) -> Floats:
        """Return (k,) the sign of s, smoothed as friction is."""
        speed = product(qd, self.direction)
        return np.asarray(speed / np.hypot(speed, slip_speed) if slip_speed else np.sign(speed))

    def columns(self, qd: Floats, qdd: Floats, slip_speed: float, transmitted: Floats) -> Iterator[Floats]:
        """Yield (k,) the column of each atom: s, sign(s), sign(s)^2, its acceleration, signs times exp(-(s / v)^2).

        The last, if it is loaded, is sign(s) |torque that passes the gear|.

        Args:
            transmitted: (k, n) torques that the joints transmit, as a first fit has them.
        """
        speed, sign = product(qd, self.direction), self.sign(qd, slip_speed)
        yield from (speed, sign, sign * sign, product(qdd, self.direction))
        for each in self.stribeck:
            decay = np.exp(-((speed / each) ** 2))
            yield from (sign * decay, sign * sign * decay)
        if self.loaded:
            yield sign * np.abs(product(transmitted, self.direction))


@dataclass(frozen=True)
class Shape:
    """How a motor is modelled: the speed of Stribeck's excess, None without, and whether friction grows with load."""

    stribeck: float | None = None
    load: bool = False

    def kinds(self) -> list[str]:
        """Return which of `PARAMETERS` there are."""
        absent = {"stribeck"} if self.stribeck is None else set[str]()
        return [kind for kind in PARAMETERS if kind not in absent | (set() if self.load else {"load"})]

    def matrix(self, motor: Motor) -> Floats:
        """Return (atoms, parameters) which sums of a motor's atoms are the columns of its parameters."""
        atoms, kinds = motor.atoms, self.kinds()
        found = np.zeros((len(atoms), len(kinds)))
        of = {"viscous": "viscous", "coulomb": "sign", "offset": "square", "rotor": "rotor", "load": "load"}
        for column, kind in enumerate(kinds):
            if kind in of:
                found[atoms.index(of[kind]), column] = 1.0
        if self.stribeck is not None:
            sign, square = (atoms.index(f"{kind}@{self.stribeck:.17g}") for kind in ("sign", "square"))
            found[sign, kinds.index("coulomb")] = found[square, kinds.index("offset")] = -1.0
            found[sign, kinds.index("stribeck")] = 1.0
        return found

    def names(self, motor: Motor) -> tuple[str, ...]:
        """Return the names of the parameters."""
        return tuple(f"{motor.name}.{kind}" for kind in self.kinds())


PLAIN = Shape()
