"""The limits hold along the given motion.

With --trajectory FILE: the torques of inverse dynamics, speeds and positions along the motion,
against effort, velocity, lower and upper. It is what robodyn torques --fail-on-limits says, among the other
findings. The examples are held against a motion that swings the arm by 1 rad.
"""

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule


@rule(
    Severity.WARNING,
    Stage.MODEL,
    good=arm('<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="30" velocity="9"/>'),
    bad=('lower="-2" upper="2"', 'lower="-0.5" upper="0.5"'),
)
def check(context: Context) -> Faults:
    """Silent unless a motion is asked for."""
    if context.asked.trajectory is None:
        return
    from robodyn.loads.torques import torques
    from robodyn.trajectory.robot_motion import read_motion

    with read_motion(context.asked.trajectory, context.model, **context.asked.reading) as motion:
        result = torques(context.model, motion)
    for caveat in motion.caveats:
        what = f"limits along {context.asked.trajectory} hold only {caveat.kind}: {caveat.text}"
        yield Fault(context.view.root.span, what, "say which unit it is", subject=None)
    for excess in result.exceeded:
        joint = context.view.joint[excess.joint]
        assert joint.limit is not None, "a limit is exceeded"
        name: str = excess.quantity
        if name == "position":
            name = "lower" if excess.value < excess.limit else "upper"
        what = (
            f"the motion of {context.asked.trajectory} reaches {excess.quantity} {excess.value:.4g} "
            f"{excess.unit}, beyond the limit {excess.limit:g}"
        )
        remedy = "slow the motion down or raise the limit; robodyn torques says when"
        yield Fault(getattr(joint.limit, name).span, what, remedy, excess.value, excess.limit)
