"""A configuration of a robot: values of its coordinates, and where its links then are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from robodyn.errors import InputError
from robodyn.programs.vectors import narrowed
from robodyn.robot.kinematics import REST, Pose, motions, poses
from robodyn.robot.model import Model
from robodyn.support.floats import Floats
from robodyn.support.wording import alternatives, count, listed, shown

Values = Sequence[float] | Mapping[str, float]

_UNITS = {"revolute": "rad", "prismatic": "m"}


def coordinates(model: Model) -> tuple[str, ...]:
    """Return names of the coordinates that place the links in the base's frame: all but those of a base that moves."""
    return model.coordinates[7 if model.floating else 0 :]


def configuration(model: Model, values: Values = ()) -> Floats:
    """Return the q of a configuration; coordinates that are not given are zero, a floating joint at its place.

    Args:
        values: of all `coordinates` in their order, or of some by name [rad or m].

    Raises:
        InputError: there are more or fewer values than coordinates, a name is none, or a quaternion is zero.
    """
    q = np.zeros(model.nq)
    for _, k in model.quaternions:
        q[k : k + 4] = (0.0, 0.0, 0.0, 1.0)
    place = {name: k for k, name in enumerate(model.coordinates)}
    for name, value in named(model, values, coordinates(model)).items():
        q[place[name]] = value
    for joint, k in model.quaternions:
        if not q[k : k + 4].any():
            raise InputError(f"the quaternion of joint {shown(joint)} is zero", remedy="give four numbers, w last")
    return q


def unit_rows(model: Model, states: Floats) -> Floats:
    """Return rows of q and more (N, width), which change, with quaternions of unit length."""
    for _, k in model.quaternions:
        states[:, k : k + 4] /= np.linalg.norm(states[:, k : k + 4], axis=1)[:, None]
    return states


def rates(model: Model, values: Values = ()) -> Floats:
    """Return the velocities or accelerations of the joints, a base that moves being at rest; what is not given is zero.

    Args:
        values: of all joints in the order of `model.rates`, or of some by name; see `named` [rad or m, per s or s^2].
    """
    given = named(model, values, model.rates[6 if model.floating else 0 :])
    return np.array([given.get(name, 0.0) for name in model.rates])


def named(model: Model, values: Values, names: tuple[str, ...]) -> Mapping[str, float]:
    """Return values by name, given in the order of these names, or some by name already; InputError of others."""
    if not isinstance(values, Mapping):
        if len(values) not in (0, len(names)):
            what = f"{count(len(values), 'value')} for {len(names)} coordinates"
            remedy = f"in the order: {listed(names)}" if names else "no joint moves"
            raise InputError(what, remedy=remedy, file=model.file)
        return dict(zip(names, values, strict=False))
    for name in values:
        if name not in names:
            leaders = (body.joint.mimics for body in model.bodies if body.joint.name == name and body.joint.mimics)
            remedy = next((f"it follows {shown(leader)}" for leader in leaders), alternatives(name, names, "joints"))
            raise InputError(f"no joint {shown(name)} to set", remedy=remedy, file=model.file)
    return values


def beyond_limits(model: Model, q: Floats) -> tuple[str, ...]:
    """Return what is outside its limits, mimic joints included, in words."""
    found = []
    for joint in (body.joint for body in model.bodies if body.joint.kind in ("revolute", "prismatic")):
        value, unit = joint.multiplier * float(q[joint.coordinate]) + joint.offset, _UNITS[joint.kind]
        for name, limit, side in (("lower", joint.lower, "below"), ("upper", joint.upper, "above")):
            if limit is not None and (value < limit if side == "below" else value > limit):
                found.append(f"joint {shown(joint.name)} at {value:.6g} {unit} is {side} its {name} limit {limit:.6g}")
    return tuple(found)


def link_poses(model: Model, q: Floats) -> dict[str, Pose]:
    """Return rotation and origin of every link's frame in the frame of the base, wherever the base is.

    Accuracy: 4 eps for each joint between, of rotations and of the robot's size.
    """
    bodies = body_poses(model, q)
    placed = {}
    for name, frame in model.links.items():
        R, p = bodies[frame.body]
        placed[name] = Pose(narrowed(R @ frame.R), narrowed(p + R @ frame.p))
    return placed


def body_poses(model: Model, q: Floats) -> list[Pose]:
    """Return rotation and origin of every body's frame in the frame of the base; see `link_poses`."""
    still = [0.0] * model.n
    return poses(model.parents, [REST, *motions(model, q.tolist(), still, still)[1:]])
