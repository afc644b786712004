"""Described joints -> the model's joints: elementary, with places in q, mimic joints mapped onto their masters."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robodyn.errors import DescriptionError
from robodyn.programs.vectors import length, rotation_from_rpy, snapped
from robodyn.robot.model import Joint
from robodyn.robot.urdf.parts import Description, Origin
from robodyn.robot.urdf.parts import Joint as DescribedJoint
from robodyn.support.floats import Floats

WIDTH = {"fixed": (0, 0), "revolute": (1, 1), "prismatic": (1, 1), "floating": (7, 6)}
"""How many entries of q and of qd each kind of joint has."""


def placement(origin: Origin) -> tuple[Floats, Floats]:
    """Return rotation and offset of an origin."""
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
    """Return two unit vectors that make a right-handed frame with `normal`: x and y for z, y and z for x, and so on."""
    k = int(np.argmax(np.abs(normal)))
    first = np.zeros(3)
    first[(k + 1) % 3] = 1.0
    first -= normal * normal[(k + 1) % 3]
    first = snapped(first / length(first))
    return first, snapped(np.cross(normal, first))


def numbered(joints: list[Joint], description: Description) -> list[Joint]:
    """Return the joints with places in q and qd (the base first, then the file's order) and transmissions.

    Raises:
        DescriptionError: a mimic joint follows a joint that has no single coordinate, or two joints have one name.
    """
    order = _places_in_file(description)
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
                link=links.get(joint.name, ""),
            )
        )
    return out


def _places_in_file(description: Description) -> dict[str, int]:
    """Return by its name where every elementary joint stands."""
    order: dict[str, int] = {}
    for k, described in enumerate(description.joints):
        for name in _parts(described):
            if name in order:
                planar = name.rpartition("_")[0]
                raise DescriptionError(
                    f'joint "{name}" is named as a part of planar joint "{planar}"',
                    remedy="rename one of them",
                    file=description.file,
                    line=next(joint.line for joint in description.joints if joint.name == name),
                )
            order[name] = k
    return order


def _parts(described: DescribedJoint) -> list[str]:
    """Return names of the elementary joints that a described joint is made of."""
    return [joint.name for joint in elementary(described, np.eye(3), np.zeros(3))]


def _master(i: int, joints: list[Joint], index: dict[str, int]) -> tuple[int, float, float]:
    """Return the independent joint that joint i follows in the end, and q_joint = multiplier q_master + offset."""
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
