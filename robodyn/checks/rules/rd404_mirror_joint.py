"""Kind, axis, limits, effort and velocity of a right joint are the mirror image of the left one's.

A reflection carries a rotation about an axis into one about the axis's image, the other way
round. Where the axis of a joint is that image, equal positions of twins are mirror images and so are equal limits;
where it is the image reversed, lower and upper change places and signs; on a part that is mounted on both sides either
is right. Copying limits from left to right where the axes ask for a change of sign is a common slip: a knee then bends
the wrong way. So is a joint that was fixed for a test, while its twin still moves; and an axis that is reversed, which
also shows where front and hind legs are not turned alike, or where all other joints of the limb that have their axes in
the mirror plane, or across it, are turned the other way. Twins are found as RD401 says. Ranges that RD503, RD504 or
RD507 report are not compared.
"""

from collections.abc import Sequence
from math import pi

from robodyn.checks.examples import ARM_LIMIT, two_arms
from robodyn.checks.mirror.directions import directions, unlike_the_other_legs, unlike_their_limb
from robodyn.checks.mirror.pairs import Pair, pairs
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.robot.urdf.elements import Span
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.parts import WITH_RANGE, Limit
from robodyn.robot.urdf.view import JointView, View
from robodyn.support.wording import shown

_LIMIT = 0.02
"""How far limits may differ: in rad or m, or as a part of the range, whichever is more."""
_MAGNITUDE = 0.02
_TURNS = 4 * pi
"""RD507 reports ranges of revolute joints that go farther [rad]."""
_REMEDY = "correct the one of the two that is wrong, or allow it where the joints differ"


@rule(
    Severity.WARNING,
    Stage.MODEL,
    good=two_arms(right_joint='<axis xyz="0 -1 0"/>' + ARM_LIMIT.replace("-0.5", "-2").replace('"2"', '"0.5"')),
    bad=('"0 -1 0"', '"0 1 0"'),
)
def check(context: Context) -> Faults:
    unlike, odd = context.once(unlike_the_other_legs), context.once(unlike_their_limb)
    for pair in context.once(pairs):
        left, right = pair.left_joint, pair.right_joint
        view, twin = context.view.joint[right.name], f"{shown(left.name)} (line {left.line})"
        if left.type != right.type:
            yield _kind(pair, context.view)
        elif left.type in ("revolute", "continuous", "prismatic"):
            ranges, other = list(_range(pair, context, twin)), unlike.get(right.name)
            yield from ranges
            if not any(directions(pair, context)):
                what = f"the axis is not parallel to the mirror image of that of its twin {twin}"
                yield Fault(_axis(view), what, _REMEDY)
            elif other is not None and not ranges and not list(_range(other, context, "")):
                yield _unlike(view, twin, other)
            elif right.name in odd and not ranges:
                yield _odd(view, twin, odd[right.name])
            yield from _magnitudes(pair, view, twin)


def _axis(view: JointView) -> Span:
    return view.element.span if view.axis.element is None else view.axis.span


def _unlike(view: JointView, twin: str, other: Pair) -> Fault:
    others = f"{shown(other.left_joint.name)} and {shown(other.right_joint.name)} (line {other.right_joint.line})"
    what = (
        f"it and its mirror twin {twin} are turned to each other as {others} are not: one of the four axes is reversed"
    )
    return Fault(_axis(view), what, "correct the one of the four that is wrong, or allow it where the legs differ")


def _odd(view: JointView, twin: str, others: Sequence[Pair]) -> Fault:
    named = " and ".join(shown(pair.right_joint.name) for pair in others[:2])
    what = (
        f"it and its mirror twin {twin} are turned to each other as those of the limb whose axes lie like theirs, "
        f"{named} among {len(others)}, are not: one of the two axes is reversed"
    )
    return Fault(_axis(view), what, _REMEDY)


def _kind(pair: Pair, view: View) -> Fault:
    """Return that the joints are of two kinds, at the one that is fixed if only one is."""
    one, other = pair.right_joint, pair.left_joint
    if other.type == "fixed":
        one, other = other, one
    what = f"it is {one.type}, but its mirror twin {shown(other.name)} (line {other.line}) is {other.type}"
    return Fault(value_span(view.joint[one.name].element, "type"), what, _REMEDY)


def _range(pair: Pair, context: Context, twin: str) -> Faults:
    kind, left, right = pair.left_joint.type, pair.left_joint.limit, pair.right_joint.limit
    limit, ways = context.view.joint[pair.right_joint.name].limit, set(directions(pair, context))
    plain = kind in WITH_RANGE and _is_plain(left, kind) and _is_plain(right, kind)
    if limit is None or not plain or len(ways) != 1:
        return
    direction = ways.pop()
    (low, high), here = _ends(left), _ends(right)
    image = (low, high) if direction > 0 else (0.0 - high, 0.0 - low)
    slack = _LIMIT * max(1.0, abs(high - low))
    off = [abs(value - wanted) for value, wanted in zip(here, image, strict=True)]
    if max(off) <= slack:
        return
    k = off.index(max(off))
    what = (
        f"the range is {here[0]:g} to {here[1]:g}, the mirror image of that of its twin {twin} {image[0]:g} to "
        f"{image[1]:g}"
    )
    copied = direction < 0 and max(abs(here[0] - low), abs(here[1] - high)) <= slack
    cause = "the ranges are equal, but the axes ask for a change of sign" if copied else None
    at = (limit.lower, limit.upper)[k]
    yield Fault(at.span, what, _REMEDY, here[k], image[k], cause=cause)


def _ends(limit: Limit | None) -> tuple[float, float]:
    return (0.0, 0.0) if limit is None else (limit.lower or 0.0, limit.upper or 0.0)


def _is_plain(limit: Limit | None, kind: str) -> bool:
    """Return whether there is a range that no other rule reports."""
    low, high = _ends(limit)
    return low < high and (kind == "prismatic" or max(-low, high) <= _TURNS)


def _magnitudes(pair: Pair, view: JointView, twin: str) -> Faults:
    left, right = pair.left_joint.limit, pair.right_joint.limit
    if left is None or right is None or view.limit is None:
        return
    found = [
        (name, one, other)
        for name, one, other in (("effort", left.effort, right.effort), ("velocity", left.velocity, right.velocity))
        if one is not None and other is not None and abs(one - other) > _MAGNITUDE * max(abs(one), abs(other))
    ]
    if found:
        name, one, other = found[0]
        here, there = (" and ".join(f"{each[0]} {each[k]:g}" for each in found) for k in (2, 1))
        what = f"the limit of {here} is not that of its mirror twin {twin}, {there}"
        yield Fault(getattr(view.limit, name).span, what, _REMEDY, other, one)
