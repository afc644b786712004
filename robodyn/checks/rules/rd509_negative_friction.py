"""Damping and friction are not negative.

Friction takes energy out of a joint. With a negative coefficient it speeds up by itself, and a
simulation diverges.
"""

from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule


@rule(
    Severity.ERROR,
    good=arm(f'<axis xyz="0 1 0"/>{LIMIT}<dynamics damping="0.1"/>'),
    bad=('"0.1"', '"-0.1"'),
    explains=("RD901",),
)
def check(context: Context) -> Faults:
    for joint in context.view.joints:
        for found in (joint.damping, joint.friction):
            if found.value is not None and found.value < 0:
                what = f"the {found.attribute} is {found.value:g}, and feeds energy in"
                yield Fault(found.span, what, "write it without the sign", found.value, 0.0)
