"""The parallel axis theorem is applied once.

A tensor that is about the centre of mass already becomes too small, and often impossible, where m
(|c|^2 1 - c c^T) is subtracted from it, and too large where the term is added twice. RD206 and RD207 name the cause
of tensors that no body has; this rule reports those that a body could have, but not this link, by its mirror twin or
its shapes. That adding the term makes a tensor possible is no evidence: the shapes or the twin have to agree.
"""

from robodyn.checks.causes.causes import faults
from robodyn.checks.examples import IMAGE, inertia, two_arms
from robodyn.checks.rule import Context, Faults, Severity, rule


@rule(Severity.WARNING, good=two_arms(), bad=(IMAGE, inertia("0.19 0.016 -0.078 0.23 0.037 0.075")))
def check(context: Context) -> Faults:
    return faults(context, "RD308")
