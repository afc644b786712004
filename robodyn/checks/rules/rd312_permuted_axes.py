"""The tensor is in the axes of the link, not in another program's.

Programs differ in which axis points up or forward. A tensor with x, y and z exchanged has the
right principal moments about the wrong axes, and a centre of mass outside the shapes is one in those axes, too (RD302):
iCub's forearms have both along y, and are drawn along x. RD206 and RD207 name the cause of tensors that no body has;
this rule reports those that a body could have, but not this link, by its mirror twin or its shapes.
"""

from robodyn.checks.causes.causes import faults
from robodyn.checks.examples import IMAGE, inertia, two_arms
from robodyn.checks.rule import Context, Faults, Severity, rule


@rule(
    Severity.WARNING,
    good=two_arms(),
    bad=(IMAGE, inertia("0.03 -0.004 -0.003 0.02 0.002 0.025")),
    explains=("RD302",),
)
def check(context: Context) -> Faults:
    return faults(context, "RD312")
