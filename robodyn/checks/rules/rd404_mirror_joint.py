"""Axis, limits, effort and velocity of a right joint are the mirror image of the left one's.

A reflection carries a rotation about an axis into one about the axis's image, the other way
round. Where the axis of a joint is that image, equal positions of twins are mirror images and so are equal limits;
where it is the image reversed, lower and upper change places and signs. Copying limits from left to right where the
axes ask for a change of sign is a common slip: a knee then bends the wrong way. Twins are found as RD401 says.
"""

from collections.abc import Iterator

import numpy as np

from robodyn.checks.examples import ARM_LIMIT, two_arms
from robodyn.checks.mirror.pairs import Pair, pairs
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.programs.vectors import length, product
from robodyn.robot.urdf.view import JointView
from robodyn.support.wording import shown

_AXIS = 0.02
_LIMIT = 0.02
"""How far limits may differ: in rad or m, or as a part of the range, whichever is more."""
_MAGNITUDE = 0.02


@rule(
    Severity.WARNING,
    Stage.MODEL,
    good=two_arms(right_joint='<axis xyz="0 -1 0"/>' + ARM_LIMIT.replace("-0.5", "-2").replace('"2"', '"0.5"')),
    bad=('"0 -1 0"', '"0 1 0"'),
)
def check(context: Context) -> Faults:
    for pair in context.once(pairs):
        left, right = pair.left_joint, pair.right_joint
        if left.type != right.type or left.type not in ("revolute", "continuous", "prismatic"):
            continue
        view = context.view.joint[right.name]
        direction = _direction(pair)
        if direction is None:
            what = f"the axis is not parallel to the mirror image of that of {shown(left.name)}"
            remedy = "correct one of the two"
            yield Fault(view.element.span if view.axis.element is None else view.axis.span, what, remedy)
        else:
            yield from _limits(pair, view, direction)


def _direction(pair: Pair) -> int | None:
    """Return 1 where equal positions of both joints are mirror images, -1 where opposite ones are, None if neither.

    A reflection D carries a translation a to D a, and a rotation about a to one about -D a.
    """
    left, right = (np.array(joint.axis) for joint in (pair.left_joint, pair.right_joint))
    left, right = left / length(left), right / length(right)
    image = product(pair.D, left) * (1.0 if pair.left_joint.type == "prismatic" else -1.0)
    along = float(product(image, right))
    return None if abs(along) < 1.0 - _AXIS**2 else (1 if along > 0 else -1)


def _limits(pair: Pair, view: JointView, direction: int) -> Iterator[Fault]:
    left, right = pair.left_joint.limit, pair.right_joint.limit
    if left is None or right is None or view.limit is None:
        return
    twin = shown(pair.left_joint.name)
    if pair.left_joint.type != "continuous" and None not in (left.lower, left.upper, right.lower, right.upper):
        low, high = left.lower or 0.0, left.upper or 0.0
        image = (low, high) if direction > 0 else (0.0 - high, 0.0 - low)
        slack = _LIMIT * max(1.0, abs(high - low))
        ends = (("lower", right.lower or 0.0), ("upper", right.upper or 0.0))
        for (name, value), wanted in zip(ends, image, strict=True):
            if abs(value - wanted) > slack:
                what = f"{name} is {value:g}; the mirror image of the range of {twin} is {image[0]:g} to {image[1]:g}"
                yield Fault(getattr(view.limit, name).span, what, _REMEDY, value, wanted)
    for name, one, other in (("effort", left.effort, right.effort), ("velocity", left.velocity, right.velocity)):
        if one is not None and other is not None and abs(one - other) > _MAGNITUDE * max(abs(one), abs(other)):
            what = f"{name} is {other:g}, that of its mirror twin {twin} is {one:g}"
            yield Fault(getattr(view.limit, name).span, what, _REMEDY, other, one)


_REMEDY = "correct one of the two, or allow it where the joints differ"
