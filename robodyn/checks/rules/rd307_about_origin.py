"""The tensor is about the centre of mass.

URDF wants the tensor about the centre of mass, where the origin of <inertial> is. About the
link's origin it is larger by m (|c|^2 1 - c c^T), the term of the parallel axis theorem. Such a tensor is physical,
and so it takes the link's shapes or its mirror twin to see it: corrected, it is within 20 % of the inertia of the
uniform solid that the shapes are, and twice as near as it stands.
"""

from robodyn.checks.causes.causes import faults
from robodyn.checks.examples import IMAGE, inertia, two_arms
from robodyn.checks.rule import Context, Faults, Severity, rule


@rule(Severity.WARNING, good=two_arms(), bad=(IMAGE, inertia("0.105 0.006 -0.038 0.13 0.017 0.05")))
def check(context: Context) -> Faults:
    return faults(context, "RD307")
