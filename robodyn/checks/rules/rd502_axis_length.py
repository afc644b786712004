"""The axis of a joint is a unit vector.

URDF asks for it. Most readers normalise the axis, but those that do not turn the joint by a
multiple of its coordinate.
"""

from math import hypot

from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Context, Edit, Fault, Faults, Fix, Severity, rule
from robodyn.robot.urdf.elements import Span
from robodyn.robot.urdf.parts import WITH_AXIS


@rule(Severity.WARNING, good=arm(f'<axis xyz="0 0 1"/>{LIMIT}'), bad=('"0 0 1"', '"0 0 2"'))
def check(context: Context) -> Faults:
    bound = context.thresholds.axis_length
    for joint in context.view.joints:
        axis = joint.axis.values
        if joint.type not in WITH_AXIS or axis is None or not any(axis):
            continue
        length = hypot(*axis)
        if abs(length - 1) > bound:
            what = f"the axis has the length {length:.6g}, not 1"
            remedy = "divide it by its length"
            yield Fault(joint.axis.span, what, remedy, length, 1.0, fix=_fix(axis, joint.axis.span))


def _fix(axis: tuple[float, ...], at: Span) -> Fix:
    """Return the division by the length, which changes nothing; by the largest entry first, lest it overflow."""
    largest = max(map(abs, axis))
    length = hypot(*(x / largest for x in axis))
    text = " ".join(repr(x / largest / length) for x in axis)
    return Fix("divide the axis by its length", (Edit(at.start, at.end, text),), safe=True)
