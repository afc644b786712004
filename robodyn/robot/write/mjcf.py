"""Description -> MJCF: links become bodies, joints joints, loops and mimic rules equality constraints.

The frame of a body is that of its link. Links without mass between joints that follow each other have no body: their
joints stand in that of the next link.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from robodyn.errors import DescriptionError, InputError
from robodyn.programs.vectors import product, rpy_from_rotation, snapped
from robodyn.robot import model
from robodyn.robot.load import elementary, placement
from robodyn.robot.urdf.parts import ZERO, Description, Geometry, Inertial, Joint, Link
from robodyn.robot.write.common import MARK, Written, check_possible, comments_of, impossible, tag
from robodyn.solids.inertia.laws import symmetric
from robodyn.solids.mesh.read.load import load_triangles
from robodyn.support.floats import Floats
from robodyn.support.wording import listed, shown

WORLD, MESHES = "world", "meshes"
_LEAST = 1e-15
"""The least mass and moment that MuJoCo takes of what moves."""
_MOST_FACES = 200_000
"""Of a mesh that MuJoCo reads."""
_ONE = (1.0, 1.0, 1.0)
_HEAD = (
    '<compiler angle="radian" eulerseq="XYZ" autolimits="true" inertiafromgeom="false" balanceinertia="false"'
    ' boundmass="0" boundinertia="0" discardvisual="false" fusestatic="false"/>'
)


class _Move(NamedTuple):
    """An elementary joint, its frame in the parent body, and that of MuJoCo's kind."""

    joint: model.Joint
    R: Floats
    p: Floats


def write_mjcf(description: Description, out: str, *, convert_meshes: bool = False) -> Written:
    """Return the MJCF of a description for a file of this name.

    Args:
        convert_meshes: write meshes that MuJoCo does not read as STL, into the folder `meshes` beside the file.

    Raises:
        DescriptionError: a link is impossible, moves without mass, or floats on another.
    """
    check_possible(description)
    return _Writer(description, out, convert_meshes).written()


class _Writer:
    def __init__(self, description: Description, out: str, convert: bool) -> None:
        self.description, self.folder, self.convert = description, os.path.dirname(out) or os.curdir, convert
        self.links = {link.name: link for link in description.links}
        self.carried: dict[str, list[Joint]] = {name: [] for name in self.links}
        for joint in description.joints:
            self.carried[joint.parent].append(joint)
        self.armature = {e.joint: e.reduction**2 * (e.rotor_inertia or 0.0) for e in description.transmissions}
        self.springs: dict[str, Any] = description.scene.get("spring", {})
        self.comments = comments_of(description.data) if description.data else {}
        self.sites: dict[str, list[str]] = {}
        self.assets: dict[tuple[str, tuple[float, ...]], str] = {}
        self.files: dict[str, bytes] = {}
        self.made: dict[str, str] = {}
        self.unread: dict[str, str] = {}
        self.lost: dict[str, list[str]] = {}
        self.equalities: list[str] = []
        self.order: list[str] = []

    def written(self) -> Written:
        for loop in self.description.scene.get("loop", []):
            self._loop(loop)
        root = self.links[self.description.root]
        free = "base" in self.description.scene
        only = self.carried[root.name]
        floating = any(joint.type == "floating" for joint in only)
        body: list[str] = []
        if not free and not _massive(root) and (root.name == WORLD or floating):
            if root.name != WORLD:
                self._lose("names of links that are the world", root.name)
            body += self._content(root)
            for joint in only:
                body += self._bodies(joint)
        else:
            if root.name == WORLD:
                raise DescriptionError(
                    f"link {shown(WORLD)} has mass or moves, and is the ground in MJCF",
                    remedy="give it another name",
                    file=self.description.file,
                    line=root.line,
                )
            names = {joint.name for joint in self.description.joints}
            name = next(n for k in range(len(names) + 1) if (n := f"base{k or ''}") not in names)
            if free:
                self._check_mass(root)
            body += [tag("body", ">", name=root.name), *([f"  {tag('freejoint', name=name)}"] if free else [])]
            body += [f"  {line}" for line in self._content(root)]
            for joint in only:
                body += [f"  {line}" for line in self._bodies(joint)]
            body.append("</body>")
        gravity = self.description.scene.get("gravity", (0.0, 0.0, -9.81))
        assets = [
            tag("mesh", name=name, file=file, scale=None if scale == _ONE else scale, inertia="shell")
            for (file, scale), name in self.assets.items()
        ]
        lines = [f"<!--{each}-->" for each in dict.fromkeys([MARK, *self.comments.get(("", ""), [])])]
        lines += [tag("mujoco", ">", model=self.description.name or "robot"), f"  {_HEAD}"]
        lines.append(f"  {tag('option', gravity=gravity)}")
        for name, inner in (("asset", assets), ("worldbody", body), ("equality", self.equalities)):
            lines += [f"  <{name}>", *(f"    {line}" for line in inner), f"  </{name}>"] if inner else []
        return Written("\n".join([*lines, "</mujoco>", ""]).encode(), self._said(), self.files)

    def _said(self) -> list[str]:
        said = [f"{what}: {listed(list(dict.fromkeys(of)))}" for what, of in self.lost.items()]
        said += [f"mesh {name}: {why}" for name, why in self.unread.items()]
        if self.equalities:
            said.append("exact mimic rules and loops: MuJoCo's equality constraints are soft")
        if self.order != [each.name for joint in self.description.joints for each in _moved(joint)]:
            said.append(f"the order of the file in q, which is that of the tree: {listed(self.order)}")
        if b"<material" in self.description.data:
            said.append("materials")
        return said

    def _lose(self, what: str, name: str) -> None:
        self.lost.setdefault(what, []).append(name)

    def _bodies(self, joint: Joint) -> Iterator[str]:
        """Yield the lines of the body that a joint carries, with all below it."""
        waiting: list[tuple[int, Joint | None]] = [(0, joint)]
        while waiting:
            depth, above = waiting.pop()
            indent = "  " * depth
            if above is None:
                yield f"{indent}</body>"
                continue
            link, moves, R, p, pose = self._chain(above)
            yield indent + tag("body", ">", name=link.name, **pose)
            yield from (f"{indent}  {line}" for line in [*self._joints(moves, R, p), *self._content(link)])
            waiting.append((depth, None))
            waiting += [(depth + 1, each) for each in reversed(self.carried[link.name])]

    def _chain(self, joint: Joint) -> tuple[Link, list[_Move], Floats, Floats, dict[str, Any]]:
        """Return the link of a body, its joints, and its place in the parent as matrices and as attributes."""
        moves: list[_Move] = []
        R, p, pose = np.eye(3), np.zeros(3), _pose(joint.origin.xyz, joint.origin.rpy)
        while True:
            turn, shift = placement(joint.origin)
            R, p = snapped(product(R, turn)), p + product(R, shift)
            if joint.type == "fixed":
                self._lose("names of fixed joints", joint.name)
            elif joint.type == "floating" and joint.parent != self.description.root:
                what = (
                    f"joint {shown(joint.name)} floats on link {shown(joint.parent)}; MJCF has free joints of the world"
                )
                raise DescriptionError(
                    what, remedy="let it float on the root", file=self.description.file, line=joint.line
                )
            moves += [_Move(each, R, p) for each in _moved(joint)]
            link, below = self.links[joint.child], self.carried[joint.child]
            bare = not _massive(link) and not link.geometries and link.name not in self.sites and len(below) == 1
            if not (bare and joint.type not in ("fixed", "floating") and below[0].type not in ("fixed", "floating")):
                break
            self._lose("links without mass between joints", link.name)
            joint = below[0]
            pose = {}
        if joint.type != "fixed":
            self._check_mass(link)
        return link, moves, R, p, pose or _pose(p, rpy_from_rotation(R))

    def _check_mass(self, link: Link) -> None:
        """Raise unless the link, or one that is fixed to it, has mass and moments."""
        waiting, heavy = [link], False
        while waiting:
            each = waiting.pop()
            if each.inertial is not None and each.inertial.mass > _LEAST:
                if (np.linalg.eigvalsh(symmetric(each.inertial.inertia)) > _LEAST).all():
                    return
                heavy = True
            waiting += [self.links[joint.child] for joint in self.carried[each.name] if joint.type == "fixed"]
        if not heavy:
            raise impossible(self.description, link, "it moves without mass", "RD202")
        what = f"link {shown(link.name)} moves, and MJCF has no masses without moments of inertia that move"
        remedy = "give it some; robodyn rule RD204 tells why"
        raise DescriptionError(what, remedy=remedy, file=self.description.file, line=link.line)

    def _joints(self, moves: list[_Move], R: Floats, p: Floats) -> Iterator[str]:
        for joint, turn, place in moves:
            self.order.append(joint.name)
            for each in self.comments.get(("joint", joint.name), []):
                yield f"<!--{each}-->"
            if joint.kind == "floating":
                yield tag("freejoint", name=joint.name)
                continue
            axis, pos = product(R.T, turn, joint.axis), product(R.T, place - p)
            spring = self.springs.get(joint.name)
            if joint.mimics is not None:
                leader = (joint.offset, joint.multiplier, 0.0, 0.0, 0.0)
                self.equalities.append(tag("joint", joint1=joint.name, joint2=joint.mimics, polycoef=leader))
            yield tag(
                "joint",
                name=joint.name,
                type="slide" if joint.kind == "prismatic" else "hinge",
                pos=pos if pos.any() else None,
                axis=axis,
                range=self._range(joint),
                actuatorfrcrange=self._effort(joint),
                damping=joint.damping or None,
                frictionloss=joint.friction or None,
                armature=self.armature.get(joint.name) or None,
                stiffness=spring["stiffness"] if spring else None,
                springref=spring["rest"] if spring else None,
            )

    def _range(self, joint: model.Joint) -> tuple[float, float] | None:
        if joint.velocity is not None:
            self._lose("velocity limits", joint.name)
        if joint.lower is None or joint.upper is None or not joint.lower < joint.upper:
            if joint.lower is not None or joint.upper is not None:
                self._lose("ranges with one end, or without room between the ends", joint.name)
            return None
        return joint.lower, joint.upper

    def _effort(self, joint: model.Joint) -> tuple[float, float] | None:
        if joint.effort is not None and joint.effort <= 0.0:
            self._lose("effort limits of 0 or less", joint.name)
        return (-joint.effort, joint.effort) if joint.effort is not None and joint.effort > 0.0 else None

    def _content(self, link: Link) -> Iterator[str]:
        for kind in ("link", "body"):
            yield from (f"<!--{each}-->" for each in self.comments.get((kind, link.name), []))
        if link.inertial is not None and _massive(link):
            yield _inertial(link.inertial)
        for each in link.geometries:
            if (shape := self._shape(each)) is not None:
                pose = _pose(each.origin.xyz, each.origin.rpy)
                seen = {"contype": "0", "conaffinity": "0", "group": "2"} if each.kind == "visual" else {"group": "3"}
                yield tag("geom", **shape, **pose, **seen)
        yield from self.sites.get(link.name, [])

    def _shape(self, each: Geometry) -> dict[str, Any] | None:
        if each.shape == "mesh":
            name = self._mesh(each)
            return None if name is None else {"type": "mesh", "mesh": name}
        if min(each.size) <= 0.0:
            self._lose("shapes without size", each.shape)
            return None
        if each.shape == "box":
            return {"type": "box", "size": [x / 2.0 for x in each.size]}
        return {"type": each.shape, "size": [each.size[0], *(x / 2.0 for x in each.size[1:])]}

    def _mesh(self, each: Geometry) -> str | None:
        """Return the asset of a mesh; None if there is no file that MuJoCo reads."""
        named = each.filename or ""
        path = self.description.search.find(named)
        if path is None or named in self.unread:
            self.unread.setdefault(named, "is not found")
            return None
        file, stem = os.path.relpath(path, self.folder).replace(os.sep, "/"), os.path.splitext(path.name)[0]
        if not _readable(str(path)):
            if not self.convert:
                self.unread[named] = "MuJoCo does not read it; --meshes writes it as STL"
                return None
            try:
                file = self.made[named] if named in self.made else self._converted(named, str(path), stem)
            except InputError as error:
                self.unread[named] = str(error)
                return None
        key = (file, each.scale)
        if key not in self.assets:
            taken = set(self.assets.values())
            self.assets[key] = next(
                n for k in range(len(taken) + 1) if (n := f"{stem}{f'_{k}' if k else ''}") not in taken
            )
        return self.assets[key]

    def _converted(self, named: str, path: str, stem: str) -> str:
        corners = load_triangles(path).array()
        if len(corners) > _MOST_FACES:
            raise InputError(f"has {len(corners)} faces, and MuJoCo reads {_MOST_FACES}", file=path)
        record = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
        record["corners"] = corners
        name = next(n for k in range(len(self.files) + 1) if (n := f"{MESHES}/{stem}{k or ''}.stl") not in self.files)
        self.files[name] = b"written by robodyn".ljust(80) + np.uint32(len(corners)).tobytes() + record.tobytes()
        self.made[named] = name
        return name

    def _loop(self, loop: dict[str, Any]) -> None:
        """Add the sites and the constraint of a loop; a hinge is held at two points of its axis."""
        if loop.get("directions"):
            self._lose("loops that are held along some directions", loop["name"])
            return
        ends = (loop["to"], loop.get("to_point", ZERO)), (loop["link"], loop.get("point", ZERO))
        shifts: list[tuple[Floats, Floats]] = [(np.zeros(3), np.zeros(3))]
        if loop["kind"] == "hinge":
            axes = [np.array(loop[key]) / np.linalg.norm(loop[key]) for key in ("to_axis", "axis")]
            shifts += [(0.1 * axes[0], 0.1 * axes[1])]
            self._lose("hinges of loops, which are held at two points of their axes", loop["name"])
        for k, shift in enumerate(shifts):
            names = []
            for (link, point), along, key in zip(ends, shift, ("to", "link"), strict=True):
                names.append(f"{loop['name']}_{key}{k or ''}")
                turn = loop.get("rpy") if key == "to" and loop["kind"] == "weld" else ZERO
                owner = link if link in self.links else self.description.root
                pose = _pose(np.array(point) + along, turn)
                self.sites.setdefault(owner, []).append(tag("site", name=names[-1], **pose))
            kind = "weld" if loop["kind"] == "weld" else "connect"
            self.equalities.append(tag(kind, name=f"{loop['name']}{k or ''}", site1=names[0], site2=names[1]))


def _moved(joint: Joint) -> list[model.Joint]:
    return elementary(joint, np.eye(3), np.zeros(3))


def _massive(link: Link) -> bool:
    return link.inertial is not None and bool(link.inertial.mass or any(link.inertial.inertia))


def _pose(p: Any, rpy: Any) -> dict[str, Any]:
    return {"pos": p if any(p) else None, "euler": rpy if any(rpy) else None}


def _inertial(inertial: Inertial) -> str:
    """Return the element, with moments about principal axes: MuJoCo's own search for these stops at 1e-12 kg m^2."""
    ixx, ixy, ixz, iyy, iyz, izz = inertial.inertia
    moments, rpy = [ixx, iyy, izz], inertial.origin.rpy
    if ixy or ixz or iyz:
        values, V = np.linalg.eigh(symmetric(inertial.inertia))
        V[:, 0] *= np.sign(np.linalg.det(V))
        moments, rpy = values.tolist(), rpy_from_rotation(product(placement(inertial.origin)[0], V))
    k = int(np.argmax(moments))
    moments[k] = min(moments[k], sum(moments[:k] + moments[k + 1 :]))  # which differ by rounding at most
    mass, pos = inertial.mass, inertial.origin.xyz
    return tag("inertial", pos=pos, euler=rpy if any(rpy) else None, mass=mass, diaginertia=moments)


def _readable(path: str) -> bool:
    """Whether MuJoCo reads a mesh: OBJ, and binary STL of not too many faces."""
    suffix = os.path.splitext(path)[1].lower()
    if suffix != ".stl":
        return suffix == ".obj"
    with open(path, "rb") as stream:
        head = stream.read(84)
    faces = int.from_bytes(head[80:84], "little")
    return len(head) == 84 and 0 < faces <= _MOST_FACES and os.path.getsize(path) == 84 + 50 * faces
