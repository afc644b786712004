"""What other programs do to descriptions: a table of facts about links, joints and shapes.

Each row was learnt by running the program or from what it documents. The table is not complete: what is refused for how
it is written, for materials, textures or transmissions, the program itself tells where it is installed; see `opinion`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from math import hypot
from os.path import splitext
from typing import NamedTuple

from robodyn.checks.bodies.masses import behind, link_poses, pose, principal_moments
from robodyn.checks.context import Context
from robodyn.checks.importers.inferred_mass import inferred_masses
from robodyn.checks.importers.run import Answer, answer
from robodyn.checks.meshes.files import MeshUse, State, mesh_names, mesh_uses
from robodyn.programs.vectors import ZERO
from robodyn.robot.masses.inertia_mistakes import UPPER
from robodyn.robot.urdf.elements import Span
from robodyn.robot.urdf.parts import WITH_AXIS, WITH_RANGE
from robodyn.robot.urdf.view import JointView, LimitView, LinkView
from robodyn.solids.inertia.laws import combined, inertia_of, symmetric

_LEAST_MASS, _LEAST_MOMENT = 1e-15, 1e-14
"""MuJoCo: kg, and principal moments [kg m^2]."""
_ROUNDING = 1e-15
"""MuJoCo: of principal moments, relative; within it its own rounding decides."""
_LEAST_GAZEBO = 1e-6
"""kg."""
_LIMITED = ("revolute", "continuous", "prismatic")
_FREEDOM = {"fixed": 0, "planar": 3, "floating": 6}


class Verdict(IntEnum):
    """From good to bad."""

    LOADS = 0
    ALTERS = 1
    REJECTS = 2


class Found(NamedTuple):
    """A place, what is there, and the mass of it where that is what matters [kg]."""

    at: Span
    what: str
    mass: float = 0.0


Find = Callable[[Context], Iterable[Found]]


@dataclass(frozen=True, slots=True)
class Fact:
    """One thing that a program does: to what (`find`), what (`does`), and how that is known (`source`).

    KG in what it does stands for the mass of all that is found. Of nearly every robot the meshes cannot be read by some
    program: facts about `files` count only where the program is asked for.
    """

    target: str
    verdict: Verdict
    does: str
    source: str
    find: Find
    files: bool = False


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
    return Found(of.element.span, named(of))


def _used(use: MeshUse, what: str) -> Found:
    return Found(use.at, f"{what} in the {use.geometry.kind} of {named(use.link)}")


def _inertials(holds: Callable[[Context, LinkView], object]) -> Find:
    return lambda context: [
        Found(link.inertial.element.span, named(link))
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


def _unread_meshes(target: str) -> Find:
    return lambda context: [
        _used(use, suffix or "no suffix") for suffix, uses in unread(context, target).items() for use in uses
    ]


def _missing_meshes(*kinds: str) -> Find:
    return lambda context: [
        _used(use, name.uri)
        for name in context.once(mesh_names).values()
        if name.state in (State.MISSING, State.OTHER_CASE)
        for use in name.uses
        if use.geometry.kind in kinds
    ]


def _sizeless(context: Context) -> Iterator[Found]:
    """Primitives to collide with that have a size which is not positive."""
    for link in context.view.links:
        for shape in link.geometries:
            sizes = [value for size in shape.sizes for value in size.values or ()]
            if shape.kind == "collision" and min(sizes, default=1.0) <= 0:
                yield Found(shape.element.span, f"the collision of {named(link)}")


def _nameless(context: Context) -> list[Found]:
    return [] if context.view.root.get("name") else [Found(context.view.root.span, "the robot")]


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
    balanced = context.once(_compiler).get("balanceinertia") == "true"
    return small < _LEAST_MOMENT or (small + middle < large - room and not balanced)


def _massless(context: Context) -> Iterator[Found]:
    """Rigid groups that a joint moves, in which nothing with mass has moments of inertia; but for those that are
    refused for a tensor, and whose mass MuJoCo is told to bound or to take from shapes."""
    if {"boundmass", "boundinertia", "inertiafromgeom"} & context.once(_compiler).keys():
        return
    for group in context.tree.groups[1:]:
        inferred = inferred_masses(context, group.links)
        weighed = any(_has_inertia(link) for link in group.links)
        shaped = any(mass is None or mass >= _LEAST_MASS for mass in inferred.values())
        if not weighed and not shaped and not any(_unphysical(context, link) for link in group.links):
            yield _part(group.links[0])


def _has_inertia(link: LinkView) -> bool:
    """Whether a link has mass and moments of inertia, or they cannot be read."""
    if link.inertial is None or link.mass is None or link.tensor is None:
        return link.inertial is not None
    return link.mass >= _LEAST_MASS and any(link.tensor)


def _inferred(context: Context) -> Iterator[Found]:
    """Links whose mass MuJoCo infers, with it; what stands still with the root has none to it."""
    moving = (link for group in context.tree.groups[1:] for link in group.links)
    for name, mass in inferred_masses(context, moving).items():
        link = context.view.link[name]
        known = "of a mesh that is not there or cannot be read" if mass is None else f"{mass:.3g} kg"
        yield Found(link.element.span, f"{named(link)} {known}", mass or 0.0)


def _unlimited(limit: LimitView) -> bool:
    lower, upper = limit.lower.value, limit.upper.value
    given = limit.lower.given or limit.upper.given
    return given and (lower is None or upper is None or not lower < upper)


def _visuals(context: Context) -> Iterator[Found]:
    if context.once(_compiler).get("discardvisual", "true") == "true":
        for link in context.view.links:
            yield from (Found(one.element.span, named(link)) for one in link.geometries if one.kind == "visual")


def _uris(context: Context) -> list[Found]:
    if context.once(_compiler).get("strippath") == "true":
        return []
    return [
        _used(use, use.geometry.uri)
        for use in mesh_uses(context)
        if "://" in use.geometry.uri and use.geometry.kind == "collision"
    ]


def _turned(limit: LimitView) -> bool:
    lower, upper = limit.lower.value, limit.upper.value
    return lower is not None and upper is not None and lower > upper


def _mimic_leader(context: Context) -> Iterator[Found]:
    """Mimic joints whose leader is not there, is the joint itself, or has other degrees of freedom."""
    for joint in context.view.joints:
        if joint.mimic is not None:
            leader = context.view.joint.get(joint.mimic.joint)
            if leader is None or leader is joint or _FREEDOM.get(leader.type, 1) != _FREEDOM.get(joint.type, 1):
                yield Found(joint.mimic.element.span, named(joint))


class _Lumps(NamedTuple):
    """The links that Gazebo makes one, by the name of the first; the names of those that it keeps, the links that it
    drops, and the names of those without a centre of mass."""

    links: dict[str, list[LinkView]]
    kept: set[str]
    dropped: list[LinkView]
    nowhere: set[str]


def _lumps(context: Context) -> _Lumps:
    """What Gazebo makes of the links: each joins what fixed joints hang on it, but for those to a root called world.
    From the root down, a link without mass is dropped with everything behind it. Two <inertial>s without mass that are
    joined have no centre: 0 / 0."""
    tree = context.tree
    onto = {one.child: one.parent for one in tree.above.values() if not one.moves and one.parent != "world"}
    joining: dict[str, list[LinkView]] = {}
    for link in tree.links:
        joining.setdefault(onto.get(link.name, ""), []).append(link)
    mass: dict[str, float | None] = {}
    found = _Lumps({}, set(), [], set())
    for link in reversed(tree.links):
        whole = None if link.inertial is None else link.mass or 0.0
        for other in joining.get(link.name, ()):
            more = mass[other.name]
            if more is not None:
                whole = (whole or 0.0) + more
                if whole == 0.0 or other.name in found.nowhere:
                    found.nowhere.add(link.name)
        mass[link.name] = whole
    first: dict[str, str] = {}
    for link in tree.links:
        first[link.name] = first[onto[link.name]] if link.name in onto else link.name
        found.links.setdefault(first[link.name], []).append(link)
        above = tree.above.get(link.name)
        if above is None or above.parent in found.kept:
            if abs(mass[link.name] or 0.0) > _LEAST_GAZEBO or (above is None and link.name == "world"):
                found.kept.add(link.name)
            else:
                found.dropped.append(link)
    return found


def _dropped(context: Context) -> list[Found]:
    """Links that are left out and take joints with them."""
    moving = {joint.child for joint in context.view.joints if joint.moves}
    for link in reversed(context.tree.links):
        above = context.tree.above.get(link.name)
        if above is not None and link.name in moving:
            moving.add(above.parent)
    return [_part(link) for link in context.once(_lumps).dropped if link.name in moving]


def _unphysical_lumps(context: Context) -> Iterator[Found]:
    """Links whose mass or inertia, with that of what is fixed to them, no body has."""
    found = context.once(_lumps)
    for name, links in found.links.items():
        doubtful = any((link.mass or 0.0) < 0 or _unphysical(context, link) for link in links)
        if name in found.kept - {"world"} and doubtful:
            small, middle, large = _moments(context, links)
            massless = sum(link.mass or 0.0 for link in links) <= 0
            if massless or small < -_ROUNDING * large or small + middle < (1.0 - 2.0 * _ROUNDING) * large:
                yield _part(links[0])


def _moments(context: Context, links: Sequence[LinkView]) -> tuple[float, float, float]:
    """Principal moments of links that are fixed to each other, ascending [kg m^2]: of those that can be read."""
    if len(links) == 1:
        return principal_moments(links[0].tensor or (0.0,) * 6)
    poses, bodies = context.once(link_poses), []
    for link in links:
        inner, outer = None if link.inertial is None else pose(link.inertial.origin), poses.get(link.name)
        if inner is not None and outer is not None and link.tensor is not None:
            at = behind(outer, inner)
            bodies.append(inertia_of(max(link.mass or 0.0, 0.0), ZERO, symmetric(link.tensor), at.R, at.p))
    return principal_moments(tuple(combined(bodies).about_centre[UPPER].tolist()))


def _malformed(joint: JointView) -> bool:
    if joint.limit is None:
        return joint.type in WITH_RANGE
    effort, velocity = joint.limit.effort, joint.limit.velocity
    wrong = any(one.problem for one in (joint.limit.lower, joint.limit.upper, effort, velocity))
    return joint.type in WITH_RANGE and (wrong or not (effort.given and velocity.given))


def _taken_names(context: Context) -> Iterator[Found]:
    """Joints that are kept and called as a link, and links with reserved names, __so__."""
    found = context.once(_lumps)
    kept, first = found.kept, found.kept & found.links.keys()
    for link in context.tree.links:
        if link.name in first and len(link.name) > 3 and link.name.startswith("__") and link.name.endswith("__"):
            yield _part(link)
    yield from (_part(one) for one in context.view.joints if one.moves and one.name in first and one.child in kept)


_MIMIC = _joints(lambda joint: joint.mimic)
_FIXED = _joints(lambda joint: joint.type == "fixed")
_UNACTUATED = _joints(lambda joint: joint.type in ("floating", "planar"))
_HEAVY_ROOT = _root(lambda link: link.mass)
_REFUSED_TENSOR, _MALFORMED = _inertials(_unphysical), _joints(_malformed)
_INCOMPLETE = _inertials(
    lambda _, link: link.inertial and None in (link.inertial.inertia_element, link.inertial.mass_element)
)
_MUJOCO, _DRAKE = "MuJoCo 4.0, run; its XML reference, compiler", "Drake 1.51, run"
_GAZEBO, _KDL = "sdformat 12.3 with urdfdom 3.0, run", "kdl_parser.cpp"
_ISAAC = "Isaac Sim 5, URDF importer and its ImportConfig"
_TABLE: Mapping[tuple[str, Verdict, str, bool], Mapping[str, Find]] = {
    ("mujoco", Verdict.REJECTS, _MUJOCO, False): {
        "requires mass and inertia in what moves": _massless,
        "requires principal moments of 1e-14 kg m^2 or more, no two of them below the third": _REFUSED_TENSOR,
        "requires <mass> and <inertia> in <inertial>": _INCOMPLETE,
        "requires an axis of 1e-7 or more": _axis_shorter_than(1e-7),
        "requires positive sizes of what collides": _sizeless,
    },
    ("mujoco", Verdict.ALTERS, _MUJOCO, False): {
        "infers KG: links without <inertial> weigh what water in their collision shapes does": _inferred,
        "leaves out what is only <visual>": _visuals,
        "makes the root a part of the world, without its mass": _HEAVY_ROOT,
        "ignores limits unless lower < upper, both given": _limits(WITH_RANGE, _unlimited),
        "makes mimic a soft equality constraint": _MIMIC,
    },
    ("mujoco", Verdict.REJECTS, _MUJOCO, True): {
        "reads meshes in .stl, .obj and .msh only": _unread_meshes("mujoco"),
        "requires meshes to be there": _missing_meshes("collision"),
        'opens no URI without <mujoco><compiler strippath="true" meshdir="..."/>': _uris,
    },
    ("drake", Verdict.REJECTS, _DRAKE, False): {
        "requires lower <= upper": _limits(_LIMITED, _turned),
        "requires a velocity that is not negative, and ends the process otherwise": _limits(
            _LIMITED, lambda limit: (limit.velocity.value or 0.0) < 0
        ),
        "requires an axis of 1e-8 or more": _axis_shorter_than(1e-8),
        "requires damping that is not negative": _joints(
            lambda joint: joint.type in _LIMITED and (joint.damping.value or 0.0) < 0
        ),
        "requires mimic and another joint as leader, with equal degrees of freedom": _mimic_leader,
        "requires a name of the robot": _nameless,
    },
    ("drake", Verdict.ALTERS, _DRAKE, False): {
        "ignores joint friction": _joints(lambda joint: joint.friction.value),
        "lets the root float unless it is called world": _root(lambda link: link.name != "world"),
        "leaves the child of a floating joint free of its parent": _joints(lambda joint: joint.type == "floating"),
    },
    ("drake", Verdict.REJECTS, _DRAKE, True): {
        "collides with meshes in .obj, .vtk and .gltf only": _unread_meshes("drake"),
        "requires meshes to be there": _missing_meshes("visual", "collision"),
    },
    ("gz", Verdict.REJECTS, _GAZEBO, False): {
        "keeps nothing, since it drops links without mass and all behind them": lambda context: (
            [] if context.once(_lumps).kept - {"world"} else [_part(context.tree.root)]
        ),
        "requires inertia that a body can have, of links with what is fixed to them": _unphysical_lumps,
        "finds no centre of mass of <inertial>s without mass that are fixed to each other": lambda context: [
            _part(context.view.link[name])
            for name in context.once(_lumps).links
            if name in context.once(_lumps).kept & context.once(_lumps).nowhere
        ],
        "knows no floating and no planar joints": _UNACTUATED,
        "requires an axis of 1e-6 or more": _axis_shorter_than(1e-6),
        "requires numbers, and <limit> with effort and velocity, in revolute and prismatic joints": _MALFORMED,
        "requires names of joints that are no links', and none like __this__": _taken_names,
        "requires a name of the robot": _nameless,
    },
    ("gz", Verdict.ALTERS, _GAZEBO, False): {
        "drops links without mass, and all joints and links behind them": _dropped,
        "exchanges limits where lower > upper": _limits(WITH_RANGE, _turned),
        "merges links on fixed joints": _FIXED,
    },
    ("gz", Verdict.ALTERS, READS["gz"].source, False): {
        "leaves out meshes in formats that it does not read": _unread_meshes("gz")
    },
    ("kdl", Verdict.ALTERS, _KDL, False): {
        "ignores the mass of the root": _HEAVY_ROOT,
        "makes the joint fixed": _UNACTUATED,
        "moves mimic joints on their own": _MIMIC,
    },
    ("isaac", Verdict.ALTERS, _ISAAC, False): {
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
    Fact(target, verdict, does, source, find, files)
    for (target, verdict, source, files), column in _TABLE.items()
    for does, find in column.items()
)
"""The table, row by row: what a program does, and where to find that."""


class Opinion(NamedTuple):
    """What one program makes of a file: the verdict, for each fact that counts where it was found, and what the program
    itself said, if it was run."""

    target: str
    verdict: Verdict
    found: tuple[tuple[Fact, tuple[Found, ...]], ...]
    answer: Answer | None = None


def refusals(context: Context, target: str) -> tuple[tuple[Fact, tuple[Found, ...]], ...]:
    """What the table knows that makes a program reject a file, but for its meshes. From stage TREE on."""
    facts = (fact for fact in FACTS if (fact.target, fact.verdict) == (target, Verdict.REJECTS) and not fact.files)
    return tuple((fact, found) for fact in facts if (found := tuple(fact.find(context))))


def opinion(context: Context, target: str) -> Opinion:
    """The opinion of a program, its facts with the worst verdict first. From stage TREE on.

    MuJoCo and Drake are run where they are installed, and reject what they do reject; what else they do, and what
    others do, the table tells.
    """
    said = answer(context, target)
    refused = said is not None and said.refusal is not None
    taken = said is not None and said.version is not None and not refused
    found = ((fact, tuple(fact.find(context))) for fact in FACTS if fact.target == target)
    counted = [one for one in found if one[1] and not (taken and one[0].verdict is Verdict.REJECTS)]
    counted.sort(key=lambda one: -one[0].verdict)
    verdict = Verdict.REJECTS if refused else counted[0][0].verdict if counted else Verdict.LOADS
    return Opinion(target, verdict, tuple(counted), said)
