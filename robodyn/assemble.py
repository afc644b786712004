"""Description -> Model: fixed joints merged, mimic joints mapped, parents before children."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np

from robodyn.errors import DescriptionError
from robodyn.inertia.moments import MASSLESS, Inertia, combined, inertia_of, unphysical
from robodyn.model import Body, Floats, Frame, Joint, Model
from robodyn.spatial import rotation_from_rpy, snapped
from robodyn.urdf.description import Description, Inertial, Origin, load_description
from robodyn.urdf.description import Joint as DescribedJoint

WIDTH = {"fixed": (0, 0), "revolute": (1, 1), "prismatic": (1, 1), "floating": (7, 6)}
"""How many entries of q and of qd each kind of joint has."""


def load(source: str | os.PathLike[str] | bytes, *, moving_base: bool = False) -> Model:
    """The Model of a URDF file.

    Args:
        source: its path, or its bytes.
        moving_base: give the base six degrees of freedom of its own, as for a floating or a carried robot.

    Raises:
        DescriptionError: the file cannot be read, is malformed or contradicts itself; with the line.
    """
    return assemble(load_description(source), moving_base=moving_base)


def assemble(description: Description, *, moving_base: bool = False) -> Model:
    """The Model of a description.

    A body is a link that a joint moves, with every link fixed to it: their moments are added in the body's frame, which
    is exact but for rounding. A planar joint J becomes the slides J_x, J_y and the hinge J_theta about its axis, with
    massless bodies between. A massless root that carries the robot by one floating joint is the ground, and that joint
    becomes the moving base. Axes are normalised. Bodies stand in depth-first order. Nothing recurses and the time is
    linear in the number of links.

    Args:
        description: see `robodyn.urdf.description`.
        moving_base: give the base six degrees of freedom of its own, as for a floating or a carried robot.

    Raises:
        DescriptionError: a mimic joint follows a joint that has no single coordinate.
    """
    carried: dict[str, list[DescribedJoint]] = {}
    for described in description.joints:
        carried.setdefault(described.parent, []).append(described)
    base, base_joint = _base(description, carried, moving_base)
    frames = {base: Frame(0, np.eye(3), np.zeros(3))}
    parents, names, joints = [-1], [base], [base_joint]
    waiting = carried.get(base, [])[::-1]
    while waiting:
        described = waiting.pop()
        body, R_link, p_link = frames[described.parent]
        R, p = _placement(described.origin)
        R, p = snapped(R_link @ R), p_link + R_link @ p
        for joint in _joints(described, R, p):
            parents.append(body)
            names.append(described.child)
            joints.append(joint)
            body, R, p = len(joints) - 1, np.eye(3), np.zeros(3)
        frames[described.child] = Frame(body, R, p)
        waiting += carried.get(described.child, [])[::-1]
    parts: list[list[Inertia]] = [[] for _ in joints]
    for link in description.links:
        if link.inertial is not None and link.name in frames:
            body, R, p = frames[link.name]
            parts[body].append(_moments(link.inertial, R, p))
    joints = _numbered(joints, description)
    inertias = [_frozen(combined(some)) if some else MASSLESS for some in parts]
    bodies = tuple(Body(*row) for row in zip(names, parents, joints, inertias, strict=True))
    return Model(description.name, description.file, bodies, frames, _notes(description))


def _base(description: Description, carried: dict[str, list[DescribedJoint]], moving: bool) -> tuple[str, Joint]:
    root, axis = description.root, np.zeros(3)
    first = carried.get(root, [])
    inertial = next(link.inertial for link in description.links if link.name == root)
    if len(first) == 1 and first[0].type == "floating" and inertial is None:
        return first[0].child, Joint("base", "floating", *_placement(first[0].origin), axis)
    return root, Joint("base", "floating" if moving else "fixed", np.eye(3), np.zeros(3), axis)


def _placement(origin: Origin) -> tuple[Floats, Floats]:
    return rotation_from_rpy(*origin.rpy), np.array(origin.xyz, dtype=float)


def _joints(described: DescribedJoint, R: Floats, p: Floats) -> list[Joint]:
    """The elementary joints, in a row, that a described joint is made of; none if it is fixed."""
    if described.type == "fixed":
        return []
    axis = np.array(described.axis, dtype=float)
    axis /= np.abs(axis).max()
    axis = snapped(axis / np.sqrt(axis @ axis))
    if described.type == "floating":
        return [Joint(described.name, "floating", R, p, np.zeros(3))]
    if described.type == "planar":
        first, second = _across(axis)
        still, here = np.eye(3), np.zeros(3)
        return [
            Joint(f"{described.name}_x", "prismatic", R, p, first),
            Joint(f"{described.name}_y", "prismatic", still, here, second),
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


def _across(normal: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors that make a right-handed frame with `normal`; x and y for z, y and z for x, z and x for y."""
    k = int(np.argmax(np.abs(normal)))
    first = np.zeros(3)
    first[(k + 1) % 3] = 1.0
    first -= normal * normal[(k + 1) % 3]
    first = snapped(first / np.sqrt(first @ first))
    return first, snapped(np.cross(normal, first))


def _numbered(joints: list[Joint], description: Description) -> list[Joint]:
    """The joints with their places in q and qd (the base first, then the file's order) and their transmissions."""
    order = {name: k for k, described in enumerate(description.joints) for name in _parts(described)}
    ranked = sorted(range(1, len(joints)), key=lambda i: order[joints[i].name])
    index = {joints[i].name: i for i in ranked}
    transmissions = {transmission.joint: transmission for transmission in description.transmissions}
    places: dict[int, tuple[int, int]] = {}
    coordinate = rate = 0
    for i in [0, *ranked]:
        if joints[i].mimics is None:
            places[i] = (coordinate, rate)
            nq, nv = WIDTH[joints[i].kind]
            coordinate, rate = coordinate + nq, rate + nv
    out = []
    for i, joint in enumerate(joints):
        master, multiplier, offset = _master(i, joints, index)
        geared = transmissions.get(joint.name)
        out.append(
            replace(
                joint,
                coordinate=places[master][0],
                rate=places[master][1],
                mimics=None if master == i else joints[master].name,
                multiplier=multiplier,
                offset=offset,
                reduction=geared.reduction if geared else 1.0,
                rotor_inertia=(geared.rotor_inertia or 0.0) if geared else 0.0,
            )
        )
    return out


def _parts(described: DescribedJoint) -> list[str]:
    """Names of the elementary joints that a described joint is made of."""
    return [joint.name for joint in _joints(described, np.eye(3), np.zeros(3))]


def _master(i: int, joints: list[Joint], index: dict[str, int]) -> tuple[int, float, float]:
    """The independent joint that joint i follows in the end, and q_joint = multiplier q_master + offset."""
    multiplier, offset = 1.0, 0.0
    while (followed := joints[i].mimics) is not None:
        multiplier, offset = multiplier * joints[i].multiplier, multiplier * joints[i].offset + offset
        if followed not in index or joints[index[followed]].kind == "floating":
            raise DescriptionError(
                f'joint "{joints[i].name}" mimics joint "{followed}", which has no single coordinate',
                remedy="mimic a revolute, continuous or prismatic joint",
            )
        i = index[followed]
    return i, multiplier, offset


def _moments(inertial: Inertial, R: Floats, p: Floats) -> Inertia:
    turn, c = _placement(inertial.origin)
    return inertia_of(inertial.mass, c, turn @ _matrix(inertial) @ turn.T, R, p)


def _matrix(inertial: Inertial) -> Floats:
    xx, xy, xz, yy, yz, zz = inertial.inertia
    return np.array(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))


def _frozen(inertia: Inertia) -> Inertia:
    inertia.mc.flags.writeable = inertia.I.flags.writeable = False
    return inertia


def _notes(description: Description) -> tuple[str, ...]:
    notes = [note.what for note in description.notes if note.kind == "warning"]
    for link in description.links:
        why = unphysical(_matrix(link.inertial)) if link.inertial else None
        if why:
            notes.append(f'link "{link.name}" (line {link.line}): {why}; computed as given')
    return tuple(notes)
