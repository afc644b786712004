"""Effort and velocity limits are positive and those of a machine.

URDF asks for both wherever there is a <limit>: urdfdom refuses a file in which one of them is missing, also
that of a joint that is fixed. A limit of 0 makes a joint that some simulators can never move, and that others
do not limit. 1e9 is a stand-in that nothing can be sized against: a remark; an effort in N mm is RD515's.
"""

from robodyn.checks.bodies.limit_units import of_numbers
from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule


@rule(Severity.WARNING, good=arm(), bad=('"30"', '"0"'), explains=("RD901",))
def check(context: Context) -> Faults:
    limits, of_another_unit = context.thresholds, context.once(of_numbers)
    for joint in context.view.joints:
        if joint.limit is None:
            continue
        for numbers, most in ((joint.limit.effort, limits.most_effort), (joint.limit.velocity, limits.most_velocity)):
            value = numbers.value
            if not numbers.given:
                what = f"<limit> has no {numbers.attribute}, and urdfdom refuses the file"
            elif not joint.moves or value is None or 0 < value < most or id(numbers) in of_another_unit:
                continue
            else:
                what = f"{numbers.attribute} is {value:g}, " + (
                    "a stand-in that limits nothing" if value > 0 else "not positive"
                )
            endless = value is not None and value > 0
            severity = Severity.NOTE if endless else Severity.WARNING
            remedy = "write what the drive can do"
            if not numbers.given:
                severity = Severity.ERROR
            kind = "a limit that is not positive" if numbers.given and not endless else None
            yield Fault(numbers.span, what, remedy, value, most if endless else 0.0, severity=severity, kind=kind)
