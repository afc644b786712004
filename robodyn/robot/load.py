"""The door of this room: a description file -> Model.

Of URDF:

1. `urdf/sources` reads the bytes and finds meshes, `urdf/xacro` expands xacro files first.
2. `urdf/document` makes elements of them, with their places and what is wrong as XML.
3. `urdf/view` reads numbers and texts out of the elements.
4. `urdf/description` raises what is wrong with them, and sees that links and joints are one tree.
5. `assemble` (here) makes the `model`: fixed joints merged, mimic joints mapped, parents before children.

`mjcf/read` makes the same description of MJCF, `sdf/read` of SDF.

What a model says of itself: `model`, `limits`, `kinematics` (named values, poses; recursions for any scalar).
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import cast

import numpy as np

from robodyn.errors import DescriptionError, InputError
from robodyn.programs.vectors import length, product, rotation_from_rpy, snapped
from robodyn.robot.model import Body, Frame, Joint, Model
from robodyn.robot.urdf.description import read_urdf
from robodyn.robot.urdf.parts import Description, Origin
from robodyn.robot.urdf.parts import Joint as DescribedJoint
from robodyn.robot.urdf.sources import EXPANDED, is_xacro, read_source, root_tag
from robodyn.solids.inertia.laws import Inertia, combined, inertia_of, symmetric
from robodyn.solids.inertia.validity import unphysical
from robodyn.support.floats import Floats
from robodyn.support.wording import shown

WIDTH = {"fixed": (0, 0), "revolute": (1, 1), "prismatic": (1, 1), "floating": (7, 6)}
"""How many entries of q and of qd each kind of joint has."""


def load(
    source: str | os.PathLike[str] | bytes,
    *,
    moving_base: bool = False,
    package_paths: Sequence[str | os.PathLike[str]] = (),
    xacro_args: Mapping[str, str] | None = None,
    trust_xacro: bool = False,
) -> Model:
    """Return the Model of a URDF, xacro, MJCF or SDF file.

    Args:
        source: its path, or the bytes of a URDF, MJCF or SDF.
        moving_base: give the base six degrees of freedom of its own, as for a floating or a carried robot.
        package_paths: packages, or folders of packages, that are looked at first for what xacro includes and meshes.
        xacro_args: values of the arguments of a xacro file; defaults hold for the others.
        trust_xacro: let a xacro file run any Python, read any file and all of the environment.

    Raises:
        DescriptionError: the file cannot be read, is malformed or contradicts itself; with the line.
        InputError: a xacro file cannot be expanded, or what reads the format is not installed.
    """
    description = load_description(source, package_paths=package_paths, xacro_args=xacro_args, trust_xacro=trust_xacro)
    return assemble(description, moving_base=moving_base)


def load_description(
    source: str | os.PathLike[str] | bytes,
    name: str | None = None,
    *,
    package_paths: Sequence[str | os.PathLike[str]] = (),
    xacro_args: Mapping[str, str] | None = None,
    trust_xacro: bool = False,
) -> Description:
    """Return what a file describes, whose root element tells its format; options and errors as of `load`. `name` is the
    file as messages show it."""
    folders = tuple(os.fspath(path) for path in package_paths)
    if is_xacro(source):
        from robodyn.robot.urdf.xacro import expanded

        path = os.fspath(cast("str", source))
        return read_urdf(expanded(path, folders, xacro_args, trust_xacro).text, (name or path) + EXPANDED, folders)
    file, data = read_source(source, name)
    if xacro_args:
        what = f"the argument {shown(next(iter(xacro_args)))} is for a file that is xacro"
        raise InputError(what, remedy="xacro files end in .xacro", file=file)
    tag = root_tag(data)
    if tag == "mujoco":
        from robodyn.robot.mjcf.read import read_mjcf

        return read_mjcf(data, file, folders)
    if tag == "sdf":
        from robodyn.robot.sdf.read import read_sdf

        return read_sdf(data, file, folders)
    return read_urdf(data, file, folders)


def assemble(description: Description, *, moving_base: bool = False) -> Model:
    """Return the Model of a description.

    A body is a link that a joint moves, with every link fixed to it: their moments are added in the body's frame. A
    planar joint J becomes the slides J_x, J_y and the hinge J_theta about its axis, with massless bodies between. A
    massless root that carries the robot by one floating joint is the ground, and that joint becomes the moving base.
    Bodies stand in depth-first order. The time is linear in the number of links.

    Args:
        moving_base: give the base six degrees of freedom of its own, as for a floating or a carried robot.

    Raises:
        DescriptionError: a mimic joint follows a joint that has no single coordinate; two joints have one name.
    """
    carried: dict[str, list[DescribedJoint]] = {}
    for described in description.joints:
        carried.setdefault(described.parent, []).append(described)
    still, here = np.eye(3), np.zeros(3)
    root = next(link for link in description.links if link.name == description.root)
    base, base_joint = root.name, Joint("base", "floating" if moving_base else "fixed", still, here, here)
    only = carried.get(base, [])
    if len(only) == 1 and only[0].type == "floating" and root.inertial is None:
        base, base_joint = only[0].child, Joint("base", "floating", *placement(only[0].origin), here)
    frames = {base: Frame(0, still, here)}
    parents, names, joints = [-1], [base], [base_joint]
    waiting = carried.get(base, [])[::-1]
    while waiting:
        described = waiting.pop()
        body, R_link, p_link = frames[described.parent]
        R, p = placement(described.origin)
        R, p = snapped(product(R_link, R)), p_link + product(R_link, p)
        for joint in elementary(described, R, p):
            parents.append(body)
            names.append(described.child)
            joints.append(joint)
            body, R, p = len(joints) - 1, still, here
        frames[described.child] = Frame(body, R, p)
        waiting += carried.get(described.child, [])[::-1]
    parts: list[list[Inertia]] = [[] for _ in joints]
    for link in description.links:
        if link.inertial is not None and link.name in frames:
            body, R, p = frames[link.name]
            turn, c = placement(link.inertial.origin)
            tensor = product(turn, symmetric(link.inertial.inertia), turn.T)
            parts[body].append(inertia_of(link.inertial.mass, c, tensor, R, p))
    joints = numbered(joints, description)
    inertias = [combined(some) for some in parts]
    bodies = tuple(Body(*row) for row in zip(names, parents, joints, inertias, strict=True))
    return Model(description.name, description.file, bodies, frames, _notes(description), description)


def _notes(description: Description) -> tuple[str, ...]:
    notes = [what for _, what in description.notes]
    for joint in description.joints:
        for what, given in (("friction", joint.damping or joint.friction), ("limits", joint.limit)):
            if given and joint.type in ("planar", "floating"):
                notes.append(f'joint "{joint.name}" (line {joint.line}): a {joint.type} joint has no {what} here')
    for link in description.links:
        why = unphysical(symmetric(link.inertial.inertia)) if link.inertial else None
        if why:
            notes.append(f'link "{link.name}" (line {link.line}): {why}; computed as given')
    return tuple(notes)


def placement(origin: Origin) -> tuple[Floats, Floats]:
    return rotation_from_rpy(*origin.rpy), np.array(origin.xyz, dtype=float)


def elementary(described: DescribedJoint, R: Floats, p: Floats) -> list[Joint]:
    """Return the elementary joints, in a row, that a described joint is made of; none if it is fixed."""
    if described.type == "fixed":
        return []
    if described.type == "floating":
        return [Joint(described.name, "floating", R, p, np.zeros(3))]
    axis = np.array(described.axis, dtype=float)
    axis /= np.abs(axis).max()
    axis = snapped(axis / length(axis))
    if described.type == "planar":
        # Two unit vectors make a right-handed frame with the axis: x and y for z, y and z for x, and so on.
        k = (int(np.argmax(np.abs(axis))) + 1) % 3
        still, here = np.eye(3), np.zeros(3)
        first = still[k] - axis * axis[k]
        first = snapped(first / length(first))
        return [
            Joint(f"{described.name}_x", "prismatic", R, p, first),
            Joint(f"{described.name}_y", "prismatic", still, here, snapped(np.cross(axis, first))),
            Joint(f"{described.name}_theta", "revolute", still, here, axis, continuous=True),
        ]
    limit, mimic = described.limit, described.mimic
    return [
        Joint(
            described.name,
            "prismatic" if described.type == "prismatic" else "revolute",
            R,
            p,
            axis,
            continuous=described.type == "continuous",
            mimics=mimic.joint if mimic else None,
            multiplier=mimic.multiplier if mimic else 1.0,
            offset=mimic.offset if mimic else 0.0,
            lower=limit.lower if limit and described.type != "continuous" else None,
            upper=limit.upper if limit and described.type != "continuous" else None,
            effort=limit.effort if limit else None,
            velocity=limit.velocity if limit else None,
            damping=described.damping,
            friction=described.friction,
        )
    ]


def numbered(joints: list[Joint], description: Description) -> list[Joint]:
    """Return the joints with places in q and qd (the base first, then the file's order) and transmissions."""
    order: dict[str, int] = {}
    for k, described in enumerate(description.joints):
        for part in elementary(described, np.eye(3), np.zeros(3)):
            if part.name in order:
                what = f'joint "{part.name}" is named as a part of planar joint "{part.name.rpartition("_")[0]}"'
                line = next(joint.line for joint in description.joints if joint.name == part.name)
                raise DescriptionError(what, remedy="rename one of them", file=description.file, line=line)
            order[part.name] = k
    ranked = sorted(range(1, len(joints)), key=lambda i: order[joints[i].name])
    index = {joints[i].name: i for i in ranked}
    transmissions = {transmission.joint: transmission for transmission in description.transmissions}
    links = {described.name: described.parent for described in description.joints}
    places: dict[int, tuple[int, int]] = {}
    coordinate = rate = 0
    for i in [0, *ranked]:
        if joints[i].mimics is None:
            places[i] = (coordinate, rate)
            nq, nv = WIDTH[joints[i].kind]
            coordinate, rate = coordinate + nq, rate + nv
    out = []
    for i, joint in enumerate(joints):
        leader, multiplier, offset = _leader(i, joints, index)
        geared = transmissions.get(joint.name)
        out.append(
            replace(
                joint,
                coordinate=places[leader][0],
                rate=places[leader][1],
                mimics=None if leader == i else joints[leader].name,
                multiplier=multiplier,
                offset=offset,
                reduction=geared.reduction if geared else 1.0,
                rotor_inertia=(geared.rotor_inertia or 0.0) if geared else 0.0,
                link=links.get(joint.name, ""),
            )
        )
    return out


def _leader(i: int, joints: list[Joint], index: dict[str, int]) -> tuple[int, float, float]:
    """Return the independent joint that joint i follows in the end, and q_joint = multiplier q_leader + offset."""
    multiplier, offset = 1.0, 0.0
    while (followed := joints[i].mimics) is not None:
        multiplier, offset = multiplier * joints[i].multiplier, multiplier * joints[i].offset + offset
        if followed not in index or joints[index[followed]].kind == "floating":
            what = f'joint "{joints[i].name}" mimics joint "{followed}", which has no single coordinate'
            raise DescriptionError(what, remedy="mimic a revolute, continuous or prismatic joint")
        i = index[followed]
    return i, multiplier, offset
