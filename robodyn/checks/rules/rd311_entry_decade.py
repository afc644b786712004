"""No entry is off by a power of ten.

A slip of the exponent in one entry. Without a twin to compare with, only a moment can be told
from others, by the link's shapes. RD206 and RD207 name the cause
of tensors that no body has; this rule reports those that a body could have, but not this link, by its mirror twin or
its shapes.
"""

from robodyn.checks.causes.causes import faults
from robodyn.checks.examples import two_arms
from robodyn.checks.rule import Context, Faults, Severity, rule


@rule(Severity.WARNING, good=two_arms(), bad=('"-0.004"', '"-0.0004"'))
def check(context: Context) -> Faults:
    return faults(context, "RD311")
