"""SDF -> Description: links and joints by their names, what closes loops, springs and gravity as a scene.

1. `frames` reads models within models and files within files, and finds where everything stands at rest.
2. Joints that make a tree of the links are joints, the others loops: of those that can be, balls first, then hinges.
3. A link has the axes that it has in SDF, and its origin there or, where it turns about another point, in that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Any, cast

import numpy as np

from robodyn.errors import DescriptionError, InputError, RobodynError
from robodyn.programs.vectors import IDENTITY, ZERO, length, product, rpy_from_rotation, snapped
from robodyn.robot.sdf.frames import MODEL, WORLD, Frames, Node, Pose, composed, named, pose_in, relative, truth
from robodyn.robot.urdf import parts
from robodyn.robot.urdf.description import check_mimics
from robodyn.robot.urdf.document import Element
from robodyn.robot.urdf.parts import Description, Geometry, Inertial, Joint, Kind, Limit, Link, Mimic, Origin, Vector
from robodyn.robot.urdf.sources import Search, package_of
from robodyn.robot.urdf.view import TEXT, NumbersError, numbers, parse_numbers
from robodyn.solids.inertia.properties import MassProperties, composite
from robodyn.solids.inertia.solids import SHAPES, WATER
from robodyn.solids.mass_properties import mass_properties
from robodyn.solids.mesh.read.load import load_triangles
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
    def __init__(self, frames: Frames) -> None:
        self.frames, self.world = frames, frames.world
        self.notes: list[tuple[int, str]] = []
        self.lost: list[str] = []
        self.bare: list[str] = []
        self.springs: dict[str, dict[str, float]] = {}
        self.written: dict[str, Element] = {}
        self.taken = {*(node.name for node in (*frames.links, *frames.joints)), WORLD}
        self.free: list[Node] = []
        self.edges = [self._edge(joint) for joint in frames.joints]
        self._grow()

    def _error(self, node: Node, what: str, remedy: str) -> DescriptionError:
        return node.text.strict.error(node.element.line, f"{node.owner} {what}", remedy)

    def _note(self, node: Node, what: str) -> None:
        file = node.text.strict.file
        place = "" if file == self.frames.search.file else f"{file}: "
        self.notes.append((node.element.line, f"{place}{node.owner} {what}"))

    def _name(self, name: str) -> str:
        """Return the name, or one like it that nothing has."""
        found, k = name, 1
        while found in self.taken:
            found, k = f"{name}{k + 1}", k + 1
        self.taken.add(found)
        return found

    def _edge(self, node: Node) -> _Edge:
        element, strict, frames, name = node.element, node.text.strict, self.frames, node.name
        kind = strict.text(element, "type", node.owner)
        if kind not in _TYPES:
            raise self._error(node, f"has the unknown type {shown(kind)}", alternatives(kind.lower(), _TYPES, "types"))
        parent = frames.body(frames.find(named(element, "parent", node.owner, strict), node))
        child = frames.body(frames.find(node.attached, node))
        if parent is child or not {parent, child} <= {self.world, *frames.links}:
            raise self._error(node, f"ties {shown(parent.name)} to {shown(child.name)}", "name two links of one robot")
        names = [self._name(f"{name}_{end}") for end in _ROWS.get(kind, "")]
        row = []
        if kind == "ball":
            R, axis = frames.poses[node][0], strict.child(element, "axis", node.owner)
            resists = {} if axis is None else self._resistance(axis, node, names, "ball")
            row = [Joint(each, "continuous", "", "", axis=_vector(R[:, k]), **resists) for k, each in enumerate(names)]
        elif kind in _ROWS:
            row = [self._hinge(node, tag, each) for tag, each in zip(("axis", "axis2"), names, strict=True)]
        elif kind not in ("fixed", "gearbox"):
            row = [
                self._hinge(
                    node, "axis", name, "prismatic" if kind == "prismatic" else kind.replace("screw", _TURNS[0])
                )
            ]
        if names:
            singular = f", singular where {shown(names[1])} is at 90 degrees" if kind == "ball" else ""
            rates = kind == "ball" and (row[0].damping or row[0].friction or names[0] in self.springs)
            more = "; friction and springs act on their angles" if rates else ""
            self._note(node, f"is the hinges {listed(names)} in a row{singular}{more}")
        if kind == "screw":
            pitch = _value(element, "screw_thread_pitch", node, 0.0)
            if not pitch and (old := _value(element, "thread_pitch", node, 0.0)):
                pitch = -2 * pi / old  # rad/m of a left-handed thread, as Gazebo had it
            slide = self._name(f"{name}_slide")
            row.append(Joint(slide, "prismatic", "", "", axis=row[0].axis, mimic=Mimic(name, pitch / (2 * pi))))
            self._note(node, f"is a hinge, and the slide {shown(slide)} that mimics it")
        return _Edge(node, kind, parent, child, [replace(joint, line=element.line) for joint in row])

    def _axis(self, node: Node, tag: str) -> tuple[Element, Floats]:
        """Return an axis as written and as a direction in the robot's frame."""
        strict, owner = node.text.strict, node.owner
        axis = strict.needed_child(node.element, tag, owner)
        written, frame = strict.child(axis, "xyz", owner), node
        direction = np.array((0.0, 0.0, 1.0) if written is None else strict.vector(numbers(written, TEXT, 3), owner))
        if not direction.any():
            what = f"the axis of {owner} has the length 0, which gives no direction"
            raise strict.error(axis.line, what, "write a direction, for example 0 0 1")
        if written is not None and (other := written.get("expressed_in")):
            frame = self.frames.find(other, node)
        elif node.text.old:
            usual = "true" if node.text.version < (1, 5) else "false"
            if truth(named(axis, "use_parent_model_frame", owner, strict, usual)):
                frame = self.frames.find(MODEL, node)
        direction = direction / np.abs(direction).max()
        return axis, product(self.frames.poses[frame][0], direction / length(direction))

    def _hinge(self, node: Node, tag: str, name: str, kind: str = "revolute") -> Joint:
        axis, along = self._axis(node, tag)
        resists = self._resistance(axis, node, [name], kind)
        if (mimic := node.text.strict.child(axis, "mimic", node.owner)) is not None:
            self.written[name] = mimic
        if kind == "revolute" and (
            resists["limit"] is None or resists["limit"].lower is resists["limit"].upper is None
        ):
            kind = "continuous"
        return Joint(name, kind, "", "", axis=_vector(along), **resists)

    def _resistance(self, axis: Element, node: Node, names: list[str], kind: str) -> dict[str, Any]:
        """Return limits and friction of an axis, and keep its spring."""
        strict, owner = node.text.strict, node.owner
        dynamics, within = strict.child(axis, "dynamics", owner), strict.child(axis, "limit", owner)
        keys = ("damping", "friction", "spring_stiffness", "spring_reference")
        *friction, stiffness, rest = (_value(dynamics, key, node, 0.0) for key in keys)
        for key, value in zip(keys, friction, strict=False):
            if value < 0.0:
                self._note(node, f"has a negative {key}: {value:g}")
        if stiffness:
            self.springs |= {name: {"stiffness": stiffness, "rest": rest} for name in names}
        lower, upper, *most = (_bound(within, tag, node) for tag in ("lower", "upper", "effort", "velocity"))
        effort, velocity = (None if value is None or value < 0.0 else value for value in most)
        limit = Limit(*((None, None) if kind in ("continuous", "ball") else (lower, upper)), effort, velocity)
        return {"damping": friction[0], "friction": friction[1], "limit": None if limit == Limit() else limit}

    def _grow(self) -> None:
        """Find the joints that make a tree of the links, from its root on, and the loops that the others close."""
        group: dict[Node, Node] = {}

        def of(body: Node) -> Node:
            while body in group:
                group[body] = body = group.get(group[body], group[body])
            return body

        at: dict[Node, list[_Edge]] = {}
        self.loops: list[_Edge] = []
        for edge in sorted(self.edges, key=lambda edge: edge.rank):
            if edge.type != "gearbox" and of(edge.parent) is of(edge.child):
                self.loops.append(edge)
            elif edge.type != "gearbox":
                group[of(edge.child)] = of(edge.parent)
                at.setdefault(edge.parent, []).append(edge)
                at.setdefault(edge.child, []).append(edge)
        children = {edge.child for edge in self.edges}
        roots = {of(self.world): self.world} if self.world in at else {}
        for link in sorted(self.frames.links, key=lambda link: link in children):
            roots.setdefault(of(link), link)
        if not roots:
            raise self._error(self.frames.robot, "has no link", "add a <link>")
        self.root, self.free = self.world, [root for root in roots.values() if root is not self.world]
        self.still = self.frames.static[self.frames.robot] or (len(roots) == 1 and self.world not in at)
        if self.free and not self.frames.static[self.frames.robot]:
            how = "stands fixed here unless its base is freed, as that of a URDF" if self.still else "moves here, too"
            names = listed([link.name for link in self.free])
            what = f"nothing fixes {names} to the world: SDF lets it move, and it {how}"
            self.notes.append((self.frames.robot.element.line, what))
        if self.world not in at and len(roots) == 1:
            turned = relative(self.frames.poses[self.world], self.frames.poses[self.free[0]])[0]
            if np.array_equal(turned, IDENTITY):
                self.root, self.free = self.free[0], []
        self.inboard: dict[Node, _Edge] = {}
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
        R, p = self.frames.poses[body]
        edge = self.inboard.get(body)
        turns = edge is not None and any(joint.type in _TURNS for joint in edge.row)
        return (R, self.frames.poses[edge.node][1]) if edge is not None and turns else (R, p)

    def description(self) -> Description:
        frames, strict = self.frames, self.frames.robot.text.strict
        joints, between = list[Joint](), dict[Node, list[Link]]()
        for link in self.free:
            kind = "fixed" if self.still else "floating"
            origin = _origin(relative(frames.poses[self.world], self._frame(link)))
            name = self._name(f"{link.name}_{kind}")
            joints.append(Joint(name, kind, WORLD, link.name, origin, line=link.element.line))
        below = {edge: body for body, edge in self.inboard.items()}
        for edge in filter(below.__contains__, self.edges):
            body = below[edge]
            above, row = (edge.parent, edge.row) if body is edge.child else (edge.child, edge.row[::-1])
            here, parent = _origin(relative(self._frame(above), self._frame(body))), above.name
            row = row or [Joint(edge.node.name, "fixed", "", "", line=edge.node.element.line)]
            for k, joint in enumerate(row):
                child = body.name if k == len(row) - 1 else self._name(f"{body.name}_{joint.name}")
                if child != body.name:
                    between.setdefault(body, []).append(Link(child, line=joint.line))
                # Seen from the other side, a joint has the same coordinate about the opposite axis.
                along = snapped(product(frames.poses[body][0].T, np.array(joint.axis)))
                axis = _vector(along if body is edge.child else -along)
                joints.append(replace(joint, parent=parent, child=child, origin=here, axis=axis))
                parent, here = child, Origin()
        links = [Link(WORLD)] if self.root is self.world else []
        for body in frames.links:
            links += [*between.get(body, ()), self._link(body)]
        scene, joints = self._scene(links), self._followed(joints)
        rotors = tuple(filter(None, map(self._rotor, below)))
        if self.bare:
            what = f"no <inertial> in {listed(self.bare)}: SDF makes it 1 kg, and 1 kg m^2 about each axis"
            self.notes.append((frames.robot.element.line, what))
        lost = [count(number, what, what) for what, number in frames.left.items() if number]
        if lost := [*lost, *(f"{uri}, which is not found" for uri in frames.missing), *self.lost]:
            self.notes.append((1, f"left out, as nothing here is like it: {'; '.join(lost)}"))
        by_name = {joint.name: joint for joint in joints}
        check_mimics(by_name, {joint.name: joint.line for joint in joints}, strict)
        notes, search = tuple(sorted(self.notes, key=lambda note: note[0])), frames.search
        name = frames.robot.name
        return Description(
            name, search.file, tuple(links), tuple(joints), rotors, self.root.name, notes, search, b"", scene, "sdf"
        )

    def _link(self, node: Node) -> Link:
        element, strict, name = node.element, node.text.strict, node.name
        moved = relative(self._frame(node), self.frames.poses[node])
        shapes = [(each, self._placed(each, node)) for each in element.children if each.tag in ("visual", "collision")]
        geometries = []
        for each, pose in shapes:
            if (shape := self._shape(each, node)) is not None:
                geometries.append(replace(shape, origin=_origin(composed(moved, pose))))
        written = strict.child(element, "inertial", node.owner)
        if written is None:
            self.bare.append(name)
        if written is not None and truth(written.get("auto") or ""):
            body = self._weighed(written, node, [shape for shape in shapes if shape[0].tag == "collision"])
            mass, pose, I = body.mass, (IDENTITY, body.com), body.inertia
            entries = [float(I["xyz".index(tag[1]), "xyz".index(tag[2])]) for tag in parts.INERTIA]
        else:
            pose = (IDENTITY, ZERO) if written is None else pose_in(written, node.owner, strict)[0]
            mass = _value(written, "mass", node, 1.0)
            inertia = None if written is None else strict.child(written, "inertia", node.owner)
            entries = [_value(inertia, tag, node, float(tag[1] == tag[2])) for tag in parts.INERTIA]
        if mass < 0:
            self._note(node, f"has a negative mass: {mass:g} kg")
        xx, xy, xz, yy, yz, zz = entries
        inertial = Inertial(mass, _origin(composed(moved, pose)), (xx, xy, xz, yy, yz, zz))
        return Link(name, inertial, tuple(geometries), element.line)

    def _placed(self, element: Element, node: Node) -> Pose:
        """Return the pose of a shape in its link."""
        pose, base = pose_in(element, node.owner, node.text.strict)
        if not base:
            return pose
        return composed(relative(self.frames.poses[node], self.frames.poses[self.frames.find(base, node)]), pose)

    def _shape(self, element: Element, node: Node) -> Geometry | None:
        """Return a shape at the origin; None, with a note, of what is no shape here."""
        strict, owner, kind = node.text.strict, node.owner, cast("Kind", element.tag)
        for child in strict.needed_child(element, "geometry", owner).children:
            if child.tag in parts.SIZES:
                size: tuple[float, ...] = ()
                for tag in parts.SIZES[child.tag]:
                    written = strict.needed_child(child, tag, owner)
                    size += strict.numbers(numbers(written, TEXT, 3 if tag == "size" else 1), owner)
                return Geometry(kind, Origin(), cast("parts.Shape", child.tag), size, line=element.line)
            if child.tag == "mesh" and child.find("submesh") is None:
                uri, scale = named(child, "uri", owner, strict), strict.child(child, "scale", owner)
                factors = (1.0, 1.0, 1.0) if scale is None else strict.vector(numbers(scale, TEXT, 3), owner)
                if package_of(uri) is None and "://" not in uri and node.text.folder:
                    uri = f"{node.text.folder}/{uri}"
                return Geometry(kind, Origin(), "mesh", (), uri, factors, element.line)
            if child.tag != "empty":
                self.frames.left[f"<{child.tag}> of a {kind}"] += 1
        return None

    def _weighed(self, inertial: Element, node: Node, shapes: Sequence[tuple[Element, Pose]]) -> MassProperties:
        """Return the body of a link's collisions, each of its density or that of the link, in the link's frame."""
        strict, usual = node.text.strict, _value(inertial, "density", node, WATER)
        bodies = []
        for collision, pose in shapes:
            shape, density = self._shape(collision, node), _value(collision, "density", node, usual)
            path = None if shape is None or shape.filename is None else self.frames.search.find(shape.filename)
            try:
                if not density > 0.0 or shape is None or (shape.filename is not None and path is None):
                    raise InputError(
                        f"is of a shape that is not known or not found, or of the density {density:g} kg/m^3"
                    )
                if path is None:
                    body = SHAPES[shape.shape](*shape.size, density=density)
                else:
                    mesh = load_triangles(path)
                    body = mass_properties(mesh, scale=shape.scale, symmetry=False, tessellation=False).body
                    body = body.scaled_to_mass(body.mass * density / WATER)
            except RobodynError as error:
                what = f"a <collision> of {node.owner} gives no mass: {error.what}"
                raise strict.error(collision.line, what, error.remedy or "write <mass> and <inertia>") from None
            bodies.append((body, pose))
        if not bodies:
            raise self._error(node, 'has <inertial auto="true"> and no <collision>', "add one, or write the mass")
        body = composite(bodies)
        mass = _value(inertial, "mass", node, body.mass)
        return body if mass == body.mass else body.scaled_to_mass(mass)

    def _scene(self, links: Sequence[Link]) -> dict[str, Any]:
        """Return gravity, springs and loops as the tables of a scene."""
        frames = self.frames
        scene: dict[str, Any] = {"gravity": list(frames.gravity)} if frames.gravity else {}
        light = {link.name: None for link in frames.links if self._weightless(link)}
        if len(light) == len(frames.links):
            scene["gravity"] = [0.0, 0.0, 0.0]
        elif light:
            down = frames.gravity or _EARTH
            g = " ".join(f"{each:g}" for each in down)
            what = f"gravity is off for {listed(light)}: forces carry them against {g} m/s^2"
            self.notes.append((frames.robot.element.line, what))
            scene["wrench"] = []
            for link in links:
                if link.name in light and link.inertial is not None:
                    force, point = [-link.inertial.mass * g + 0.0 for g in down], list(link.inertial.origin.xyz)
                    scene["wrench"].append({"link": link.name, "force": force, "point": point, "frame": "world"})
        closing = {joint.name for edge in self.loops for joint in edge.row}
        scene["spring"] = {name: spring for name, spring in self.springs.items() if name not in closing}
        loops = [
            edge
            for edge in self.loops
            if edge.type in _LOOPS and self._rigid(edge.child) is not self._rigid(edge.parent)
        ]
        scene["loop"] = [self._loop(edge) for edge in loops]
        for edge in self.loops:
            where = f"joint {shown(edge.node.name)}"
            if edge not in loops and edge.type in _LOOPS:
                self.lost.append(f"{where}, whose links are fixed to each other")
            elif edge.type not in _LOOPS:
                self.lost.append(f"{where} ({edge.type}), which closes a loop")
            elif any(j.damping or j.friction or j.limit or j.name in self.springs for j in edge.row):
                self.lost.append(f"limits, friction and springs of {where}, which closes a loop")
        return {key: value for key, value in scene.items() if value}

    def _rigid(self, body: Node) -> Node:
        """Return the link nearest to the root that a link is fixed to."""
        while (edge := self.inboard.get(body)) is not None and not edge.row:
            body = edge.parent if body is edge.child else edge.child
        return body

    def _loop(self, edge: _Edge) -> dict[str, Any]:
        kind, joint, ends = _LOOPS[edge.type], self.frames.poses[edge.node], (edge.child, edge.parent)
        loop: dict[str, Any] = {"name": edge.node.name, "link": edge.child.name, "to": edge.parent.name, "kind": kind}
        for prefix, end in zip(("", "to_"), map(self._frame, ends), strict=True):
            loop[f"{prefix}point"] = list(_vector(relative(end, joint)[1]))
            if kind == "hinge":
                loop[f"{prefix}axis"] = list(_vector(snapped(product(end[0].T, np.array(edge.row[0].axis)))))
        if kind == "weld":
            loop["rpy"] = list(rpy_from_rotation(relative(self._frame(edge.parent), self._frame(edge.child))[0]))
        return loop

    def _weightless(self, link: Node) -> bool:
        assert link.model is not None, "a link is in a model"
        falls = truth(named(link.element, "gravity", link.owner, link.text.strict, "true"))
        return link.model.weightless or not falls

    def _rotor(self, edge: _Edge) -> parts.Transmission | None:
        name, line = edge.node.name, edge.node.element.line
        inertia = _value(edge.node.element, "drake:rotor_inertia", edge.node, 0.0)
        gear = _value(edge.node.element, "drake:gear_ratio", edge.node, 1.0)
        driven = inertia and edge.row and edge.row[0].name == name
        return parts.Transmission(f"{name}_rotor", name, gear, inertia, line) if driven else None

    def _followed(self, joints: Sequence[Joint]) -> list[Joint]:
        """Return the joints with those that mimic others: by <mimic> or gearbox."""
        mimics = {joint.name: joint.mimic for joint in joints if joint.mimic is not None}
        rows = {edge.node: edge.row for edge in self.edges}
        for edge in self.edges:
            for name in (joint.name for joint in edge.row if joint.name in self.written):
                mimic, node = self.written[name], edge.node
                leader = self.frames.find(node.text.strict.text(mimic, "joint", node.owner), node)
                of = rows.get(leader, [])
                which = min(int(mimic.get("axis") == "axis2"), len(of) - 1)
                multiplier, offset = _value(mimic, "multiplier", node, 1.0), _value(mimic, "offset", node, 0.0)
                offset -= multiplier * _value(mimic, "reference", node, 0.0)
                mimics[name] = Mimic(of[which].name if of else leader.name, multiplier, offset)
            if edge.type == "gearbox" and not self._geared(edge, mimics):
                self.lost.append(f"gearbox {shown(edge.node.name)}, whose links do not turn about its reference body")
        return [replace(joint, mimic=mimics.get(joint.name)) for joint in joints]

    def _geared(self, edge: _Edge, mimics: dict[str, Mimic]) -> bool:
        """Let one hinge follow another, if there are two: the angle of the child about axis2 is -ratio times that of
        the parent about axis, both against the reference body."""
        node, element = edge.node, edge.node.element
        ratio = _value(element, "gearbox_ratio", node, 1.0)
        body = named(element, "gearbox_reference_body", node.owner, node.text.strict)
        reference, sides = self.frames.body(self.frames.find(body, node)), []
        for end, tag in ((edge.parent, "axis"), (edge.child, "axis2")):
            about = self._axis(node, tag if element.find(tag) is not None else "axis")[1]
            for each in self.inboard.values():
                if {each.parent, each.child} == {reference, end} and each.type in _TURNS:
                    along = float(about @ np.array(each.row[0].axis)) * (1 if each.child is end else -1)
                    sides += [(each.node.name, np.sign(along))] if abs(along) > 1 - _PARALLEL else []
        if len(sides) != 2 or sides[1][0] in mimics:
            return False
        mimics[sides[1][0]] = Mimic(sides[0][0], float(-ratio * sides[0][1] * sides[1][1]))
        return True


def _value(element: Element | None, tag: str, node: Node, default: float) -> float:
    """Return the number that a child holds."""
    child = None if element is None else node.text.strict.child(element, tag, node.owner)
    empty = child is None or not child.text.strip()
    return default if empty else node.text.strict.number(numbers(child, TEXT, 1), node.owner)


def _bound(limit: Element | None, tag: str, node: Node) -> float | None:
    """Return a limit; None where it is missing or none, as infinity and 1e16 are."""
    child = None if limit is None else node.text.strict.child(limit, tag, node.owner)
    text = "" if child is None else child.text.strip()
    if child is None or text.lower().lstrip("+-") in ("", "inf", "infinity"):
        return None
    try:
        (value,) = parse_numbers(text, 1, "limit")
    except NumbersError as error:
        what = f"<{tag}> of {node.owner} {error}"
        raise node.text.strict.error(child.line, what, error.remedy) from None
    return value if abs(value) < _NONE else None


def _origin(pose: Pose) -> Origin:
    return Origin(_vector(pose[1]), rpy_from_rotation(pose[0]))


def _vector(values: Floats) -> Vector:
    x, y, z = (float(value) + 0.0 for value in values)
    return x, y, z
