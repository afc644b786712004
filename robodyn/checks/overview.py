"""What a description holds, at a glance: its tree, masses, freedoms, meshes, and how many findings a check has."""

from __future__ import annotations

import os
import re
import shlex
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import fsum

import numpy as np

from robodyn.checks.check import Checked, Options, check_description, tasks_for
from robodyn.programs.vectors import Array, narrowed, product
from robodyn.robot.kinematics import beyond_limits, body_poses, configuration, nearest_to_zero
from robodyn.robot.load import assemble, load_description
from robodyn.robot.model import Model
from robodyn.robot.urdf.parts import Description, Geometry, Joint
from robodyn.scene.fit import constraints

_PACKAGE = re.compile("(package|model)://[^/]")


@dataclass(frozen=True)
class Branch:
    """A link in the tree."""

    name: str
    line: int
    depth: int  # how many joints are between it and the root
    mass: float | None  # [kg]; None without <inertial>
    joint: Joint | None  # that carries it; None for the root


@dataclass(frozen=True, eq=False)
class Overview:
    """A description at a glance. Its notes say why there is no centre of mass, and which joints are beyond their limits
    all the same; those of the model, of formats other than URDF, what the file says beyond."""

    name: str
    file: str
    base: str  # the link in whose frame the centre of mass is
    branches: tuple[Branch, ...]  # the links, depth first and in the order of the file
    massive: int  # how many of them have mass
    types: Mapping[str, int]  # how many joints there are of each, the most frequent first
    mimics: int
    loops: int  # that the description closes itself
    freedoms: int
    base_freedoms: int  # of these, those of a base that floats
    mass: float  # of all links [kg]; inf beyond the range of numbers
    com: Array | None  # [m]; None without mass
    at: Mapping[str, float]  # where it is taken, each coordinate zero or the limit nearest to zero [rad or m]
    notes: tuple[str, ...]
    meshes: tuple[int, int]  # how often they are named, how many names there are
    missing: Sequence[tuple[str, Geometry]]  # of each that has no file the first place
    checked: Checked
    next: tuple[str, ...]

    @property
    def moved(self) -> dict[str, float]:
        """The coordinates that cannot be zero."""
        return {name: value for name, value in self.at.items() if value}


def overview(
    source: str | os.PathLike[str] | bytes,
    package_paths: Sequence[str | os.PathLike[str]] = (),
    xacro_args: Mapping[str, str] | None = None,
    trust_xacro: bool = False,
) -> Overview:
    """Return what a URDF or xacro file holds, with the findings of `robodyn check` by the settings of its project.

    Args:
        source: path of the file, or its bytes; DescriptionError where it cannot be read, or is no robot.
        package_paths: folders in which `package://` names are looked up first.
        xacro_args, trust_xacro: values of the arguments of a xacro file; let it run any Python and read any file.

    Accuracy: the mass is correctly rounded; the centre of mass within 1e-14 of the robot's size for twenty joints in a
        row."""
    path = source if isinstance(source, bytes) else os.fspath(source)
    folders = tuple(os.fspath(folder) for folder in package_paths)
    options = tasks_for([path], Options(package_path=folders))[0].options
    description = load_description(
        path, package_paths=options.package_path, xacro_args=xacro_args, trust_xacro=trust_xacro
    )
    model = assemble(description)
    at = nearest_to_zero(model)
    uses = [(link.name, each) for link in description.links for each in link.geometries if each.filename is not None]
    first = {use[1].filename or "": use for use in reversed(uses)}
    missing = [use for use in uses if first[use[1].filename or ""] is use]
    missing = [use for use in missing if description.search.find(use[1].filename or "") is None]
    mass, com, notes = _centre(description, model, at)
    checked = check_description(description, Options(package_path=folders))
    file = "-" if isinstance(path, bytes) else shlex.quote(path)
    commands = [f"robodyn check {file}"] if checked.findings else []
    if any(_PACKAGE.match(geometry.filename or "") for _, geometry in missing):
        commands.append(f"robodyn info {file} --package-path DIR")
    if description.massive and model.n:
        commands += [f"robodyn fbd {file}", f"robodyn torques {file} motion.csv --example --report report.html"]
    elif uses:
        commands.append(f"robodyn inertia {file} --link NAME --geometry visual")
    return Overview(
        name=description.name,
        file=description.file,
        base=model.bodies[0].name,
        branches=tuple(branches(description)),
        massive=len(description.massive),
        types=dict(Counter(joint.type for joint in description.joints).most_common()),
        mimics=sum(joint.mimic is not None for joint in description.joints),
        loops=len(constraints(description)) + len(description.scene.get("loop", ())),
        freedoms=model.n,
        base_freedoms=6 if model.floating else 0,
        mass=mass,
        com=com,
        at=at,
        notes=notes if description.format == "urdf" else (*notes, *model.notes),
        meshes=(len(uses), len(first)),
        missing=missing,
        checked=checked,
        next=tuple(commands),
    )


def _centre(
    description: Description, model: Model, at: Mapping[str, float]
) -> tuple[float, Array | None, tuple[str, ...]]:
    mass = fsum(link.inertial.mass for link in description.massive if link.inertial is not None)
    if not mass:
        why = "the masses of the parts add up to zero" if description.massive else "the robot has no mass"
        return mass, None, (f"no centre of mass: {why}",)
    q = configuration(model, at)
    moments = [
        narrowed(body.inertia.m * pose.p + product(pose.R, body.inertia.mc))
        for body, pose in zip(model.bodies, body_poses(model, q), strict=True)
    ]
    com = np.array([fsum(column) / mass for column in np.array(moments, dtype=float).T.tolist()])
    return mass, com, beyond_limits(model, q)


def branches(description: Description) -> Iterator[Branch]:
    """Yield the links, depth first and in the order of the file."""
    links = {link.name: link for link in description.links}
    carried: dict[str, list[Joint]] = {}
    for joint in description.joints:
        carried.setdefault(joint.parent, []).append(joint)
    waiting: list[tuple[int, str, Joint | None]] = [(0, description.root, None)]
    while waiting:
        depth, name, carrier = waiting.pop()
        link = links[name]
        yield Branch(name, link.line, depth, link.inertial.mass if link.inertial else None, carrier)
        waiting += [(depth + 1, joint.child, joint) for joint in reversed(carried.get(name, []))]
