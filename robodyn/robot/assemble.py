"""Description -> Model: fixed joints merged, mimic joints mapped, parents before children."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

import numpy as np

from robodyn.programs.vectors import product, snapped
from robodyn.robot.joints import elementary, numbered, placement
from robodyn.robot.model import Body, Frame, Joint, Model
from robodyn.robot.urdf.description import load_description
from robodyn.robot.urdf.parts import Description, Inertial
from robodyn.robot.urdf.parts import Joint as DescribedJoint
from robodyn.solids.inertia.laws import Inertia, combined, inertia_of, symmetric
from robodyn.solids.inertia.validity import unphysical
from robodyn.support.floats import Floats


def load(
    source: str | os.PathLike[str] | bytes,
    *,
    moving_base: bool = False,
    package_paths: Sequence[str | os.PathLike[str]] = (),
    xacro_args: Mapping[str, str] | None = None,
    trust_xacro: bool = False,
) -> Model:
    """Return the Model of a URDF or xacro file.

    Args:
        source: its path, or the bytes of a URDF.
        moving_base: give the base six degrees of freedom of its own, as for a floating or a carried robot.
        package_paths: packages, or folders of packages, that are looked at first for what xacro includes and meshes.
        xacro_args: values of the arguments of a xacro file; defaults hold for the others.
        trust_xacro: let a xacro file run any Python, read any file and all of the environment.

    Raises:
        DescriptionError: the file cannot be read, is malformed or contradicts itself; with the line.
        InputError: a xacro file cannot be expanded, or xacrodoc is not installed.
    """
    description = load_description(source, package_paths=package_paths, xacro_args=xacro_args, trust_xacro=trust_xacro)
    return assemble(description, moving_base=moving_base)


def assemble(description: Description, *, moving_base: bool = False) -> Model:
    """Return the Model of a description.

    A body is a link that a joint moves, with every link fixed to it: their moments are added in the body's frame, which
    is exact but for rounding. A planar joint J becomes the slides J_x, J_y and the hinge J_theta about its axis, with
    massless bodies between. A massless root that carries the robot by one floating joint is the ground, and that joint
    becomes the moving base. Axes are normalised. Bodies stand in depth-first order. Nothing recurses and the time is
    linear in the number of links.

    Args:
        description: see `robodyn.robot.urdf.description`.
        moving_base: give the base six degrees of freedom of its own, as for a floating or a carried robot.

    Raises:
        DescriptionError: a mimic joint follows a joint that has no single coordinate; two joints have one name.
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
        R, p = placement(described.origin)
        R, p = snapped(product(R_link, R)), p_link + product(R_link, p)
        for joint in elementary(described, R, p):
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
    joints = numbered(joints, description)
    inertias = [combined(some) for some in parts]
    bodies = tuple(Body(*row) for row in zip(names, parents, joints, inertias, strict=True))
    return Model(description.name, description.file, bodies, frames, _notes(description), description)


def _base(description: Description, carried: dict[str, list[DescribedJoint]], moving: bool) -> tuple[str, Joint]:
    root, axis = description.root, np.zeros(3)
    first = carried.get(root, [])
    inertial = next(link.inertial for link in description.links if link.name == root)
    if len(first) == 1 and first[0].type == "floating" and inertial is None:
        return first[0].child, Joint("base", "floating", *placement(first[0].origin), axis)
    return root, Joint("base", "floating" if moving else "fixed", np.eye(3), np.zeros(3), axis)


def _moments(inertial: Inertial, R: Floats, p: Floats) -> Inertia:
    turn, c = placement(inertial.origin)
    return inertia_of(inertial.mass, c, product(turn, symmetric(inertial.inertia), turn.T), R, p)


def _notes(description: Description) -> tuple[str, ...]:
    notes = [note.what for note in description.notes if note.kind == "warning"]
    for joint in description.joints:
        if joint.type in ("planar", "floating") and (joint.damping or joint.friction):
            notes.append(f'joint "{joint.name}" (line {joint.line}): a {joint.type} joint has no friction here')
        if joint.type in ("planar", "floating") and joint.limit:
            notes.append(f'joint "{joint.name}" (line {joint.line}): a {joint.type} joint has no limits here')
    for link in description.links:
        why = unphysical(symmetric(link.inertial.inertia)) if link.inertial else None
        if why:
            notes.append(f'link "{link.name}" (line {link.line}): {why}; computed as given')
    return tuple(notes)
