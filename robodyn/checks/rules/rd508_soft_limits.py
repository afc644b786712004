"""Soft limits lie within the hard limits, lower below upper.

The safety controller begins to brake at the soft limit. Outside the hard one it never does, and
the joint meets its end stop at full speed.
"""

from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import numbers
from robodyn.robot.urdf.parts import WITH_RANGE

_SLACK = 1e-9


@rule(
    Severity.WARNING,
    good=arm(
        f'<axis xyz="0 1 0"/>{LIMIT}<safety_controller soft_lower_limit="-1.9" soft_upper_limit="1.9" k_velocity="9"/>'
    ),
    bad=('"-1.9"', '"-2.5"'),
)
def check(context: Context) -> Faults:
    for joint in context.view.joints:
        safety = joint.element.find("safety_controller")
        limit = joint.limit
        if safety is None or limit is None or joint.type not in WITH_RANGE:
            continue
        soft = {name: numbers(safety, f"soft_{name}_limit", 1) for name in ("lower", "upper")}
        lower, upper = soft["lower"].value, soft["upper"].value
        inverted = limit.range is None or limit.range[0] > limit.range[1]
        for name, hard, outside in (("lower", limit.lower.value, -1), ("upper", limit.upper.value, 1)):
            value = soft[name].value
            if value is not None and hard is not None and not inverted and outside * (value - hard) > _SLACK:
                what = f"the soft {name} limit {value:g} is outside the hard one, {hard:g}"
                remedy = "move it inside, so that the controller stops before the end stop"
                yield Fault(soft[name].span, what, remedy, value, hard)
        if lower is not None and upper is not None and lower > upper:
            what = f"the soft lower limit {lower:g} is greater than the soft upper one, {upper:g}"
            yield Fault(soft["lower"].span, what, "exchange the two", lower, upper)
