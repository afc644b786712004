"""The mass properties that a description declares: of a link, and of the whole robot at a configuration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from robodyn.errors import InputError
from robodyn.programs.vectors import IDENTITY, ZERO, narrowed
from robodyn.robot.kinematics import Pose, Values, beyond_limits, configuration, coordinates, link_poses, named_links
from robodyn.robot.load import assemble, placement
from robodyn.robot.urdf.description import link_named
from robodyn.robot.urdf.parts import Description, Link
from robodyn.solids.inertia.laws import symmetric
from robodyn.solids.inertia.properties import MassProperties, composite, from_inertia
from robodyn.solids.inertia.validity import Validity, validity
from robodyn.support.wording import shown

BASE = "base"
_BASE_POSE = Pose(IDENTITY, ZERO)


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
    """The robot, or some links, as one rigid body in a frame, the joints locked.

    Attributes:
        at: values of the coordinates [rad or m]; warnings: faults of links, and coordinates beyond their limits.
        links: those with an <inertial>, in the order of the file; massive, count: how many have mass, and of how many.
        frame: of `body`, a link or `BASE` where no link has this name; frame_pose: in the frame of the base.
        composite: whether links were chosen.
    """

    name: str
    file: str
    at: Mapping[str, float]
    links: tuple[LinkInertia, ...]
    massive: int
    count: int
    body: MassProperties
    warnings: tuple[str, ...]
    frame: str = BASE
    frame_pose: Pose = _BASE_POSE
    composite: bool = False

    def placed(self, link: LinkInertia) -> MassProperties:
        """The body of a link in the frame."""
        return link.body.placed(*_in_frame(self.frame_pose, link.pose))


def declared(link: Link, pose: Pose | None = None) -> LinkInertia | None:
    """Return what stands in a link's <inertial>, in the link's frame: R I R^T about the origin's xyz; or None."""
    inertial = link.inertial
    if inertial is None:
        return None
    body = from_inertia(inertial.mass, ZERO, symmetric(inertial.inertia)).placed(*placement(inertial.origin))
    return LinkInertia(link.name, link.line, body, validity(body), pose or _BASE_POSE)


def link_inertia(description: Description, name: str) -> LinkInertia:
    """Return what is declared of a link, in its own frame; InputError without such a link, or its <inertial>."""
    link = link_named(description, name)
    found = declared(link)
    if found is None:
        what, remedy = f"link {shown(name)} has no <inertial>", "--geometry takes its shapes instead"
        raise InputError(what, remedy=remedy, file=description.file, line=link.line)
    return found


def robot_inertia(
    description: Description, at: Values = (), links: Sequence[str] = (), frame: str = BASE
) -> RobotInertia:
    """Return all links, or some, as one rigid body in the frame of the base or of a link: the composite of their bodies
    at their poses.

    Method: forward kinematics in floats, then the laws in fractions (see `composite`). Links that no body could be are
    added as declared, with a warning. `at`: values of all coordinates, or of some by name [rad or m]; the others are 0.

    Raises: InputError: a link or joint that is none, or no mass.

    Accuracy: mass correctly rounded; centre of mass and inertia within 1e-14 of the robot's size and largest moment for
        twenty joints in a row.
    """
    model = assemble(description)
    q = configuration(model, at)
    where, chosen = link_poses(model, q), named_links(model, links) or tuple(model.links)
    stand = _BASE_POSE if frame == BASE not in where else where[named_links(model, [frame])[0]]
    found = (declared(link, where[link.name]) for link in description.links if link.name in chosen)
    bodies = tuple(link for link in found if link is not None)
    massive = sum(link.name in chosen for link in description.massive)
    if not massive:
        what = "the links have no mass" if links else "the robot has no mass"
        raise InputError(what, remedy="give links an <inertial>", file=description.file)
    body = composite((link.body, _in_frame(stand, link.pose)) for link in bodies)
    values = dict(zip(model.coordinates, q.tolist(), strict=True))
    given = {name: values[name] for name in coordinates(model)}
    warnings = (*(warning for link in bodies for warning in link.warnings), *beyond_limits(model, q))
    count = len(chosen) if links else len(description.links)
    rest = (massive, count, body, warnings, frame, stand, bool(links))
    return RobotInertia(description.name, description.file, given, bodies, *rest)


def _in_frame(frame: Pose, pose: Pose) -> Pose:
    return pose if frame is _BASE_POSE else Pose(*map(narrowed, frame.inverse.after(pose)))
