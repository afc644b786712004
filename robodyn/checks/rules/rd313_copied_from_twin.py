"""A right link's tensor is the mirror image of the left one's, not a copy.

A reflection turns the sign of two products of inertia. A tensor that equals its twin's entry by
entry, in mirrored axes, was copied; it is right only where the same part is mounted on both sides, turned and not
mirrored, and a waiver says so.
"""

from robodyn.checks.causes.causes import faults
from robodyn.checks.examples import IMAGE, TENSOR, two_arms
from robodyn.checks.rule import Context, Faults, Severity, rule


@rule(Severity.WARNING, good=two_arms(), bad=(IMAGE, TENSOR))
def check(context: Context) -> Faults:
    return faults(context, "RD313")
