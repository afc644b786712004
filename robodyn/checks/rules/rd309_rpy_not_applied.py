"""The tensor is in the axes of its <origin>.

Where <origin> in <inertial> has an rpy, the tensor is in the axes turned by it. A tensor in the
link's axes is right with rpy 0 only. Its principal moments are right either way: it takes the link's shapes or
its mirror twin to see it.
"""

from robodyn.checks.causes.causes import faults
from robodyn.checks.examples import IMAGE, inertia, two_arms
from robodyn.checks.rule import Context, Faults, Severity, rule

_ORIGIN = '<origin xyz="0.1 -0.05 0.2" rpy="0 0 1.5707963267948966"/>'
_TURNED = inertia("0.03 0.004 -0.003 0.02 -0.002 0.025")


@rule(Severity.WARNING, good=two_arms(right=f'{_ORIGIN}<mass value="2"/>{_TURNED}'), bad=(_TURNED, IMAGE))
def check(context: Context) -> Faults:
    return faults(context, "RD309")
