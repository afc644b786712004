"""SDF -> Description: links and joints by their names, what closes loops, springs and gravity as a scene.

1. `frames` reads models within models and files within files, and finds where everything stands at rest.
2. Joints that make a tree of the links are joints, the others loops: of those that can be, balls first, then hinges.
3. `bodies` reads the links. One has the axes that it has in SDF, and its origin there or at the point it turns about.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np

from robodyn.programs.vectors import IDENTITY, length, product, rpy_from_rotation, snapped
from robodyn.robot.sdf.bodies import link_of, origin, vector
from robodyn.robot.sdf.frames import MODEL, WORLD, Frames, Node, Pose, relative, truth
from robodyn.robot.urdf.description import check_mimics
from robodyn.robot.urdf.document import Element
from robodyn.robot.urdf.parts import Description, Joint, Limit, Link, Mimic, Origin, Transmission
from robodyn.robot.urdf.sources import Search
from robodyn.support.floats import Floats
from robodyn.support.wording import alternatives, count, listed, shown

_NONE = 1e16
"""What a limit must be less than to be one."""
_TURNS = ("revolute", "continuous")
_ROWS = {"ball": "xyz", "universal": "12", "revolute2": "12"}
"""Joints that are several hinges in a row, and what their names end with."""
_TYPES = (*_TURNS, "prismatic", "fixed", *_ROWS, "screw", "gearbox")
_LOOPS = {"fixed": "weld", "revolute": "hinge", "continuous": "hinge", "ball": "point"}
_EARTH = (0.0, 0.0, -9.81)
_PARALLEL = 1e-6


def read_sdf(data: bytes, file: str, package_paths: tuple[str, ...] = ()) -> Description:
    """Return what an SDF file says, with the one model of its world, as a description.

    The root is `world` where a joint fixes something to it, where the model stands turned or where its links do not
    hang together; otherwise a link, which stands fixed unless a scene or the call frees it, as that of a URDF.

    Raises:
        DescriptionError: the file is no SDF, names what is not there, or includes what it may not; with the line.
    """
    frames = Frames(Search(file, package_paths))
    frames.read(data)
    return replace(_Robot(frames).description(), data=data)


@dataclass(frozen=True, eq=False)
class _Edge:
    """A joint between two links, and the elementary ones in a row that it is, with axes in the robot's frame."""

    node: Node
    type: str
    parent: Node
    child: Node
    row: list[Joint]

    @property
    def rank(self) -> int:
        """Joints of low rank are taken into the tree first: those that are no loops, then welds, hinges, balls."""
        return (None, "weld", "hinge", "point").index(_LOOPS.get(self.type))


class _Robot:
    """The joints, of which some make a tree with the root `root`; `inboard` is that between a link and the root.

    Attributes:
        free: links that no joint holds to the world, where that is the root; `still` if they do not move there.
    """

    def __init__(self, frames: Frames) -> None:
        self.frames, self.world, self.poses = frames, frames.world, frames.poses
        self.notes: list[tuple[int, str]] = []
        self.lost: list[str] = []
        self.springs: dict[str, dict[str, float]] = {}
        self.written: dict[str, Element] = {}
        self.taken = {*(node.name for node in (*frames.links, *frames.joints)), WORLD}
        self.inside = {self.world, *frames.links}
        self.edges = [self._edge(joint) for joint in frames.joints]
        self.loops: list[_Edge] = []
        self.inboard: dict[Node, _Edge] = {}
        self._grow()

    def _note(self, node: Node, what: str) -> None:
        file = node.text.strict.file
        place = "" if file == self.frames.search.file else f"{file}: "
        self.notes.append((node.line(), f"{place}{what}"))

    def _name(self, name: str) -> str:
        """Return the name, or one like it that nothing has."""
        found, k = name, 1
        while found in self.taken:
            found, k = f"{name}{k + 1}", k + 1
        self.taken.add(found)
        return found

    def _edge(self, node: Node) -> _Edge:
        element, frames, name, owner = node.element, self.frames, node.name, node.owner
        kind = node.text.strict.text(element, "type", owner)
        if kind not in _TYPES:
            raise node.error(f"{owner} has the unknown type {shown(kind)}", alternatives(kind.lower(), _TYPES, "types"))
        parent, child = (frames.body(frames.find(end, node)) for end in (node.said("parent"), node.attached))
        if parent is child or not {parent, child} <= self.inside:
            raise node.error(f"{owner} ties {shown(parent.name)} to {shown(child.name)}", "name two links of a robot")
        names, row = [self._name(f"{name}_{end}") for end in _ROWS.get(kind, "")], list[Joint]()
        if kind == "ball":
            axis, axes = node.child("axis", element), self.poses[node][0].T
            resists = {} if axis is None else self._resistance(axis, node, names, "ball")
            ends = zip(names, map(vector, axes), strict=True)
            row = [Joint(each, "continuous", "", "", axis=along, **resists) for each, along in ends]
        elif kind in _ROWS:
            row = [self._hinge(node, tag, each) for tag, each in zip(("axis", "axis2"), names, strict=True)]
        elif kind not in ("fixed", "gearbox"):
            row = [self._hinge(node, "axis", name, "revolute" if kind == "screw" else kind)]
        if names:
            singular = f", singular where {shown(names[1])} is at 90 degrees" if kind == "ball" else ""
            rates = kind == "ball" and (row[0].damping or row[0].friction or names[0] in self.springs)
            more = "; friction and springs act on their angles" if rates else ""
            self._note(node, f"{owner} is the hinges {listed(names)} in a row{singular}{more}")
        if kind == "screw":
            pitch = node.number("screw_thread_pitch", 0.0, element)
            if not pitch and (old := node.number("thread_pitch", 0.0, element)):
                pitch = -2 * pi / old  # rad/m of a left-handed thread, as Gazebo had it
            slide = self._name(f"{name}_slide")
            row.append(Joint(slide, "prismatic", "", "", axis=row[0].axis, mimic=Mimic(name, pitch / (2 * pi))))
            self._note(node, f"{owner} is a hinge, and the slide {shown(slide)} that mimics it")
        return _Edge(node, kind, parent, child, [replace(joint, line=node.line()) for joint in row])

    def _axis(self, node: Node, tag: str) -> tuple[Element, Floats]:
        """Return an axis as written and as a direction in the robot's frame."""
        axis = node.text.strict.needed_child(node.element, tag, node.owner)
        written, frame = node.child("xyz", axis), node
        direction = np.array((0.0, 0.0, 1.0) if written is None else node.numbers(written, 3))
        if not direction.any():
            what = f"the axis of {node.owner} has the length 0, which gives no direction"
            raise node.error(what, "write a direction, for example 0 0 1", axis)
        usual = "true" if node.text.version < (1, 5) else "false"
        if written is not None and (other := written.get("expressed_in")):
            frame = self.frames.find(other, node)
        elif node.text.version < (1, 7) and truth(node.said("use_parent_model_frame", usual, axis)):
            frame = self.frames.find(MODEL, node)
        direction = direction / np.abs(direction).max()
        return axis, product(self.poses[frame][0], direction / length(direction))

    def _hinge(self, node: Node, tag: str, name: str, kind: str = "revolute") -> Joint:
        axis, along = self._axis(node, tag)
        resists = self._resistance(axis, node, [name], kind)
        if (mimic := node.child("mimic", axis)) is not None:
            self.written[name] = mimic
        limit = resists["limit"] or Limit()
        kind = "continuous" if kind == "revolute" and limit.lower is limit.upper is None else kind
        return Joint(name, kind, "", "", axis=vector(along), **resists)

    def _resistance(self, axis: Element, node: Node, names: list[str], kind: str) -> dict[str, Any]:
        """Return limits and friction of an axis, and keep its spring."""
        dynamics, within = node.child("dynamics", axis), node.child("limit", axis)
        keys = ("damping", "friction", "spring_stiffness", "spring_reference")
        damping, friction, stiffness, rest = (node.number(key, 0.0, dynamics) for key in keys)
        for key, value in (("damping", damping), ("friction", friction)):
            if value < 0.0:
                self._note(node, f"{node.owner} has a negative {key}: {value:g}, which feeds energy in")
        if stiffness:
            self.springs |= {name: {"stiffness": stiffness, "rest": rest} for name in names}
        lower, upper, *most = (_bound(within, tag, node) for tag in ("lower", "upper", "effort", "velocity"))
        effort, velocity = (None if value is None or value < 0.0 else value for value in most)
        limit = Limit(*((None, None) if kind in ("continuous", "ball") else (lower, upper)), effort, velocity)
        return {"damping": damping, "friction": friction, "limit": None if limit == Limit() else limit}

    def _grow(self) -> None:
        """Find the joints that make a tree of the links, from its root on, and the loops that the others close."""
        group, at, robot = dict[Node, Node](), dict[Node, list[_Edge]](), self.frames.robot

        def of(body: Node) -> Node:
            while body in group:
                group[body] = body = group.get(group[body], group[body])
            return body

        for edge in sorted(self.edges, key=lambda edge: edge.rank):
            if edge.type != "gearbox" and of(edge.parent) is of(edge.child):
                self.loops.append(edge)
            elif edge.type != "gearbox":
                group[of(edge.child)] = of(edge.parent)
                at.setdefault(edge.parent, []).append(edge)
                at.setdefault(edge.child, []).append(edge)
        children, held = {edge.child for edge in self.edges}, self.world in at
        roots = {of(self.world): self.world} if held else {}
        for link in sorted(self.frames.links, key=lambda link: link in children):
            roots.setdefault(of(link), link)
        if not roots:
            raise robot.error(f"{robot.owner} has no link", "add a <link>")
        self.root, self.free = self.world, [root for root in roots.values() if root is not self.world]
        self.still = self.frames.static[robot] or (len(roots) == 1 and not held)
        if self.free and not self.frames.static[robot]:
            how = "stands fixed here unless its base is freed, as that of a URDF" if self.still else "moves here, too"
            names = listed([link.name for link in self.free])
            self._note(robot, f"nothing fixes {names} to the world: SDF lets it move, and it {how}")
        if not held and len(roots) == 1:
            (root,) = self.free
            if np.array_equal(relative(self.poses[self.world], self.poses[root])[0], IDENTITY):
                self.root, self.free = root, []
        waiting, seen = list(roots.values()), set(roots.values())
        while waiting:
            body = waiting.pop()
            for edge in at.get(body, ()):
                other = edge.child if edge.parent is body else edge.parent
                if other not in seen:
                    seen.add(other)
                    self.inboard[other] = edge
                    waiting.append(other)

    def _frame(self, body: Node) -> Pose:
        """Return where a link of the description stands in the robot's frame."""
        edge, (R, p) = self.inboard.get(body), self.poses[body]
        turns = edge is not None and any(joint.type in _TURNS for joint in edge.row)
        return (R, self.poses[edge.node][1]) if edge is not None and turns else (R, p)

    def description(self) -> Description:
        frames, robot, joints, between = self.frames, self.frames.robot, list[Joint](), dict[Node, list[Link]]()
        for body in self.free:
            kind = "fixed" if self.still else "floating"
            here = origin(relative(self.poses[self.world], self._frame(body)))
            name = self._name(f"{body.name}_{kind}")
            joints.append(Joint(name, kind, WORLD, body.name, here, line=body.line()))
        below = {edge: body for body, edge in self.inboard.items()}
        for edge in filter(below.__contains__, self.edges):
            body = below[edge]
            above, row = (edge.parent, edge.row) if body is edge.child else (edge.child, edge.row[::-1])
            here, parent = origin(relative(self._frame(above), self._frame(body))), above.name
            for joint in row or [Joint(edge.node.name, "fixed", "", "", line=edge.node.line())]:
                child = body.name if not row or joint is row[-1] else self._name(f"{body.name}_{joint.name}")
                if child != body.name:
                    between.setdefault(body, []).append(Link(child, line=joint.line))
                # Seen from the other side, a joint has the same coordinate about the opposite axis.
                along = snapped(product(self.poses[body][0].T, np.array(joint.axis)))
                axis = vector(along if body is edge.child else -along)
                joints.append(replace(joint, parent=parent, child=child, origin=here, axis=axis))
                parent, here = child, Origin()
        links, bare = [Link(WORLD)] if self.root is self.world else [], []
        for body in frames.links:
            link = link_of(body, frames, relative(self._frame(body), self.poses[body]))
            links += [*between.get(body, ()), link]
            bare += [body.name] if body.child("inertial", body.element) is None else []
            if link.inertial is not None and link.inertial.mass < 0:
                self._note(body, f"{body.owner} has a negative mass: {link.inertial.mass:g} kg")
        scene, joints, rotors = self._scene(links), self._followed(joints), tuple(self._rotors(below))
        if bare:
            self._note(robot, f"no <inertial> in {listed(bare)}: SDF makes it 1 kg, and 1 kg m^2 about each axis")
        lost = [count(number, what, what) for what, number in frames.left.items() if number]
        if lost := [*lost, *(f"{uri}, which is not found" for uri in frames.missing), *self.lost]:
            self.notes.append((1, f"left out, as nothing here is like it: {'; '.join(lost)}"))
        lines = {joint.name: joint.line for joint in joints}
        check_mimics({joint.name: joint for joint in joints}, lines, robot.text.strict)
        notes, search, name = tuple(sorted(self.notes, key=lambda note: note[0])), frames.search, self.root.name
        made = tuple(links), tuple(joints), rotors
        return Description(robot.name, search.file, *made, name, notes, search, scene=scene, format="sdf")

    def _scene(self, links: Sequence[Link]) -> dict[str, Any]:
        """Return gravity, springs and loops as the tables of a scene."""
        frames, wrenches = self.frames, list[dict[str, Any]]()
        gravity, down = list(frames.gravity), frames.gravity or _EARTH
        light = {link.name: None for link in frames.links if self._weightless(link)}
        if len(light) == len(frames.links):
            gravity = [0.0, 0.0, 0.0]
        elif light:
            g = " ".join(f"{each:g}" for each in down)
            self._note(frames.robot, f"gravity is off for {listed(light)}: forces carry them against {g} m/s^2")
            for link in links:
                if link.name in light and link.inertial is not None:
                    force, point = [-link.inertial.mass * g + 0.0 for g in down], list(link.inertial.origin.xyz)
                    wrenches.append({"link": link.name, "force": force, "point": point, "frame": "world"})
        closing = {joint.name for edge in self.loops for joint in edge.row}
        springs = {name: spring for name, spring in self.springs.items() if name not in closing}
        loops = []
        for edge in self.loops:
            where = f"joint {shown(edge.node.name)}"
            if edge.type not in _LOOPS:
                self.lost.append(f"{where} ({edge.type}), which closes a loop")
            elif self._rigid(edge.child) is self._rigid(edge.parent):
                self.lost.append(f"{where}, whose links are fixed to each other")
            else:
                loops.append(self._loop(edge))
                if any(j.damping or j.friction or j.limit or j.name in self.springs for j in edge.row):
                    self.lost.append(f"limits, friction and springs of {where}, which closes a loop")
        scene = {"gravity": gravity, "spring": springs, "wrench": wrenches, "loop": loops}
        return {key: value for key, value in scene.items() if value}

    def _rigid(self, body: Node) -> Node:
        """Return the link nearest to the root that a link is fixed to."""
        while (edge := self.inboard.get(body)) is not None and not edge.row:
            body = edge.parent if body is edge.child else edge.child
        return body

    def _loop(self, edge: _Edge) -> dict[str, Any]:
        kind, ends = _LOOPS[edge.type], (self._frame(edge.child), self._frame(edge.parent))
        loop: dict[str, Any] = {"name": edge.node.name, "link": edge.child.name, "to": edge.parent.name, "kind": kind}
        for prefix, end in zip(("", "to_"), ends, strict=True):
            loop[f"{prefix}point"] = list(relative(end, self.poses[edge.node])[1].tolist())
            if kind == "hinge":
                loop[f"{prefix}axis"] = list(vector(snapped(product(end[0].T, np.array(edge.row[0].axis)))))
        return loop | ({"rpy": list(rpy_from_rotation(relative(*ends[::-1])[0]))} if kind == "weld" else {})

    def _weightless(self, link: Node) -> bool:
        return not truth(link.said("gravity", "true")) or (link.model is not None and link.model.weightless)

    def _rotors(self, edges: dict[_Edge, Node]) -> list[Transmission]:
        found = []
        for edge in edges:
            name, element = edge.node.name, edge.node.element
            inertia, gear = (edge.node.number(f"drake:{tag}", 0.0, element) for tag in ("rotor_inertia", "gear_ratio"))
            if inertia and edge.row and edge.row[0].name == name:
                found.append(Transmission(f"{name}_rotor", name, gear or 1.0, inertia, edge.node.line()))
        return found

    def _followed(self, joints: Sequence[Joint]) -> list[Joint]:
        """Return the joints with those that mimic others: by <mimic> or gearbox."""
        mimics = {joint.name: joint.mimic for joint in joints if joint.mimic is not None}
        rows, moving = {edge.node: edge.row for edge in self.edges}, {j.name for j in joints if j.type != "fixed"}
        for edge in self.edges:
            for name in (joint.name for joint in edge.row if joint.name in self.written):
                mimic, node = self.written[name], edge.node
                leader = self.frames.find(node.text.strict.text(mimic, "joint", node.owner), node)
                of = rows.get(leader) or [Joint(leader.name, "fixed", "", "")]
                of_name = of[min(int(mimic.get("axis") == "axis2"), len(of) - 1)].name
                if of_name not in moving:
                    what = f"{node.owner} mimics {shown(of_name)}, which has no coordinate"
                    raise node.error(what, "name a joint that moves", mimic)
                multiplier, offset = node.number("multiplier", 1.0, mimic), node.number("offset", 0.0, mimic)
                mimics[name] = Mimic(of_name, multiplier, offset - multiplier * node.number("reference", 0.0, mimic))
            if edge.type == "gearbox" and not self._geared(edge, mimics):
                self.lost.append(f"gearbox {shown(edge.node.name)}, whose links do not turn about its reference body")
        return [replace(joint, mimic=mimics.get(joint.name)) for joint in joints]

    def _geared(self, edge: _Edge, mimics: dict[str, Mimic]) -> bool:
        """Let one hinge follow another, if there are two: the angle of the child about axis2 is -ratio times that of
        the parent about axis, both against the reference body."""
        node, sides = edge.node, list[tuple[str, float]]()
        reference = self.frames.body(self.frames.find(node.said("gearbox_reference_body"), node))
        for end, tag in ((edge.parent, "axis"), (edge.child, "axis2")):
            about = self._axis(node, tag if node.element.find(tag) is not None else "axis")[1]
            for each in map(self.inboard.get, (end, reference)):
                if each and {each.parent, each.child} == {reference, end} and each.type in _TURNS:
                    along = float(about @ np.array(each.row[0].axis)) * (1 if each.child is end else -1)
                    sides += [(each.node.name, float(np.sign(along)))] if abs(along) > 1 - _PARALLEL else []
        if len(sides) != 2 or sides[1][0] in mimics:
            return False
        ratio = node.number("gearbox_ratio", 1.0, node.element)
        mimics[sides[1][0]] = Mimic(sides[0][0], -ratio * sides[0][1] * sides[1][1])
        return True


def _bound(limit: Element | None, tag: str, node: Node) -> float | None:
    """Return a limit; None where it is missing or none, as infinity and 1e16 are."""
    child = node.child(tag, limit)
    if child is None or child.text.strip().lower().lstrip("+-") in ("", "inf", "infinity"):
        return None
    (value,) = node.numbers(child, 1)
    return value if abs(value) < _NONE else None
