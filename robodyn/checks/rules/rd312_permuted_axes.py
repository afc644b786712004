"""The tensor is in the axes of the link, not in another program's.

Programs differ in which axis points up or forward. A tensor with x, y and z exchanged has the
right principal moments about the wrong axes. RD206 and RD207 name the cause of tensors that no body has; this rule
reports those that a body could have, but not this link, by its mirror twin or its shapes.
"""

from robodyn.checks.causes.causes import faults
from robodyn.checks.examples import IMAGE, inertia, two_arms
from robodyn.checks.rule import Context, Faults, Severity, rule


@rule(Severity.WARNING, good=two_arms(), bad=(IMAGE, inertia("0.03 -0.004 -0.003 0.02 0.002 0.025")))
def check(context: Context) -> Faults:
    return faults(context, "RD312")
