"""What the robot's own weight, its effort limits and its damping make of it."""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees

import numpy as np

from robodyn.checks.bodies.bodies import other_unit
from robodyn.checks.bodies.contacts import detached
from robodyn.checks.examples import INERTIA, arm
from robodyn.checks.rule import ERROR, MODEL, NOTE, WARNING, Context, Fault, Faults, rule
from robodyn.checks.rules.ranges import of_numbers
from robodyn.programs.vectors import length, narrowed, product, skew
from robodyn.robot.kinematics import body_poses
from robodyn.robot.model import Joint, Model
from robodyn.sizing import recursion
from robodyn.sizing.directions import lattice
from robodyn.sizing.poses import Poses
from robodyn.sizing.recursion import Key
from robodyn.support.floats import Floats
from robodyn.support.wording import figure

ROWS = 16  # of the lattice
MOST_BODIES = 150
"""Of larger robots the poses are not looked at: the work grows with the square of the number, or faster."""
GRAVITY = 9.81
_SWEEPS = 6  # in which each joint is given its best position
_LEAST_LEVER = 0.05
_WORTH = 1e-2  # s; damping that is slower than this on the body's own inertia is of no interest


def static_torques(context: Context) -> list[tuple[Joint, float, Floats]]:
    """Return the most that gravity asks of joints whose effort limits it might exceed, by a bound: the joint, the
    torque of largest magnitude that was found at rest, with its sign, gravity being (0, 0, -9.81) along the root's axes
    [N m or N], and the pose (n,), with joints that do not matter nearest to 0 [rad or m]. From stage MODEL on.

    Method: `sizing.recursion`, on a coarse lattice, and `sizing.poses`. Joints whose bound is within their limit are
    left out, and robots on a floating base, and of more than MOST_BODIES bodies, give nothing.

    Accuracy: `torque` is that of `bias_forces` at `q` within 1e-12 of the weight at the farthest reach; of 4000 random
        poses none asks for more than 1.001 times as much."""
    model = context.model
    if len(model.bodies) > MOST_BODIES or any(body.joint.kind == "floating" for body in model.bodies):
        return []
    followed = {body.joint.coordinate for body in model.bodies if body.joint.mimics is not None}
    bounds = context.once(gravity_bounds)
    joints = [
        body.joint
        for body in model.bodies
        if body.joint.mimics is None and body.joint.coordinate not in followed
        if body.joint.effort and 0.0 < body.joint.effort < bounds[body.joint.name][0]
    ]
    if not joints:
        return []
    low, high = position_ranges(model)
    keys = [Key("torque", joint.rate) for joint in joints]
    most = recursion.bounds(model, recursion.weight_of(model), low, high, lattice(ROWS), keys)
    beyond = [joint for joint, key in zip(joints, keys, strict=True) if most[key] > (joint.effort or 0.0)]
    if not beyond:
        return []
    poses, rest = Poses(model, [Key("torque", joint.rate) for joint in beyond]), np.clip(0.0, low, high)
    q, values = poses.worst(np.arange(len(beyond)), low, high, rest, sweeps=_SWEEPS, starts=2)
    return [*zip(beyond, values.tolist(), q, strict=True)]


def position_ranges(model: Model) -> tuple[Floats, Floats]:
    """(n,) the least and the largest position of each coordinate [rad or m]: a turn at most; 0 of a slide without
    limits."""
    low, high = np.zeros(model.n), np.zeros(model.n)
    for joint in model.independent:
        lower, upper = joint.lower, joint.upper
        endless = joint.continuous or lower is None or upper is None or upper - lower > 2 * np.pi
        if joint.kind == "revolute" and endless:
            lower, upper = -np.pi, np.pi
        if lower is not None and upper is not None and lower <= upper and abs(lower) < 1e3 and abs(upper) < 1e3:
            low[joint.coordinate], high[joint.coordinate] = lower, upper
    return low, high


def gravity_bounds(context: Context) -> Mapping[str, tuple[float, float]]:
    """What the weight of all that a joint carries and of the whole robot, as of a leg that stands, can be about it in
    no pose, by joint, from the sum of the lengths on the way to the farthest part of what it carries, of the whole at 5
    cm at least, and what turns it [N m or N]. From stage MODEL on."""
    model = context.model
    count = len(model.bodies)
    carried, reach, tilt = np.zeros(count), np.zeros(count), np.ones(count)
    standing = {-1: np.eye(3)}  # gravity across a hinge's axis or along a slide: all of it above a hinge
    for i, body in enumerate(model.bodies):
        if body.parent in standing:
            R = product(standing[body.parent], body.joint.R)
            slides = body.joint.kind == "prismatic"
            tilt[i] = abs(float(product(R[2], body.joint.axis))) if slides else length(np.cross(R[2], body.joint.axis))
            if body.joint.kind != "revolute":
                standing[i] = R
    bounds = {}
    for i in reversed(range(count)):
        body = model.bodies[i]
        joint, mass = body.joint, body.inertia.m
        carried[i] += mass
        if mass > 0.0:
            reach[i] = max(reach[i], length(body.inertia.mc) / mass)
        lever = 1.0 if joint.kind == "prismatic" else float(reach[i])
        whole = model.total_mass * GRAVITY * max(lever, _LEAST_LEVER)
        bounds[joint.name] = float(carried[i]) * GRAVITY * lever * float(tilt[i]), whole
        if body.parent >= 0:
            carried[body.parent] += carried[i]
            slide = max(abs(joint.lower or 0.0), abs(joint.upper or 0.0)) if joint.kind == "prismatic" else 0.0
            reach[body.parent] = max(reach[body.parent], length(joint.p) + slide + reach[i])
    return bounds


def inverse_of_definite(M: Floats) -> Floats | None:
    """The inverse of a positive definite matrix, None of others, by Gauss-Jordan in place: of links of next to no
    inertia only rounding is left, which is printed, and is the same everywhere so, unlike that of LAPACK."""
    A = M.copy()
    for k in range(len(A)):
        pivot = A[k, k]
        if not pivot > 0.0:
            return None
        row = A[k] / pivot
        A -= A[:, k, None] * row
        A[k] = A[:, k] = row
        A[k, k] = -1.0 / pivot
    return np.asarray(-A)


def joint_space_inertia(model: Model, q: Floats) -> Floats:
    """M(q) = sum of m J_v^T J_v + J_w^T I_c J_w over the bodies, with rotor inertias on the diagonal. For one pose
    (n,), without floating joints, it is ready before `robodyn.mass_matrix` is traced. Accuracy: 1e-12."""
    M, columns = np.zeros((model.n, model.n)), list[Floats]()
    for body, pose in zip(model.bodies, body_poses(model, q), strict=True):
        R, p, joint = narrowed(pose.R), narrowed(pose.p), body.joint
        axis = product(R, joint.axis)
        J = columns[body.parent].copy() if body.parent >= 0 else np.zeros((6, model.n))  # of a point at the origin
        if joint.kind == "revolute":
            J[:, joint.rate] += joint.multiplier * np.concatenate((axis, np.cross(p, axis)))
        elif joint.kind == "prismatic":
            J[3:, joint.rate] += joint.multiplier * axis
        if joint.kind != "fixed":
            M[joint.rate, joint.rate] += joint.multiplier**2 * joint.reduction**2 * joint.rotor_inertia
        columns.append(J)
        J_c = J[3:] - product(skew(product(R, body.inertia.centre_of_mass) + p), J[:3])
        M += body.inertia.m * product(J_c.T, J_c) + product(J[:3].T, R, body.inertia.about_centre, R.T, J[:3])
    return M


_HEAVY = f'<origin xyz="0.5 0 0"/><mass value="2"/>{INERTIA}'
_MOST_JOINTS = 8
_SLACK = 1e-3
_KIND = "more than the effort limit"
_MUCH = 2.0
"""Times the limit from which it is a warning: published robots have up to 1.74, and 6 where the limits are made up."""


@rule(
    "RD801",
    WARNING,
    MODEL,
    good=arm('<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="30" velocity="3"/>').replace(
        f'<mass value="2"/>{INERTIA}', _HEAVY
    ),
    bad=('"30"', '"5"'),
)
def static_torque(context: Context) -> Faults:
    """Every joint can hold the robot's weight in every pose within the limits.

    The torque of gravity about each joint at rest, the root standing still with z up, in the worst pose within the
    position limits; a joint without limits turns all the way round. What is reported is reached in the pose that is
    named; `robodyn envelope` bounds what any other asks for. Less than twice the limit is a remark: springs that hold a
    part of the weight are no part of URDF, and no robot has to hold still in every pose. Loads, motion and friction
    come on top: robodyn torques computes them. Silent where a part is detached (RD111)."""
    silent = bool(context.once(detached)) or context.once(other_unit) is not None
    for joint, torque, q in [] if silent else static_torques(context):
        limit = context.view.joint[joint.name].limit
        if limit is None or joint.effort is None or abs(torque) <= (1.0 + _SLACK) * joint.effort:
            continue
        unit, values = "N" if joint.kind == "prismatic" else "N m", list[str]()
        for other in context.model.independent:
            value = q[other.coordinate]
            if abs(value) > 1e-3:
                text = f"{value:.3g} m" if other.kind == "prismatic" else f"{degrees(value):.0f} deg"
                values.append(f"{other.name} = {text}")
        more = f" and {len(values) - _MOST_JOINTS} more" if len(values) > _MOST_JOINTS else ""
        pose = ", ".join(values[:_MOST_JOINTS]) + more if values else "q = 0"
        what = f"the robot's own weight asks for {abs(torque):.4g} {unit} at rest, more than the effort limit "
        what += f"{joint.effort:g}, at {pose}"
        remedy = "raise the limit, lower masses or levers, or narrow the ranges; a counterbalance deserves a waiver"
        severity = None if abs(torque) >= _MUCH * joint.effort else NOTE
        yield Fault(limit.effort.span, what, remedy, abs(torque), joint.effort, severity=severity, kind=_KIND)


FACTOR = 1000.0  # an effort limit of more than this many times the robot's weight at the joint's reach bounds nothing


@rule(
    "RD803",
    WARNING,
    MODEL,
    explanation=f"""A limit of more than {FACTOR:g} times the weight of the whole robot, hanging where the joint's
farthest part can be (5 cm away at least), was never meant to limit anything: saturation, planning and sizing against
it say nothing. Greater ones still, which stand for no limit at all, are RD506's; those in N mm are RD515's.""",
    good=arm('<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="900" velocity="3"/>'),
    bad=('"900"', '"90000"'),
    default=ERROR,
)
def absurd_effort(context: Context) -> Faults:
    """An effort limit is within reach of the loads."""
    bounds, explained = context.once(gravity_bounds), context.once(of_numbers)
    for joint in context.model.independent:
        limit = None if joint.name not in context.view.joint else context.view.joint[joint.name].limit
        _, most = bounds[joint.name]
        if limit is None or joint.effort is None or id(limit.effort) in explained:
            continue
        if not FACTOR * most < joint.effort <= context.thresholds.most_effort or not most > 0.0:
            continue
        unit = "N" if joint.kind == "prismatic" else "N m"
        what = f"the effort limit {joint.effort:g} {unit} is {figure(joint.effort / most, 2)} times what the weight "
        what += f"of the whole robot asks for at the reach of this joint, {most:.3g} {unit}"
        yield Fault(limit.effort.span, what, "write what the actuator can give", joint.effort, FACTOR * most)


STEP = 1e-3  # s; the usual step of a simulation


@rule(
    "RD804",
    WARNING,
    MODEL,
    explanation=f"""A joint of damping b and reflected inertia J = 1 / (M^-1)_ii comes to rest within J / b. Explicit
Euler with a longer step than 2 J / b overshoots more with every step; the rule asks for {STEP:g} s. Real joints have
the inertia of a rotor times the square of the gear ratio, which most descriptions leave out. J is taken at the
middle of the ranges.""",
    good=arm('<axis xyz="1 0 0"/><limit lower="-2" upper="2" effort="30" velocity="3"/><dynamics damping="1"/>'),
    bad=('"1"', '"50"'),
    default=ERROR,
)
def stiff_damping(context: Context) -> Faults:
    """Inertia and damping of a joint allow steps of 1 ms."""
    model, joints = context.model, list[Joint]()
    for body in model.bodies:
        joint, m = body.joint, body.inertia.m
        if joint.kind in ("revolute", "prismatic") and joint.mimics is None and joint.damping > 0.0:
            own = m if joint.kind == "prismatic" else float(product(joint.axis, body.inertia.I, joint.axis))
            if own < _WORTH * joint.damping:
                joints.append(joint)
    if not joints or model.nq != model.n or len(model.bodies) > MOST_BODIES:
        return
    low, high = position_ranges(model)
    inverse = inverse_of_definite(joint_space_inertia(model, (low + high) / 2.0))
    diagonal = {} if inverse is None else {joint.rate: float(inverse[joint.rate, joint.rate]) for joint in joints}
    for joint in joints if diagonal else ():
        inertia = 1.0 / diagonal[joint.rate]
        step = 2.0 * inertia / joint.damping
        if not 0.0 < step < STEP:
            continue
        view = context.view.joint[joint.name]
        unit = "kg" if joint.kind == "prismatic" else "kg m^2"
        what = f"damping {joint.damping:g} on a reflected inertia of {inertia:.3g} {unit}: explicit integration "
        what += f"diverges with steps above {step:.2g} s"
        remedy = "add the rotor's inertia (rotorInertia and mechanicalReduction of its transmission), lower the "
        remedy += "damping, or integrate implicitly"
        at = view.element.span if view.damping.element is None else view.damping.span
        yield Fault(at, what, remedy, step, STEP)
