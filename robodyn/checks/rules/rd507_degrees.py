"""Angles are in radians: no limit and no rpy is beyond one turn.

An rpy of 90 is a turn by 90 rad, that is 14 turns and 117 degrees: the part stands askew and
nothing else tells. A limit of 180 is none. A joint that does turn more than once between its limits is the
exception. A range is one thing: its ends, with the soft limits, are turned into radians together, where all of them
are round in degrees, or not at all.
"""

from math import degrees, pi, radians

from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Context, Edit, Fault, Faults, Fix, Severity, rule
from robodyn.robot.urdf.numbers import Numbers, numbers
from robodyn.robot.urdf.view import JointView, LimitView

_TURN = 2 * pi * (1 + 1e-3)
_TURNS = 4 * pi
"""Between its limits a joint may well turn twice to each side; no rpy needs to."""
_DEGREES = 720.0
"""Two turns: of limits beyond them, even if they are in degrees, hardly any is one."""
_STEP = 5.0
"""Angles written in degrees are most often multiples of this."""


@rule(
    Severity.WARNING,
    good=arm(f'<origin rpy="0 0 1.5707963267948966"/><axis xyz="0 1 0"/>{LIMIT}'),
    bad=("1.5707963267948966", "90"),
)
def check(context: Context) -> Faults:
    view = context.view
    inertials = [link.inertial for link in view.links if link.inertial is not None]
    shapes = [geometry for link in view.links for geometry in link.geometries]
    for part in (*view.joints, *inertials, *shapes):
        yield from _rpy(part.origin.rpy)
    for joint in view.joints:
        if joint.type == "revolute" and joint.limit is not None:
            yield from _range(joint, joint.limit, context.thresholds.most_range)


def _rpy(angles: Numbers) -> Faults:
    largest = max(angles.values or (0.0,), key=abs)
    if abs(largest) > _TURN:
        cause, fix = ("written in degrees", _fix([angles])) if _round([angles]) else (None, None)
        yield Fault(angles.span, _what(angles, largest), "write radians", abs(largest), 2 * pi, cause=cause, fix=fix)


def _range(joint: JointView, limit: LimitView, endless: float) -> Faults:
    """Yield one fault for both ends of a range, at that which is farther from zero."""
    hard = [end for end in (limit.lower, limit.upper) if end.value is not None]
    farther = max(hard, key=lambda end: abs(end.value or 0.0), default=None)
    largest = 0.0 if farther is None or farther.value is None else farther.value
    if farther is None or not _TURN < abs(largest) < endless:
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
        if _round(ends):
            cause, fix = "written in degrees", _fix(ends)
    yield Fault(farther.span, what, remedy, abs(largest), 2 * pi, cause=cause, fix=fix)


def _what(angles: Numbers, largest: float) -> str:
    return f"{angles.attribute} is {largest:g} rad, or {degrees(largest):.5g} degrees: more than a turn"


def _round(written: list[Numbers]) -> bool:
    """Return whether all of the angles can be read, and are round in degrees."""
    return all(one.values is not None and all(value % _STEP == 0 for value in one.values) for one in written)


def _fix(written: list[Numbers]) -> Fix:
    edits = (
        Edit(one.span.start, one.span.end, " ".join(repr(radians(value)) for value in one.values or ()))
        for one in written
    )
    return Fix("degrees to radians", tuple(edits), safe=False)
