"""What the robot's own weight, its effort limits and its damping make of it."""

from __future__ import annotations

from math import degrees

from robodyn.checks.bodies.contacts import detached
from robodyn.checks.bodies.shapes import other_unit
from robodyn.checks.bodies.statics import StaticTorque, gravity_bounds, reflected_inertias, static_torques
from robodyn.checks.examples import INERTIA, arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.checks.rules.ranges import of_numbers
from robodyn.robot.model import Model
from robodyn.support.wording import figure

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
        unit = "N" if joint.kind == "prismatic" else "N m"
        what = (
            f"the robot's own weight asks for {abs(one.torque):.4g} {unit} at rest, more than the effort limit "
            f"{joint.effort:g}, at {_pose(context.model, one)}"
        )
        remedy = "raise the limit, lower masses or levers, or narrow the ranges; a counterbalance deserves a waiver"
        severity = None if abs(one.torque) >= _MUCH * joint.effort else Severity.NOTE
        yield Fault(limit.effort.span, what, remedy, abs(one.torque), joint.effort, severity=severity, kind=_KIND)


def _pose(model: Model, one: StaticTorque) -> str:
    values = []
    for joint in model.independent:
        value = one.q[joint.coordinate]
        if abs(value) > 1e-3:
            text = f"{value:.3g} m" if joint.kind == "prismatic" else f"{degrees(value):.0f} deg"
            values.append(f"{joint.name} = {text}")
    more = f" and {len(values) - _MOST_JOINTS} more" if len(values) > _MOST_JOINTS else ""
    return ", ".join(values[:_MOST_JOINTS]) + more if values else "q = 0"


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
