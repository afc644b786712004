"""What a free-body diagram holds: bodies cut free, and every force and moment that then acts on them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from robodyn.programs.vectors import cross
from robodyn.robot.kinematics import Pose, Wrench
from robodyn.support.floats import Floats


@dataclass(frozen=True, eq=False)
class Action:
    """A force and a moment on a body, in the body's axes.

    Attributes:
        kind: "weight", "inertial", "reaction", "drive", "viscous friction", "coulomb friction", "rotor inertia",
            "coupled motor", "gyroscopic moment", "joint spring", "external wrench" or "fluid".
        what: in words; by: the body, joint or thing that exerts it.
        symbols: of the force and of the moment; a joint's have its number, and a minus sign on the parent.
        point: (3,) where the force acts, from the body's origin [m].
        force: (3,) N.
        moment: (3,) N m, besides that of the force.
    """

    kind: str
    what: str
    by: str
    symbols: tuple[str, str]
    point: Floats
    force: Floats
    moment: Floats

    @property
    def at_origin(self) -> Floats:
        """The moment about the body's origin [N m]."""
        return self.moment + cross(self.point, self.force)


@dataclass(frozen=True, eq=False)
class FreeBody:
    """One body with all that acts on it.

    Attributes:
        number: its place in the model, which is also its joint's number.
        links: of the description that move as this body.
        com: (3,) mass centre in the body's frame [m].
        pose: rotation and origin of the body's frame in the ground's.
        actions: their forces and moments add up to zero.
        ends: (number, point) of the joints of the bodies that it carries, in its frame [m].
    """

    number: int
    name: str
    links: tuple[str, ...]
    mass: float
    com: Floats
    pose: Pose
    actions: tuple[Action, ...]
    ends: tuple[tuple[int, Floats], ...]

    @property
    def force(self) -> Floats:
        total: Floats = np.array([action.force for action in self.actions]).sum(axis=0)
        return total

    @property
    def moment(self) -> Floats:
        """The sum of the moments about the body's origin [N m]."""
        total: Floats = np.array([action.at_origin for action in self.actions]).sum(axis=0)
        return total


@dataclass(frozen=True, eq=False)
class JointRow:
    """A joint as an engineer counts it: f degrees of freedom and 6 - f reactions.

    Attributes:
        number: of the body that it carries; parent, child: names of bodies ("ground" below the base).
        kind: "fixed" (the base only), "revolute", "prismatic" or "floating".
        axis: (3,) in the child's axes, zeros without one.
        wrench: on the child, all of it, in its axes at its origin; force, moment: (3,) what the joint's surfaces
            transmit of it [N, N m]; nothing along the axis of a hinge (moment) or slide (force).
        drive: along the axis, what the actuator supplies there [N m or N]; None without an axis.
        others: by effect, what takes up part of the drive.
    """

    number: int
    name: str
    parent: str
    child: str
    kind: str
    axis: Floats
    wrench: Wrench
    force: Floats
    moment: Floats
    drive: float | None
    others: Mapping[str, float]

    @property
    def freedom(self) -> int:
        """f."""
        return {"fixed": 0, "floating": 6}.get(self.kind, 1)

    @property
    def reactions(self) -> int:
        """6 - f."""
        return 6 - self.freedom


@dataclass(frozen=True, eq=False)
class FreeBodies:
    """A robot in one state, taken apart.

    Attributes:
        q, qd, qdd: the state, in the model's order; gravity: m/s^2, in the ground's axes.
        tau: (n,) along the coordinates, the drives of followers reflected onto their leaders [N m or N].
        residual_force, residual_moment: the largest sum on any body, of the largest single force and moment on any.
    """

    robot: str
    file: str
    q: dict[str, float]
    qd: dict[str, float]
    qdd: dict[str, float]
    gravity: tuple[float, float, float]
    bodies: tuple[FreeBody, ...]
    joints: tuple[JointRow, ...]
    tau: dict[str, float]
    residual_force: float
    residual_moment: float
    warnings: tuple[str, ...]
