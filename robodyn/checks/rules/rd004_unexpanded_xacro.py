"""Nothing is left of xacro: no xacro: element, no ${...}, no $(...).

A reader takes ${mass} for a text, not for a number, and drops the element that it stands in. Where
an element of xacro is left, links may be missing, and nothing else is checked.
"""

from robodyn.checks.examples import INERTIA, one_link
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule


@rule(
    Severity.ERROR,
    Stage.TEXT,
    bad=one_link(f'<mass value="${{arm_mass}}"/>{INERTIA}'),
    good=one_link(f'<mass value="2"/>{INERTIA}'),
)
def check(context: Context) -> Faults:
    for found in context.reading.found("RD004"):
        yield Fault(at=found.at, what=found.what, remedy=found.remedy)
