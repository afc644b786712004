"""The tensor is in the axes of the link, not in another program's.

Programs differ in which axis points up or forward. A tensor with x, y and z exchanged has the
right principal moments about the wrong axes. RD206 and RD207 name the cause of tensors that no body has; this rule
reports those that a body could have, but not this link, by its mirror twin or its shapes.
"""

from robodyn.checks.causes.causes import faults
from robodyn.checks.examples import ORIGIN_IMAGE, two_arms
from robodyn.checks.rule import Context, Faults, Severity, Stage, rule

_WRONG = '<inertia ixx="0.03" ixy="-0.004" ixz="-0.003" iyy="0.02" iyz="0.002" izz="0.025"/>'


@rule(
    Severity.WARNING,
    Stage.DOCUMENT,
    bad=two_arms(right=f'{ORIGIN_IMAGE}<mass value="2"/>{_WRONG}'),
    good=two_arms(),
)
def check(context: Context) -> Faults:
    yield from faults(context, "RD312")
