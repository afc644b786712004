"""The most torque that gravity asks of each joint in any pose within the limits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from robodyn.checks.context import Context
from robodyn.checks.statics.sweep import Sweep, around
from robodyn.programs.vectors import length, product
from robodyn.robot.model import Joint, Model
from robodyn.support.floats import Floats, first_largest

STARTS = 4
MOST_BODIES = 150
"""Of larger robots the poses are not looked at: the work grows with the square of the number, or faster."""
SWEEPS = 10
GRAVITY = 9.81
_CONVERGED = 1e-3
_LEAST_LEVER = 0.05


@dataclass(frozen=True, eq=False)
class StaticTorque:
    """What a joint must carry at rest.

    Attributes:
        joint: with a coordinate of its own.
        torque: of largest magnitude that was found, with its sign; gravity is (0, 0, -9.81) along the root's axes
            [N m or N].
        q: (n,) the pose, with joints that do not matter at or nearest to 0 [rad or m].
    """

    joint: Joint
    torque: float
    q: Floats


@dataclass(frozen=True, slots=True)
class GravityBound:
    """What the weight of `own`, all that a joint carries, or of the `whole` robot, as of a leg that stands, can be
    about the joint at the farthest reach of what the joint carries, of the whole at 5 cm at least [N m or N]."""

    own: float
    whole: float


def static_torques(context: Context) -> tuple[StaticTorque, ...]:
    """Return the most that gravity asks of joints whose effort limits it might exceed, by a bound. From stage MODEL on.

    Method: the torque of gravity about a joint is M g u . (a x r), u pointing up, r from the joint to the centre of the
    mass M that it carries. As a function of the angle of one joint it is a + b cos q + c sin q: of one above, which
    turns u, of one below, which turns a part of r, and of the joint itself. So the best angle of one joint within its
    limits is known in closed form, and going through the joints again and again only ever raises the torque. From
    STARTS poses up and as many down, the same for every robot, until a sweep gains less than 0.1 %, SWEEPS at most.
    What is found is reached, and may be short of the most where there are several local ones. Joints that others mimic
    are left out, and stay where they start. Robots on a floating base have no such torque and give nothing,
    nor do robots of more than MOST_BODIES bodies.

    Accuracy: `torque` is that of `bias_forces` at `q` within 1e-12 of the weight at the farthest reach; of 4000 random
        poses none asks for more than 1.02 times as much.
    """
    model = context.model
    if len(model.bodies) > MOST_BODIES or any(body.joint.kind == "floating" for body in model.bodies):
        return ()
    places = {body.joint.name: i for i, body in enumerate(model.bodies)}
    bounds = context.once(gravity_bounds)
    single = [joint for joint in model.independent if joint.coordinate not in _followed(model)]
    might = [joint for joint in single if joint.effort and 0.0 < joint.effort < bounds[joint.name].own]
    return tuple(_worst(model, might, [places[joint.name] for joint in might])) if might else ()


def _worst(model: Model, joints: Sequence[Joint], targets: Sequence[int]) -> Iterator[StaticTorque]:
    low, high = position_ranges(model)
    free = np.array([k not in _followed(model) for k in range(model.n)])
    sweep = Sweep(model, targets, starts(low, high), low, high, free)
    last = sweep.improve()
    for _ in range(SWEEPS):
        now = sweep.improve()
        if (now - last <= _CONVERGED * np.abs(now)).all():
            break
        last = now
    torques, poses = GRAVITY * sweep.torques(), sweep.poses()
    for k, joint in enumerate(joints):
        worst = first_largest(np.abs(torques[k]))
        matter = [model.bodies[i].joint.coordinate for i in around(model.parents, frozenset({targets[k]}))[1:]]
        q = np.clip(np.zeros(model.n), low, high)
        q[matter] = poses[k, worst, matter]
        yield StaticTorque(joint, float(torques[k, worst]), q)


def _followed(model: Model) -> frozenset[int]:
    """Return the coordinates that move several joints."""
    return frozenset(body.joint.coordinate for body in model.bodies if body.joint.mimics is not None)


def position_ranges(model: Model) -> tuple[Floats, Floats]:
    """Return (n,) the least and the largest position of each coordinate [rad or m]: a turn where an angle has no
    limits, or a wider range; 0 where a slide has none."""
    low, high = np.zeros(model.n), np.zeros(model.n)
    for joint in model.independent:
        lower, upper = joint.lower, joint.upper
        if joint.kind == "revolute" and (
            joint.continuous or lower is None or upper is None or upper - lower > 2 * np.pi
        ):
            lower, upper = -np.pi, np.pi
        if lower is not None and upper is not None and lower <= upper and abs(lower) < 1e3 and abs(upper) < 1e3:
            low[joint.coordinate], high[joint.coordinate] = lower, upper
    return low, high


def starts(low: Floats, high: Floats) -> Floats:
    """Return (STARTS, n) the middle, and points spread evenly by multiples of irrational numbers."""
    n = len(low)
    spread = np.outer(np.arange(STARTS), np.sqrt(np.arange(2, n + 2))) % 1.0
    spread[0] = 0.5
    inside: Floats = low + spread * (high - low)
    return inside


def gravity_bounds(context: Context) -> Mapping[str, GravityBound]:
    """Return by joint what no pose exceeds, from the sum of the lengths on the way and what turns it. From stage MODEL
    on."""
    model = context.model
    count = len(model.bodies)
    carried, reach, tilt = np.zeros(count), np.zeros(count), _tilts(model)
    bounds = {}
    for i in reversed(range(count)):
        body = model.bodies[i]
        joint, mass = body.joint, body.inertia.m
        carried[i] += mass
        if mass > 0.0:
            reach[i] = max(reach[i], length(body.inertia.mc) / mass)
        lever = 1.0 if joint.kind == "prismatic" else float(reach[i])
        whole = model.total_mass * GRAVITY * max(lever, _LEAST_LEVER)
        bounds[joint.name] = GravityBound(float(carried[i]) * GRAVITY * lever * tilt[i], whole)
        if body.parent >= 0:
            carried[body.parent] += carried[i]
            slide = max(abs(joint.lower or 0.0), abs(joint.upper or 0.0)) if joint.kind == "prismatic" else 0.0
            reach[body.parent] = max(reach[body.parent], length(joint.p) + slide + reach[i])
    return bounds


def _tilts(model: Model) -> list[float]:
    """The most that gravity has of its strength across each hinge's axis or along each slide: 1 above a hinge."""
    tilts, standing = [], {-1: np.eye(3)}
    for i, body in enumerate(model.bodies):
        joint = body.joint
        if body.parent not in standing:
            tilts.append(1.0)
            continue
        up = product(standing[body.parent], joint.R)[2]
        along = abs(float(product(up, joint.axis)))
        tilts.append(along if joint.kind == "prismatic" else length(np.cross(up, joint.axis)))
        if joint.kind != "revolute":
            standing[i] = product(standing[body.parent], joint.R)
    return tilts
