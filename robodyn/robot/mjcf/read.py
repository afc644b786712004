"""MJCF -> Description: bodies become links, joints joints, and what is no robot a scene (`surroundings`).

A link has the axes of its body. Its origin is the body's or, where a hinge or ball is away from that, its anchor.
"""

from __future__ import annotations

import os
from dataclasses import replace
from math import isfinite
from typing import Any

import numpy as np

from robodyn.errors import DescriptionError
from robodyn.programs.vectors import product, rotation_about, rpy_from_rotation, snapped
from robodyn.robot.mjcf.compiler import ARRAYS, compiled
from robodyn.robot.mjcf.surroundings import Names, actuated, geoms_of, loops_of, lost_of, mimics_of, rotation_of, told
from robodyn.robot.urdf import parts
from robodyn.robot.urdf.parts import Description, Geometry, Inertial, Joint, Kind, Limit, Link, Origin, Vector
from robodyn.robot.urdf.sources import Search
from robodyn.support.floats import Floats
from robodyn.support.wording import count, listed, shown

WORLD = "world"
_SHAPES: dict[str, tuple[parts.Shape, int]] = {
    "geom_sphere": ("sphere", 1),
    "geom_capsule": ("capsule", 2),
    "geom_cylinder": ("cylinder", 2),
    "geom_box": ("box", 3),
    "geom_mesh": ("mesh", 0),
    "geom_sdf": ("mesh", 0),
}
"""Shapes by type of geom, and how many of its sizes count."""
_DRAWN = 2
"""The last group of geoms that MuJoCo draws unless it is told otherwise."""


def read_mjcf(data: bytes, file: str, package_paths: tuple[str, ...] = ()) -> Description:
    """Return what MuJoCo's compiler makes of an MJCF file, as a description below a massless link `world`.

    Several joints of a body have massless links between them. A ball joint J is the hinges J_x, J_y, J_z in a row, a
    free joint a floating one. Armature is the inertia of a rotor of reduction 1. The effort limit of a joint is what
    its actuators give together. `ref` is part of the placement, so that coordinates are MuJoCo's.

    Raises:
        DescriptionError: the file is not XML, includes what it may not, or MuJoCo refuses it.
        InputError: MuJoCo is not installed.
    """
    found = compiled(data, file)
    for key in ARRAYS:
        if key not in ("jnt_range", "jnt_actfrcrange") and not np.isfinite(np.array(found.get(key, []), float)).all():
            raise DescriptionError(f"the compiled {key} is not finite", remedy="correct its numbers", file=file)
    if len(found["body_mass"]) == 1:
        raise DescriptionError("<worldbody> has no body", remedy="give a file with a robot", file=file)
    robot = _Robot(found, os.path.dirname(os.path.abspath(file)))
    for body in range(1, len(robot.links)):
        robot.add(body)
    only = [joint for joint in robot.joints if joint.parent == WORLD]
    names = Names(robot.links, robot.origins, robot.named, len(only) == 1 and only[0].type == "floating")
    (mimics, free), (loops, idle) = mimics_of(found, names), loops_of(found, names)
    lost = [*robot.lost(), *idle, *free, *lost_of(found)]
    notes = [(1, f"left out, as nothing here is like it: {'; '.join(lost)}")] if lost else []
    return Description(
        found["name"] or os.path.splitext(os.path.basename(file))[0],
        file,
        (Link(WORLD), *robot.parts),
        tuple(replace(joint, mimic=mimics.get(joint.name)) for joint in robot.joints),
        tuple(robot.rotors),
        WORLD,
        tuple(sorted(notes + robot.notes, key=lambda note: note[0])),
        Search(file, package_paths),
        data,
        told(found, names, mimics) | ({"loop": loops} if loops else {}),
        "mjcf",
    )


class _Robot:
    """Links and joints of the bodies that were added, parents first.

    Attributes:
        links, origins: of each body its link, and where the link's origin is in the body's frame [m].
        named: of each joint its name.
    """

    def __init__(self, found: dict[str, Any], folder: str) -> None:
        self.found, self.folder = found, folder
        self.types = {number: name for name, number in found["kinds"].items() if name.startswith("jnt_")}
        self.links = _distinct(found["names"]["body"], [f"body{k}" for k in range(len(found["names"]["body"]))])
        self.origins = [np.zeros(3) for _ in self.links]
        usual = [f"{self.links[body]}_joint" for body, n in enumerate(found["body_jntnum"]) for _ in range(n)]
        self.named = _distinct(found["names"]["joint"], usual)
        self.efforts, self.armatures, self.dampings = actuated(found)
        self.parts: list[Link] = []
        self.joints: list[Joint] = []
        self.rotors: list[parts.Transmission] = []
        self.notes: list[tuple[int, str]] = []
        self.unshaped: list[str] = []
        self.geoms = geoms_of(found)
        self.taken = {*self.links, *self.named}

    def add(self, body: int) -> None:
        """Add a body: its joints one after another, at the reference of each, then its link."""
        found, name = self.found, self.links[body]
        parent = found["body_parentid"][body]
        above, here = self.links[parent], np.zeros(3)
        R = rotation_of(found["body_quat"][body])
        p = np.array(found["body_pos"][body]) - self.origins[parent]
        first, line = found["body_jntadr"][body], found["lines"]["body"][body]
        own = range(first, first + found["body_jntnum"][body])
        moves: list[Joint] = []
        for j in own:
            kind, anchor = self.types[found["jnt_type"][j]], np.array(found["jnt_pos"][j])
            axis, ref = np.array(found["jnt_axis"][j]), found["qpos0"][found["jnt_qposadr"][j]]
            if kind == "jnt_free":  # whose coordinates are the pose in the world
                R, p = np.eye(3), np.zeros(3)
            if kind in ("jnt_hinge", "jnt_ball"):
                p, here = p + R @ (anchor - here), anchor
            if kind == "jnt_hinge" and ref:
                R = product(R, rotation_about(axis, -ref))
            elif kind == "jnt_slide":
                p = p - R @ (axis * ref)
            for joint in self._joints(j, kind, axis):
                moves.append(replace(joint, origin=_origin(p, R)))
                R, p = np.eye(3), np.zeros(3)
        if not moves:
            moves = [Joint(self._free(f"{name}_fixed"), "fixed", "", "", _origin(p, R), line=line)]
        for k, joint in enumerate(moves):
            last = k == len(moves) - 1
            child = name if last else self._free(f"{name}_{joint.name}")
            self.joints.append(replace(joint, parent=above, child=child))
            if not last:
                self.parts.append(Link(child, line=joint.line))
            above = child
        self.origins[body] = here
        self.parts.append(Link(name, self._inertial(body), tuple(self._geometries(body)), line))

    def _joints(self, j: int, kind: str, axis: Floats) -> list[Joint]:
        """Return the joints that one of MuJoCo's is, still without a place."""
        found, name, dof = self.found, self.named[j], self.found["jnt_dofadr"][j]
        line, off = found["lines"]["joint"][j], found["off"]
        where, armature = f"joint {shown(name)}", found["dof_armature"][dof]
        if kind == "jnt_free":
            if armature or found["dof_damping"][dof] or found["dof_frictionloss"][dof]:
                self.notes.append((line, f"{where}: a free joint has no armature, damping or friction here"))
            return [Joint(name, "floating", "", "", line=line)]
        lower, upper = (
            (value if isfinite(value) else None) if found["jnt_limited"][j] and "limit" not in off else None
            for value in found["jnt_range"][j]
        )
        effort = self.efforts.get(j)
        damping = 0.0 if "damper" in off else found["dof_damping"][dof] + self.dampings.get(j, 0.0)
        friction = 0.0 if "frictionloss" in off else found["dof_frictionloss"][dof]
        type_, axes, names = "prismatic" if kind == "jnt_slide" else "revolute", [axis], [name]
        if kind == "jnt_ball":
            lower, upper, effort = None, None, None
            axes, names = list(np.eye(3)), [self._free(f"{name}_{letter}") for letter in "xyz"]
            what = f"{where} is the hinges {listed(names)} in a row, singular where {names[1]} is at 90 degrees"
            rated = bool(armature or damping or friction)
            more = "; armature, damping and friction act on their rates, not on the angular velocity" if rated else ""
            self.notes.append((line, what + more))
        if type_ == "revolute" and lower is None and upper is None:
            type_ = "continuous"
        limit = None if lower is upper is effort is None else Limit(lower, upper, effort)
        armature += self.armatures.get(j, 0.0)
        if armature:
            self.rotors += [parts.Transmission(f"{each}_rotor", each, 1.0, armature, line) for each in names]
        return [
            Joint(each, type_, "", "", axis=_vector(along), limit=limit, damping=damping, friction=friction, line=line)
            for each, along in zip(names, axes, strict=True)
        ]

    def _inertial(self, body: int) -> Inertial | None:
        mass, moments = self.found["body_mass"][body], self.found["body_inertia"][body]
        if not mass and not any(moments):
            return None
        R = rotation_of(self.found["body_iquat"][body])
        centre = np.array(self.found["body_ipos"][body]) - self.origins[body]
        return Inertial(mass, _origin(centre, R), (moments[0], 0.0, 0.0, moments[1], 0.0, moments[2]))

    def _geometries(self, body: int) -> list[Geometry]:
        """Return the shapes of a body: collisions, and what MuJoCo draws as visuals."""
        found, geometries = self.found, []
        names = {number: name for name, number in found["kinds"].items() if name.startswith("geom_")}
        for g in self.geoms[body]:
            shape, sizes = _SHAPES.get(names[found["geom_type"][g]], (None, 0))
            R, p = rotation_of(found["geom_quat"][g]), np.array(found["geom_pos"][g]) - self.origins[body]
            mesh, file, scale = found["geom_dataid"][g], None, (1.0, 1.0, 1.0)
            if shape == "mesh":
                if mesh < 0 or not found["files"][mesh] or found["turned"][mesh]:
                    shape = None
                else:
                    # MuJoCo moves the vertices of a mesh to its own centre and axes, and the geom the other way.
                    R = snapped(product(R, rotation_of(found["mesh_quat"][mesh]).T))
                    p = p - R @ np.array(found["mesh_pos"][mesh])
                    scale = _vector(found["mesh_scale"][mesh])
                    file = self._relative(found["files"][mesh])
            if shape is None:
                self.unshaped.append(names[found["geom_type"][g]].removeprefix("geom_"))
                continue
            x, y, z = found["geom_size"][g]
            size = (2 * x, 2 * y, 2 * z) if shape == "box" else (x, 2 * y)[:sizes]
            kinds: list[Kind] = ["collision"] if found["geom_contype"][g] or found["geom_conaffinity"][g] else []
            if not kinds or found["geom_group"][g] <= _DRAWN:
                kinds.append("visual")
            line = found["lines"]["body"][body]
            geometries += [Geometry(kind, _origin(p, R), shape, size, file, scale, line) for kind in kinds]
        return geometries

    def _relative(self, path: str) -> str:
        """Return the file of a mesh relative to the folder of the description, if it is on the same disk."""
        try:
            return os.path.relpath(os.path.join(self.folder, path), self.folder)
        except ValueError:
            return path

    def _free(self, name: str) -> str:
        """Return the name, or one like it that nothing has."""
        (name,) = _distinct([""], [name], self.taken)
        return name

    def lost(self) -> list[str]:
        """Return what is left out of the bodies, in words."""
        kinds, still = sorted(set(self.unshaped)), len(self.geoms[0])
        lost = [f"{count(len(self.unshaped), 'shape')} ({', '.join(kinds)})"] if kinds else []
        return [*lost, count(still, "shape of the world", "shapes of the world")] if still else lost


def _distinct(names: list[str], usual: list[str], taken: set[str] | None = None) -> list[str]:
    """Return the names, and for those that are empty usual ones, with a number where they are taken."""
    taken = set() if taken is None else taken
    taken |= set(names)
    out = []
    for name, otherwise in zip(names, usual, strict=True):
        each, k = name or otherwise, 1
        while not name and each in taken:
            k += 1
            each = f"{otherwise}{k}"
        taken.add(each)
        out.append(each)
    return out


def _vector(values: Any) -> Vector:
    x, y, z = (float(value) + 0.0 for value in values)
    return x, y, z


def _origin(p: Floats, R: Floats) -> Origin:
    return Origin(_vector(p), _vector(rpy_from_rotation(R)))
