"""A mimic joint stays within its limits wherever the joint that it follows goes.

Otherwise the robot described cannot move through the range that its limits promise: simulators
violate the limits or the coupling, and planners reach positions that the hand does not have.
"""

from robodyn.checks.examples import LIMIT, longer_arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.parts import WITH_RANGE
from robodyn.robot.urdf.view import JointView

_FOLLOWER = f'<axis xyz="0 1 0"/>{LIMIT}<mimic joint="shoulder" multiplier="0.5"/>'


@rule(Severity.WARNING, good=longer_arm(inside=_FOLLOWER), bad=('"0.5"', '"1.5"'))
def check(context: Context) -> Faults:
    for joint in context.view.joints:
        reached, own = _reached(context, joint), _range(joint)
        if reached is None or own is None or joint.mimic is None:
            continue
        beyond = max(own[0] - reached[0], reached[1] - own[1])
        if beyond > context.thresholds.mimic_range:
            what = (
                f"following joint '{joint.mimic.joint}' through its range, it goes from {reached[0]:.6g} to "
                f"{reached[1]:.6g}, beyond its own limits {own[0]:.6g} and {own[1]:.6g} by {beyond:.3g}"
            )
            remedy = "correct multiplier or offset, or the limits of one of the two"
            yield Fault(joint.mimic.multiplier.span, what, remedy, beyond, context.thresholds.mimic_range)


def _range(joint: JointView | None) -> tuple[float, float] | None:
    """Return lower and upper of a joint that has both, in order."""
    if joint is None or joint.limit is None or joint.type not in WITH_RANGE:
        return None
    lower, upper = joint.limit.lower.value, joint.limit.upper.value
    return (lower, upper) if lower is not None and upper is not None and lower < upper else None


def _reached(context: Context, joint: JointView) -> tuple[float, float] | None:
    """Return multiplier q + offset over the range of the joint that is followed, if that one is free."""
    if joint.mimic is None:
        return None
    multiplier, offset = joint.mimic.multiplier.or_default(1.0), joint.mimic.offset.or_default(0.0)
    followed = context.view.joint.get(joint.mimic.joint)
    master = _range(followed)
    if multiplier is None or offset is None or master is None or followed is None or followed.mimic is not None:
        return None
    ends = sorted(multiplier[0] * end + offset[0] for end in master)
    return ends[0], ends[1]
