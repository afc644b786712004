"""Where a description has what some program does not take as it is.

That meshes cannot be read is reported only of programs that are asked for: nearly every robot has some.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from os.path import splitext
from typing import NamedTuple

from robodyn.checks.bodies.masses import principal_moments
from robodyn.checks.context import Context
from robodyn.checks.meshes.files import MeshUse, State, mesh_names, mesh_uses
from robodyn.robot.urdf.elements import Element, Span
from robodyn.robot.urdf.view import JointView, LinkView

Found = tuple[Span, str]
"""A place, and what is there."""
Find = Callable[[Context], Iterable[Found]]
_TINY = 1e-15
_SLACK = 1e-6
_FREEDOM = {"fixed": 0, "planar": 3, "floating": 6}


def _part(part: LinkView | JointView, element: Element | None = None) -> Found:
    """Return a link or joint at its start tag, or at that of an element in it."""
    return (element or part.element).span, f"{part.subject.kind} '{part.name}'"


def massless(context: Context) -> Iterator[Found]:
    """Yield rigid groups that a joint moves, without mass or without moments of inertia."""
    for group in context.tree.groups[1:]:
        heavy = [link for link in group.links if link.mass]
        inert = len(heavy) > 1 or any(any(link.tensor or ()) for link in heavy)
        if group.mass is not None and (group.mass <= _TINY or not inert):
            yield _part(group.links[0])


def no_mass(context: Context) -> Iterable[Found]:
    """Return links without mass that a joint moves."""
    return [_part(group.links[0]) for group in context.tree.groups[1:] if not group.links[0].mass]


def unphysical(context: Context) -> Iterator[Found]:
    """Yield tensors that no body has, also of the root and of links without mass; a tensor of zeros counts as none."""
    for link in context.tree.links:
        if link.inertial is None or link.tensor is None or not any(link.tensor):
            continue
        small, middle, large = principal_moments(link.tensor)
        if small <= 0.0 or small + middle < (1.0 - _SLACK) * large:
            yield _part(link, link.inertial.element)


def no_tensor(context: Context) -> Iterator[Found]:
    for link in context.view.links:
        inertial = link.inertial
        if inertial is not None and (inertial.inertia_element is None or inertial.mass_element is None):
            yield _part(link, inertial.element)


def root(holds: Callable[[LinkView], object]) -> Find:
    """Return the root, if something holds of it."""
    return lambda context: [_part(context.tree.root)] if holds(context.tree.root) else []


def joints(holds: Callable[[JointView], object]) -> Find:
    """Return the joints of which something holds."""
    return lambda context: [_part(joint) for joint in context.view.joints if holds(joint)]


def ranges(holds: Callable[[float, float], bool]) -> Find:
    """Return the joints of whose lower and upper limit something holds."""

    def limited(joint: JointView) -> bool:
        limit = joint.limit if joint.type in ("revolute", "prismatic") else None
        return limit is not None and limit.range is not None and holds(*limit.range)

    return joints(limited)


def friction(context: Context) -> Iterable[Found]:
    return [(joint.friction.span, _part(joint)[1]) for joint in context.view.joints if joint.friction.value]


def mimic_leader(context: Context) -> Iterator[Found]:
    """Yield mimic joints whose leader is not there, or does not have as many degrees of freedom."""
    for joint in context.view.joints:
        if joint.mimic is None:
            continue
        leader = context.view.joint.get(joint.mimic.joint)
        if leader is None or _FREEDOM.get(leader.type, 1) != _FREEDOM.get(joint.type, 1):
            yield _part(joint, joint.mimic.element)


def nameless(context: Context) -> Iterable[Found]:
    """Return the robot, where it has no name."""
    return [] if context.view.root.get("name") else [(context.view.root.span, "the robot")]


def odd_names(context: Context) -> Iterable[Found]:
    """Return links and joints whose names are no identifiers: of letters, digits and _."""
    parts: tuple[LinkView | JointView, ...] = (*context.view.links, *context.view.joints)
    return [_part(part) for part in parts if not part.name.isidentifier()]


class Reads(NamedTuple):
    """Suffixes that a program reads, what it does with others, how that is known, and for which kinds of shapes."""

    suffixes: tuple[str, ...]
    otherwise: str
    source: str
    kinds: tuple[str, ...] = ("visual", "collision")


READS: Mapping[str, Reads] = {
    "mujoco": Reads((".stl", ".obj", ".msh"), "rejects the file", "MuJoCo 4.0, run", ("collision",)),
    "drake": Reads((".obj", ".gltf", ".vtk"), "rejects the file", "Drake 1.51, run", ("collision",)),
    "gz": Reads((".stl", ".dae", ".obj", ".gltf", ".glb", ".fbx"), "leaves the shape out", "gz-common 6, MeshManager"),
}


def unread(context: Context, target: str) -> dict[str, list[MeshUse]]:
    """Return the shapes whose mesh a program does not read, by the suffix."""
    found: dict[str, list[MeshUse]] = {}
    reads = READS.get(target)
    for name in context.once(mesh_names).values() if reads else ():
        suffix = splitext(name.uri)[1].lower()
        uses = [use for use in name.uses if reads and use.geometry.kind in reads.kinds]
        if uses and reads and suffix not in reads.suffixes:
            found.setdefault(suffix, []).extend(uses)
    return found


def unread_meshes(target: str) -> Find:
    """Return meshes in a format that a program does not read."""

    def find(context: Context) -> Iterator[Found]:
        for suffix, uses in unread(context, target).items() if target in context.asked.targets else ():
            yield from (_use(use, suffix or "no suffix") for use in uses)

    return find


def missing_meshes(target: str, *kinds: str) -> Find:
    """Return meshes that are not there."""

    def find(context: Context) -> Iterator[Found]:
        for name in context.once(mesh_names).values() if target in context.asked.targets else ():
            if name.state in (State.MISSING, State.OTHER_CASE):
                yield from (_use(use, name.uri) for use in name.uses if use.geometry.kind in kinds)

    return find


def uris(context: Context) -> Iterator[Found]:
    """Yield meshes to collide with that are named by a URI, where MuJoCo is not told to strip it."""
    extension = context.view.root.find("mujoco")
    compiler = None if extension is None else extension.find("compiler")
    if "mujoco" not in context.asked.targets or (compiler is not None and compiler.get("strippath") == "true"):
        return
    for use in mesh_uses(context):
        if "://" in use.uri and use.geometry.kind in READS["mujoco"].kinds:
            yield _use(use, use.uri)


def visuals(context: Context) -> Iterator[Found]:
    for link in context.view.links:
        visual = [geometry for geometry in link.geometries if geometry.kind == "visual"]
        yield from ((geometry.element.span, f"link '{link.name}'") for geometry in visual)


def _use(use: MeshUse, what: str) -> Found:
    return use.at, f"{what} in the {use.geometry.kind} of link '{use.link.name}'"
