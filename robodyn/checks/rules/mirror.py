"""Left and right: masses, tensors, joints and origins of mirror twins."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from itertools import combinations
from math import acos, degrees, isclose, pi, radians

import numpy as np

from robodyn.checks.bodies.bodies import box_of, outside, real_shapes, size_of, solids
from robodyn.checks.bodies.collision_fit import corners
from robodyn.checks.bodies.masses import POINT, STILL, broken_law, principal_moments
from robodyn.checks.examples import ARM_LIMIT, IMAGE, ORIGIN, ORIGIN_IMAGE, TENSOR, two_arms, two_elbows
from robodyn.checks.meshes.files import mesh_names
from robodyn.checks.mirror import MASS, MOMENTS, Symmetry, Twins, both_ways, is_square, named_pairs, symmetry, twins
from robodyn.checks.rule import MODEL, WARNING, Context, Fault, Faults, rule
from robodyn.checks.rules.inertia_mistakes import causes
from robodyn.programs.vectors import length, product, rotation_from_rpy, rpy_from_rotation
from robodyn.robot.kinematics import Pose
from robodyn.robot.urdf.parts import INERTIA, WITH_RANGE, Joint
from robodyn.robot.urdf.view import JointView, LimitView, LinkView, value_span
from robodyn.support.floats import Floats
from robodyn.support.wording import figure, place, shown, shown_path

_ONE_OF_TWO = "correct the one of the two that is wrong, or allow it where the {} differ"
_FACTORS = (
    (1000.0, True, "in grams, 1000 times the other"),
    (1 / 0.45359237, True, "in pounds, 2.2046 times the other"),
    (10.0, False, "10 times the other, as with the decimal point one place off"),
    (100.0, False, "100 times the other, as with the decimal point two places off"),
)
"""Of masses, each with whether the larger one is in another unit."""
_EXACT = 1e-3  # how far the ratio may be from a factor: masses of twins are equal or differ by chance
_LIGHT = 1e-3  # sensors and marks that weigh no more [kg] are put where there is room


@rule(
    "RD401",
    WARNING,
    MODEL,
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
    judged = {one.link.name for one in context.once(twins)}
    for one in context.once(twins):
        left, right = one.masses
        if abs(left - right) <= MASS * max(left, right):
            continue
        ratio = max(left, right) / min(left, right)
        named = (factor for factor in _FACTORS if isclose(ratio, factor[0], rel_tol=_EXACT))
        _, unit, how = next(named, (1.0, False, None))
        if unit and left > right and one.pair.left.name in judged:
            continue
        apart = figure(100 * abs(left - right) / max(left, right), 2)
        what = f"the mass is {right:g} kg, that of its mirror twin {one.other} {left:g} kg, {apart} % apart"
        cause = None if how is None else f"{'it' if right > left else 'that of the twin'} is {how}"
        remedy = f"correct it, to {left:g} kg if the parts are alike" if unit else _ONE_OF_TWO.format("parts")
        yield Fault(one.inertial.mass.span, what, remedy, right, left, cause=cause, kind="the masses of twins")


@rule(
    "RD402",
    WARNING,
    MODEL,
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
            each = (mass * moments for mass, moments in zip(one.masses, one.moments, strict=True))
            left, right = (", ".join(f"{moment:.4g}" for moment in moments.tolist()) for moments in each)
            what = f"the principal moments are {right} kg m^2, those of its mirror twin {one.other} {left}, "
            what += f"up to {figure(100 * apart, 2)} % apart"
            yield Fault(one.inertial.entries[0].span, what, _ONE_OF_TWO.format("parts"), apart, MOMENTS)


def _unexplained(context: Context, one: Twins) -> bool:
    """Whether bodies can have both of the tensors, and none has a cause that is known."""
    if {one.link.name, one.pair.left.name} & context.once(causes).keys():
        return False
    both = [link.inertial for link in (one.pair.left, one.pair.right) if link.inertial is not None]
    points = any(principal_moments(each.inertia)[2] <= POINT * POINT * each.mass for each in both)
    return not points and not any(broken_law(each.inertia, context.thresholds) for each in both)


_IMAGE = "the mirror image of that"
_REFLECT = "reflect the one of the two that is wrong, or allow it where one part is mounted on both sides"


@rule("RD403", WARNING, MODEL, good=two_arms(), bad=("-0.05", "0.05"))
def mirror_image(context: Context) -> Faults:
    """Centre of mass and tensor of a right link are the mirror image of the left one's.

    A reflection turns the sign of one coordinate of the centre of mass and of two products of inertia. Copying a limb's
    numbers to the other side without it shifts the robot's centre of mass to one side. The centre may be a tenth of the
    radius of gyration and 1 mm from the mirror image. Where the very same part is mounted on both sides, it is no
    mirror image of itself: where both links have the same <visual> shapes (or, without any, the same <collision>
    shapes), what goes with these is as good. Twins are found as RD401 says; where one cause explains the tensor, RD306
    to RD313 name it instead, and where no body can have one of the two, RD204, RD206 or RD207 do."""
    for one in context.once(twins):
        both = (context.once(causes).get(each.name) for each in (one.pair.left, one.pair.right))
        reported = one.centre_is_copied and any(each is not None and each.code == "RD313" for each in both)
        if one.shift > one.most_shift and not reported:
            origin = one.inertial.origin
            copied = "one is a copy of the other that is not reflected" if one.centre_is_copied else None
            what = f"the centre of mass is at {place(one.c_right.tolist())} m, "
            what += f"{'that' if one.pair.is_alike else _IMAGE} of {one.other} at {place(one.c.tolist())}, "
            what += f"{one.shift:.3g} m away"
            at = one.inertial.element.span if origin.element is None else origin.xyz.span
            yield Fault(at, what, _REFLECT, one.shift, one.most_shift, cause=copied)
        wrong = one.wrong_signs
        if wrong and one.tensors_apart <= MOMENTS and not reported:
            what = f"{' and '.join(wrong)} {'has' if len(wrong) == 1 else 'have'} not the sign of the mirror image of "
            what += f"{one.other}, although all else of the two is its image to the last digit"
            at = one.inertial.entries[INERTIA.index(wrong[0])].span
            yield Fault(at, what, _REFLECT, one.tensors_apart, 0.0)
        apart = one.tensors_apart
        if apart > MOMENTS >= one.apart(*one.moments) and _unexplained(context, one):
            what = f"the inertia tensor is {figure(100 * apart, 2)} % from the mirror image of that of "
            what += f"{one.other}, although their principal moments agree"
            yield Fault(one.inertial.entries[0].span, what, _REFLECT, apart, MOMENTS)


@rule("RD313", WARNING, good=two_arms(), bad=(IMAGE, TENSOR))
def copied_from_twin(context: Context) -> Faults:
    """A right link's tensor is the mirror image of the left one's, not a copy.

    A reflection turns the sign of two products of inertia. A tensor that equals its twin's entry by entry, in mirrored
    axes, was copied. It is right only where the same part is mounted on both sides, turned and not mirrored: where both
    links have the same meshes at the same place nothing is reported, and otherwise a waiver says so. Where the centre
    of mass is a copy, too, RD403 does not report it again."""
    for one in context.once(twins):
        cause = context.once(causes).get(one.link.name)
        if cause is None or cause.code != "RD313" or (one.tensors_apart <= MOMENTS and not one.centre_is_copied):
            continue
        centre = f"the centre of mass, {one.shift:.3g} m away, and " if one.centre_is_copied else ""
        what = f"{centre}the inertia tensor, {figure(100 * one.tensors_apart, 2)} % from its mirror image, "
        what += f"{'are copies of those' if centre else 'is a copy of that'} of its twin {one.other}"
        yield Fault(one.inertial.entries[0].span, what, _REFLECT, one.tensors_apart, kind="a copy of its twin")


_LIMIT = 0.02  # how far limits may differ: in rad or m, or as a part of the range, whichever is more
_MAGNITUDE = 0.02
_TURNS = 4 * pi  # RD507 reports ranges of revolute joints that go farther [rad]
_CORRECT_JOINT = _ONE_OF_TWO.format("joints")


@rule(
    "RD404",
    WARNING,
    MODEL,
    good=two_arms(right_joint='<axis xyz="0 -1 0"/>' + ARM_LIMIT.replace("-0.5", "-2").replace('"2"', '"0.5"')),
    bad=('"0 -1 0"', '"0 1 0"'),
)
def mirror_joint(context: Context) -> Faults:
    """Kind, axis, limits, effort and velocity of a right joint are the mirror image of the left one's.

    Where the axis of a joint is the image of its twin's, equal positions of twins are mirror images and so are equal
    limits; where it is the image reversed, lower and upper change places and signs; on a part that is mounted on both
    sides either is right. Copying limits from left to right where the axes ask for a change of sign is a common slip: a
    knee then bends the wrong way. So is a joint that was fixed for a test, while its twin still moves. Limits may
    differ by 0.02 rad or m, or by 2 % of the range where that is more, effort and velocity by 2 %. Of two joints whose
    numbers differ both are named. Twins are found as RD401 says. Ranges that RD503, RD504 or RD507 report are not
    compared."""
    found = context.once(symmetry)
    for pair in both_ways(context):
        assert found is not None, "it has pairs"
        left, right = (context.view.joint[joint.name] for joint in (pair.left_joint, pair.right_joint))
        twin = f"{shown(left.name)} (line {left.element.line})"
        if left.type != right.type:
            if left.type != "fixed":
                what = f"it is {right.type}, but its mirror twin {twin} is {left.type}"
                yield Fault(value_span(right.element, "type"), what, _CORRECT_JOINT)
        elif left.type in ("revolute", "continuous", "prismatic"):
            ways = set(found.directions(pair))
            if not ways and is_square(pair.D):
                what = f"the axis is not parallel to the mirror image of that of its twin {twin}"
                at = right.element.span if right.axis.element is None else right.axis.span
                yield Fault(at, what, _CORRECT_JOINT)
            if left.limit is not None and right.limit is not None:
                if ways and left.type in WITH_RANGE:
                    yield from _range(left, right.limit, sorted(ways), twin)
                yield from _magnitudes(left.limit, right.limit, twin)


def _range(left: JointView, limit: LimitView, ways: Sequence[int], twin: str) -> Faults:
    ranges = [each.range for each in (left.limit, limit) if each is not None and each.range is not None]
    slides = left.type == "prismatic"
    if not all(low < high and (slides or max(-low, high) <= _TURNS) for low, high in ranges):
        return
    (low, high), here = ranges
    images = [(low, high) if way > 0 else (0.0 - high, 0.0 - low) for way in ways]
    slack = _LIMIT * max(1.0, abs(high - low))
    offs = [[abs(value - wanted) for value, wanted in zip(here, image, strict=True)] for image in images]
    off = min(offs, key=max)
    if max(off) <= slack:
        return
    k, image = off.index(max(off)), images[offs.index(off)]
    what = f"the range is {here[0]:g} to {here[1]:g}, {_IMAGE if len(ways) == 1 else 'that'} of its twin {twin} "
    what += f"{image[0]:g} to {image[1]:g}"
    copied = ways == [-1] and max(abs(here[0] - low), abs(here[1] - high)) <= slack
    cause = "the ranges are equal, but the axes ask for a change of sign" if copied else None
    at = (limit.lower, limit.upper)[k]
    yield Fault(at.span, what, _CORRECT_JOINT, here[k], image[k], cause=cause)


def _magnitudes(left: LimitView, right: LimitView, twin: str) -> Faults:
    both = (left.effort, right.effort), (left.velocity, right.velocity)
    known = ((its, own, its.value, own.value) for its, own in both if its.value is not None and own.value is not None)
    found = [each for each in known if abs(each[2] - each[3]) > _MAGNITUDE * max(map(abs, each[2:]))]
    if found:
        here, there = (" and ".join(f"{each[0].attribute} {each[k]:g}" for each in found) for k in (3, 2))
        what = f"the limit of {here} is not that of its mirror twin {twin}, {there}"
        yield Fault(found[0][1].span, what, _CORRECT_JOINT, found[0][3], found[0][2])


_CORRECT_SIDE = _ONE_OF_TWO.format("sides")


@rule("RD405", WARNING, MODEL, good=two_elbows(), bad=two_elbows("0.1 0.05 0.3"))
def mirror_origin(context: Context) -> Faults:
    """Twin joints stand at each other's mirror image, where what carries them does.

    A wrong sign in the origin of one leg's joint moves the rest of the leg to the wrong side of it, and nothing else
    tells. Joints are twins if the names of the links that they carry are each other's but for left and right; the
    mirror plane is the robot's own, as RD401 finds it. Reported are joints whose parent is one link in that plane or on
    two links that are twins, and whose origin is 0.2 % of the robot's size or more from the image of the other's, or
    whose rpy has a wrong sign; and those that are turned, where centre, shapes and joints of what they carry are the
    image once they are turned back. Passed over are fixed ones that carry no mass, such as sensors; what is mounted
    alike on a part that is itself mounted on both sides, as fingers on a gripper; and frames that lie askew in other
    ways."""
    found, heavy = context.once(symmetry), set[str]()
    if found is None:
        return
    for link in reversed(context.tree.links[1:]):
        if link.name in heavy or (link.mass or 0.0) > _LIGHT:
            heavy |= {link.name, found.above[link.name].parent}
    for left, right in (way for names in found.named for way in (names, names[::-1])):
        joints = found.above[left], found.above[right]
        over = [joint.parent for joint in joints]
        pair = found.pairs.get(over[1]) or found.pairs.get(over[0])
        pair = pair if pair is None or pair.right.name == over[1] else pair.turned
        if right in found.turned:
            yield _turned(context.view.joint[joints[1].name], *joints, found.turned[right])
        light = any(joint.type == "fixed" and joint.child not in heavy for joint in joints)
        if light or {left, right} & found.pairs.keys():
            continue
        if over[0] == over[1] and length(found.plane.image(found.p[over[0]]) - found.p[over[0]]) <= found.near:
            pair = None
        elif pair is None or pair.left.name != over[0]:
            continue
        if pair is None or not pair.mounts_alike(*joints, found.near):
            yield from _misplaced(found, *joints, context.view.joint[joints[1].name])


def _turned(view: JointView, left: Joint, right: Joint, wanted: Floats) -> Fault:
    """The right joint's frame is turned from the one for which all that its link has is the left one's image."""
    cosine = (float(np.trace(product(rotation_from_rpy(*right.origin.rpy).T, wanted))) - 1.0) / 2.0
    by = degrees(acos(min(1.0, max(-1.0, cosine))))
    what = f"it is turned by {by:.3g} degrees from the mirror image of its twin {shown(left.name)} (line {left.line}): "
    what += "turned back, centres and joints of what it carries are the images of the twin's"
    rpy = " ".join(f"{angle + 0.0:.6g}" for angle in np.round(rpy_from_rotation(wanted), 9).tolist())
    at = view.element.span if view.origin.element is None else view.origin.rpy.span
    return Fault(at, what, f'write rpy="{rpy}" if the twin is right, or turn that one', radians(by), 0.0)


def _misplaced(found: Symmetry, left: Joint, right: Joint, view: JointView) -> Faults:
    """The right joint's origin is not the mirror image of the left one's, or its axes are not but for signs in rpy."""
    twin, R, p = f"{shown(left.name)} (line {left.line})", found.R[right.parent], found.p[right.parent]
    expected = product(R.T, found.plane.image(found.p[left.child]) - p)
    off = length(expected - np.array(right.origin.xyz))
    at = view.element.span if view.origin.element is None else view.origin.xyz.span
    if off > found.near:
        flips = (signs for signs, xyz in _flips(right.origin.xyz, "xyz") if length(xyz - expected) <= found.near)
        what = f"the origin is at {place(right.origin.xyz)} m; that of its mirror twin {twin} asks for "
        what += f"{place(expected.tolist())}, {off:.3g} m away"
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


_OFF, _LEAST_OFF = 0.15, 0.01  # of the size of the box around the shapes, and in metres
_ARMS = two_arms()
for _at in (ORIGIN, ORIGIN_IMAGE):
    _shape = f'<collision>{_at}<geometry><cylinder radius="0.05" length="0.2"/></geometry></collision>'
    _ARMS = _ARMS.replace(f"<inertial>{_at}", f"{_shape}<inertial>{_at}")


@rule(
    "RD406",
    WARNING,
    MODEL,
    good=_ARMS,
    bad=_ARMS.replace('"0.05"', '"0.1"', 1),
    explains=("RD301", "RD302", "RD306", "RD312", "RD403"),
)
def mirror_shapes(context: Context) -> Faults:
    """A left link has the shapes of the right one, and not its mesh.

    Of the <visual> shapes and of the <collision> shapes of twins, found as RD401 says, the boxes around them are each
    other's mirror image, or that of one part mounted on both sides, within 15 % of their size and 1 cm; and where the
    one has some, so has the other. Where one link's <visual> and <collision> shapes are farther from each other than
    those of its twin, it is the wrong one. A mesh for both whose file is called left or right, beside a counterpart, is
    wrong."""
    yield from _mesh_of_the_other(context)
    known = context.once(solids)
    for pair in both_ways(context):
        link, twin = context.view.link[pair.right.name], context.view.link[pair.left.name]
        other = f"{shown(twin.name)} (line {twin.element.line})"
        for kind in ("visual", "collision"):
            shapes, its = (real_shapes(each, kind) for each in (link, twin))
            box, image = box_of(shapes, known, STILL), box_of(its, known, STILL)
            if its and not shapes:
                what = f"it has no <{kind}>, and its mirror twin {other} has one"
                yield Fault(link.name_span, what, f"write its <{kind}>, or allow it where the parts differ")
            if box is None or image is None or not is_square(pair.D):
                continue
            if (own := pair.left.inertial) and outside(image, np.array(own.origin.xyz)) > _LEAST_OFF:
                continue
            ways = [Pose(pair.D, pair.t)] + ([pair.part] if pair.part is not None else [])
            off = min(corners(box, image.placed(*way)) for way in ways)
            if off > max(_OFF * size_of(box), _LEAST_OFF) and _more_apart(context, link, twin):
                what = f"its <{kind}> shapes are up to {off:.3g} m from the mirror image of those of {other}"
                yield Fault(shapes[0].element.span, what, _ONE_OF_TWO.format("shapes"), off, _OFF * size_of(box))


def _more_apart(context: Context, link: LinkView, twin: LinkView) -> bool:
    """Whether what collides is farther from what is seen than in the twin, or that is not known."""
    apart, known = list[float](), context.once(solids)
    for each in (link, twin):
        seen, felt = (box_of(real_shapes(each, kind), known, STILL) for kind in ("visual", "collision"))
        apart += [corners(seen, felt)] if seen is not None and felt is not None else []
    return len(apart) < 2 or apart[0] > apart[1] + _LEAST_OFF


def _mesh_of_the_other(context: Context) -> Faults:
    """Yield the meshes of two links whose file is that of one of them, with one for the other beside it."""
    files, view = context.once(mesh_names), context.view
    listed = cache(lambda folder: list(named_pairs([file.name for file in folder.glob("*")])))
    for names in named_pairs(list(view.link)):
        meshes = [[shape for shape in view.link[name].geometries if shape.uri in files] for name in names]
        for k, shape in ((side, one) for side in (0, 1) for one in meshes[side]):
            path = files[shape.uri].path
            alike = any((each.uri, each.kind) == (shape.uri, shape.kind) for each in meshes[1 - k])
            if path is None or not alike or all(path.stem.lower() in name.lower() for name in names):
                continue  # the last is a letter of the part, as in the left ring finger L_rf
            told = next((pair for pair in listed(path.parent) if path.name in pair), ("", ""))
            if told[1 - k] == path.name and shape.shape is not None:
                what = f"its {shape.kind} mesh is {shown_path(path.name)}, that of its twin {shown(names[1 - k])}"
                remedy = f"write {shown_path(shape.uri.replace(path.name, told[k]))}"
                yield Fault(value_span(shape.shape, "filename"), what, remedy)
