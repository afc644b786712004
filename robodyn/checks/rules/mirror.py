"""Left and right: masses, tensors, joints and origins of mirror twins."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from math import isclose, pi

import numpy as np

from robodyn.checks.bodies.masses import POINT, is_physical, principal_moments
from robodyn.checks.examples import ARM_LIMIT, IMAGE, TENSOR, two_arms, two_elbows
from robodyn.checks.mirror.causes import causes
from robodyn.checks.mirror.pairs import Pair, Symmetry, is_square, pairs, row_of, symmetry
from robodyn.checks.mirror.twins import (
    MASS,
    MOMENTS,
    Twins,
    directions,
    heavy_links,
    reversed_axes,
    twins,
)
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.programs.vectors import length, product, rotation_from_rpy
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.parts import WITH_RANGE, Joint, Limit
from robodyn.robot.urdf.view import JointView
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
_LEGS = 16
"""More than any robot has in a row."""


@rule(
    "RD401",
    Severity.WARNING,
    Stage.MODEL,
    explanation=f"""Links are twins if their names are each other's but for left and right, and at q = 0 each stands
where the mirror image of the other does; the plane is found from the robot. Masses may differ by {100 * MASS:g} %.
Where two parts that stand opposite each other do differ, as two tools do, a waiver says so. A ratio of 1000, 2.2046, 10
or 100 is named as the slip that makes it. The one that is in grams or pounds, or that weighs what no other of the legs
in front and behind does, is the wrong one; where neither tells, both are named.""",
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
        named = (
            factor for factor in _FACTORS if isclose(max(left, right) / min(left, right), factor[0], rel_tol=_EXACT)
        )
        (_, unit, how), others = next(named, (1.0, False, None)), _others(context, one)
        is_left = left > right if unit else others is not None and others[0]
        link = context.view.link[one.pair.left.name] if is_left else one.link
        assert link.inertial is not None, "it has mass"
        mass, its = (left, right) if is_left else (right, left)
        twin = f"{shown(one.pair.right.name)} (line {one.pair.right.line})" if is_left else one.other
        told = "" if others is None else f"; {others[1]} other links of this row weigh that"
        apart = figure(100 * abs(left - right) / max(left, right), 2)
        what = f"the mass is {mass:g} kg, that of its mirror twin {twin} {its:g} kg, {apart} % apart{told}"
        cause = None if how is None else f"{'it' if mass > its else 'that of the twin'} is {how}"
        known = unit or others is not None
        remedy = f"correct it, to {its:g} kg if the parts are alike" if known else _ONE_OF_TWO.format("parts")
        yield Fault(link.inertial.mass.span, what, remedy, mass, its, cause=cause)


def _others(context: Context, one: Twins) -> tuple[bool, int] | None:
    """Return whether it is the left link that weighs what no other leg's does, and how many weigh what the right one
    does, or the other way round; None where the other legs do not tell."""
    legs = context.once(_legs)[row_of(one.pair.left.name)]
    masses = [mass for other in legs[: _LEGS + 1] if other is not one for mass in other.masses][:_LEGS]
    alike = [sum(abs(other - mass) <= MASS * mass for other in masses) for mass in one.masses]
    if len(masses) < 2 or max(alike) < len(masses) or min(alike):
        return None
    return alike[1] > alike[0], max(alike)


def _legs(context: Context) -> dict[str, list[Twins]]:
    """Return the twins in front, behind and so on together."""
    found: dict[str, list[Twins]] = {}
    for one in context.once(twins):
        found.setdefault(row_of(one.pair.left.name), []).append(one)
    return found


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
    """Return whether bodies can have both of the tensors, and none has a cause that is known."""
    if {one.link.name, one.pair.left.name} & context.once(causes).keys():
        return False
    both = [link.inertial for link in (one.pair.left, one.pair.right) if link.inertial is not None]
    points = any(principal_moments(each.inertia)[2] <= POINT * POINT * each.mass for each in both)
    return not points and all(is_physical(each.inertia, context.thresholds) for each in both)


_REFLECT = "reflect the one of the two that is wrong, or allow it where one part is mounted on both sides"


@rule("RD403", Severity.WARNING, Stage.MODEL, good=two_arms(), bad=("-0.05", "0.05"))
def mirror_image(context: Context) -> Faults:
    """Centre of mass and tensor of a right link are the mirror image of the left one's.

    A reflection turns the sign of one coordinate of the centre of mass and of two products of inertia. Copying a
    limb's numbers to the other side without it shifts the robot's centre of mass to one side, by twice the offset
    of the link's. The centre may be a tenth of the radius of gyration and 1 mm from the mirror image. Where the
    very same part, an actuator say, is mounted on both sides, it is no mirror image of itself: where both links
    have the same <visual> shapes (or, without any, the same <collision> shapes), what goes with these is as good.
    Twins are found as RD401 says; where one cause explains the tensor, RD306 to RD313 name it instead, and where no
    body can have one of the two, RD204, RD206 or RD207 do.
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

    A reflection turns the sign of two products of inertia. A tensor that equals its twin's entry by entry, in
    mirrored axes, was copied. It is right only where the same part is mounted on both sides, turned and not
    mirrored: where both links have the same meshes at the same place nothing is reported, and otherwise a waiver
    says so. Where the centre of mass is a copy, too, RD403 does not report it again.
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

    A reflection carries a rotation about an axis into one about the axis's image, the other way round. Where the
    axis of a joint is that image, equal positions of twins are mirror images and so are equal limits; where it is
    the image reversed, lower and upper change places and signs; on a part that is mounted on both sides either is
    right. Copying limits from left to right where the axes ask for a change of sign is a common slip: a knee then
    bends the wrong way. So is a joint that was fixed for a test, while its twin still moves; and an axis that is
    reversed, which also shows where front and hind legs are not turned alike, or where all other joints of the limb
    that have their axes in the mirror plane, or across it, are turned the other way. Twins are found as RD401 says.
    Ranges that RD503, RD504 or RD507 report are not compared.
    """
    for pair in context.once(pairs):
        left, right = pair.left_joint, pair.right_joint
        view, twin = context.view.joint[right.name], f"{shown(left.name)} (line {left.line})"
        at = view.element.span if view.axis.element is None else view.axis.span
        if left.type != right.type:
            one, other = (left, right) if left.type == "fixed" else (right, left)
            what = f"it is {one.type}, but its mirror twin {shown(other.name)} (line {other.line}) is {other.type}"
            yield Fault(value_span(context.view.joint[one.name].element, "type"), what, _CORRECT_JOINT)
        elif left.type in ("revolute", "continuous", "prismatic"):
            yield from (ranges := list(_range(pair, context, twin)))
            shown_by = context.once(reversed_axes).get(right.name, ())
            others = next((each for each in shown_by if len(each) > 1 or not list(_range(each[0], context, ""))), ())
            if not any(directions(pair, context)):
                what = f"the axis is not parallel to the mirror image of that of its twin {twin}"
                yield Fault(at, what, _CORRECT_JOINT)
            elif len(others) == 1 and not ranges:
                front, rear = others[0].left_joint, others[0].right_joint
                what = (
                    f"it and its mirror twin {twin} are turned to each other as {shown(front.name)} and "
                    f"{shown(rear.name)} (line {rear.line}) are not: one of the four axes is reversed"
                )
                yield Fault(at, what, "correct the one of the four that is wrong, or allow it where the legs differ")
            elif len(others) > 1 and not ranges:
                named = " and ".join(shown(each.right_joint.name) for each in others[:2])
                what = (
                    f"it and its mirror twin {twin} are turned to each other as those of the limb whose axes lie like "
                    f"theirs, {named} among {len(others)}, are not: one of the two axes is reversed"
                )
                yield Fault(at, what, _CORRECT_JOINT)
            yield from _magnitudes(pair, view, twin)


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
    yield Fault(at.span, what, _CORRECT_JOINT, here[k], image[k], cause=cause)


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
        yield Fault(getattr(view.limit, name).span, what, _CORRECT_JOINT, other, one)


_CORRECT_SIDE = _ONE_OF_TWO.format("sides")


@rule("RD405", Severity.WARNING, Stage.MODEL, good=two_elbows(), bad=two_elbows("0.1 0.05 0.3"))
def mirror_origin(context: Context) -> Faults:
    """Twin joints stand at each other's mirror image, where what carries them does.

    A sign that was not turned, or turned twice, in the origin of one leg's joint moves the rest of the leg to the
    wrong side of it, and nothing else tells: the leg is still a leg. Joints are twins if the names of the links
    that they carry are each other's but for left and right; the mirror plane is the robot's own, as RD401 finds it.
    Reported are joints whose parent is one link in that plane or on two links that are twins. Passed over are fixed
    ones that carry no mass, such as sensors; what is mounted alike on a part that is itself mounted on both sides,
    as fingers on a gripper; and frames that lie askew where no sign in rpy explains it: they are chosen freely.
    """
    found = context.once(symmetry)
    if found is None:
        return
    heavy = heavy_links(found)
    for left, right in found.named:
        joints = found.above[left], found.above[right]
        over = [joint.parent for joint in joints]
        pair = found.by_right.get(over[1])
        if right in found.by_right or not all(joint.type != "fixed" or joint.child in heavy for joint in joints):
            continue
        if over[0] == over[1] and length(found.plane.image(found.p[over[0]]) - found.p[over[0]]) <= found.near:
            pair = None
        elif pair is None or pair.left.name != over[0]:
            continue
        if pair is None or not pair.mounts_alike(*joints, found.near):
            yield from _misplaced(found, *joints, context.view.joint[joints[1].name])


def _misplaced(found: Symmetry, left: Joint, right: Joint, view: JointView) -> Faults:
    """Yield where the right joint's origin is not the mirror image of the left one's, or where its axes are not but for
    signs in rpy."""
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
