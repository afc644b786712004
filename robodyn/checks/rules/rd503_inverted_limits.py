"""RD503: a lower limit above the upper one."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Fault, Rule, Severity, Stage
from robodyn.checks.view import WITH_RANGE


def check(context: Context) -> Iterator[Fault]:
    for joint in context.view.joints:
        if joint.limit is None or joint.limit.range is None or joint.type not in WITH_RANGE:
            continue
        lower, upper = joint.limit.range
        if lower > upper:
            absent = [name for name in ("lower", "upper") if joint.limit.element.get(name) is None]
            default = f" ({absent[0]} is absent, and so 0)" if absent else ""
            yield Fault(
                at=(joint.limit.lower if joint.limit.lower.given else joint.limit.upper).span,
                subject=joint.subject,
                what=f"lower {lower:g} is greater than upper {upper:g}{default}: there is no position",
                remedy=f'write {absent[0]}="..."' if absent else "exchange the two, or correct a sign",
                measured=lower,
                bound=upper,
            )


RULE = Rule(
    code="RD503",
    name="inverted-limits",
    severity=Severity.E,
    stage=Stage.DOCUMENT,
    summary="The lower limit is less than the upper one.",
    explanation="""No position keeps to both limits. Controllers clamp to one of them, and drive the joint into a stop
there.""",
    bad=arm('<axis xyz="0 1 0"/>' + LIMIT.replace("-2", "3")),
    good=arm(f'<axis xyz="0 1 0"/>{LIMIT}'),
    check=check,
)
