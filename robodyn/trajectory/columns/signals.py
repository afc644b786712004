"""What the robot wants to read: one signal per coordinate, and the names its columns may have."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

from robodyn.errors import InputError
from robodyn.trajectory.columns.units import split_unit, unit_of

Kind = Literal["angle", "continuous", "length", "floating"]
Quantity = Literal["q", "qd", "qdd", "tau"]
Place = tuple[Quantity, int]

POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
TWIST = ("wx", "wy", "wz", "vx", "vy", "vz")
TWIST_RATE = ("wdx", "wdy", "wdz", "ax", "ay", "az")
COMPONENTS = ("fx", "fy", "fz", "mx", "my", "mz")
"""Of a wrench, in the order of its columns."""
TIME_NAMES = ("time", "t", "timestamp")
MEASURED: dict[Quantity, str] = {"q": "position", "qd": "velocity", "qdd": "acceleration", "tau": "torque"}
WORDS: dict[str, Quantity] = {
    **dict.fromkeys(("q", "pos", "position", "positions", "angle"), "q"),
    **dict.fromkeys(("qd", "dq", "vel", "velocity", "velocities"), "qd"),
    **dict.fromkeys(("qdd", "ddq", "acc", "acceleration", "accelerations"), "qdd"),
    **dict.fromkeys(("tau", "eff", "effort", "efforts", "torque"), "tau"),
}
"""Words before or behind a joint's name, with `_`, `.`, `/` or a blank between: `/states/elbow/velocity`."""
ANY_WORD = rf"(?P<word>(?i:{'|'.join(sorted(WORDS, key=len, reverse=True))}))"
_WORDED = (re.compile(rf"(?:.*[./])?{ANY_WORD}[_./ -](?P<stem>.+)"), re.compile(rf"(?P<stem>.+)[_./ -]{ANY_WORD}"))


@dataclass(frozen=True)
class Signal:
    """One coordinate of the robot: a scalar joint, or a floating joint (7 positions, 6 velocities).

    Attributes:
        lower, upper: limits of the position that count, infinite where there is none; speed: of the velocity.
    """

    name: str
    kind: Kind
    lower: float = -math.inf
    upper: float = math.inf
    speed: float = math.inf


class Meaning(NamedTuple):
    """What a column holds: a quantity and an index in it, None of a joint without a coordinate; and the unit's text, if
    its name tells one."""

    place: Place | None
    unit: str | None = None


@dataclass(frozen=True)
class Signals:
    """The signals of a robot in coordinate order.

    Args:
        dependent: joints that have no coordinate (mimic, fixed); their columns are accepted and not used.
        looped: joints that move a loop: those without columns follow from it.
        constraints: loops and contacts, whose wrenches may have columns, which are not used.
    """

    joints: tuple[Signal, ...]
    dependent: tuple[str, ...] = ()
    looped: tuple[str, ...] = ()
    constraints: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        stems = self.positions + self.velocities
        twice = sorted({stem for part in (self.positions, self.velocities) for stem in part if part.count(stem) > 1})
        if twice or any(not stem for stem in stems):
            raise InputError(f"two coordinates would share the column name {twice[0]!r}" if twice else "unnamed joint")

    @cached_property
    def positions(self) -> tuple[str, ...]:
        """Stems of the position columns, e.g. `elbow`; for a floating joint J `J_x J_y J_z J_qx J_qy J_qz J_qw`."""
        return self._stems(POSE)

    @cached_property
    def velocities(self) -> tuple[str, ...]:
        """Stems of the velocity columns; for a floating joint J `J_wx J_wy J_wz J_vx J_vy J_vz`, w in body axes, v the
        rate of the position in parent axes."""
        return self._stems(TWIST)

    @cached_property
    def accelerations(self) -> tuple[str, ...]:
        """Stems of the bare acceleration columns; for a floating joint J `J_wdx J_wdy J_wdz J_ax J_ay J_az`."""
        return self._stems(TWIST_RATE)

    def _stems(self, parts: Sequence[str]) -> tuple[str, ...]:
        stems: list[str] = []
        for joint in self.joints:
            stems += [f"{joint.name}_{part}" for part in parts] if joint.kind == "floating" else [joint.name]
        return tuple(stems)

    @cached_property
    def spans(self) -> dict[str, tuple[range, range]]:
        """Name of each joint -> its indices in q, and in qd and qdd."""
        found: dict[str, tuple[range, range]] = {}
        q = qd = 0
        for joint in self.joints:
            of = (len(POSE), len(TWIST)) if joint.kind == "floating" else (1, 1)
            found[joint.name] = range(q, q + of[0]), range(qd, qd + of[1])
            q, qd = q + of[0], qd + of[1]
        return found

    @cached_property
    def rest(self) -> tuple[float, ...]:
        """The position nearest to zero within the limits; of a floating joint at its place and not turned."""
        found: list[float] = []
        for joint in self.joints:
            found += (0.0,) * 6 + (1.0,) if joint.kind == "floating" else (min(max(0.0, joint.lower), joint.upper),)
        return tuple(found)

    @cached_property
    def kinds(self) -> dict[str, str]:
        """What each stem of a position or velocity measures: "angle", "length", or "" for parts of quaternions."""
        kinds = ("length",) * 3 + ("",) * 4 + ("angle",) * 3 + ("length",) * 3
        found: dict[str, str] = {}
        for joint in self.joints:
            if joint.kind == "floating":
                found |= {f"{joint.name}_{part}": kind for part, kind in zip((*POSE, *TWIST), kinds, strict=True)}
            else:
                found[joint.name] = "length" if joint.kind == "length" else "angle"
        return found

    @cached_property
    def names(self) -> dict[str, Meaning]:
        """Our own column names: `q_<joint>` wins over the joint's bare name, and both over `q<number>`."""
        found: dict[str, Meaning] = {}
        stems: dict[Quantity, tuple[str, ...]] = {"q": self.positions, "qd": self.velocities, "qdd": self.velocities}
        for quantity, of in stems.items():
            found |= {f"{quantity}_{stem}": Meaning((quantity, i)) for i, stem in enumerate(of)}
        for i, stem in enumerate(self.positions):
            found.setdefault(stem, Meaning(("q", i)))
        for i, stem in enumerate(self.velocities):
            if stem != self.accelerations[i]:  # of a floating joint
                found.setdefault(f"qdd_{self.accelerations[i]}", Meaning(("qdd", i)))
                found.setdefault(stem, Meaning(("qd", i)))
                found.setdefault(self.accelerations[i], Meaning(("qdd", i)))
        for quantity, of in stems.items():
            for i in range(len(of)):
                found.setdefault(f"{quantity}{i + 1}", Meaning((quantity, i)))
                found.setdefault(matrix_column(quantity, i), Meaning((quantity, i)))
        return found

    @cached_property
    def wrenches(self) -> frozenset[str]:
        """The columns of the constraints' wrenches."""
        return frozenset(f"{part}_{name}" for name in self.constraints for part in COMPONENTS)

    def find(self, column: str) -> Meaning | None:
        """What a column of this name holds, None if the robot does not know it: by our own names, by words beside a
        joint's name, then by the same before a unit that is not of time."""
        if found := self._find(column):
            return found
        for name, text in split_unit(column):
            unit = unit_of(text)
            if (unit is None or unit.dimension != "time") and (found := self._find(name)):
                return found._replace(unit=text)
        return None

    def _find(self, column: str) -> Meaning | None:
        if column in self.names:
            return self.names[column]
        if column in self.dependent:
            return Meaning(None)
        for quantity, stem in worded(column):
            stems = self.positions if quantity == "q" else self.velocities
            # with and without what stands before slashes and points
            for end in (stem, *(stem[found.end() :] for found in re.finditer(r"[/.]", stem))):
                if end in stems:
                    return Meaning((quantity, stems.index(end)))
                if end in self.dependent:
                    return Meaning(None)
        return None


def worded(column: str) -> Iterator[tuple[Quantity, str]]:
    """Yield the readings of a name as a word for a quantity and the rest, which should name a joint."""
    for pattern in _WORDED:
        if found := pattern.fullmatch(column):
            yield WORDS[found["word"].lower()], found["stem"]


def matrix_column(quantity: str, index: int) -> str:
    """The name of a column of a matrix in coordinate order, which no joint's name overrides in practice: `q[1]`."""
    return f"{quantity}[{index + 1}]"
