"""No entry is off by a power of ten.

A slip of the exponent in one entry. Without a twin to compare with, only a moment can be told
from others, and only where one entry and one power of ten make the tensor possible. RD206 and RD207 name the cause
of tensors that no body has; this rule reports those that a body could have, but not this link, by its mirror twin or
its shapes.
"""

from robodyn.checks.causes.causes import faults
from robodyn.checks.examples import ORIGIN_IMAGE, two_arms
from robodyn.checks.rule import Context, Faults, Severity, Stage, rule

_WRONG = '<inertia ixx="0.02" ixy="-0.0004" ixz="0.002" iyy="0.03" iyz="-0.003" izz="0.025"/>'


@rule(
    Severity.WARNING,
    Stage.DOCUMENT,
    bad=two_arms(right=f'{ORIGIN_IMAGE}<mass value="2"/>{_WRONG}'),
    good=two_arms(),
)
def check(context: Context) -> Faults:
    yield from faults(context, "RD311")
