"""What the robot wants to read: one signal per coordinate, and the names its columns may have."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from robodyn.errors import InputError

Kind = Literal["angle", "continuous", "length", "floating"]
Quantity = Literal["q", "qd", "qdd"]

POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
TWIST = ("wx", "wy", "wz", "vx", "vy", "vz")
TWIST_RATE = ("wdx", "wdy", "wdz", "ax", "ay", "az")
TIME_NAMES = ("time", "t", "timestamp")
SUFFIXES: dict[str, Quantity] = {"position": "q", "velocity": "qd", "acceleration": "qdd"}
_DOTTED: dict[Quantity, str] = {"q": "pos", "qd": "vel", "qdd": "acc"}


@dataclass(frozen=True)
class Signal:
    """One coordinate of the robot: a scalar joint, or a floating joint (7 positions, 6 velocities)."""

    name: str
    kind: Kind


@dataclass(frozen=True)
class Signals:
    """The signals of a robot in coordinate order.

    Args:
        joints: one entry per coordinate; a floating joint is one entry.
        dependent: joints that have no coordinate (mimic, fixed); their columns are accepted and not used.
    """

    joints: tuple[Signal, ...]
    dependent: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        stems = self.positions + self.velocities
        twice = sorted({stem for part in (self.positions, self.velocities) for stem in part if part.count(stem) > 1})
        if twice or any(not stem for stem in stems):
            raise InputError(f"two coordinates would share the column name {twice[0]!r}" if twice else "unnamed joint")

    @cached_property
    def positions(self) -> tuple[str, ...]:
        """Stems of the position columns, e.g. `elbow`; for a floating joint J `J_x J_y J_z J_qx J_qy J_qz J_qw`."""
        return tuple(stem for joint in self.joints for stem in _stems(joint, POSE))

    @cached_property
    def velocities(self) -> tuple[str, ...]:
        """Stems of the velocity columns; for a floating joint J `J_wx J_wy J_wz J_vx J_vy J_vz`.

        w is the angular velocity in body axes, v the rate of the position in parent axes.
        """
        return tuple(stem for joint in self.joints for stem in _stems(joint, TWIST))

    @cached_property
    def accelerations(self) -> tuple[str, ...]:
        """Stems of the bare acceleration columns; for a floating joint J `J_wdx J_wdy J_wdz J_ax J_ay J_az`."""
        return tuple(stem for joint in self.joints for stem in _stems(joint, TWIST_RATE))

    @cached_property
    def names(self) -> dict[str, tuple[Quantity, int]]:
        """Every understood column name without prefix path -> (quantity, index in q, qd or qdd).

        Where two readings of a name collide, `q_<joint>` wins over the joint's bare name, and both over `q<number>`.
        """
        found: dict[str, tuple[Quantity, int]] = {}
        bare = tuple(joint.kind == "floating" for joint in self.joints for _ in _stems(joint, TWIST))
        stems: dict[Quantity, tuple[str, ...]] = {"q": self.positions, "qd": self.velocities, "qdd": self.velocities}
        for quantity, of in stems.items():
            found |= {f"{quantity}_{stem}": (quantity, i) for i, stem in enumerate(of)}
        for i, stem in enumerate(self.positions):
            found.setdefault(stem, ("q", i))
        for i, floating in enumerate(bare):
            if floating:
                found.setdefault(f"qdd_{self.accelerations[i]}", ("qdd", i))
                found.setdefault(self.velocities[i], ("qd", i))
                found.setdefault(self.accelerations[i], ("qdd", i))
        for quantity, of in stems.items():
            for i, stem in enumerate(of):
                found.setdefault(f"{stem}.{_DOTTED[quantity]}", (quantity, i))
        for quantity, of in stems.items():
            for i in range(len(of)):
                found.setdefault(f"{quantity}{i + 1}", (quantity, i))
                found.setdefault(matrix_column(quantity, i), (quantity, i))
        return found

    def find(self, column: str) -> tuple[Quantity, int] | None:
        """The quantity that a column name means, or None."""
        if column in self.names:
            return self.names[column]
        prefix, _, last = column.strip("/").rpartition("/")
        if last not in SUFFIXES:
            return None
        quantity = SUFFIXES[last]
        stems = self.positions if quantity == "q" else self.velocities
        parts = prefix.split("/")
        for start in range(len(parts)):
            stem = "/".join(parts[start:])
            if stem in stems:
                return quantity, stems.index(stem)
        return None

    def is_dependent(self, column: str) -> bool:
        """Whether a column belongs to a joint without a coordinate of its own, or is a torque: known and not used."""
        names = set(self.dependent)
        stem, _, last = column.rpartition(".")
        head, _, rest = column.partition("_")
        parts = column.strip("/").split("/")
        return (
            column in names
            or (head == "tau" and (rest in names or rest in self.velocities))
            or (last in _DOTTED.values() and stem in names)
            or (head in _DOTTED and rest in names)
            or (parts[-1] in SUFFIXES and any("/".join(parts[i:-1]) in names for i in range(len(parts) - 1)))
        )


def matrix_column(quantity: str, index: int) -> str:
    """The name of a column of a matrix in coordinate order, which no joint's name overrides in practice: `q[1]`."""
    return f"{quantity}[{index + 1}]"


def _stems(joint: Signal, parts: tuple[str, ...]) -> list[str]:
    return [f"{joint.name}_{part}" for part in parts] if joint.kind == "floating" else [joint.name]
