"""What a check is given: one file, read as far as it can be, and everything derived from it at most once; the tree that
its joints make of the links, and the rigid groups in that."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

from robodyn.errors import DescriptionError, InputError
from robodyn.robot.limits import MOST_EFFORT, MOST_VELOCITY
from robodyn.robot.urdf.description import read_description
from robodyn.robot.urdf.document import Document
from robodyn.robot.urdf.parts import JOINT_TYPES, Description
from robodyn.robot.urdf.sources import Search
from robodyn.robot.urdf.view import InertialView, JointView, LinkView, View
from robodyn.support.wording import alternatives, call_of, shown

if TYPE_CHECKING:
    from robodyn.robot.model import Model

T = TypeVar("T")
STDIN = "<stdin>"
TARGETS = ("mujoco", "drake", "gz", "kdl", "isaac")
"""The programs whose verdict is known; see `robodyn.checks.importers`."""


@dataclass(frozen=True, slots=True)
class Asked:
    """What is asked; InputError where a target is not known."""

    targets: tuple[str, ...] = ()  # programs whose verdict RD901 gives
    against: str | None = None  # a git revision whose version of the file RD902 compares with, or another file
    trajectory: str | None = None  # a file with a motion along which RD802 holds the limits against the loads
    reading: Mapping[str, Any] = field(default_factory=dict)  # how it is read, as for `read_motion`
    xacro_args: tuple[tuple[str, str], ...] = ()  # with which the version at the revision is expanded

    def __post_init__(self) -> None:
        for target in self.targets:
            if target not in TARGETS:
                raise InputError(f"there is no target {shown(target)}", remedy=alternatives(target, TARGETS, "targets"))


NOTHING = Asked()


@dataclass(frozen=True, slots=True)
class Thresholds:
    """The numbers that a project may set for itself; SI units."""

    axis_length: float = 1e-3  # RD502: how far the length of an axis may be from 1
    positive_definite: float = 1e-9  # RD206: least principal moment over the largest
    triangle: float = 1e-6  # RD207: slack of the triangle inequality over the largest principal moment
    least_mass: float = 1e-4  # RD209: mass of a moving rigid group
    least_gyration: float = 1e-4  # RD209: radius of gyration of a moving rigid group
    mass_ratio: float = 1000.0  # RD210: masses of the rigid groups on both sides of a joint
    most_effort: float = MOST_EFFORT  # RD506: a greater effort is a sentinel
    most_velocity: float = MOST_VELOCITY  # RD506: a greater velocity is a sentinel
    most_range: float = 1e4  # RD504: a greater position limit is a sentinel
    mimic_range: float = 1e-3  # RD512: how far a follower may be driven beyond its limits [rad or m]
    least_density: float = 10.0  # RD304: mass of a rigid group over the volume of the box around its shapes [kg/m^3]
    most_density: float = 9000.0  # RD304: a greater one is too dense even for solid steel


@dataclass(frozen=True, repr=False)
class Options:
    """What is checked, and against what. `select` and `ignore` are codes (RD207) or beginnings of codes (RD2) of rules
    to run and not to run, ALL, or DEFAULT, which is meant if it is empty: errors, and what is likely a defect."""

    select: tuple[str, ...] = ()
    ignore: tuple[str, ...] = ()
    thresholds: Thresholds = Thresholds()
    package_path: tuple[str, ...] = ()  # folders in which `package://` names are looked up first
    xacro_args: tuple[tuple[str, str], ...] = ()
    trust_xacro: bool = False  # whether xacro files may do whatever Python can
    asked: Asked = NOTHING  # beyond the files themselves
    expanded_to: str = ""  # the folder to which xacro files are expanded, and which their meshes are named from
    including: bool = False  # whether of a xacro file that others include those are checked in its place

    def __repr__(self) -> str:
        return call_of(self)


STANDARD = Options()  # what holds where nothing else is asked: the default set, and the thresholds as they are


@dataclass(frozen=True, eq=False)
class Group:
    """Links that fixed joints make one body; `links[0]` is the child of `joint`, which moves it against `parent`. The
    root's group has neither. `children` are the groups below this one."""

    links: list[LinkView]
    joint: JointView | None
    parent: Group | None
    children: list[Group] = field(default_factory=list)

    @cached_property
    def mass(self) -> float | None:
        """kg, asked for when all links are there; None where a mass cannot be read."""
        masses = [link.mass for link in self.links]
        known = [mass for mass in masses if mass is not None]
        return sum(known) if len(known) == len(masses) else None

    @property
    def heaviest(self) -> tuple[LinkView, InertialView]:
        """The link with the most mass, and its <inertial>, of a group that has mass."""
        link = max(self.links, key=lambda link: link.mass or 0.0)
        assert link.inertial is not None, "it has mass"
        return link, link.inertial


@dataclass(frozen=True, slots=True, eq=False)
class Tree:
    """`links` and `groups` with parents before children; `above` has the joint above each link but the root."""

    links: tuple[LinkView, ...]
    above: Mapping[str, JointView]
    groups: tuple[Group, ...]
    group: Mapping[str, Group]

    @property
    def root(self) -> LinkView:
        return self.links[0]


@dataclass(frozen=True, eq=False)
class Context:
    """One file under check, what of `Options` the rules need, and the codes of all rules."""

    reading: Document
    thresholds: Thresholds = Thresholds()
    package_path: tuple[str, ...] = ()
    asked: Asked = NOTHING
    codes: tuple[str, ...] = ()
    expanded_to: str = ""
    _kept: dict[Callable[..., Any], Any] = field(default_factory=dict, repr=False)

    def once(self, function: Callable[[Context], T]) -> T:
        """Return `function(self)`, computed when it is first asked for."""
        if function not in self._kept:
            self._kept[function] = function(self)
        value: T = self._kept[function]
        return value

    @cached_property
    def search(self) -> Search:
        """Where the files are that the description names."""
        return Search(self.reading.file, self.package_path, self.expanded_to)

    @cached_property
    def view(self) -> View:
        """Links, joints and numbers, as far as they can be read. From stage DOCUMENT on."""
        return View(self.reading.root)

    def reaches(self, stage: int) -> bool:
        needed = (lambda: self.reading.robot, lambda: self.tree_or_none, lambda: self.model_or_none)
        return all(there() is not None for there in needed[:stage])

    @property
    def tree(self) -> Tree:
        """The tree of links and its rigid groups. From stage TREE on."""
        assert self.tree_or_none is not None, "the stage has been reached"
        return self.tree_or_none

    @cached_property
    def tree_or_none(self) -> Tree | None:
        """None where there is no tree, or names or types are not in order: RD101 to RD109 say why."""
        view = self.view
        above = {joint.child: joint for joint in view.joints}
        unique = len(view.link) == len(view.links) and len(view.joint) == len(view.joints) == len(above)
        led = all(joint.parent in view.link and joint.child in view.link for joint in view.joints)
        typed = all(joint.type in JOINT_TYPES for joint in view.joints)
        roots = [link for link in view.links if link.name not in above]
        if not (unique and led and typed) or len(roots) != 1:
            return None
        below: dict[str, list[str]] = {}
        for joint in view.joints:
            below.setdefault(joint.parent, []).append(joint.child)
        links, waiting = list[LinkView](), [roots[0].name]
        while waiting:
            name = waiting.pop()
            links.append(view.link[name])
            waiting += reversed(below.get(name, ()))
        if len(links) < len(view.links):
            return None
        groups, group = list[Group](), dict[str, Group]()
        for link in links:
            carrier = above.get(link.name)
            parent = None if carrier is None else group[carrier.parent]
            if carrier is not None and parent is not None and not carrier.moves:
                parent.links.append(link)
                group[link.name] = parent
                continue
            group[link.name] = Group([link], carrier, parent)
            groups.append(group[link.name])
            if parent is not None:
                parent.children.append(group[link.name])
        return Tree(tuple(links), above, tuple(groups), group)

    @cached_property
    def description_or_none(self) -> Description | None:
        if self.reading.robot is None:
            return None
        try:
            description = read_description(self.reading, self.view)
            return replace(description, search=self.search, data=self.reading.data)
        except DescriptionError:
            return None

    @property
    def model(self) -> Model:
        """From stage MODEL on."""
        assert self.model_or_none is not None, "the stage has been reached"
        return self.model_or_none

    @cached_property
    def model_or_none(self) -> Model | None:
        from robodyn.robot.load import assemble

        if self.description_or_none is None:
            return None
        try:
            return assemble(self.description_or_none)
        except DescriptionError:
            return None
