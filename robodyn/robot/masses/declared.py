"""The mass properties that a description declares: of a link, and of the whole robot at a configuration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from robodyn.errors import InputError
from robodyn.programs.vectors import IDENTITY, ZERO
from robodyn.robot.kinematics import Pose, Values, beyond_limits, configuration, coordinates, link_poses
from robodyn.robot.load import assemble, placement
from robodyn.robot.urdf.description import link_named
from robodyn.robot.urdf.parts import Description, Link
from robodyn.solids.inertia.laws import symmetric
from robodyn.solids.inertia.properties import MassProperties, composite, from_inertia
from robodyn.solids.inertia.validity import Validity, validity
from robodyn.support.wording import shown


@dataclass(frozen=True, eq=False)
class LinkInertia:
    """What is declared of one link: the body in the link's frame, whose pose is in the base's, or itself if asked for
    alone."""

    name: str
    line: int
    body: MassProperties
    validity: Validity
    pose: Pose

    @property
    def placed(self) -> MassProperties:
        """The body in the base's frame."""
        return self.body.placed(*self.pose)

    @property
    def faults(self) -> tuple[str, ...]:
        """Why no body can have these properties; nothing is asked of a link without mass and inertia."""
        return self.validity.faults if self.body.mass or self.body.S_c.any() else ()

    @property
    def warnings(self) -> tuple[str, ...]:
        """The faults with the place of the link."""
        return tuple(f"link {shown(self.name)} (line {self.line}): {fault}" for fault in self.faults)


@dataclass(frozen=True, eq=False)
class RobotInertia:
    """The robot as one rigid body, in the frame of the base, its joints locked.

    Attributes:
        at: values of the coordinates [rad or m]; warnings: faults of links, and coordinates beyond their limits.
        links: those with an <inertial>, in the order of the file; massive, count: how many have mass, and of how many.
    """

    name: str
    file: str
    at: Mapping[str, float]
    links: tuple[LinkInertia, ...]
    massive: int
    count: int
    body: MassProperties
    warnings: tuple[str, ...]


def declared(link: Link, pose: Pose | None = None) -> LinkInertia | None:
    """Return what stands in a link's <inertial>, in the link's frame: R I R^T about the origin's xyz; or None."""
    inertial = link.inertial
    if inertial is None:
        return None
    body = from_inertia(inertial.mass, ZERO, symmetric(inertial.inertia)).placed(*placement(inertial.origin))
    return LinkInertia(link.name, link.line, body, validity(body), pose or Pose(IDENTITY, ZERO))


def link_inertia(description: Description, name: str) -> LinkInertia:
    """Return what is declared of a link, in its own frame; InputError without such a link, or its <inertial>."""
    link = link_named(description, name)
    found = declared(link)
    if found is None:
        what, remedy = f"link {shown(name)} has no <inertial>", "--geometry takes its shapes instead"
        raise InputError(what, remedy=remedy, file=description.file, line=link.line)
    return found


def robot_inertia(description: Description, at: Values = ()) -> RobotInertia:
    """Return all links as one rigid body in the frame of the base: the composite of their bodies at their poses.

    Method: forward kinematics in floats, then the laws in fractions (see `composite`). Links that no body could be are
    added as declared, with a warning. `at`: values of all coordinates, or of some by name [rad or m]; the others are 0.

    Accuracy: mass correctly rounded; centre of mass and inertia within 1e-14 of the robot's size and largest moment for
        twenty joints in a row.
    """
    model = assemble(description)
    q = configuration(model, at)
    where = link_poses(model, q)
    found = (declared(link, where[link.name]) for link in description.links if link.name in where)
    links = tuple(link for link in found if link is not None)
    if not description.massive:
        raise InputError("the robot has no mass", remedy="give links an <inertial>", file=description.file)
    body = composite((link.body, link.pose) for link in links)
    values = dict(zip(model.coordinates, q.tolist(), strict=True))
    given = {name: values[name] for name in coordinates(model)}
    warnings = (*(warning for link in links for warning in link.warnings), *beyond_limits(model, q))
    massive, count = len(description.massive), len(description.links)
    return RobotInertia(description.name, description.file, given, links, massive, count, body, warnings)
