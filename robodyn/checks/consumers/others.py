"""What Gazebo, KDL and Isaac Sim alter."""

from __future__ import annotations

from collections.abc import Iterable

from robodyn.checks.consumers.found import Found, part
from robodyn.checks.context import Context
from robodyn.robot.urdf.view import JointView, LinkView


def no_mass(context: Context) -> Iterable[Found]:
    """Return links without mass that a joint moves."""
    return [part(group.links[0]) for group in context.tree.groups[1:] if not group.links[0].mass]


def odd_names(context: Context) -> Iterable[Found]:
    """Return links and joints whose names are no identifiers: of letters, digits and _."""
    parts: tuple[LinkView | JointView, ...] = (*context.view.links, *context.view.joints)
    return [part(one) for one in parts if not one.name.isidentifier()]
