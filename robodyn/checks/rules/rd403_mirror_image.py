"""Centre of mass and tensor of a right link are the mirror image of the left one's.

A reflection turns the sign of one coordinate of the centre of mass and of two products of
inertia. Copying a limb's numbers to the other side without it shifts the robot's centre of mass to one side, by
twice the offset of the link's. The centre may be a tenth of the radius of gyration and 1 mm from the mirror image.
Where the very same part, an actuator say, is mounted on both sides, it is no mirror image of itself: where both links
have the same <visual> shapes (or, without any, the same <collision> shapes), what goes with these is as good. Twins are
found as RD401 says; where one cause explains the tensor, RD306 to RD313 name it instead, and where no body can have one
of the two, RD204, RD206 or RD207 do.
"""

from robodyn.checks.causes.causes import causes
from robodyn.checks.examples import two_arms
from robodyn.checks.mirror.loads import MOMENTS, Twins, twins
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.robot.urdf.numbers import value_span
from robodyn.support.wording import figure, place

_REMEDY = "reflect the one of the two that is wrong, or allow it where one part is mounted on both sides"


@rule(Severity.WARNING, Stage.MODEL, good=two_arms(), bad=("-0.05", "0.05"))
def check(context: Context) -> Faults:
    for one in context.once(twins):
        cause = context.once(causes).get(one.link.name)
        reported = cause is not None and cause.code == "RD313" and one.centre_is_copied
        if one.shift > one.most_shift and not reported:
            yield _centre(one)
        explained = {one.link.name, one.pair.left.name} & context.once(causes).keys()
        if not explained and one.tensors_apart > MOMENTS >= one.moments_apart and one.real:
            what = (
                f"the inertia tensor is {figure(100 * one.tensors_apart, 2)} % from the mirror image of that of "
                f"{one.other}, although their principal moments agree"
            )
            yield Fault(one.inertial.entries[0].span, what, _REMEDY, one.tensors_apart, MOMENTS)


def _centre(one: Twins) -> Fault:
    origin = one.inertial.origin.element
    cause = "one is a copy of the other that is not reflected" if one.centre_is_copied else None
    what = (
        f"the centre of mass is at {place(one.c_right.tolist())} m, the mirror image of that of {one.other} at "
        f"{place(one.c.tolist())}, {one.shift:.3g} m away"
    )
    at = one.inertial.element.span if origin is None else value_span(origin, "xyz")
    return Fault(at, what, _REMEDY, one.shift, one.most_shift, cause=cause)
