"""What other programs do to descriptions: a table of facts about links, joints and shapes.

Each row was learnt by running the program or from what it documents; of MuJoCo and Drake they hold for every version
that was run. The table is not complete: what is refused for how it is written, for meshes, materials or transmissions,
and what is changed, the program itself tells where it is installed; see `robodyn.checks.imported`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from enum import IntEnum
from math import hypot
from os.path import splitext
from typing import NamedTuple

from robodyn.checks.bodies.masses import inertia_together, principal_moments
from robodyn.checks.context import Context
from robodyn.checks.meshes.files import MeshUse, mesh_names
from robodyn.robot.masses.mistakes import UPPER
from robodyn.robot.urdf.document import Span
from robodyn.robot.urdf.parts import WITH_AXIS, WITH_RANGE
from robodyn.robot.urdf.view import GeometryView, JointView, LimitView, LinkView

_LEAST_MASS, _LEAST_MOMENT = 1e-15, 1e-14  # MuJoCo: kg, and principal moments [kg m^2]
_ROUNDING = 1e-15  # of principal moments, relative; within it a program's own rounding decides
_LEAST_GAZEBO = 1e-6  # kg
_LIMITED = ("revolute", "continuous", "prismatic")
Found = tuple[Span, str]  # a place, and what is there
Find = Callable[[Context], Iterable[Found]]


class Verdict(IntEnum):
    """From good to bad."""

    LOADS = 0
    ALTERS = 1
    REJECTS = 2


class Fact(NamedTuple):
    """One thing that a program does: to what (`find`), what (`does`), and how that is known (`source`)."""

    target: str
    verdict: Verdict
    does: str
    source: str
    find: Find


class Reads(NamedTuple):
    """Suffixes that a program reads, what it does with others, how that is known, and for which kinds of shapes."""

    suffixes: tuple[str, ...]
    otherwise: str
    source: str
    kinds: tuple[str, ...] = ("visual", "collision")


READS: Mapping[str, Reads] = {
    "mujoco": Reads((".stl", ".obj", ".msh"), "rejects the file", "MuJoCo 2.3, 3.1 and 4.0, run", ("collision",)),
    "drake": Reads((".obj", ".gltf", ".vtk"), "rejects the file", "Drake 1.30 and 1.51, run", ("collision",)),
    "gz": Reads((".stl", ".dae", ".obj", ".gltf", ".glb", ".fbx"), "leaves the shape out", "gz-common 6, MeshManager"),
}


def unread(context: Context, target: str) -> dict[str, list[MeshUse]]:
    """Shapes whose mesh a program does not read, by the suffix."""
    found: dict[str, list[MeshUse]] = {}
    if (reads := READS.get(target)) is not None:
        for name in context.once(mesh_names).values():
            suffix = splitext(name.uri)[1].lower()
            for use in name.uses:
                if use.geometry.kind in reads.kinds and suffix not in reads.suffixes:
                    found.setdefault(suffix, []).append(use)
    return found


def named(of: LinkView | JointView) -> str:
    return f"{of.subject.kind} '{of.name}'"


def _part(of: LinkView | JointView) -> Found:
    return of.element.span, named(of)


def _inertials(holds: Callable[[Context, LinkView], object]) -> Find:
    return lambda context: [
        (link.inertial.element.span, named(link))
        for link in context.tree.links
        if link.inertial is not None and holds(context, link)
    ]


def _joints(holds: Callable[[JointView], object]) -> Find:
    return lambda context: [_part(joint) for joint in context.view.joints if holds(joint)]


def _limits(types: Collection[str], holds: Callable[[LimitView], object]) -> Find:
    return _joints(lambda joint: joint.type in types and joint.limit is not None and holds(joint.limit))


def _root(holds: Callable[[LinkView], object]) -> Find:
    return lambda context: [_part(context.tree.root)] if holds(context.tree.root) else []


def _axis_shorter_than(least: float) -> Find:
    return _joints(lambda joint: joint.type in WITH_AXIS and hypot(*(joint.axis.values or (1.0,))) < least)


def _shapes(kind: str, words: str, holds: Callable[[Context, GeometryView], bool]) -> Find:
    return lambda context: [
        (shape.element.span, f"{words}{named(link)}")
        for link in context.view.links
        for shape in link.geometries
        if shape.kind == kind and holds(context, shape)
    ]


def _nameless(context: Context) -> list[Found]:
    return [] if context.view.root.get("name") else [(context.view.root.span, "the robot")]


def _compiler(context: Context) -> Mapping[str, str]:
    """Attributes of <mujoco><compiler>, by which a description tells MuJoCo how to read it."""
    extension = context.view.root.find("mujoco")
    element = None if extension is None else extension.find("compiler")
    return {} if element is None else element.values


def _unphysical(context: Context, link: LinkView) -> bool:
    """Whether MuJoCo refuses the tensor; one of zeros counts as none."""
    tensor = link.tensor
    if tensor is None or not any(tensor):
        return False
    along_axes = not (tensor[1] or tensor[2] or tensor[4])
    small, middle, large = sorted((tensor[0], tensor[3], tensor[5])) if along_axes else principal_moments(tensor)
    room = 0.0 if along_axes else _ROUNDING * large
    balanced = _compiler(context).get("balanceinertia") == "true"
    return small < _LEAST_MOMENT or (small + middle < large - room and not balanced)


def _inferred(link: LinkView) -> bool:
    """Whether MuJoCo makes up the mass of a link."""
    return link.inertial is None and any(one.kind == "collision" and one.shape is not None for one in link.geometries)


def _massless(context: Context) -> Iterator[Found]:
    """Moving rigid groups in which nothing has, or is given, mass and moments of inertia."""
    for group in context.tree.groups[1:]:
        told = [
            _inferred(link)
            or _unphysical(context, link)
            or (link.inertial is not None and (link.mass is None or link.tensor is None))
            or ((link.mass or 0.0) >= _LEAST_MASS and any(link.tensor or ()))
            for link in group.links
        ]
        if not any(told) and not {"boundmass", "boundinertia", "inertiafromgeom"} & _compiler(context).keys():
            yield _part(group.links[0])


def _turned(limit: LimitView) -> bool:
    lower, upper = limit.lower.value, limit.upper.value
    return lower is not None and upper is not None and lower > upper


def _weightless(context: Context) -> frozenset[str]:
    """Links that Gazebo drops, with all behind them: they and what is fixed to them have no mass; but a root called
    world."""
    mass = dict.fromkeys(context.view.link, 0.0)
    for link in reversed(context.tree.links):
        mass[link.name] += link.mass or 0.0
        joint = context.tree.above.get(link.name)
        if joint is not None and not joint.moves:
            mass[joint.parent] += mass[link.name]
    return frozenset(name for name, whole in mass.items() if abs(whole) <= _LEAST_GAZEBO) - {"world"}


def _dropped(context: Context) -> list[Found]:
    """Links that are left out and take a joint with them."""
    moved = {name for joint in context.view.joints if joint.moves for name in (joint.parent, joint.child)}
    dropped = moved & _weightless(context)
    return [_part(link) for link in context.tree.links if link.name in dropped]


def _unphysical_groups(context: Context) -> Iterator[Found]:
    """Rigid groups whose mass or inertia no body has; where all of it can be read."""
    for links in (group.links for group in context.tree.groups):
        doubtful = any((link.mass or 0.0) < 0 or _unphysical(context, link) for link in links)
        whole = inertia_together(context, links) if doubtful else None
        if whole is not None and abs(whole.m) > _LEAST_GAZEBO:
            tensor = tuple(whole.about_centre[UPPER].tolist()) if links[1:] else links[0].tensor or ()
            small, middle, large = principal_moments(tensor)
            if whole.m < 0 or small < -_ROUNDING * large or small + middle < (1.0 - 2.0 * _ROUNDING) * large:
                yield _part(links[0])


def _malformed(joint: JointView) -> bool:
    if joint.limit is None or joint.type not in WITH_RANGE:
        return joint.type in WITH_RANGE
    needed = joint.limit.effort, joint.limit.velocity
    return not all(one.given for one in needed) or any(
        one.problem for one in (joint.limit.lower, joint.limit.upper, *needed)
    )


_MIMIC = _joints(lambda joint: joint.mimic)
_FIXED = _joints(lambda joint: joint.type == "fixed")
_UNACTUATED = _joints(lambda joint: joint.type in ("floating", "planar"))
_HEAVY_ROOT = _root(lambda link: link.mass)
_REFUSED_TENSOR = _inertials(_unphysical)
_INCOMPLETE = _inertials(
    lambda _, link: link.inertial and None in (link.inertial.inertia_element, link.inertial.mass_element)
)
_MUJOCO, _DRAKE = "MuJoCo 2.3, 3.1 and 4.0, run", "Drake 1.30 and 1.51, run"
_GAZEBO, _KDL = "sdformat 12.3 with urdfdom 3.0, run", "kdl_parser.cpp"
_ISAAC = "Isaac Sim 5, URDF importer and its ImportConfig"
_TABLE: Mapping[tuple[str, Verdict, str], Mapping[str, Find]] = {
    ("mujoco", Verdict.REJECTS, _MUJOCO): {
        "requires mass and inertia in what moves": _massless,
        "requires principal moments of 1e-14 kg m^2 or more, no two of them below the third": _REFUSED_TENSOR,
        "requires <mass> and <inertia> in <inertial>": _INCOMPLETE,
        "requires an axis of 1e-7 or more": _axis_shorter_than(1e-7),
        "requires positive sizes of what collides": _shapes(
            "collision",
            "the collision of ",
            lambda _, shape: min((value for size in shape.sizes for value in size.values or ()), default=1.0) <= 0,
        ),
    },
    ("mujoco", Verdict.ALTERS, _MUJOCO): {
        "infers masses: links without <inertial> weigh what water in their collision shapes does": lambda context: [
            _part(link) for group in context.tree.groups[1:] for link in group.links if _inferred(link)
        ],
        "leaves out what is only <visual>": _shapes(
            "visual", "", lambda context, _: _compiler(context).get("discardvisual", "true") == "true"
        ),
        "makes the root a part of the world, without its mass": _HEAVY_ROOT,
        "ignores limits where lower > upper": _limits(WITH_RANGE, _turned),
        "does not make mimic exact": _MIMIC,
    },
    ("drake", Verdict.REJECTS, _DRAKE): {
        "requires lower <= upper": _limits(_LIMITED, _turned),
        "requires a velocity that is not negative": _limits(_LIMITED, lambda limit: (limit.velocity.value or 0.0) < 0),
        "requires an axis of 1e-8 or more": _axis_shorter_than(1e-8),
        "requires damping that is not negative": _joints(
            lambda joint: joint.type in _LIMITED and (joint.damping.value or 0.0) < 0
        ),
        "requires a name of the robot": _nameless,
    },
    ("drake", Verdict.ALTERS, _DRAKE): {
        "takes 1 kg where <inertial> has no <mass>, or a negative one": _inertials(
            lambda _, link: link.mass is None or link.mass < 0
        ),
        "ignores joint friction": _joints(lambda joint: joint.friction.value),
        "lets the root float unless it is called world": _root(lambda link: link.name != "world"),
        "leaves the child of a floating joint free of its parent": _joints(lambda joint: joint.type == "floating"),
    },
    ("gz", Verdict.REJECTS, _GAZEBO): {
        "keeps nothing, since it drops links without mass and all behind them": lambda context: [
            _part(link) for link in context.tree.links[:1] if link.name in _weightless(context)
        ],
        "requires inertia that a body can have, of links with what is fixed to them": _unphysical_groups,
        "knows no floating and no planar joints": _UNACTUATED,
        "requires an axis of 1e-6 or more": _axis_shorter_than(1e-6),
        "requires numbers, and <limit> with effort and velocity, in revolute and prismatic joints": _joints(_malformed),
        "requires names of joints that are no links', and none like __this__": lambda context: [
            *(_part(link) for link in context.tree.links if re.fullmatch("__.*__", link.name)),
            *(_part(one) for one in context.view.joints if one.moves and one.name in context.view.link),
        ],
        "requires a name of the robot": _nameless,
    },
    ("gz", Verdict.ALTERS, _GAZEBO): {
        "drops links without mass, and all joints and links behind them": _dropped,
        "exchanges limits where lower > upper": _limits(WITH_RANGE, _turned),
        "merges links on fixed joints": _FIXED,
    },
    ("kdl", Verdict.ALTERS, _KDL): {
        "ignores the mass of the root": _HEAVY_ROOT,
        "makes the joint fixed": _UNACTUATED,
        "moves mimic joints on their own": _MIMIC,
    },
    ("isaac", Verdict.ALTERS, _ISAAC): {
        "replaces characters in names by _": lambda context: [
            *(_part(link) for link in context.view.links if not link.name.isidentifier()),
            *(_part(joint) for joint in context.view.joints if not joint.name.isidentifier()),
        ],
        "merges links on fixed joints": _FIXED,
        "makes up a mass for links without one": lambda context: [
            _part(group.links[0]) for group in context.tree.groups[1:] if not group.links[0].mass
        ],
    },
}
FACTS = tuple(
    Fact(target, verdict, does, source, find)
    for (target, verdict, source), column in _TABLE.items()
    for does, find in column.items()
)
"""The table, row by row: what a program does, and where to find that."""
