"""An effort limit is within reach of the loads."""

from robodyn.checks.bodies.limit_units import of_numbers
from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.checks.statics.torque import gravity_bounds
from robodyn.support.wording import figure

FACTOR = 1000.0
"""An effort limit of more than this many times the robot's weight at the joint's reach bounds nothing."""


@rule(
    Severity.WARNING,
    Stage.MODEL,
    explanation=f"""A limit of more than {FACTOR:g} times the weight of the whole robot, hanging where the joint's
farthest part can be (5 cm away at least), was never meant to limit anything: saturation, planning and sizing against
it say nothing. Greater ones still, which stand for no limit at all, are RD506's; those in N mm are RD515's.""",
    good=arm('<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="900" velocity="3"/>'),
    bad=('"900"', '"90000"'),
    default=Severity.ERROR,
)
def check(context: Context) -> Faults:
    bounds, explained = context.once(gravity_bounds), context.once(of_numbers)
    for joint in context.model.independent:
        limit = None if joint.name not in context.view.joint else context.view.joint[joint.name].limit
        most = bounds[joint.name].whole
        sentinel = context.thresholds.most_effort
        if limit is None or joint.effort is None or not FACTOR * most < joint.effort <= sentinel or not most > 0.0:
            continue
        if id(limit.effort) in explained:
            continue
        unit = "N" if joint.kind == "prismatic" else "N m"
        what = (
            f"the effort limit {joint.effort:g} {unit} is {figure(joint.effort / most, 2)} times what the weight "
            f"of the whole robot asks for at the reach of this joint, {most:.3g} {unit}"
        )
        yield Fault(limit.effort.span, what, "write what the actuator can give", joint.effort, FACTOR * most)
