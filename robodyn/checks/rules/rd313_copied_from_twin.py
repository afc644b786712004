"""A right link's tensor is the mirror image of the left one's, not a copy.

A reflection turns the sign of two products of inertia. A tensor that equals its twin's entry by
entry, in mirrored axes, was copied. It is right only where the same part is mounted on both sides, turned and not
mirrored: where both links have the same meshes at the same place nothing is reported, and otherwise a waiver says so.
Where the centre of mass is a copy, too, RD403 does not report it again.
"""

from robodyn.checks.causes.causes import causes
from robodyn.checks.examples import IMAGE, TENSOR, two_arms
from robodyn.checks.mirror.loads import MOMENTS, twins
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.support.wording import figure

_REMEDY = "reflect the one of the two that is wrong, or allow it where one part is mounted on both sides"


@rule(Severity.WARNING, good=two_arms(), bad=(IMAGE, TENSOR))
def check(context: Context) -> Faults:
    for one in context.once(twins):
        cause = context.once(causes).get(one.link.name)
        if cause is None or cause.code != "RD313" or (one.tensors_apart <= MOMENTS and not one.centre_is_copied):
            continue
        centre = f"the centre of mass, {one.shift:.3g} m away, and " if one.centre_is_copied else ""
        what = (
            f"{centre}the inertia tensor, {figure(100 * one.tensors_apart, 2)} % from its mirror image, "
            f"{'are copies of those' if centre else 'is a copy of that'} of its twin {one.other}"
        )
        yield Fault(one.inertial.entries[0].span, what, _REMEDY, one.tensors_apart, kind="a copy of its twin")
