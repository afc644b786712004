"""The frames of an SDF file: models within models, files that it includes, and where everything stands at rest.

Links, joints, models and <frame>s are frames. Each stands relative to another one that its model names. Up to SDF 1.6
the attribute `frame` is `relative_to`, and a joint knows only its child and its model.
"""

from __future__ import annotations

import os
from collections import Counter
from dataclasses import dataclass, field
from math import radians
from pathlib import Path

import numpy as np

from robodyn.errors import DescriptionError
from robodyn.programs.vectors import IDENTITY, product, rotation_from_quaternion, rotation_from_rpy, snapped
from robodyn.robot.urdf.description import Strict
from robodyn.robot.urdf.document import Element, read_document
from robodyn.robot.urdf.sources import Search, package_of
from robodyn.robot.urdf.view import TEXT, numbers
from robodyn.support.floats import Floats
from robodyn.support.wording import alternatives, count, listed, shown

Pose = tuple[Floats, Floats]
"""Rotation and position [m] of a frame in another."""
HERE: Pose = IDENTITY, np.zeros(3)
WORLD, MODEL = "world", "__model__"
_MOST_NESTED, _MOST_INCLUDED, _MOST_BYTES = 40, 500, 1 << 24
"""Models within each other, files that are included, and their bytes."""
_NO_COUNTERPART = {"plugin", "gripper", "actor", "wind", "state", "velocity_decay", "fluid_added_mass"}
_NEAR = 8 * np.finfo(float).eps


def composed(outer: Pose, inner: Pose) -> Pose:
    (R, p), (turn, at) = outer, inner
    return snapped(product(R, turn)), p + product(R, at)


def relative(outer: Pose, inner: Pose) -> Pose:
    """Return the pose of `inner` in `outer`, both given in a third frame; what rounding leaves of 0 is 0."""
    (R, p), (turn, at) = outer, inner
    moved = np.where(np.abs(at - p) <= _NEAR * max(np.abs(at).max(), np.abs(p).max()), 0.0, at - p)
    moved = product(R.T, moved)
    return snapped(product(R.T, turn)), np.where(np.abs(moved) <= _NEAR * np.abs(moved).max(), 0.0, moved)


def truth(text: str) -> bool:
    return text.strip().lower() in ("1", "true")


@dataclass(frozen=True)
class Text:
    """One file: its folder seen from that of the main file, its version, the files that include it, itself last, and
    the line of the main file that does so; 0 for that itself."""

    strict: Strict
    folder: str
    version: tuple[int, ...]
    trail: tuple[str, ...]
    line: int = 0


@dataclass(eq=False)
class Node:
    """A frame at `pose` relative to the frame `base` that its model names; to the model where that is empty.

    Attributes:
        name: seen from the robot: `arm::hand`.
        model: that it is in; the world is in none.
        attached: of a <frame> what it moves with, of a joint its child, of a model its canonical link.
        placement: of a model the frame in it that stands at `pose`, in place of the model's own.
        names, prefix: of a model the frames in it, and what stands before their names.
        weightless: gravity is off for the model.
    """

    name: str
    element: Element
    text: Text
    model: Node | None
    pose: Pose = HERE
    base: str = ""
    attached: str = ""
    placement: str = ""
    names: dict[str, Node] | None = None
    prefix: str = ""
    weightless: bool = False

    @property
    def owner(self) -> str:
        return f"{self.element.tag} {shown(self.name)}"

    @property
    def above(self) -> list[Node]:
        """The models that it is in, itself first and the world left out."""
        node, found = self, list[Node]()
        while node.model is not None:
            found.append(node)
            node = node.model
        return found

    def line(self, element: Element | None = None) -> int:
        """Return the line of the main file in which it or one of its elements is, or which includes that."""
        return self.text.line or (element or self.element).line

    def error(self, what: str, remedy: str, at: Element | None = None) -> DescriptionError:
        return self.text.strict.error((at or self.element).line, what, remedy)

    def child(self, tag: str, inside: Element | None) -> Element | None:
        """Return a child of one of its elements."""
        return None if inside is None else self.text.strict.child(inside, tag, self.owner)

    def said(self, tag: str, default: str | None = None, inside: Element | None = None) -> str:
        """Return the text of a child of its element or of another one; without a default there must be one."""
        child = self.child(tag, inside or self.element)
        if default is None and (child is None or not child.text.strip()):
            where = self.owner if inside is None else f"<{inside.tag}> in {self.owner}"
            raise self.error(f"{where} has no <{tag}>, or an empty one", f"write <{tag}>", inside)
        return ("" if child is None else child.text.strip()) or default or ""

    def number(self, tag: str, default: float, inside: Element | None) -> float:
        """Return the number of a child."""
        child = self.child(tag, inside)
        return default if child is None or not child.text.strip() else self.numbers(child, 1)[0]

    def numbers(self, element: Element, amount: int) -> tuple[float, ...]:
        return self.text.strict.numbers(numbers(element, TEXT, amount), self.owner)

    def pose_in(self, element: Element) -> tuple[Pose, str]:
        """Return the <pose> of an element, and the name of the frame that it is relative to, empty if it says none."""
        written = self.child("pose", element)
        base = "" if written is None else written.get("relative_to") or written.get("frame") or ""
        if written is None or not written.text.strip():
            return HERE, base
        if written.get("rotation_format") == "quat_xyzw":
            *at, x, y, z, w = self.numbers(written, 7)
            size = max(map(abs, (x, y, z, w)))
            if not size:
                raise self.error(f"<pose> of {self.owner} has a quaternion of length 0", "write 0 0 0 1", written)
            return (snapped(rotation_from_quaternion(x / size, y / size, z / size, w / size)), np.array(at)), base
        *at, roll, pitch, yaw = self.numbers(written, 6)
        if truth(written.get("degrees") or ""):
            roll, pitch, yaw = map(radians, (roll, pitch, yaw))
        return (rotation_from_rpy(roll, pitch, yaw), np.array(at)), base


@dataclass(eq=False)
class Frames:
    """All that is in a file and in the files that it includes.

    Attributes:
        nodes, links, joints: in the order of the files.
        robot: the model; `static` says of the models that are in no other whether they cannot move.
        gravity: what the world says [m/s^2].
        left: how often there is what has no counterpart.
        missing: models of a world that are on no disk here.
        poses: where everything stands in the frame of the robot's model.
    """

    search: Search
    nodes: list[Node] = field(default_factory=list)
    left: Counter[str] = field(default_factory=Counter)
    missing: list[str] = field(default_factory=list)
    static: dict[Node, bool] = field(default_factory=dict)
    included: int = 0
    size: int = 0

    def read(self, data: bytes) -> None:
        """Read a file: its one model, or the one model of its world that is not static."""
        file = self.search.file
        sdf = read_document(data, file, "sdf").root
        found = [child for child in sdf.children if child.tag in ("model", "world")]
        outermost = found[0] if found and found[0].tag == WORLD else sdf
        self.world = world = Node(WORLD, outermost, _text(sdf, file, "", (os.path.realpath(file),)), None, names={})
        if len(found) != 1:
            what = f"<sdf> has {count(len(found), 'model or world', 'models and worlds')}, not one"
            raise world.error(what, "give a file with one of them", found[1] if found else sdf)
        self._contents(world)
        gravity = world.child("gravity", outermost)
        self.gravity = () if gravity is None else world.numbers(gravity, 3)
        models = list(self.static)
        moving = [model for model in models if not self.static[model]]
        chosen = moving if len(moving) == 1 else models
        if len(chosen) != 1:
            what = f"the world has {count(len(chosen), 'model')}: {listed([model.name for model in chosen])}"
            remedy = "give a file with one robot; static models beside it are left out"
            if self.missing and not chosen:
                what, remedy = f"{listed(self.missing)} is not found", "--package-path DIR names the folder it is in"
            raise world.error(what, remedy)
        (self.robot,) = chosen
        self.left["static model"] += len(models) - 1
        own = [node for node in self.nodes if node.above[-1] is self.robot or node.model is world]
        self.links, self.joints = ([node for node in own if node.element.tag == tag] for tag in ("link", "joint"))
        self._stand()

    def _contents(self, model: Node) -> None:
        """Enter what a model or the world has."""
        if len(model.above) > _MOST_NESTED:
            raise model.error(f"models are nested more than {_MOST_NESTED} deep", "no robot needs as much")
        for child in model.element.children:
            if child.tag == "include":
                self._include(child, model)
            elif child.tag == "model":
                self._model(child, model, model.text, None)
            elif child.tag in ("link", "joint", "frame"):
                node = self._entered(child, model, model.text, model.text.strict.text(child, "name", f"<{child.tag}>"))
                node.pose, node.base = node.pose_in(child)
                node.attached = node.said("child") if child.tag == "joint" else child.get("attached_to") or ""
                self._note_lost(child)
        self._note_lost(model.element)

    def _note_lost(self, element: Element) -> None:
        self.left.update(f"<{child.tag}>" for child in element.children if child.tag in _NO_COUNTERPART)

    def _entered(self, element: Element, model: Node, text: Text, name: str, hidden: bool = False) -> Node:
        node = Node(model.prefix + name, element, text, model)
        if name in (WORLD, MODEL) or "::" in name:
            raise node.error(f"{shown(name)} is a name that SDF keeps", "name it otherwise")
        assert model.names is not None, "it is a model"
        first = node if hidden else model.names.setdefault(name, node)
        if first is not node and (first.element.tag == element.tag or text.version >= (1, 7)):
            what = f"a second {shown(name)}, the first is in line {first.element.line}"
            raise node.error(what, "rename one of them")
        self.nodes.append(node)
        return node

    def _model(self, element: Element, within: Node, text: Text, by: Element | None) -> None:
        """Enter a model of the file `text`, which the file of another one may include `by` an element."""
        merged = by is not None and truth(by.get("merge") or "")
        name = within.said("name", "", by) if by is not None else ""
        name = name or text.strict.text(element, "name", "<model>")
        node = self._entered(element, within, text, name, merged)
        # What is merged belongs to the model that includes it; only its own frame has no name there.
        prefix = "" if within is self.world else f"{node.name}::"
        node.names, node.prefix = (within.names, within.prefix) if merged else ({}, prefix)
        node.pose, node.base = node.pose_in(element)
        node.placement, node.attached = element.get("placement_frame") or "", element.get("canonical_link") or ""
        node.weightless = within.weightless or not truth(node.said("gravity", "true"))
        static = node.said("static", "")
        if by is not None:
            if within.child("pose", by) is not None:
                node.pose, node.base = within.pose_in(by)
            node.placement = within.said("placement_frame", node.placement, by)
            static = within.said("static", static, by)
            self._note_lost(by)
        if within is self.world:
            self.static[node] = truth(static)
        self._contents(node)

    def _include(self, element: Element, within: Node) -> None:
        uri, trail = within.said("uri", None, element), within.text.trail
        path = self._found(uri, element, within)
        if path is None and within is self.world and package_of(uri) is not None:
            self.missing.append(uri)
            return
        if path is None:
            remedy = "--package-path DIR names the folder it is in"
            raise within.error(f"the included {shown(uri)} is not found", remedy, element)
        real = os.path.realpath(path)
        if real in trail:
            raise within.error(f"{shown(uri)} includes itself", "a file cannot contain itself", element)
        self.included, self.size = self.included + 1, self.size + os.path.getsize(real)
        if self.included > _MOST_INCLUDED or self.size > _MOST_BYTES:
            what = f"more than {_MOST_INCLUDED} files, or {_MOST_BYTES} bytes, are included"
            raise within.error(what, "no robot needs as much", element)
        sdf = read_document(path, None, "sdf").root
        here = os.path.relpath(path.parent, os.path.dirname(os.path.abspath(self.search.file)))
        text, models = _text(sdf, str(path), here, (*trail, real), within.line(element)), sdf.findall("model")
        if len(models) != 1:
            what = f"an included file has {count(len(models), 'model')}, not one"
            raise text.strict.error(sdf.line, what, "include files with one model")
        self._model(models[0], within, text, element)

    def _found(self, uri: str, element: Element, within: Node) -> Path | None:
        """Return the file that is included, which lies in the folder of the description or in a package path."""
        package, base = package_of(uri), Path(os.path.dirname(os.path.abspath(self.search.file)))
        if "\0" in uri or (package is None and "://" in uri):
            raise within.error(f"{shown(uri)} is no file here", "include a file of model://", element)
        tried = [base / within.text.folder / uri]
        if package is not None:
            tried = [path / package[1] for path in (base / package[0], *self.search.packages(package[0]))]
        allowed = [os.path.realpath(folder) for folder in (str(base), *self.search.package_paths)]
        outside = False
        for path in filter(os.path.exists, tried):
            file, safe = path, any(map(Path(os.path.realpath(path)).is_relative_to, allowed))
            if safe and os.path.isdir(path):
                file = path / _configured(path)
                safe = any(map(Path(os.path.realpath(file)).is_relative_to, allowed))
            if safe and os.path.isfile(file):
                return file
            outside |= not safe
        if outside:
            what = f"the included {shown(uri)} is outside the folder of the description and the package paths"
            raise within.error(what, "--package-path DIR lets it be read", element)
        return None

    def find(self, name: str, node: Node, model: Node | None = None) -> Node:
        """Return what a frame calls by a name, seen from its model or another: `link`, `model::link`, `__model__`."""
        if name == WORLD:
            return self.world
        found = model or node.model
        for part in name.split("::"):
            names = (found and found.names) or {}
            found = found if part == MODEL else names.get(part)
            if found is None:
                what = f"{node.owner} names {shown(name)}, which does not exist"
                raise node.error(what, alternatives(part, names, "names"))
        assert found is not None, "a name has a part"
        return found

    def _stand(self) -> None:
        """Find where everything stands: each frame but the world is one step away from another one."""
        steps: dict[Node, list[tuple[Node, Pose]]] = {}
        for node in self.nodes:
            base = node.base or (node.attached if node.element.tag in ("joint", "frame") else "") or MODEL
            outer = self.find(base, node)
            end = self.find(node.placement, node, node) if node.placement else node
            R, p = node.pose
            steps.setdefault(outer, []).append((end, node.pose))
            steps.setdefault(end, []).append((outer, (R.T, -product(R.T, p))))
        self.poses, waiting = {self.robot: HERE}, [self.robot]
        while waiting:
            node = waiting.pop()
            for other, pose in steps.get(node, ()):
                if other not in self.poses:
                    self.poses[other] = composed(self.poses[node], pose)
                    waiting.append(other)
        for node in self.nodes:
            if node not in self.poses:
                raise node.error(f"the pose of {node.owner} hangs on itself", "let it be relative to its model")

    def body(self, node: Node) -> Node:
        """Return the link that a frame moves with, or the world."""
        seen = set[Node]()
        while node.element.tag != "link" and node is not self.world:
            if node in seen:
                raise node.error(f"{node.owner} is attached to itself", "attach it to a link")
            seen.add(node)
            inside = [each for each in (node.names or {}).values() if each.element.tag in ("link", "model")]
            if node.attached:
                node = self.find(node.attached, node, None if node.names is None else node)
            elif node.names is None:
                node = self.find(MODEL, node)
            elif inside:
                node = min(inside, key=lambda each: each.element.tag)
            else:
                raise node.error(f"{node.owner} has no link", "add a <link>")
        return node


def _text(sdf: Element, file: str, folder: str, trail: tuple[str, ...], line: int = 0) -> Text:
    strict, written = Strict(file), sdf.get("version") or "1.7"
    parts = written[:20].split(".")[:2]
    if not all(part.isdecimal() for part in parts):
        raise strict.error(sdf.line, f"the version is {shown(written)}", 'write version="1.7"')
    return Text(strict, folder, tuple(map(int, parts)), trail, line)


def _configured(folder: Path) -> str:
    """Return the newest file that the model.config of a folder names."""
    config = folder / "model.config"
    files = read_document(config, None, "model").root.findall("sdf") if os.path.isfile(config) else []

    def version(element: Element) -> list[int]:
        return [int(part) for part in (element.get("version") or "")[:20].split(".") if part.isdecimal()]

    return max(files, key=version).text.strip() if files else "model.sdf"
