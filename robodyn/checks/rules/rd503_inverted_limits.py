"""The lower limit is less than the upper one.

No position keeps to both limits. Controllers clamp to one of them, and drive the joint into a stop
there.
"""

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.parts import WITH_RANGE


@rule(Severity.ERROR, good=arm(), bad=('"-2"', '"3"'), explains=("RD901",))
def check(context: Context) -> Faults:
    for joint in context.view.joints:
        if joint.limit is None or joint.limit.range is None or joint.type not in WITH_RANGE:
            continue
        lower, upper = joint.limit.range
        if lower > upper:
            absent = [name for name in ("lower", "upper") if joint.limit.element.get(name) is None]
            default = f" ({absent[0]} is absent, and so 0)" if absent else ""
            what = f"lower {lower:g} is greater than upper {upper:g}{default}: there is no position"
            remedy = f'write {absent[0]}="..."' if absent else "exchange the two, or correct a sign"
            at = (joint.limit.lower if joint.limit.lower.given else joint.limit.upper).span
            yield Fault(at, what, remedy, lower, upper)
