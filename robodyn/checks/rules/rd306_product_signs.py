"""Products of inertia have the sign of a matrix entry.

URDF's ixy is an entry of the inertia matrix, minus the integral of x y dm. Many CAD programs
print plus that integral, and then all three signs are wrong. The diagonal is right, so that few tools notice; the
principal moments are not. RD206 and RD207 name the cause of tensors that no body has; this rule reports those that a
body could have, but not this link, by its mirror twin or its shapes.
"""

from robodyn.checks.causes.causes import faults
from robodyn.checks.examples import IMAGE, inertia, two_arms
from robodyn.checks.rule import Context, Faults, Severity, rule


@rule(Severity.WARNING, good=two_arms(), bad=(IMAGE, inertia("0.02 0.004 -0.002 0.03 0.003 0.025")))
def check(context: Context) -> Faults:
    return faults(context, "RD306")
