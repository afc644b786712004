"""Position limits of joints: there, in order, and in the right unit."""

from __future__ import annotations

from itertools import islice
from math import pi, radians

from robodyn.checks.bodies.limit_units import limit_slips
from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Context, Edit, Fault, Faults, Fix, Severity, rule
from robodyn.robot.urdf.numbers import Numbers, numbers
from robodyn.robot.urdf.parts import WITH_RANGE
from robodyn.robot.urdf.view import JointView, LimitView


@rule("RD503", Severity.ERROR, good=arm(), bad=('"-2"', '"3"'), explains=("RD901",))
def inverted_limits(context: Context) -> Faults:
    """The lower limit is less than the upper one.

    No position keeps to both limits. Controllers clamp to one of them, and drive the joint into a stop there.
    """
    for joint in context.view.joints:
        if joint.limit is None or joint.limit.range is None or joint.type not in WITH_RANGE:
            continue
        lower, upper = joint.limit.range
        if lower > upper:
            absent = [name for name in ("lower", "upper") if joint.limit.element.get(name) is None]
            default = f" ({absent[0]} is absent, and so 0)" if absent else ""
            what = f"lower {lower:g} is greater than upper {upper:g}{default}: there is no position"
            remedy = f'write {absent[0]}="..."' if absent else "exchange the two, or correct a sign"
            at = (joint.limit.lower if joint.limit.lower.given else joint.limit.upper).span
            yield Fault(at, what, remedy, lower, upper)


@rule("RD504", Severity.WARNING, good=arm(), bad=('lower="-2" upper="2" ', ""))
def no_range(context: Context) -> Faults:
    """The limits of a joint leave it a range, and end somewhere.

    A revolute or prismatic joint needs lower and upper; an absent one is 0, and with both absent the joint is
    frozen. A stand-in such as 1e16 passes for a range, from which planners then draw samples. A joint that turns
    freely, as a wheel or a propeller does, is `continuous` and has neither.
    """
    for joint in context.view.joints:
        limit = joint.limit
        if limit is None or limit.range is None or joint.type not in WITH_RANGE:
            continue
        lower, upper = limit.range
        turns, free = joint.type == "revolute", ""
        if lower == upper:
            if turns and not lower:
                free = "; one that turns freely is continuous"
            what, remedy = f"lower and upper are both {lower:g}: it cannot move", f"correct one, or make it fixed{free}"
            if not limit.lower.given and not limit.upper.given:
                what, remedy = "it has neither lower nor upper, which are 0 then: it cannot move", f"write both{free}"
            yield Fault(limit.lower.span, what, remedy, measured=lower)
            continue
        ends = (end for end in (limit.lower, limit.upper) if abs(end.value or 0.0) > context.thresholds.most_range)
        for end in islice(ends, 1):
            what, remedy = f"{end.attribute} is {end.value:g}, which limits nothing", "write the real limits"
            if turns:
                remedy = f"make a joint that turns freely continuous, or {remedy}"
            yield Fault(end.span, what, remedy, measured=end.value)


_ONE_TURN = 2 * pi * (1 + 1e-3)
_TURNS = 4 * pi
"""Between its limits a joint may well turn twice to each side; no rpy needs to."""
_DEGREES = 720.0
"""Two turns: of limits beyond them, even if they are in degrees, hardly any is one."""
_STEP = 5.0
"""Angles written in degrees are most often multiples of this."""


@rule(
    "RD507",
    Severity.WARNING,
    good=arm(f'<origin rpy="0 0 1.5707963267948966"/><axis xyz="0 1 0"/>{LIMIT}'),
    bad=("1.5707963267948966", "90"),
)
def degrees(context: Context) -> Faults:
    """Angles are in radians: no limit and no rpy is beyond one turn.

    An rpy of 90 is a turn by 90 rad, that is 14 turns and 117 degrees: the part stands askew and nothing else
    tells. A limit of 180 is none. A joint that does turn more than once between its limits is the exception. A
    range is one thing: its ends, with the soft limits, are turned into radians together, where all of them are
    round in degrees, or not at all.
    """
    view = context.view
    inertials = [link.inertial for link in view.links if link.inertial is not None]
    shapes = [geometry for link in view.links for geometry in link.geometries]
    for part in (*view.joints, *inertials, *shapes):
        angles = part.origin.rpy
        largest = max(angles.values or (0.0,), key=abs)
        if abs(largest) > _ONE_TURN:
            cause, fix = _in_degrees([angles])
            what = _what(angles, largest)
            yield Fault(angles.span, what, "write radians", abs(largest), 2 * pi, cause=cause, fix=fix)
    for joint in view.joints:
        if joint.type == "revolute" and joint.limit is not None:
            yield from _range(joint, joint.limit, context.thresholds.most_range)


def _range(joint: JointView, limit: LimitView, endless: float) -> Faults:
    """Yield one fault for both ends of a range, at that which is farther from zero."""
    hard = [end for end in (limit.lower, limit.upper) if end.value is not None]
    farther = max(hard, key=lambda end: abs(end.value or 0.0), default=None)
    largest = 0.0 if farther is None or farther.value is None else farther.value
    if farther is None or not _ONE_TURN < abs(largest) < endless:
        return
    what, cause, fix = _what(farther, largest), None, None
    if abs(largest) <= _TURNS:
        remedy = "narrow it, or make the joint continuous"
        yield Fault(farther.span, what, remedy, abs(largest), 2 * pi, severity=Severity.NOTE, kind="more than a turn")
        return
    if abs(largest) > _DEGREES:
        remedy = "make a joint that turns freely continuous, or write the real limits in radians"
    else:
        remedy, safety = "write both limits in radians", joint.element.find("safety_controller")
        soft = [numbers(safety, f"soft_{name}_limit", 1) for name in ("lower", "upper")]
        ends = [end for end in (limit.lower, limit.upper, *soft) if end.given]
        cause, fix = _in_degrees(ends)
    yield Fault(farther.span, what, remedy, abs(largest), 2 * pi, cause=cause, fix=fix)


def _what(angles: Numbers, largest: float) -> str:
    return f"{angles.attribute} is {largest:g} rad, or {largest * (180 / pi):.5g} degrees: more than a turn"


def _in_degrees(written: list[Numbers]) -> tuple[str, Fix] | tuple[None, None]:
    """Return the cause and the fix of angles that can be read, and are all round in degrees."""
    if not all(one.values is not None and all(value % _STEP == 0 for value in one.values) for one in written):
        return None, None
    radian = [(one.span, " ".join(repr(radians(value)) for value in one.values or ())) for one in written]
    edits = tuple(Edit(at.start, at.end, text) for at, text in radian)
    return "written in degrees", Fix("degrees to radians", edits, safe=False)


_SLACK = 1e-9


@rule(
    "RD508",
    Severity.WARNING,
    good=arm(
        f'<axis xyz="0 1 0"/>{LIMIT}<safety_controller soft_lower_limit="-1.9" soft_upper_limit="1.9" k_velocity="9"/>'
    ),
    bad=('"-1.9"', '"-2.5"'),
)
def soft_limits(context: Context) -> Faults:
    """Soft limits lie within the hard limits, lower below upper.

    The safety controller begins to brake at the soft limit. Outside the hard one it never does, and the joint meets
    its end stop at full speed.
    """
    for joint in context.view.joints:
        safety = joint.element.find("safety_controller")
        limit = joint.limit
        if safety is None or limit is None or joint.type not in WITH_RANGE:
            continue
        soft = {name: numbers(safety, f"soft_{name}_limit", 1) for name in ("lower", "upper")}
        lower, upper = soft["lower"].value, soft["upper"].value
        inverted = limit.range is None or limit.range[0] > limit.range[1]
        for name, hard, outside in (("lower", limit.lower.value, -1), ("upper", limit.upper.value, 1)):
            value = soft[name].value
            if value is not None and hard is not None and not inverted and outside * (value - hard) > _SLACK:
                what = f"the soft {name} limit {value:g} is outside the hard one, {hard:g}"
                remedy = "move it inside, so that the controller stops before the end stop"
                yield Fault(soft[name].span, what, remedy, value, hard)
        if lower is not None and upper is not None and lower > upper:
            what = f"the soft lower limit {lower:g} is greater than the soft upper one, {upper:g}"
            yield Fault(soft["lower"].span, what, "exchange the two", lower, upper)


_ALMOST_A_TURN = 2 * pi * (1 - 1e-2)
"""A little less, for limits such as 3.14."""


@rule("RD513", Severity.WARNING, good=arm(), bad=arm(f'<axis xyz="0 1 0"/>{LIMIT}', "continuous"))
def continuous_with_range(context: Context) -> Faults:
    """A joint that turns freely has no range that leaves angles out.

    Readers ignore lower and upper of a continuous joint. A range that is less than a whole turn says that the part
    has stops: a revolute joint was meant, and simulation and planning drive it through them. Ranges of a turn and
    more leave nothing out, and lower = upper is taken for none.
    """
    for joint in context.view.joints:
        limit = joint.limit
        if joint.type != "continuous" or limit is None or limit.range is None:
            continue
        lower, upper = limit.range
        if 0 < upper - lower < _ALMOST_A_TURN:
            what = (
                f"it is continuous, and so turns freely, but has a range from {lower:g} to {upper:g} rad, "
                "which is less than a turn and ignored"
            )
            remedy = 'write type="revolute" if the part has stops; otherwise remove lower and upper'
            at = limit.lower if limit.lower.given else limit.upper
            yield Fault(at.span, what, remedy, upper - lower, 2 * pi)


@rule(
    "RD515",
    Severity.WARNING,
    good=arm('<axis xyz="0 1 0"/><limit lower="0" upper="0.3" effort="30" velocity="0.2"/>', "prismatic"),
    bad=('upper="0.3"', 'upper="300"'),
)
def limit_unit(context: Context) -> Faults:
    """Limits are in rad/s, N m, m and m/s.

    A speed of 120 is 120 rad/s, 1146 turns a minute: at a joint, deg/s were meant. Reported are turning joints of
    which the speed is at least 8 times that of all others and among theirs when it is divided by 57.3, or all of
    which have round speeds from 45 on, and one of which turns within a range (a top, a wheel and a propeller may
    turn fast); efforts at least 100 times those of all others and among theirs when they are divided by 1000, which
    are N mm; and slides of more than 5 m that are 20 times the robot's longest offset between joints, or as fast
    per second, which are in mm. Powers of ten and all nines are stand-ins, and left to RD803.
    """
    for slip in context.once(limit_slips):
        name, value = slip.numbers.attribute, slip.numbers.value
        assert value is not None, "it is a slip of it"
        what = f"{name} is {value:g} {slip.meant}, which looks like {slip.wrote}: {slip.why}"
        remedy = f"write {value / slip.factor:.6g} if that is so"
        yield Fault(slip.numbers.span, what, remedy, value, value / slip.factor)
