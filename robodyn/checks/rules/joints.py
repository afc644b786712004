"""Joints: axes, effort and velocity, friction, mimics."""

from __future__ import annotations

from collections import Counter
from math import degrees, hypot
from operator import itemgetter

import numpy as np

from robodyn.checks.bodies.bodies import shaped
from robodyn.checks.bodies.contacts import rest_poses
from robodyn.checks.examples import LIMIT, arm, longer_arm
from robodyn.checks.meshes.files import reach
from robodyn.checks.rule import ERROR, NOTE, TREE, WARNING, Context, Edit, Fault, Faults, Fix, rule
from robodyn.checks.rules.ranges import TURNING, of_numbers
from robodyn.programs.vectors import length, product
from robodyn.robot.urdf.description import cycles
from robodyn.robot.urdf.document import unexpanded
from robodyn.robot.urdf.parts import WITH_AXIS, WITH_RANGE
from robodyn.robot.urdf.view import JointView, value_span
from robodyn.support.linear import eigen
from robodyn.support.wording import alternatives, listed, shown


@rule("RD501", ERROR, good=arm(f'<axis xyz="0 0 1"/>{LIMIT}'), bad=('"0 0 1"', '"0 0 0"'), explains=("RD901",))
def zero_axis(context: Context) -> Faults:
    """The axis of a joint that moves is not zero.

    Readers divide by its length: the joint then turns about NaN, or not at all."""
    for joint in context.view.joints:
        if joint.type in WITH_AXIS and joint.axis.values is not None and not any(joint.axis.values):
            remedy = 'write the direction in the joint frame, for example xyz="0 0 1"'
            yield Fault(joint.axis.span, "the axis is 0 0 0, which is no direction", remedy, 0.0, 1.0)


@rule("RD502", WARNING, good=arm(f'<axis xyz="0 0 1"/>{LIMIT}'), bad=('"0 0 1"', '"0 0 2"'))
def axis_length(context: Context) -> Faults:
    """The axis of a joint is a unit vector.

    URDF asks for it. Most readers normalise the axis; the others turn the joint by a multiple of its coordinate."""
    bound = context.thresholds.axis_length
    for joint in context.view.joints:
        axis = joint.axis.values
        if joint.type not in WITH_AXIS or axis is None or not any(axis):
            continue
        size = hypot(*axis)
        if abs(size - 1) > bound:
            what, at, largest = f"the axis has the length {size:.6g}, not 1", joint.axis.span, max(map(abs, axis))
            unit = [x / largest / hypot(*(x / largest for x in axis)) for x in axis]  # in two steps, lest it overflow
            edit = Edit(at.start, at.end, " ".join(map(repr, unit)))
            fix = Fix("divide the axis by its length", (edit,), safe=True)
            yield Fault(at, what, "divide it by its length", size, 1.0, fix=fix)


@rule("RD505", ERROR, good=arm(), bad=arm('<axis xyz="0 1 0"/>'))
def no_limit(context: Context) -> Faults:
    """Revolute and prismatic joints have a <limit>.

    URDF asks for it, and urdfdom refuses the robot."""
    for joint in context.view.joints:
        if joint.type in WITH_RANGE and joint.limit is None:
            remedy = 'add <limit lower="..." upper="..." effort="..." velocity="..."/>'
            if joint.type == "revolute":
                remedy += ", or make it continuous"
            yield Fault(joint.name_span, f"a {joint.type} joint without <limit>", remedy)


_FEW = 3


@rule("RD506", WARNING, good=arm(), bad=('"30"', '"0"'), explains=("RD901",))
def effort_velocity(context: Context) -> Faults:
    """Effort and velocity limits are positive and those of a machine.

    URDF asks for both wherever there is a <limit>: urdfdom refuses a file in which one is missing, also that of a fixed
    joint. With a limit of 0 some simulators never move the joint, and others do not limit it. 1e9 is a stand-in that
    nothing can be sized against: a remark; an effort in N mm is RD515's. One joint of four or more with a thousandth of
    the effort, or a fiftieth of the speed, of all others has lost its digits."""
    limits, of_another_unit = context.thresholds, context.once(of_numbers)
    for joint in context.view.joints:
        if joint.limit is None:
            continue
        for numbers, most in ((joint.limit.effort, limits.most_effort), (joint.limit.velocity, limits.most_velocity)):
            value, remedy = numbers.value, "write what the drive can do"
            if not numbers.given:
                what = f"<limit> has no {numbers.attribute}, and urdfdom refuses the file"
                yield Fault(numbers.span, what, remedy, None, 0.0, severity=ERROR)
            elif not joint.moves or value is None or 0 < value < most or id(numbers) in of_another_unit:
                continue
            elif value > 0:
                what = f"{numbers.attribute} is {value:g}, a stand-in that limits nothing"
                yield Fault(numbers.span, what, remedy, value, most, severity=NOTE)
            else:
                what, kind = f"{numbers.attribute} is {value:g}, not positive", "a limit that is not positive"
                yield Fault(numbers.span, what, remedy, value, 0.0, kind=kind)
    moving = [joint for joint in context.view.joints if joint.moves and joint.limit is not None]
    for name, factor, most in (("effort", 1000.0, limits.most_effort), ("velocity", 50.0, limits.most_velocity)):
        given = [getattr(one.limit, name) for one in moving if name == "effort" or one.type in TURNING]
        positive = sorted(((one.value, one.span) for one in given if (one.value or 0.0) > 0), key=itemgetter(0))
        if len(positive) > _FEW and positive[0][0] * factor <= positive[1][0] < most:
            (least, at), (others, _) = positive[:2]
            what = f"{name} is {least:g}, and that of every other joint {others:g} or more"
            yield Fault(at, what, "write what the drive can do", least, others)


@rule(
    "RD509",
    ERROR,
    good=arm(f'<axis xyz="0 1 0"/>{LIMIT}<dynamics damping="0.1"/>'),
    bad=('"0.1"', '"-0.1"'),
    explains=("RD901",),
)
def negative_friction(context: Context) -> Faults:
    """Damping and friction are not negative.

    Friction takes energy out. With a negative coefficient a joint speeds up by itself, and a simulation diverges."""
    for joint in context.view.joints:
        for found in (joint.damping, joint.friction):
            if found.value is not None and found.value < 0:
                what = f"the {found.attribute} is {found.value:g}, and feeds energy in"
                yield Fault(found.span, what, "write it without the sign", found.value, 0.0)


_FOLLOWER = f'<axis xyz="0 1 0"/>{LIMIT}<mimic joint="shoulder" multiplier="0.5"/>'


@rule(
    "RD510", ERROR, good=longer_arm(inside=_FOLLOWER), bad=('joint="shoulder"', 'joint="sholder"'), explains=("RD901",)
)
def mimic_unknown_joint(context: Context) -> Faults:
    """A joint mimics one of the robot's joints, in a hand one of its own finger.

    Readers refuse the robot, or make the follower a free joint that nothing drives. It is a warning where a finger
    follows the joint that leads another one, and not its own free joint, while at least twice as many follow theirs: a
    name was kept when the finger was copied."""
    yield from _of_another_finger(context)
    joints = context.view.joint
    for joint in context.view.joints:
        if joint.mimic is None or joint.mimic.joint in joints or unexpanded(joint.mimic.joint):
            continue
        name = joint.mimic.joint
        what = f"it mimics joint {shown(name)}, which does not exist" if name else "<mimic> names no joint"
        remedy = alternatives(name, joints, "joints") if name else 'write joint="..."'
        yield Fault(value_span(joint.mimic.element, "joint"), what, remedy)


def _of_another_finger(context: Context) -> Faults:
    """Yield what follows the leader of another finger, and not the one joint before it, which is free."""
    groups = context.tree_or_none.groups if context.tree_or_none else ()
    moved = {group.joint.name: group for group in groups if group.joint is not None}
    mimics = [(group, group.joint.mimic) for group in moved.values() if group.joint and group.joint.mimic]
    led = {group: moved[mimic.joint] for group, mimic in mimics if mimic.joint in moved}
    own = {at for one, at in led.items() if one.parent and at in (one.parent, one.parent.parent)}
    free = {group for group in moved.values() if len(group.children) == 1} - {*led, *led.values()}
    before = ((one, mimic, one.parent) for one, mimic in mimics if one.parent in free)
    odd = [(mimic, above.joint) for one, mimic, above in before if above and led.get(one) in own - {above.parent}]
    for mimic, joint in odd if 2 * len(odd) <= len(own) else ():
        what = f"it mimics joint {shown(mimic.joint)}, which leads another finger, and not the one before it"
        remedy = f"mimic joint {shown(joint.name if joint else '')}, which leads none"
        yield Fault(value_span(mimic.element, "joint"), what, remedy, severity=WARNING)


@rule("RD511", ERROR, good=longer_arm(inside=_FOLLOWER), bad=('joint="shoulder"', 'joint="elbow"'), explains=("RD901",))
def mimic_cycle(context: Context) -> Faults:
    """Mimic joints follow one that is free, at last.

    In a cycle no joint has a position of its own. Some readers follow it for ever."""
    joints = context.view.joint
    leaders = {name: joint.mimic.joint for name, joint in joints.items() if joint.mimic is not None}
    for cycle in cycles(leaders):
        mimic = min((joints[name] for name in cycle), key=lambda joint: joint.element.start).mimic
        what = "it mimics itself" if len(cycle) == 1 else f"joints mimic each other in a cycle: {listed(cycle)}"
        if mimic is not None:
            yield Fault(value_span(mimic.element, "joint"), what, "let one of them be free")


@rule("RD512", WARNING, good=longer_arm(inside=_FOLLOWER), bad=('"0.5"', '"1.5"'))
def follower_range(context: Context) -> Faults:
    """A mimic joint stays within its limits wherever the joint that it follows goes.

    Otherwise the robot cannot move through the range that its limits promise: simulators violate the limits or the
    coupling, and planners reach positions that the hand does not have."""
    for joint in context.view.joints:
        mimic, own = joint.mimic, _range(joint)
        followed = None if mimic is None else context.view.joint.get(mimic.joint)
        leader = None if followed is None or followed.mimic is not None else _range(followed)
        if mimic is None or own is None or leader is None:
            continue
        multiplier, offset = mimic.multiplier.or_default(1.0), mimic.offset.or_default(0.0)
        if multiplier is None or offset is None:
            continue
        least, most = sorted(multiplier[0] * end + offset[0] for end in leader)
        beyond = max(own[0] - least, most - own[1])
        if beyond > context.thresholds.mimic_range:
            what = f"following joint '{mimic.joint}' through its range, it goes from {least:.6g} to {most:.6g}, "
            what += f"beyond its own limits {own[0]:.6g} and {own[1]:.6g} by {beyond:.3g}"
            remedy = "correct multiplier or offset, or the limits of one of the two"
            yield Fault(mimic.multiplier.span, what, remedy, beyond, context.thresholds.mimic_range)


def _range(joint: JointView) -> tuple[float, float] | None:
    if joint.limit is None or joint.type not in WITH_RANGE:
        return None
    lower, upper = joint.limit.lower.value, joint.limit.upper.value
    return (lower, upper) if lower is not None and upper is not None and lower < upper else None


@rule("RD514", WARNING, good=arm(), bad=arm(LIMIT))
def missing_axis(context: Context) -> Faults:
    """A joint that turns or slides says about which axis.

    Without `<axis>` it is 1 0 0, the x axis of the joint: a part that was to turn about z rolls instead, and nothing
    else tells. Writing it down costs nothing where x is meant."""
    for joint in context.view.joints:
        if joint.type in WITH_AXIS and joint.element.find("axis") is None:
            what = f"it is {joint.type} and has no <axis>: it is taken to be 1 0 0, the x axis of the joint"
            yield Fault(joint.name_span, what, 'write <axis xyz="..."/>, also where it is 1 0 0')


_RANGE, _SPEED = 0.4, 0.2
_FROM_ZERO = 0.1  # how far from 0 the range begins, as a part of it
_JOINT = '<axis xyz="0 0 1"/><limit lower="0" upper="0.3" effort="200" velocity="0.05"/>'


@rule("RD516", WARNING, good=arm(_JOINT, "prismatic"), bad=('type="prismatic"', 'type="revolute"'), explains=("RD804",))
def turning_slide(context: Context) -> Faults:
    """A slide is prismatic.

    A lift whose type is revolute turns by as many radians as it was to rise metres, and no reader complains. Reported
    are revolute joints that begin at 0, end within 0.4 rad (23 degrees) of it, and do not exceed 0.2 rad/s: what a
    finger or a lift does in metres, and of 86 published robots none in radians."""
    for joint in context.view.joints:
        if joint.type != "revolute" or joint.limit is None:
            continue
        ends, speed = joint.limit.range, joint.limit.velocity.value
        if ends is None or speed is None or not 0 < speed <= _SPEED:
            continue
        size = ends[1] - ends[0]
        if 0 < size <= _RANGE and min(map(abs, ends)) <= _FROM_ZERO * size:
            what = f"it is revolute, but goes from {ends[0]:g} to {ends[1]:g} at {speed:g} as a slide does in metres; "
            what += f"in radians that is {degrees(size):.3g} degrees at {degrees(speed):.3g} a second"
            yield Fault(value_span(joint.element, "type"), what, 'write type="prismatic" if it slides', size, _RANGE)


_ONE_LINE, _OF_REACH, _PARALLEL, _ACROSS = 1e-3, 1e-2, 0.9998, 0.1
"""Metres, of the robot's longest offset, and cosines of angles between axes."""
_FLAT, _ROUND, _CENTRED = 0.5, 0.02, 0.05
"""Of a disc: its least second moment over the largest, how far the other two differ, and how far its centre is from
the joint, by its radius of gyration. Of 3370 pairs of joints and 120 such parts of published robots none is found."""
_OTHERS = 5


@rule(
    "RD517",
    WARNING,
    TREE,
    good=longer_arm(inside=f'<origin xyz="0 0 0.3"/><axis xyz="0 1 0"/>{LIMIT}'),
    bad=longer_arm(inside=f'<origin xyz="0 0.3 0"/><axis xyz="0 1 0"/>{LIMIT}'),
)
def idle_axis(context: Context) -> Faults:
    """A joint turns about another line than the one before it, and a disc about its own axis.

    Two joints in a row about one line, with nothing else on the body between them, do what one does: a robot has no
    such pair, and one of the two axes is wrong, or the rpy of an origin is, which was lost perhaps. Nor has it a wheel
    or a flange that turns about a line across its disc: a last part whose uniform solid is flat and round, with its
    centre in the axis of its joint. Nor one, behind the first, that turns about y where five others or more, and all of
    them, turn about z of their frames, as CAD programs write them."""
    yield from _other_axis(context)
    tree, poses, shapes = context.tree, context.once(rest_poses), context.once(shaped)
    lines, near = {}, min(_ONE_LINE, _OF_REACH * reach(context))
    for group in tree.groups:
        joint = group.joint
        axis = None if joint is None or joint.type not in TURNING else joint.axis.or_default(1.0, 0.0, 0.0)
        if joint is None or axis is None or not any(axis) or joint.child not in poses:
            continue
        unit = np.array(axis) / hypot(*axis)
        lines[group] = product(poses[joint.child].R, unit), poses[joint.child].p
        above, shape = group.parent, shapes.get(joint.child)
        if above in lines and above is not None and above.joint is not None and len(above.children) == 1:
            (a, p), (b, q) = lines[above], lines[group]
            if abs(product(a, b)) >= _PARALLEL and length(np.cross(a, q - p)) <= near:
                for one, other in ((joint, above.joint), (above.joint, joint)):
                    line = f"the line of joint {shown(other.name)}, next to it"
                    what = f"it turns about {line}: one of the two does nothing"
                    at = one.element.span if one.axis.element is None else one.axis.span
                    yield Fault(at, what, "check the axes of both, and the rpy of the outer one")
        if shape is not None and not group.children and joint.axis.element is not None:
            moments, axes = eigen(shape.solid.S)
            across = shape.solid.c - axes[2] * product(axes[2], shape.solid.c)
            disc = moments[2] <= _FLAT * moments[0] and moments[0] - moments[1] <= _ROUND * moments[0]
            if disc and length(across) <= _CENTRED * shape.solid.spread**0.5 and abs(product(axes[2], unit)) <= _ACROSS:
                own = " ".join(f"{x + 0.0:.2g}" for x in np.round(axes[2], 3).tolist())
                what = f"it turns about {' '.join(f'{x:g}' for x in axis)}, but its part is a disc about {own}"
                yield Fault(joint.axis.span, what, f'write <axis xyz="{own}"/>, if it turns in its plane')


def _other_axis(context: Context) -> Faults:
    """Yield the joint that alone turns about another axis of its frame than all others; none of the root's."""
    found = {}
    for joint in context.view.joints:
        axis = joint.axis.or_default(1.0, 0.0, 0.0)
        if joint.type in TURNING and joint.mimic is None and axis is not None and joint.axis.element is not None:
            found[joint.name] = tuple(round(abs(x), 3) for x in axis)
    (axis, count), *_ = [*Counter(found.values()).most_common(1), (None, 0)]
    for name, other in found.items():
        joint = context.view.joint[name]
        if _OTHERS <= count == len(found) - 1 and other != axis and context.tree.group[joint.parent].joint is not None:
            own, theirs = (" ".join(f"{x:g}" for x in each or ()) for each in (other, axis))
            what = f"it turns about {own} of its frame, and all {count} other joints about {theirs}"
            yield Fault(joint.axis.span, what, f'write <axis xyz="{theirs}"/>, with its sign, unless it is meant')
