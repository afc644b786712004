"""What loops and contacts carry along a motion, and how far that is determined: frozen data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from robodyn.errors import Caveat
from robodyn.scene.scene import Vector
from robodyn.support.floats import first_largest
from robodyn.support.wording import count, figure, shown

_BASE = frozenset(f"base_{part}{axis}" for part in "wv" for axis in "xyz")
_WHY = {
    "slip": "feet would slip, more friction would do",
    "pull": "contacts had to pull",
    "tip": "the robot tips over",
    "fly": "no contact is on",
}


class Peak(NamedTuple):
    """A value, when [s], and in which row of the data, from 1."""

    value: float
    time: float
    row: int


@dataclass(frozen=True)
class LoopLoad:
    """What one loop bears. force, moment: the largest magnitudes [N, N m]; rms_force, rms_moment: over the whole time.
    determined: whether its wrench is the only one that balances the motion; open: its equations where it is not. gap:
    the largest |phi| [m or rad] of the positions that were given."""

    name: str
    link: str
    to: str
    kind: str
    force: Peak
    moment: Peak
    rms_force: float
    rms_moment: float
    determined: bool
    open: tuple[str, ...]
    gap: float


@dataclass(frozen=True)
class ContactLoad:
    """What one contact bears while it is on.

    Attributes:
        on: part of the samples in which it touches.
        force: the largest magnitude [N]; normal, least_normal: the largest and the least part along the normal [N].
        friction_used: the most of the available friction that its points use together, `sum |f_t| / (mu sum f_n)`;
            None if it is never on.
        margin: the least distance of the centre of pressure from the edges of its polygon [m], negative outside; None
            for a point, and where nothing presses.
        centre: of pressure there, from the middle of the points, in the axes of the ground [m]; None without a margin.
    """

    name: str
    link: str
    points: int
    friction: float
    on: float
    force: Peak
    normal: Peak
    least_normal: Peak
    friction_used: Peak | None
    margin: Peak | None
    centre: Vector | None


@dataclass(frozen=True)
class Unbalanced:
    """The most that a motion takes at a passive joint or at the base, and that nothing gives, with its sign."""

    name: str
    unit: str
    most: Peak


@dataclass(frozen=True)
class Missing:
    """A span of time in which no contact forces balance the motion. kind: "slip" (more friction would do), "pull"
    (contacts had to pull), "tip" (the robot tips over) or "fly" (no contact is on). start, end: s; force, moment:
    largest magnitudes that are missing [N, N m], about the base's origin."""

    kind: str
    start: float
    end: float
    force: Peak
    moment: Peak


@dataclass(frozen=True)
class Constraints:
    """Loops and contacts along a motion.

    Attributes:
        equations, rank: of the loops, and how many of them are independent; overconstrained: those that others imply.
        freedoms: of the robot with its loops; redundancy: actuators beyond the freedoms that they drive.
        undriven: passive joints that move while all drives stand still.
        determined: by joint that drives, whether its torque is the only one that balances the motion; share: how the
            others were chosen, in words.
        unbalanced: at passive joints, and at the base.
        missing: spans without contact forces, the first of them; spans: how many there are.
        singular: times [s] at which loops hold less than elsewhere, of each span the first.
        followed: joints whose motion follows from the loops.
        least_friction: the least coefficient, alike at all contacts, that the motion takes; None without contacts or
            where none suffices.
        beyond_limits: the first time [s] at which no forces that balance the motion keep the effort limits, where they
            are asked to; None without one.
    """

    loops: tuple[LoopLoad, ...]
    contacts: tuple[ContactLoad, ...]
    equations: int
    rank: int
    freedoms: int
    redundancy: int
    overconstrained: int
    undriven: tuple[str, ...]
    determined: Mapping[str, bool]
    share: str
    unbalanced: tuple[Unbalanced, ...]
    missing: tuple[Missing, ...]
    spans: int
    singular: tuple[float, ...]
    followed: tuple[str, ...]
    least_friction: float | None
    beyond_limits: float | None = None

    @property
    def balanced(self) -> bool:
        return not self.unbalanced and not self.missing

    @property
    def caveats(self) -> tuple[Caveat, ...]:
        caveats = []
        if self.missing:
            worst = self.missing[first_largest([each.force.value for each in self.missing])]
            others = f" (and in {count(self.spans - 1, 'more span')})" if self.spans > 1 else ""
            said = (
                f"no contact forces balance the motion from {figure(worst.start)} s to {figure(worst.end)} s{others}: "
                f"{_WHY[worst.kind]}; {figure(worst.force.value)} N and {figure(worst.moment.value)} N m are missing "
                f"at {figure(worst.force.time)} s and {figure(worst.moment.time)} s"
            )
            if joints := [each for each in self.unbalanced if each.name not in _BASE]:
                most = joints[first_largest([abs(each.most.value) for each in joints])]
                more = f", and {len(joints) - 1} more" if len(joints) > 1 else ""
                said += f"; {figure(most.most.value)} {most.unit} at the passive {shown(most.name)}{more}"
            caveats.append(Caveat("as long as something gives the forces that contacts cannot (assumed)", said))
        elif self.unbalanced:
            worst_joint = self.unbalanced[first_largest([abs(each.most.value) for each in self.unbalanced])]
            value, time, _ = worst_joint.most
            others = f", and {len(self.unbalanced) - 1} more" if len(self.unbalanced) > 1 else ""
            said = (
                f"nothing drives {shown(worst_joint.name)}{others}, and the motion takes {figure(value)} "
                f"{worst_joint.unit} there at {figure(time)} s; let it drive, or give a motion that it makes by itself"
            )
            caveats.append(Caveat("as long as something gives what passive joints need (assumed)", said))
        if self.singular:
            times = ", ".join(f"{time:.4g}" for time in self.singular[:4]) + (", ..." if len(self.singular) > 4 else "")
            said = (
                f"the loops lose hold of passive joints at {times} s: torques nearby grow with every error of the "
                "motion, and at such a place they are not determined and taken from beside it"
            )
            caveats.append(Caveat("by torques that are not determined at singular places", said))
        return tuple(caveats)
