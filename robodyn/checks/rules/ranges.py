"""Position limits of joints: there, in order, and in the right unit."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice, pairwise
from math import isclose, log10, pi, radians
from typing import NamedTuple

from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.meshes.files import reach
from robodyn.checks.rule import ERROR, NOTE, WARNING, Context, Edit, Fault, Faults, Fix, rule
from robodyn.robot.urdf.parts import WITH_RANGE
from robodyn.robot.urdf.view import JointView, LimitView, Numbers, numbers


@rule("RD503", ERROR, good=arm(), bad=('"-2"', '"3"'), explains=("RD901",))
def inverted_limits(context: Context) -> Faults:
    """The lower limit is less than the upper one.

    No position keeps to both limits. Controllers clamp to one of them, and drive the joint into a stop there."""
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


@rule("RD504", WARNING, good=arm(), bad=('lower="-2" upper="2" ', ""))
def no_range(context: Context) -> Faults:
    """The limits of a joint leave it a range, and end somewhere.

    A revolute or prismatic joint needs lower and upper; an absent one is 0, and with both absent the joint is frozen. A
    stand-in such as 1e16, beyond the threshold `most-range` of 1e4, passes for a range. What turns freely, as a wheel
    or a propeller, is `continuous` and has neither."""
    for joint in context.view.joints:
        limit = joint.limit
        if limit is None or limit.range is None or joint.type not in WITH_RANGE:
            continue
        lower, upper = limit.range
        turns = joint.type == "revolute"
        if lower == upper:
            free = "; one that turns freely is continuous" if turns and not lower else ""
            what, remedy = f"lower and upper are both {lower:g}: it cannot move", f"correct one, or make it fixed{free}"
            if not limit.lower.given and not limit.upper.given:
                what, remedy = "it has neither lower nor upper, which are 0 then: it cannot move", f"write both{free}"
            yield Fault(limit.lower.span, what, remedy, measured=lower)
            continue
        ends = (end for end in (limit.lower, limit.upper) if abs(end.value or 0.0) > context.thresholds.most_range)
        for end in islice(ends, 1):
            remedy = f"{'make a joint that turns freely continuous, or ' if turns else ''}write the real limits"
            yield Fault(end.span, f"{end.attribute} is {end.value:g}, which limits nothing", remedy, measured=end.value)


_ONE_TURN = 2 * pi * (1 + 1e-3)
_TURNS = 4 * pi  # between its limits a joint may well turn twice to each side; no rpy needs to
_DEGREES = 720.0  # two turns: of limits beyond them, even if they are in degrees, hardly any is one
_STEP = 5.0  # angles written in degrees are most often multiples of this


@rule(
    "RD507",
    WARNING,
    good=arm(f'<origin rpy="0 0 1.5707963267948966"/><axis xyz="0 1 0"/>{LIMIT}'),
    bad=("1.5707963267948966", "90"),
)
def degrees(context: Context) -> Faults:
    """Angles are in radians: no limit and no rpy is beyond one turn.

    An rpy of 90 is a turn by 90 rad, that is 14 turns and 117 degrees. A limit of 180 is none. A joint that does turn
    more than once between its limits is the exception. The ends of a range, with the soft limits, are turned into
    radians together, where all of them are round in degrees, or not at all; a range that is round is an error."""
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
    """Yield one fault for both ends of a range, at the one farther from zero."""
    hard = [end for end in (limit.lower, limit.upper) if end.value is not None]
    farther = max(hard, key=lambda end: abs(end.value or 0.0), default=None)
    largest = 0.0 if farther is None or farther.value is None else farther.value
    if farther is None or not _ONE_TURN < abs(largest) < endless:
        return
    what, cause, fix = _what(farther, largest), None, None
    if abs(largest) <= _TURNS:
        remedy = "narrow it, or make the joint continuous"
        yield Fault(farther.span, what, remedy, abs(largest), 2 * pi, severity=NOTE, kind="more than a turn")
        return
    if abs(largest) > _DEGREES:
        remedy = "make a joint that turns freely continuous, or write the real limits in radians"
    else:
        remedy, safety = "write both limits in radians", joint.element.find("safety_controller")
        soft = [numbers(safety, f"soft_{name}_limit", 1) for name in ("lower", "upper")]
        ends = [end for end in (limit.lower, limit.upper, *soft) if end.given]
        cause, fix = _in_degrees(ends)
    severity = None if cause is None else ERROR
    yield Fault(farther.span, what, remedy, abs(largest), 2 * pi, cause=cause, fix=fix, severity=severity)


def _what(angles: Numbers, largest: float) -> str:
    return f"{angles.attribute} is {largest:g} rad, or {largest * (180 / pi):.5g} degrees: more than a turn"


def _in_degrees(written: list[Numbers]) -> tuple[str, Fix] | tuple[None, None]:
    if not all(one.values is not None and all(value % _STEP == 0 for value in one.values) for one in written):
        return None, None
    radian = [(one.span, " ".join(repr(radians(value)) for value in one.values or ())) for one in written]
    edits = tuple(Edit(at.start, at.end, text) for at, text in radian)
    return "written in degrees", Fix("degrees to radians", edits, safe=False)


_SLACK = 1e-9


@rule(
    "RD508",
    WARNING,
    good=arm(
        f'<axis xyz="0 1 0"/>{LIMIT}<safety_controller soft_lower_limit="-1.9" soft_upper_limit="1.9" k_velocity="9"/>'
    ),
    bad=('"-1.9"', '"-2.5"'),
)
def soft_limits(context: Context) -> Faults:
    """Soft limits lie within the hard limits, lower below upper.

    The safety controller brakes from the soft limit on. Outside the hard one the joint meets its stop at full speed."""
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


_ALMOST_A_TURN = 2 * pi * (1 - 1e-2)  # a little less, for limits such as 3.14


@rule("RD513", WARNING, good=arm(), bad=arm(f'<axis xyz="0 1 0"/>{LIMIT}', "continuous"))
def continuous_with_range(context: Context) -> Faults:
    """A joint that turns freely has no range that leaves angles out.

    Readers ignore lower and upper of a continuous joint. A range that is less than a whole turn says that the part has
    stops: a revolute joint was meant. Ranges of a turn and more leave nothing out; lower = upper is none."""
    for joint in context.view.joints:
        limit = joint.limit
        if joint.type != "continuous" or limit is None or limit.range is None:
            continue
        lower, upper = limit.range
        if 0 < upper - lower < _ALMOST_A_TURN:
            what = f"it is continuous, and so turns freely, but has a range from {lower:g} to {upper:g} rad, "
            what += "which is less than a turn and ignored"
            remedy = 'write type="revolute" if the part has stops; otherwise remove lower and upper'
            at = limit.lower if limit.lower.given else limit.upper
            yield Fault(at.span, what, remedy, upper - lower, 2 * pi)


_PER_RADIAN = 180 / pi
TURNING = ("revolute", "continuous")
_FASTEST = 20.0  # speeds [rad/s, m/s] up to which nothing is in doubt; a wheel or a propeller may turn `_FREELY` fast
_FREELY = 60.0
_SPEED_GAP, _SPEED_BAND = 8.0, 2.0
"""How many times all the others' a limit is at least, and how near to theirs it is when it is divided."""
_EFFORT_GAP, _EFFORT_BAND = 100.0, 3.0
_ROUND, _SLOWEST = 5.0, 45.0  # speeds in degrees are multiples of 5, and of a whole robot not below 45
_LONG, _TRACK, _REACHES = 5.0, 50.0, 20.0
"""A slide of more metres (a track, which carries all other joints, of more), which is as many times as long as the
robot's longest offset, is in millimetres."""


class LimitSlip(NamedTuple):
    """A number of <limit> in another unit: how many times too large, the unit it seems to be in, URDF's, and what
    speaks for it."""

    numbers: Numbers
    factor: float
    wrote: str
    meant: str
    why: str


def limit_slips(context: Context) -> tuple[LimitSlip, ...]:
    return (*_speeds(context), *_efforts(context), *_slides(context))


def of_numbers(context: Context) -> frozenset[int]:
    """The identities of the numbers that a slip explains, for the rules that are silent about them."""
    return frozenset(id(slip.numbers) for slip in context.once(limit_slips))


_Given = list[tuple[JointView, LimitView, float]]


def _speeds(context: Context) -> Iterator[LimitSlip]:
    most = context.thresholds.most_velocity
    found = [each for each in _given(context, "velocity") if each[0].type in TURNING and each[2] < most]
    large = [each for each in found if each[2] > (_FASTEST if each[0].type == "revolute" else _FREELY)]
    why = _apart(large, found, _PER_RADIAN, _SPEED_GAP, _SPEED_BAND)
    speeds = [each[2] for each in found]  # several values, for one alone may be a stand-in
    several = len(speeds) > 2 and len(set(speeds)) > 1 and any(each[0].type == "revolute" for each in found)
    if not why and several and all(speed >= _SLOWEST and speed % _ROUND == 0 for speed in speeds):
        large, why = found, f"those of all joints are multiples of {_ROUND:g}, which are speeds of no drive in rad/s"
    for _, limit, _ in large if why else ():
        yield LimitSlip(limit.velocity, _PER_RADIAN, "deg/s", "rad/s", why)


def _efforts(context: Context) -> Iterator[LimitSlip]:
    limits = context.thresholds
    found = [
        each
        for each in _given(context, "effort")
        if each[0].type in TURNING and each[2] < 1e3 * limits.most_effort
        if each[1].velocity.value is None or each[1].velocity.value < limits.most_velocity
    ]
    values = sorted(value for _, _, value in found)
    jump = next((above for below, above in pairwise(values) if above >= _EFFORT_GAP * below), None)
    large = [each for each in found if jump is not None and each[2] >= jump]
    powers = {value: (log10(value), log10(value + 1.0)) for *_, value in large}  # a power of ten, all nines: a stand-in
    large = [each for each in large if not any(isclose(x, round(x), abs_tol=1e-12) for x in powers[each[2]])]
    why = _apart(large, found, 1e3, _EFFORT_GAP, _EFFORT_BAND)
    for _, limit, _ in large if why else ():
        yield LimitSlip(limit.effort, 1e3, "N mm", "N m", why)


def _slides(context: Context) -> Iterator[LimitSlip]:
    tree = context.tree_or_none
    first = [] if tree is None else [group.joint for group in tree.groups[0].children if group.children]
    far = _REACHES * reach(context)
    why = f"the robot's longest offset between joints is {reach(context):.3g} m"
    for joint in context.view.joints:
        if joint.type != "prismatic" or joint.limit is None:
            continue
        bound = max(_TRACK if first == [joint] else _LONG, far)
        for end in (joint.limit.lower, joint.limit.upper):
            if end.value is not None and bound < abs(end.value) <= context.thresholds.most_range:
                yield LimitSlip(end, 1e3, "mm", "m", why)
        speed = joint.limit.velocity
        if speed.value is not None and max(bound, _FASTEST) < speed.value < context.thresholds.most_velocity:
            yield LimitSlip(speed, 1e3, "mm/s", "m/s", why)


def _given(context: Context, attribute: str) -> _Given:
    """The joints that move, with their positive limits of this attribute."""
    limits = ((joint, joint.limit) for joint in context.view.joints if joint.moves and joint.limit is not None)
    found = ((joint, limit, getattr(limit, attribute).value) for joint, limit in limits)
    return [each for each in found if each[2] is not None and each[2] > 0]


def _apart(large: _Given, found: _Given, factor: float, gap: float, band: float) -> str:
    """Why the large limits are in another unit: they are no more than the others, all above `gap` times these, and
    among them when they are divided by the factor; empty if they are not."""
    marked = {id(each[0]) for each in large}
    others = [value for joint, _, value in found if id(joint) not in marked]
    values = [value for *_, value in large]
    if not large or len(large) > len(others) or len(others) < 2 or min(values) < gap * max(others):
        return ""
    least, most = min(others) / band, max(others) * band
    within = all(least <= value / factor <= most for value in values)
    between = " to ".join(f"{value:g}" for value in sorted({min(others), max(others)}))
    return f"those of the other joints are {between}" if within else ""


@rule(
    "RD515",
    WARNING,
    good=arm('<axis xyz="0 1 0"/><limit lower="0" upper="0.3" effort="30" velocity="0.2"/>', "prismatic"),
    bad=('upper="0.3"', 'upper="300"'),
)
def limit_unit(context: Context) -> Faults:
    """Limits are in rad/s, N m, m and m/s.

    A speed of 120 is 120 rad/s, 1146 turns a minute: at a joint, deg/s were meant. Reported are turning joints of which
    the speed is at least 8 times that of all others and among theirs when it is divided by 57.3, or all of which have
    round speeds from 45 on, and one of which turns within a range; efforts at least 100 times those of all others and
    among theirs when they are divided by 1000, which are N mm; and slides of more than 5 m, or 50 m of a track that
    carries all other joints, which are 20 times the robot's longest offset between joints, or as fast per second, which
    are in mm. Powers of ten and all nines are stand-ins, and left to RD803."""
    for slip in context.once(limit_slips):
        name, value = slip.numbers.attribute, slip.numbers.value or 0.0
        what = f"{name} is {value:g} {slip.meant}, which looks like {slip.wrote}: {slip.why}"
        remedy = f"write {value / slip.factor:.6g} if that is so"
        yield Fault(slip.numbers.span, what, remedy, value, value / slip.factor)
