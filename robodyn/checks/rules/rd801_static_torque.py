"""Every joint can hold the robot's weight in every pose within the limits.

The torque of gravity about each joint at rest, the root standing still with z up, in the worst
pose within the position limits; a joint without limits turns all the way round. The pose is found by going through
the joints again and again, the torque being a sine of each angle alone, from several starts. What is reported is
reached in the pose that is named; a worse one may exist.
Less than twice the limit is a remark: springs that hold a part of the weight are no part of URDF (PR2's shoulders need
1.7 times their limit, and hang on them), and no robot has to hold still in every pose. Loads, motion and friction come
on top: robodyn torques computes them. Silent where a part is detached (RD111), for levers are not known then.
"""

from math import degrees

from robodyn.checks.bodies.contacts import detached
from robodyn.checks.bodies.shapes import other_unit
from robodyn.checks.examples import INERTIA, arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.checks.statics.torque import StaticTorque, static_torques
from robodyn.robot.model import Model

_HEAVY = f'<origin xyz="0.5 0 0"/><mass value="2"/>{INERTIA}'
_MOST_JOINTS = 8
_SLACK = 1e-3
_KIND = "more than the effort limit"
_MUCH = 2.0
"""Times the limit from which it is a warning: published robots have up to 1.74, and 6 where the limits are made up."""


@rule(
    Severity.WARNING,
    Stage.MODEL,
    good=arm('<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="30" velocity="3"/>').replace(
        f'<mass value="2"/>{INERTIA}', _HEAVY
    ),
    bad=('"30"', '"5"'),
)
def check(context: Context) -> Faults:
    if context.once(detached):
        return
    if context.once(other_unit):
        return
    for one in context.once(static_torques):
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
    """Return the positions of the joints, those that are not zero, in degrees or metres."""
    values = []
    for joint in model.independent:
        value = one.q[joint.coordinate]
        if abs(value) > 1e-3:
            text = f"{value:.3g} m" if joint.kind == "prismatic" else f"{degrees(value):.0f} deg"
            values.append(f"{joint.name} = {text}")
    more = f" and {len(values) - _MOST_JOINTS} more" if len(values) > _MOST_JOINTS else ""
    return ", ".join(values[:_MOST_JOINTS]) + more if values else "q = 0"
