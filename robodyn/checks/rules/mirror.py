"""Left and right: masses, tensors, joints and origins of mirror twins."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from math import isclose, pi

import numpy as np

from robodyn.checks.bodies.masses import POINT, broken_law, principal_moments
from robodyn.checks.examples import ARM_LIMIT, IMAGE, TENSOR, two_arms, two_elbows
from robodyn.checks.mirror import MASS, MOMENTS, Pair, Symmetry, Twins, is_square, symmetry, twins
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.checks.rules.inertia_mistakes import causes
from robodyn.programs.vectors import length, product, rotation_from_rpy
from robodyn.robot.urdf.parts import WITH_RANGE, Joint, Limit
from robodyn.robot.urdf.view import JointView, LimitView, value_span
from robodyn.support.floats import Floats
from robodyn.support.wording import figure, place, shown

_ONE_OF_TWO = "correct the one of the two that is wrong, or allow it where the {} differ"
_FACTORS = (
    (1000.0, True, "in grams, 1000 times the other"),
    (1 / 0.45359237, True, "in pounds, 2.2046 times the other"),
    (10.0, False, "10 times the other, as with the decimal point one place off"),
    (100.0, False, "100 times the other, as with the decimal point two places off"),
)
"""Of masses, each with whether the larger one is in another unit."""
_EXACT = 1e-3
"""How far the ratio may be from a factor: masses of twins are equal or differ by chance."""
_LIGHT = 1e-3
"""Sensors and marks that weigh no more [kg] are put where there is room."""


@rule(
    "RD401",
    Severity.WARNING,
    Stage.MODEL,
    explanation=f"""Links are twins if their names are each other's but for left and right, and at q = 0 each stands
where the mirror image of the other does; the plane is found from the robot. Masses may differ by {100 * MASS:g} %.
Where two parts that stand opposite each other do differ, as two tools do, a waiver says so. A ratio of 1000, 2.2046, 10
or 100 is named as the slip that makes it. The one that is in grams or pounds is the wrong one; otherwise both are
named.""",
    good=two_arms(),
    bad=(f'"2"/>{IMAGE}', f'"2.1"/>{IMAGE}'),
    explains=("RD208", "RD313"),
)
def mirror_mass(context: Context) -> Faults:
    """A left link weighs what the right one does."""
    for one in context.once(twins):
        left, right = one.masses
        if abs(left - right) <= MASS * max(left, right):
            continue
        ratio = max(left, right) / min(left, right)
        named = (factor for factor in _FACTORS if isclose(ratio, factor[0], rel_tol=_EXACT))
        _, unit, how = next(named, (1.0, False, None))
        is_left = unit and left > right
        link = context.view.link[one.pair.left.name] if is_left else one.link
        assert link.inertial is not None, "it has mass"
        mass, its = (left, right) if is_left else (right, left)
        twin = f"{shown(one.pair.right.name)} (line {one.pair.right.line})" if is_left else one.other
        apart = figure(100 * abs(left - right) / max(left, right), 2)
        what = f"the mass is {mass:g} kg, that of its mirror twin {twin} {its:g} kg, {apart} % apart"
        cause = None if how is None else f"{'it' if mass > its else 'that of the twin'} is {how}"
        remedy = f"correct it, to {its:g} kg if the parts are alike" if unit else _ONE_OF_TWO.format("parts")
        yield Fault(link.inertial.mass.span, what, remedy, mass, its, cause=cause)


@rule(
    "RD402",
    Severity.WARNING,
    Stage.MODEL,
    explanation=f"""A reflection leaves principal moments as they are. They may differ by {100 * MOMENTS:g} % of the
largest, as they stand or each divided by the mass of its link, so that a wrong mass is RD401's alone. Twins are found
as RD401 says. Where one cause explains the difference, RD306 to RD312 name it instead, and where no body can have one
of the tensors, RD204, RD206 or RD207 do.""",
    good=two_arms(),
    bad=(IMAGE, IMAGE.replace('"0.02"', '"0.024"')),
)
def mirror_moments(context: Context) -> Faults:
    """A left link has the principal moments of the right one."""
    for one in context.once(twins):
        apart = one.apart(*one.moments)
        if apart > MOMENTS and _unexplained(context, one):
            left, right = (
                ", ".join(f"{moment:.4g}" for moment in (mass * moments).tolist())
                for mass, moments in zip(one.masses, one.moments, strict=True)
            )
            what = (
                f"the principal moments are {right} kg m^2, those of its mirror twin {one.other} {left}, "
                f"up to {figure(100 * apart, 2)} % apart"
            )
            yield Fault(one.inertial.entries[0].span, what, _ONE_OF_TWO.format("parts"), apart, MOMENTS)


def _unexplained(context: Context, one: Twins) -> bool:
    """Whether bodies can have both of the tensors, and none has a cause that is known."""
    if {one.link.name, one.pair.left.name} & context.once(causes).keys():
        return False
    both = [link.inertial for link in (one.pair.left, one.pair.right) if link.inertial is not None]
    points = any(principal_moments(each.inertia)[2] <= POINT * POINT * each.mass for each in both)
    return not points and not any(broken_law(each.inertia, context.thresholds) for each in both)


_REFLECT = "reflect the one of the two that is wrong, or allow it where one part is mounted on both sides"


@rule("RD403", Severity.WARNING, Stage.MODEL, good=two_arms(), bad=("-0.05", "0.05"))
def mirror_image(context: Context) -> Faults:
    """Centre of mass and tensor of a right link are the mirror image of the left one's.

    A reflection turns the sign of one coordinate of the centre of mass and of two products of inertia. Copying a limb's
    numbers to the other side without it shifts the robot's centre of mass to one side. The centre may be a tenth of the
    radius of gyration and 1 mm from the mirror image. Where the very same part is mounted on both sides, it is no
    mirror image of itself: where both links have the same <visual> shapes (or, without any, the same <collision>
    shapes), what goes with these is as good. Twins are found as RD401 says; where one cause explains the tensor, RD306
    to RD313 name it instead, and where no body can have one of the two, RD204, RD206 or RD207 do.
    """
    for one in context.once(twins):
        cause = context.once(causes).get(one.link.name)
        reported = cause is not None and cause.code == "RD313" and one.centre_is_copied
        if one.shift > one.most_shift and not reported:
            origin = one.inertial.origin
            copied = "one is a copy of the other that is not reflected" if one.centre_is_copied else None
            what = (
                f"the centre of mass is at {place(one.c_right.tolist())} m, the mirror image of that of {one.other} at "
                f"{place(one.c.tolist())}, {one.shift:.3g} m away"
            )
            at = one.inertial.element.span if origin.element is None else origin.xyz.span
            yield Fault(at, what, _REFLECT, one.shift, one.most_shift, cause=copied)
        apart = one.tensors_apart
        if apart > MOMENTS >= one.apart(*one.moments) and _unexplained(context, one):
            what = (
                f"the inertia tensor is {figure(100 * apart, 2)} % from the mirror image of that of "
                f"{one.other}, although their principal moments agree"
            )
            yield Fault(one.inertial.entries[0].span, what, _REFLECT, apart, MOMENTS)


@rule("RD313", Severity.WARNING, good=two_arms(), bad=(IMAGE, TENSOR))
def copied_from_twin(context: Context) -> Faults:
    """A right link's tensor is the mirror image of the left one's, not a copy.

    A reflection turns the sign of two products of inertia. A tensor that equals its twin's entry by entry, in mirrored
    axes, was copied. It is right only where the same part is mounted on both sides, turned and not mirrored: where both
    links have the same meshes at the same place nothing is reported, and otherwise a waiver says so. Where the centre
    of mass is a copy, too, RD403 does not report it again.
    """
    for one in context.once(twins):
        cause = context.once(causes).get(one.link.name)
        if cause is None or cause.code != "RD313" or (one.tensors_apart <= MOMENTS and not one.centre_is_copied):
            continue
        centre = f"the centre of mass, {one.shift:.3g} m away, and " if one.centre_is_copied else ""
        what = (
            f"{centre}the inertia tensor, {figure(100 * one.tensors_apart, 2)} % from its mirror image, "
            f"{'are copies of those' if centre else 'is a copy of that'} of its twin {one.other}"
        )
        yield Fault(one.inertial.entries[0].span, what, _REFLECT, one.tensors_apart, kind="a copy of its twin")


_LIMIT = 0.02
"""How far limits may differ: in rad or m, or as a part of the range, whichever is more."""
_MAGNITUDE = 0.02
_TURNS = 4 * pi
"""RD507 reports ranges of revolute joints that go farther [rad]."""
_CORRECT_JOINT = _ONE_OF_TWO.format("joints")


@rule(
    "RD404",
    Severity.WARNING,
    Stage.MODEL,
    good=two_arms(right_joint='<axis xyz="0 -1 0"/>' + ARM_LIMIT.replace("-0.5", "-2").replace('"2"', '"0.5"')),
    bad=('"0 -1 0"', '"0 1 0"'),
)
def mirror_joint(context: Context) -> Faults:
    """Kind, axis, limits, effort and velocity of a right joint are the mirror image of the left one's.

    Where the axis of a joint is the image of its twin's, equal positions of twins are mirror images and so are equal
    limits; where it is the image reversed, lower and upper change places and signs; on a part that is mounted on both
    sides either is right. Copying limits from left to right where the axes ask for a change of sign is a common slip: a
    knee then bends the wrong way. So is a joint that was fixed for a test, while its twin still moves. Twins are found
    as RD401 says. Ranges that RD503, RD504 or RD507 report are not compared.
    """
    found = context.once(symmetry)
    for pair in () if found is None else found.pairs.values():
        assert found is not None, "it has pairs"
        left, right = pair.left_joint, pair.right_joint
        view, twin = context.view.joint[right.name], f"{shown(left.name)} (line {left.line})"
        at = view.element.span if view.axis.element is None else view.axis.span
        if left.type != right.type:
            one, other = (left, right) if left.type == "fixed" else (right, left)
            what = f"it is {one.type}, but its mirror twin {shown(other.name)} (line {other.line}) is {other.type}"
            yield Fault(value_span(context.view.joint[one.name].element, "type"), what, _CORRECT_JOINT)
        elif left.type in ("revolute", "continuous", "prismatic"):
            ways = set(found.directions(pair))
            if not ways:
                what = f"the axis is not parallel to the mirror image of that of its twin {twin}"
                yield Fault(at, what, _CORRECT_JOINT)
            elif len(ways) == 1 and view.limit is not None:
                yield from _range(pair, view.limit, ways.pop(), twin)
            yield from _magnitudes(pair, view, twin)


def _range(pair: Pair, limit: LimitView, direction: int, twin: str) -> Faults:
    kind, left, right = pair.left_joint.type, pair.left_joint.limit, pair.right_joint.limit
    if kind not in WITH_RANGE or not (_is_plain(left, kind) and _is_plain(right, kind)):
        return
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
    yield Fault(at.span, what, _CORRECT_JOINT, here[k], image[k], cause=cause)


def _ends(limit: Limit | None) -> tuple[float, float]:
    return (0.0, 0.0) if limit is None else (limit.lower or 0.0, limit.upper or 0.0)


def _is_plain(limit: Limit | None, kind: str) -> bool:
    """Whether there is a range that no other rule reports."""
    low, high = _ends(limit)
    return low < high and (kind == "prismatic" or max(-low, high) <= _TURNS)


def _magnitudes(pair: Pair, view: JointView, twin: str) -> Faults:
    left, right = pair.left_joint.limit, pair.right_joint.limit
    if left is None or right is None or view.limit is None:
        return
    both = ("effort", left.effort, right.effort), ("velocity", left.velocity, right.velocity)
    known = ((name, one, other) for name, one, other in both if one is not None and other is not None)
    found = [each for each in known if abs(each[1] - each[2]) > _MAGNITUDE * max(map(abs, each[1:]))]
    if found:
        name, one, other = found[0]
        here, there = (" and ".join(f"{each[0]} {each[k]:g}" for each in found) for k in (2, 1))
        what = f"the limit of {here} is not that of its mirror twin {twin}, {there}"
        yield Fault(getattr(view.limit, name).span, what, _CORRECT_JOINT, other, one)


_CORRECT_SIDE = _ONE_OF_TWO.format("sides")


@rule("RD405", Severity.WARNING, Stage.MODEL, good=two_elbows(), bad=two_elbows("0.1 0.05 0.3"))
def mirror_origin(context: Context) -> Faults:
    """Twin joints stand at each other's mirror image, where what carries them does.

    A wrong sign in the origin of one leg's joint moves the rest of the leg to the wrong side of it, and nothing else
    tells. Joints are twins if the names of the links that they carry are each other's but for left and right; the
    mirror plane is the robot's own, as RD401 finds it. Reported are joints whose parent is one link in that plane or on
    two links that are twins. Passed over are fixed ones that carry no mass, such as sensors; what is mounted alike on a
    part that is itself mounted on both sides, as fingers on a gripper; and frames that lie askew where no sign in rpy
    explains it.
    """
    found, heavy = context.once(symmetry), set[str]()
    if found is None:
        return
    for link in reversed(context.tree.links[1:]):
        if link.name in heavy or (link.mass or 0.0) > _LIGHT:
            heavy |= {link.name, found.above[link.name].parent}
    for left, right in found.named:
        joints = found.above[left], found.above[right]
        over = [joint.parent for joint in joints]
        pair = found.pairs.get(over[1])
        if right in found.pairs or not all(joint.type != "fixed" or joint.child in heavy for joint in joints):
            continue
        if over[0] == over[1] and length(found.plane.image(found.p[over[0]]) - found.p[over[0]]) <= found.near:
            pair = None
        elif pair is None or pair.left.name != over[0]:
            continue
        if pair is None or not pair.mounts_alike(*joints, found.near):
            yield from _misplaced(found, *joints, context.view.joint[joints[1].name])


def _misplaced(found: Symmetry, left: Joint, right: Joint, view: JointView) -> Faults:
    """The right joint's origin is not the mirror image of the left one's, or its axes are not but for signs in rpy."""
    twin, R, p = f"{shown(left.name)} (line {left.line})", found.R[right.parent], found.p[right.parent]
    expected = product(R.T, found.plane.image(found.p[left.child]) - p)
    off = length(expected - np.array(right.origin.xyz))
    at = view.element.span if view.origin.element is None else view.origin.xyz.span
    if off > found.near:
        flips = (signs for signs, xyz in _flips(right.origin.xyz, "xyz") if length(xyz - expected) <= found.near)
        what = (
            f"the origin is at {place(right.origin.xyz)} m; that of its mirror twin {twin} asks for "
            f"{place(expected.tolist())}, {off:.3g} m away"
        )
        signs = next(flips, None)
        cause = f"the sign of {signs} is not that of a mirror image" if signs else None
        yield Fault(at, what, _CORRECT_SIDE, off, 0.0, cause=cause)
        return
    turned = product(R.T, found.plane.H, found.R[left.child])
    for signs, rpy in _flips(right.origin.rpy, ("roll", "pitch", "yaw")):
        if is_square(product(rotation_from_rpy(*rpy).T, turned)):
            what = f"its axes are not the mirror image of those of its twin {twin}, but for the sign of {signs}"
            yield Fault(at if view.origin.element is None else view.origin.rpy.span, what, _CORRECT_SIDE)
            return


def _flips(values: tuple[float, ...], names: Sequence[str]) -> Iterator[tuple[str, Floats]]:
    """Yield the names of values that are not 0, few first, and the values with the other sign there."""
    places = [k for k in range(3) if values[k]]
    for count in range(1, len(places) + 1):
        for chosen in combinations(places, count):
            flipped = np.array(values)
            flipped[list(chosen)] *= -1.0
            yield " and ".join(names[k] for k in chosen), flipped
