"""The limits of a joint leave it a range, and end somewhere.

A revolute or prismatic joint needs lower and upper; an absent one is 0, and with both absent the
joint is frozen. A stand-in such as 1e16 passes for a range, from which planners then draw samples. A joint that turns
freely, as a wheel or a propeller does, is `continuous` and has neither.
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
        found = _frozen(joint.type, limit) or _endless(joint.type, limit, context.thresholds.most_range)
        if found is not None:
            at, what, remedy, measured = found
            yield Fault(at.span, what, remedy, measured=measured)


def _frozen(kind: str, limit: LimitView) -> tuple[Numbers, str, str, float] | None:
    assert limit.range is not None, "the limits can be read"
    lower, upper = limit.range
    if lower != upper:
        return None
    free = "; one that turns freely is continuous" if kind == "revolute" and not lower else ""
    if not limit.lower.given and not limit.upper.given:
        what = "it has neither lower nor upper, which are 0 then: it cannot move"
        return limit.lower, what, f"write both{free}", 0.0
    what = f"lower and upper are both {lower:g}: it cannot move"
    return limit.lower, what, f"correct one, or make it fixed{free}", lower


def _endless(kind: str, limit: LimitView, bound: float) -> tuple[Numbers, str, str, float] | None:
    for numbers in (limit.lower, limit.upper):
        if numbers.value is not None and abs(numbers.value) > bound:
            what = f"{numbers.attribute} is {numbers.value:g}, which limits nothing"
            remedy = "make a joint that turns freely continuous, or write the real limits"
            return numbers, what, remedy if kind == "revolute" else "write the real limits", numbers.value
    return None
