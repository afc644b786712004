"""The limits of a joint leave it a range, and end somewhere.

A revolute or prismatic joint needs lower and upper; an absent one is 0, and with both absent the
joint is frozen. A stand-in such as 1e16 passes for a range, from which planners then draw samples.
"""

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import Numbers
from robodyn.robot.urdf.parts import WITH_RANGE
from robodyn.robot.urdf.view import LimitView


@rule(Severity.WARNING, good=arm(), bad=('lower="-2" upper="2" ', ""))
def check(context: Context) -> Faults:
    for joint in context.view.joints:
        limit = joint.limit
        if limit is None or limit.range is None or joint.type not in WITH_RANGE:
            continue
        found = _frozen(limit) or _endless(limit, context.thresholds.most_range)
        if found is not None:
            at, what, remedy, measured = found
            yield Fault(at.span, what, remedy, measured=measured)


def _frozen(limit: LimitView) -> tuple[Numbers, str, str, float] | None:
    assert limit.range is not None, "the limits can be read"
    lower, upper = limit.range
    if lower != upper:
        return None
    if not limit.lower.given and not limit.upper.given:
        return limit.lower, "it has neither lower nor upper, which are 0 then: it cannot move", "write both", 0.0
    return limit.lower, f"lower and upper are both {lower:g}: it cannot move", "correct one, or make it fixed", lower


def _endless(limit: LimitView, bound: float) -> tuple[Numbers, str, str, float] | None:
    for numbers in (limit.lower, limit.upper):
        if numbers.value is not None and abs(numbers.value) > bound:
            what = f"{numbers.attribute} is {numbers.value:g}, which limits nothing"
            return numbers, what, "make a revolute joint continuous, or write the real limit", numbers.value
    return None
