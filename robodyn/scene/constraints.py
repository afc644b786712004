"""What holds a robot in a scene: loops that close chains, and contacts that links stand on."""

from __future__ import annotations

from dataclasses import dataclass

from robodyn.scene.parts import Vector
from robodyn.support.frozen import FrozenValue

GROUND = "ground"
"""What a loop calls the ground, where no link of the robot has that name."""


@dataclass(frozen=True)
class Loop(FrozenValue):
    """A closure, by which the tree of links that a description is becomes a closed chain.

    Attributes:
        name: as reports call it.
        link, point: a point of this link, in its frame [m], is held at
        to, to_point: a point of that link, in its frame [m]; `to` may be GROUND.
        kind: "point", a ball joint of 3 equations; "hinge", of 5; or "weld", of 6.
        axis, to_axis: of a hinge, in the axes of `link` and of `to`.
        rpy: of a weld, how `link` is turned in the axes of `to` [rad].
        directions: of a point, the directions in the axes of `to` along which it is held; all if empty.
    """

    name: str
    link: str
    point: Vector = (0.0, 0.0, 0.0)
    to: str = GROUND
    to_point: Vector = (0.0, 0.0, 0.0)
    kind: str = "point"
    axis: Vector = (0.0, 0.0, 0.0)
    to_axis: Vector = (0.0, 0.0, 0.0)
    rpy: Vector = (0.0, 0.0, 0.0)
    directions: tuple[Vector, ...] = ()


ALWAYS, AUTO = "always", "auto"
"""Of a contact, `on`: in every sample, or where its points are low and slow."""


@dataclass(frozen=True)
class Contact(FrozenValue):
    """Where a link stands on something, which presses on it and rubs, and does not pull.

    Attributes:
        name: as reports call it.
        link, points: the points of the link that may touch, in its frame [m]: one, or the corners of a polygon.
        normal: in the axes of the ground, out of what it stands on; None: against gravity.
        friction: coefficient of Coulomb's cone.
        on: ALWAYS; AUTO; the name of a column that is not 0 where it touches; or intervals of time (from, to) [s].
        level, height, speed: with AUTO each of its points touches where it is at most `height` [m] above the plane
            `normal . p = level` [m] and slower than `speed` [m/s].
    """

    name: str
    link: str
    points: tuple[Vector, ...] = ((0.0, 0.0, 0.0),)
    normal: Vector | None = None
    friction: float = 0.7
    on: str | tuple[tuple[float, float], ...] = ALWAYS
    level: float = 0.0
    height: float = 0.01
    speed: float = 0.1

    @property
    def columns(self) -> tuple[str, ...]:
        """The trajectory columns that it needs."""
        return (self.on,) if isinstance(self.on, str) and self.on not in (ALWAYS, AUTO) else ()


@dataclass(frozen=True)
class ContactCost(FrozenValue):
    """What contact forces make least, of all that balance: `forces |f|^2 / W^2 + torques sum (tau / limit)^2`.

    Attributes:
        forces, torques: weights of the forces, relative to the robot's weight W, and of torques relative to limits.
        within_limits: whether torques may not exceed the effort limits.
    """

    forces: float = 1.0
    torques: float = 0.0
    within_limits: bool = False


LEAST_FORCES = ContactCost()
EFFORT = "effort"
"""As a weight: 1 / (effort limit)^2."""
