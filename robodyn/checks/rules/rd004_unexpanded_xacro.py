"""Nothing is left of xacro: no xacro: element, no ${...}, no $(...).

A reader takes ${mass} for a text, not for a number, and drops the element that it stands in. Where
an element of xacro is left, links may be missing, and nothing else is checked.
"""

from robodyn.checks.examples import one_link
from robodyn.checks.rule import Context, Faults, Severity, Stage, rule, text_faults


@rule(Severity.ERROR, Stage.TEXT, good=one_link(), bad=('"2"', '"${arm_mass}"'))
def check(context: Context) -> Faults:
    return text_faults(context, "RD004")
