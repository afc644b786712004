"""Description -> MJCF: links become bodies, joints joints, loops and mimic rules equality constraints.

The frame of a body is that of its link. Links without mass between joints that follow each other have no body: their
joints stand in that of the next link.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

import numpy as np

from robodyn.errors import DescriptionError, InputError
from robodyn.programs.vectors import product, rpy_from_rotation, snapped
from robodyn.robot import model
from robodyn.robot.load import elementary, placement
from robodyn.robot.urdf.parts import ZERO, Description, Geometry, Inertial, Joint, Link, Vector
from robodyn.robot.write.common import MARK, Written, check_possible, comments_of, free_name, impossible, tag
from robodyn.solids.inertia.laws import symmetric
from robodyn.solids.mesh.read.load import load_triangles
from robodyn.support.floats import Floats
from robodyn.support.input_file import open_input
from robodyn.support.wording import listed, shown

WORLD = "world"
_LEAST = 1e-15
"""The least mass and moment that MuJoCo takes of what moves."""
_MOST_FACES = 200_000
"""Of a mesh that MuJoCo reads."""
_ONE = (1.0, 1.0, 1.0)
_HEAD = (
    '<compiler angle="radian" eulerseq="XYZ" autolimits="true" inertiafromgeom="false" balanceinertia="false"'
    ' boundmass="0" boundinertia="0" discardvisual="false" fusestatic="false"/>'
)


def write_mjcf(description: Description, out: str, *, convert_meshes: bool = False) -> Written:
    """Return the MJCF of a description for a file of this name.

    Args:
        convert_meshes: write meshes that MuJoCo does not read as STL, for `out.xml` into the folder `out_meshes`.

    Raises:
        DescriptionError: a link is impossible, moves without mass, or floats on another.
    """
    check_possible(description)
    return _Writer(description, out, convert_meshes).written()


class _Writer:
    def __init__(self, description: Description, out: str, convert: bool) -> None:
        self.description, self.folder, self.convert = description, os.path.dirname(out) or os.curdir, convert
        self.meshes = os.path.splitext(os.path.basename(out))[0] + "_meshes"
        self.links = {link.name: link for link in description.links}
        self.carried: dict[str, list[Joint]] = {name: [] for name in self.links}
        for joint in description.joints:
            self.carried[joint.parent].append(joint)
        root, only = self.links[description.root], self.carried[description.root]
        self.free = "base" in description.scene
        self.grounded = not self.free and not _massive(root)
        self.grounded &= root.name == WORLD or any(joint.type == "floating" for joint in only)
        self.armature = {e.joint: e.reduction**2 * (e.rotor_inertia or 0.0) for e in description.transmissions}
        self.springs: dict[str, Any] = description.scene.get("spring", {})
        self.comments = comments_of(description.data) if description.data else {}
        self.sites: dict[str, list[str]] = {}
        self.assets: dict[tuple[str, Vector], str] = {}
        self.files: dict[str, bytes] = {}
        self.converted: dict[str, str] = {}
        self.lost: dict[str, list[str]] = {}
        self.equalities: list[str] = []
        self.order: list[str] = []

    def written(self) -> Written:
        for loop in self.description.scene.get("loop", []):
            self._loop(loop)
        bodies = self._bodies(self.links[self.description.root])
        assets = [
            tag("mesh", name=name, file=file, scale=None if scale == _ONE else scale, inertia="shell")
            for (file, scale), name in self.assets.items()
        ]
        lines = [f"<!--{each}-->" for each in dict.fromkeys([MARK, *self.comments.get(("", ""), [])])]
        lines += [tag("mujoco", ">", model=self.description.name or "robot"), f"  {_HEAD}"]
        lines.append(f"  {tag('option', gravity=self.description.scene.get('gravity', (0.0, 0.0, -9.81)))}")
        for name, inner in (("asset", assets), ("worldbody", bodies), ("equality", self.equalities)):
            lines += [f"  <{name}>", *(f"    {line}" for line in inner), f"  </{name}>"] if inner else []
        said = [f"{what}: {listed(list(dict.fromkeys(of)))}" for what, of in self.lost.items()]
        said += ["exact mimic rules and loops: MuJoCo's equality constraints are soft"] if self.equalities else []
        if self.order != [each.name for joint in self.description.joints for each in _moved(joint)]:
            said.append(f"the order of the file in q, which is that of the tree: {listed(self.order)}")
        said += ["materials"] if b"<material" in self.description.data else []
        return Written("\n".join([*lines, "</mujoco>", ""]).encode(), said, self.files)

    def _lose(self, what: str, name: str) -> None:
        self.lost.setdefault(what, []).append(name)

    def _refused(self, part: Link | Joint, what: str, remedy: str) -> DescriptionError:
        return DescriptionError(what, remedy=remedy, file=self.description.file, line=part.line)

    def _bodies(self, root: Link) -> list[str]:
        """Return the lines of all bodies, each within that which carries it."""
        lines, waiting, depth = list[str](), list[tuple[int, Joint | None]](), 0
        if WORLD in self.links and not (self.grounded and root.name == WORLD):
            what = f"link {shown(WORLD)} has mass or moves, and is the ground in MJCF"
            raise self._refused(self.links[WORLD], what, "give it another name")
        if self.grounded and root.name != WORLD:
            self._lose("names of links that are the world", root.name)
        if not self.grounded:
            lines, waiting, depth = [tag("body", ">", name=root.name)], [(0, None)], 1
        if self.free:
            self._check_mass(root)
            lines.append(f"  {tag('freejoint', name=free_name('base', {j.name for j in self.description.joints}))}")
        lines += ["  " * depth + line for line in self._content(root)]
        waiting += [(depth, each) for each in reversed(self.carried[root.name])]
        while waiting:
            depth, above = waiting.pop()
            if above is None:
                lines.append("  " * depth + "</body>")
                continue
            link, head, *inner = self._body(above)
            lines += ["  " * depth + head, *("  " * (depth + 1) + line for line in inner)]
            waiting += [(depth, None), *((depth + 1, each) for each in reversed(self.carried[link]))]
        return lines

    def _body(self, joint: Joint) -> Iterator[str]:
        """Yield the link of the body that a joint carries, its start tag, and its lines but for bodies in it."""
        moves: list[tuple[model.Joint, Floats, Floats]] = []
        R, p, pose = np.eye(3), np.zeros(3), _pose(joint.origin.xyz, joint.origin.rpy)
        while True:
            turn, shift = placement(joint.origin)
            R, p = snapped(product(R, turn)), p + product(R, shift)
            if joint.type == "fixed":
                self._lose("names of fixed joints", joint.name)
            elif joint.type == "floating" and not (self.grounded and joint.parent == self.description.root):
                what = (
                    f"joint {shown(joint.name)} floats on link {shown(joint.parent)}; MJCF has free joints of the world"
                )
                raise self._refused(joint, what, "let it float on a root without mass")
            moves += [(each, R, p) for each in _moved(joint)]
            link, below = self.links[joint.child], self.carried[joint.child]
            bare = not _massive(link) and not link.geometries and link.name not in self.sites and len(below) == 1
            if not bare or {joint.type, below[0].type} & {"fixed", "floating"}:
                break
            self._lose("links without mass between joints", link.name)
            joint, pose = below[0], {}
        if joint.type != "fixed":
            self._check_mass(link)
        yield link.name
        yield tag("body", ">", name=link.name, **(pose or _pose(p, rpy_from_rotation(R))))
        for each, turn, place in moves:
            yield from self._joint(each, product(R.T, turn, each.axis), product(R.T, place - p))
        yield from self._content(link)

    def _check_mass(self, link: Link) -> None:
        """Raise unless the link, or one that is fixed to it, has mass and moments."""
        waiting, heavy = [link], False
        while waiting:
            each = waiting.pop()
            if each.inertial is not None and each.inertial.mass > _LEAST:
                heavy = True
                if (np.linalg.eigvalsh(symmetric(each.inertial.inertia)) > _LEAST).all():
                    return
            waiting += [self.links[joint.child] for joint in self.carried[each.name] if joint.type == "fixed"]
        if not heavy:
            raise impossible(self.description, link, "it moves without mass", "RD202")
        what = f"link {shown(link.name)} moves, and MJCF has no masses without moments of inertia that move"
        raise self._refused(link, what, "give it some; robodyn rule RD204 tells why")

    def _joint(self, joint: model.Joint, axis: Floats, pos: Floats) -> Iterator[str]:
        self.order.append(joint.name)
        yield from (f"<!--{each}-->" for each in self.comments.get(("joint", joint.name), []))
        if joint.kind == "floating":
            yield tag("freejoint", name=joint.name)
            return
        spring = self.springs.get(joint.name, {})
        if joint.mimics is not None:
            rule = (joint.offset, joint.multiplier, 0.0, 0.0, 0.0)
            self.equalities.append(tag("joint", joint1=joint.name, joint2=joint.mimics, polycoef=rule))
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
            stiffness=spring.get("stiffness"),
            springref=spring.get("rest"),
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
        named, path = each.filename or "", self.description.search.find(each.filename or "")
        if path is None:
            self._lose("meshes that are not found", named)
            return None
        file = os.path.relpath(path, self.folder).replace(os.sep, "/")
        if not _readable(str(path)):
            if not self.convert:
                self._lose("meshes that MuJoCo does not read, which --meshes writes as STL", named)
                return None
            try:
                file = self.converted.get(named) or self._stl(str(path), path.stem)
            except InputError as error:
                self._lose(f"a mesh that cannot be converted ({error})", named)
                return None
            self.converted[named] = file
        return self.assets.setdefault((file, each.scale), free_name(path.stem, set(self.assets.values())))

    def _stl(self, path: str, stem: str) -> str:
        corners = load_triangles(path).array()
        if len(corners) > _MOST_FACES:
            raise InputError(f"has {len(corners)} faces, and MuJoCo reads {_MOST_FACES}", file=path)
        record = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
        record["corners"] = corners
        stems = {os.path.splitext(os.path.basename(file))[0] for file in self.files}
        name = f"{self.meshes}/{free_name(stem, stems)}.stl"
        self.files[name] = b"written by robodyn".ljust(80) + len(corners).to_bytes(4, "little") + record.tobytes()
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
    with open_input(path) as stream:
        head = stream.read(84)
    faces = int.from_bytes(head[80:84], "little")
    return len(head) == 84 and 0 < faces <= _MOST_FACES and os.path.getsize(path) == 84 + 50 * faces
