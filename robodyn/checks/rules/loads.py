"""What the robot's own weight, its effort limits and its damping make of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import degrees
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.checks.bodies.bodies import other_unit
from robodyn.checks.bodies.contacts import detached
from robodyn.checks.examples import INERTIA, arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.checks.rules.ranges import of_numbers
from robodyn.programs.vectors import arctan2, cross, length, narrowed, product, skew
from robodyn.robot.kinematics import body_poses
from robodyn.robot.model import Joint, Model
from robodyn.support.floats import Floats, first_largest
from robodyn.support.wording import figure

_NOTHING = 1e-12
"""First moments that are no more than this, by the robot's mass, are rounding [m]."""
STARTS = 4
MOST_BODIES = 150
"""Of larger robots the poses are not looked at: the work grows with the square of the number, or faster."""
SWEEPS = 10
GRAVITY = 9.81
_CONVERGED = 1e-3
_LEAST_LEVER = 0.05
_WORTH = 1e-2
"""s; damping that is slower than this on the body's own inertia is of no interest."""


class StaticTorque(NamedTuple):
    """The torque of largest magnitude that was found of a joint at rest, with its sign, gravity being (0, 0, -9.81)
    along the root's axes [N m or N], and the pose (n,), with joints that do not matter nearest to 0 [rad or m]."""

    joint: Joint
    torque: float
    q: Floats


class GravityBound(NamedTuple):
    """What the weight of `own`, all that a joint carries, or of the `whole` robot, as of a leg that stands, can be
    about the joint at the farthest reach of what the joint carries, of the whole at 5 cm at least [N m or N]."""

    own: float
    whole: float


def static_torques(context: Context) -> tuple[StaticTorque, ...]:
    """Return the most that gravity asks of joints whose effort limits it might exceed, by a bound. From stage MODEL on.

    Method: in the angle of one joint the torque is a + b cos q + c sin q, so that its best angle within the limits is
    known, and going through the joints again and again only ever raises the torque: from STARTS poses up and as many
    down, until a sweep gains less than 0.1 %, SWEEPS at most. There may be a larger one elsewhere. Joints that others
    mimic stay where they start. Robots on a floating base, and of more than MOST_BODIES bodies, give nothing.

    Accuracy: `torque` is that of `bias_forces` at `q` within 1e-12 of the weight at the farthest reach; of 4000 random
        poses none asks for more than 1.02 times as much.
    """
    model = context.model
    if len(model.bodies) > MOST_BODIES or any(body.joint.kind == "floating" for body in model.bodies):
        return ()
    followed = {body.joint.coordinate for body in model.bodies if body.joint.mimics is not None}
    single = [body.joint.mimics is None and body.joint.coordinate not in followed for body in model.bodies]
    bounds = context.once(gravity_bounds)
    targets = [
        i
        for i, body in enumerate(model.bodies)
        if single[i] and body.joint.effort and 0.0 < body.joint.effort < bounds[body.joint.name].own
    ]
    if not targets:
        return ()
    low, high = position_ranges(model)
    above, found = ancestors(model), []
    near = above[targets].any(axis=0) | above[:, targets].any(axis=1)
    free = [i for i in np.flatnonzero(near).tolist() if i and single[i]]
    torques, poses = worst_poses(model, above, targets, free, low, high)
    for k, i in enumerate(targets):
        worst = first_largest(np.abs(torques[k]))
        matter = [body.joint.coordinate for j, body in enumerate(model.bodies) if j and (above[i, j] or above[j, i])]
        q = np.clip(np.zeros(model.n), low, high)
        q[matter] = poses[k, worst, matter]
        found.append(StaticTorque(model.bodies[i].joint, float(torques[k, worst]), q))
    return tuple(found)


def ancestors(model: Model) -> NDArray[np.bool_]:
    """(bodies, bodies) whether body j is body i or carries it."""
    above = np.eye(len(model.bodies), dtype=bool)
    for i, parent in enumerate(model.parents[1:], 1):
        above[i] |= above[parent]
    return above


def worst_poses(
    model: Model, above: NDArray[np.bool_], targets: Sequence[int], free: Sequence[int], low: Floats, high: Floats
) -> tuple[Floats, Floats]:
    """(targets, 2 STARTS) torques [N m or N] and (targets, 2 STARTS, n) poses: half of a target's rows start to raise
    its torque, half to lower it.

    The torque of gravity about joint t, divided by g, is u . v with u up and v = a_t x sum m (c - p_t). Turning a joint
    at or above t turns v about its axis; one below t turns the first moment sum m (c - p_j) of what it carries, whose
    product with w = u x a_t is the torque's part. A slide below t moves that along its axis, one above changes nothing.
    """
    begin, bodies = starts(low, high), model.bodies
    q = np.tile(begin.T, (1, 2 * len(targets)))
    sign = np.tile(np.repeat((1.0, -1.0), STARTS), len(targets))
    of_row = np.repeat(targets, 2 * STARTS)
    mass = np.array([body.inertia.m for body in bodies])
    held, rows = above[:, of_row].astype(float), np.arange(len(of_row))
    carried = product(above.T.astype(float), mass)
    slides = np.array([bodies[t].joint.kind == "prismatic" for t in of_row])
    # (3, 3, bodies, rows): x, y, z of origin, own first moment and joint axis of each body, in the frame of the base
    placed = np.repeat(at_zero(model)[..., None], len(rows), axis=3)
    weights = np.stack((np.ones_like(mass), mass, np.zeros_like(mass)))[:, :, None]

    def levers() -> tuple[Floats, Floats]:
        """(3, rows) v, and the axis of each row's target."""
        moment = (held * placed[:, 1]).sum(axis=1)
        origin, axis = placed[:, 0, of_row, rows], placed[:, 2, of_row, rows]
        return np.where(slides, carried[of_row] * axis, cross(axis, moment - carried[of_row] * origin)), axis

    def sweep() -> None:
        """Give each free joint in turn, from the base to the tips, its best position."""
        for i in free:
            joint, (origin, _, axis) = bodies[i].joint, placed[:, :, i].swapaxes(0, 1)
            now, least, most = q[joint.coordinate], low[joint.coordinate], high[joint.coordinate]
            v, of_target = levers()
            over = above[of_row, i]  # rows whose target joint i carries
            under = above[i, of_row] & ~over & ~slides
            w = np.where(under, np.stack((-of_target[1], of_target[0], np.zeros_like(now))), 0.0)
            if joint.kind == "prismatic":
                gain = sign * (w * axis).sum(axis=0)
                best = np.where(gain > 0.0, most, np.where(gain < 0.0, least, now))
            else:
                x = np.where(over, v, placed[:, 1, above[:, i]].sum(axis=1) - carried[i] * origin)
                y = np.where(over, np.array((0.0, 0.0, 1.0))[:, None], w)
                cosine = sign * ((y * x).sum(axis=0) - (y * axis).sum(axis=0) * (x * axis).sum(axis=0))
                sine = sign * (y * cross(axis, x)).sum(axis=0)
                best = best_angle(cosine, sine, now, least, most)
                best = np.where(np.hypot(cosine, sine) > _NOTHING * (carried[0] or 1.0), best, now)
            move(joint, i, above[:, i], placed, weights, best - now)
            q[joint.coordinate] = best

    for i, body in enumerate(bodies[1:], 1):
        move(body.joint, i, above[:, i], placed, weights, body.joint.multiplier * q[body.joint.coordinate])
    last = np.full(len(rows), -np.inf)
    for _ in range(SWEEPS + 1):
        now = sign * levers()[0][2]
        sweep()
        if (now - last <= _CONVERGED * np.abs(now)).all():
            break
        last = now
    torques = GRAVITY * levers()[0][2].reshape(len(targets), -1)
    return torques, q.T.reshape(*torques.shape, model.n)


def move(joint: Joint, i: int, part: NDArray[np.bool_], placed: Floats, weights: Floats, by: Floats) -> None:
    """Turn or shift the part that joint i carries."""
    origin, _, axis = placed[:, :, i].swapaxes(0, 1).copy()[:, :, None, None]
    if joint.kind == "prismatic":
        placed[:, :, part] += weights[:, part] * (by * axis)
    else:
        arm = placed[:, :, part] - weights[:, part] * origin
        along = (arm * axis).sum(axis=0) * axis
        placed[:, :, part] += (np.cos(by) - 1.0) * (arm - along) + np.sin(by) * cross(axis, arm)


def at_zero(model: Model) -> Floats:
    """(3, 3, bodies) origin [m], own first moment about the base's [kg m], and axis of the joint of each body, at 0."""
    found = []
    for body, pose in zip(model.bodies, body_poses(model, np.zeros(model.n)), strict=True):
        R, p = narrowed(pose.R), narrowed(pose.p)
        found.append((p, product(R, body.inertia.mc) + body.inertia.m * p, product(R, body.joint.axis)))
    return np.array(found).T


def best_angle(cosine: Floats, sine: Floats, now: Floats, least: float, most: float) -> Floats:
    """Angles from `least` to `most` at which cosine cos(q - now) + sine sin(q - now) is largest."""
    best = least + (now + arctan2(sine, cosine) - least) % (2.0 * np.pi)
    at_least, at_most = (cosine * np.cos(end - now) + sine * np.sin(end - now) for end in (least, most))
    return np.where(best <= most, best, np.where(at_least > at_most, least, most))


def position_ranges(model: Model) -> tuple[Floats, Floats]:
    """(n,) the least and the largest position of each coordinate [rad or m]: a turn where an angle has no limits, or a
    wider range; 0 where a slide has none."""
    low, high = np.zeros(model.n), np.zeros(model.n)
    for joint in model.independent:
        lower, upper = joint.lower, joint.upper
        endless = joint.continuous or lower is None or upper is None or upper - lower > 2 * np.pi
        if joint.kind == "revolute" and endless:
            lower, upper = -np.pi, np.pi
        if lower is not None and upper is not None and lower <= upper and abs(lower) < 1e3 and abs(upper) < 1e3:
            low[joint.coordinate], high[joint.coordinate] = lower, upper
    return low, high


def starts(low: Floats, high: Floats) -> Floats:
    """(STARTS, n) the middle, and points spread evenly by multiples of irrational numbers."""
    n = len(low)
    spread = np.outer(np.arange(STARTS), np.sqrt(np.arange(2, n + 2))) % 1.0
    spread[0] = 0.5
    return np.asarray(low + spread * (high - low))


def gravity_bounds(context: Context) -> Mapping[str, GravityBound]:
    """What no pose exceeds, by joint, from the sum of the lengths on the way and what turns it. From stage MODEL on."""
    model = context.model
    count = len(model.bodies)
    carried, reach = np.zeros(count), np.zeros(count)
    bounds = {}
    for i in reversed(range(count)):
        body = model.bodies[i]
        joint, mass = body.joint, body.inertia.m
        carried[i] += mass
        if mass > 0.0:
            reach[i] = max(reach[i], length(body.inertia.mc) / mass)
        lever = 1.0 if joint.kind == "prismatic" else float(reach[i])
        whole = model.total_mass * GRAVITY * max(lever, _LEAST_LEVER)
        bounds[joint.name] = GravityBound(float(carried[i]) * GRAVITY * lever, whole)
        if body.parent >= 0:
            carried[body.parent] += carried[i]
            slide = max(abs(joint.lower or 0.0), abs(joint.upper or 0.0)) if joint.kind == "prismatic" else 0.0
            reach[body.parent] = max(reach[body.parent], length(joint.p) + slide + reach[i])
    return bounds


def reflected_inertias(context: Context) -> tuple[tuple[Joint, float], ...]:
    """Return (joint, J) of the joints whose damping may be fast; J = 1 / (M^-1)_ii at the middle of the ranges. From
    stage MODEL on; empty for a singular mass matrix, a floating joint or more than MOST_BODIES bodies.

    Accuracy: M within 1e-12 of its largest entry.
    """
    model, joints = context.model, list[Joint]()
    for body in model.bodies:
        joint, m = body.joint, body.inertia.m
        if joint.kind in ("revolute", "prismatic") and joint.mimics is None and joint.damping > 0.0:
            own = m if joint.kind == "prismatic" else float(product(joint.axis, body.inertia.I, joint.axis))
            if own < _WORTH * joint.damping:
                joints.append(joint)
    if not joints or model.nq != model.n or len(model.bodies) > MOST_BODIES:
        return ()
    low, high = position_ranges(model)
    inverse = inverse_of_definite(joint_space_inertia(model, (low + high) / 2.0))
    return () if inverse is None else tuple((joint, 1.0 / float(inverse[joint.rate, joint.rate])) for joint in joints)


def inverse_of_definite(M: Floats) -> Floats | None:
    """The inverse of a positive definite matrix, None of others, by Gauss-Jordan in place: of links of next to
    no inertia only rounding is left, which is printed, and is the same everywhere so, unlike that of LAPACK."""
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
    """M(q) = sum of m J_v^T J_v + J_w^T I_c J_w over the bodies, with rotor inertias on the diagonal.

    For one pose (n,) of a robot without floating joints this is ready long before `robodyn.mass_matrix` is traced.

    Accuracy: 1e-12 of the largest entry.
    """
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
    Severity.WARNING,
    Stage.MODEL,
    good=arm('<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="30" velocity="3"/>').replace(
        f'<mass value="2"/>{INERTIA}', _HEAVY
    ),
    bad=('"30"', '"5"'),
)
def static_torque(context: Context) -> Faults:
    """Every joint can hold the robot's weight in every pose within the limits.

    The torque of gravity about each joint at rest, the root standing still with z up, in the worst pose within the
    position limits; a joint without limits turns all the way round. What is reported is reached in the pose that is
    named; a worse one may exist. Less than twice the limit is a remark: springs that hold a part of the weight are no
    part of URDF, and no robot has to hold still in every pose. Loads, motion and friction come on top: robodyn torques
    computes them. Silent where a part is detached (RD111).
    """
    silent = bool(context.once(detached)) or context.once(other_unit) is not None
    for one in () if silent else context.once(static_torques):
        limit, joint = context.view.joint[one.joint.name].limit, one.joint
        if limit is None or joint.effort is None or abs(one.torque) <= (1.0 + _SLACK) * joint.effort:
            continue
        unit, values = "N" if joint.kind == "prismatic" else "N m", list[str]()
        for other in context.model.independent:
            value = one.q[other.coordinate]
            if abs(value) > 1e-3:
                text = f"{value:.3g} m" if other.kind == "prismatic" else f"{degrees(value):.0f} deg"
                values.append(f"{other.name} = {text}")
        more = f" and {len(values) - _MOST_JOINTS} more" if len(values) > _MOST_JOINTS else ""
        pose = ", ".join(values[:_MOST_JOINTS]) + more if values else "q = 0"
        what = (
            f"the robot's own weight asks for {abs(one.torque):.4g} {unit} at rest, more than the effort limit "
            f"{joint.effort:g}, at {pose}"
        )
        remedy = "raise the limit, lower masses or levers, or narrow the ranges; a counterbalance deserves a waiver"
        severity = None if abs(one.torque) >= _MUCH * joint.effort else Severity.NOTE
        yield Fault(limit.effort.span, what, remedy, abs(one.torque), joint.effort, severity=severity, kind=_KIND)


FACTOR = 1000.0
"""An effort limit of more than this many times the robot's weight at the joint's reach bounds nothing."""


@rule(
    "RD803",
    Severity.WARNING,
    Stage.MODEL,
    explanation=f"""A limit of more than {FACTOR:g} times the weight of the whole robot, hanging where the joint's
farthest part can be (5 cm away at least), was never meant to limit anything: saturation, planning and sizing against
it say nothing. Greater ones still, which stand for no limit at all, are RD506's; those in N mm are RD515's.""",
    good=arm('<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="900" velocity="3"/>'),
    bad=('"900"', '"90000"'),
    default=Severity.ERROR,
)
def absurd_effort(context: Context) -> Faults:
    """An effort limit is within reach of the loads."""
    bounds, explained = context.once(gravity_bounds), context.once(of_numbers)
    for joint in context.model.independent:
        limit = None if joint.name not in context.view.joint else context.view.joint[joint.name].limit
        most = bounds[joint.name].whole
        if limit is None or joint.effort is None or id(limit.effort) in explained:
            continue
        if not FACTOR * most < joint.effort <= context.thresholds.most_effort or not most > 0.0:
            continue
        unit = "N" if joint.kind == "prismatic" else "N m"
        what = (
            f"the effort limit {joint.effort:g} {unit} is {figure(joint.effort / most, 2)} times what the weight "
            f"of the whole robot asks for at the reach of this joint, {most:.3g} {unit}"
        )
        yield Fault(limit.effort.span, what, "write what the actuator can give", joint.effort, FACTOR * most)


STEP = 1e-3
"""s; the usual step of a simulation."""


@rule(
    "RD804",
    Severity.WARNING,
    Stage.MODEL,
    explanation=f"""A joint of damping b and reflected inertia J = 1 / (M^-1)_ii comes to rest within J / b. Explicit
Euler with a longer step than 2 J / b overshoots more with every step; the rule asks for {STEP:g} s. Real joints have
the inertia of a rotor times the square of the gear ratio, which most descriptions leave out. J is taken at the
middle of the ranges.""",
    good=arm('<axis xyz="1 0 0"/><limit lower="-2" upper="2" effort="30" velocity="3"/><dynamics damping="1"/>'),
    bad=('"1"', '"50"'),
    default=Severity.ERROR,
)
def stiff_damping(context: Context) -> Faults:
    """Inertia and damping of a joint allow steps of 1 ms."""
    for joint, inertia in context.once(reflected_inertias):
        step = 2.0 * inertia / joint.damping
        if not 0.0 < step < STEP:
            continue
        view = context.view.joint[joint.name]
        unit = "kg" if joint.kind == "prismatic" else "kg m^2"
        what = (
            f"damping {joint.damping:g} on a reflected inertia of {inertia:.3g} {unit}: explicit integration "
            f"diverges with steps above {step:.2g} s"
        )
        remedy = (
            "add the rotor's inertia (rotorInertia and mechanicalReduction of its transmission), lower the "
            "damping, or integrate implicitly"
        )
        at = view.element.span if view.damping.element is None else view.damping.span
        yield Fault(at, what, remedy, step, STEP)
