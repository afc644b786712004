"""Angles are in radians: no limit and no rpy is beyond one turn.

An rpy of 90 is a turn by 90 rad, that is 14 turns and 117 degrees: the part stands askew and
nothing else tells. A limit of 180 is none. A joint that does turn more than once between its limits is the
exception.
"""

from math import degrees, pi, radians

from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Context, Edit, Fault, Faults, Fix, Severity, rule
from robodyn.robot.urdf.numbers import Numbers

_TURN = 2 * pi * (1 + 1e-3)
_TURNS = 4 * pi
"""Between its limits a joint may well turn twice to each side; no rpy needs to."""
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
        yield from _angles(part.origin.rpy)
    for joint in view.joints:
        if joint.type == "revolute" and joint.limit is not None:
            for numbers in (joint.limit.lower, joint.limit.upper):
                if numbers.value is not None and abs(numbers.value) < context.thresholds.most_range:
                    yield from _angles(numbers, _TURNS)


def _angles(numbers: Numbers, certain: float = _TURN) -> Faults:
    largest = max(numbers.values or (0.0,), key=abs)
    what = f"{numbers.attribute} is {largest:g} rad, or {degrees(largest):.5g} degrees: more than a turn"
    if abs(largest) > certain:
        in_degrees = all(value % _STEP == 0 for value in numbers.values or ())
        cause, fix = ("written in degrees", _fix(numbers)) if in_degrees else (None, None)
        yield Fault(numbers.span, what, "write radians", abs(largest), 2 * pi, cause=cause, fix=fix)
    elif abs(largest) > _TURN:
        remedy = "narrow it, or make the joint continuous"
        yield Fault(numbers.span, what, remedy, abs(largest), 2 * pi, severity=Severity.NOTE, kind="more than a turn")


def _fix(numbers: Numbers) -> Fix:
    text = " ".join(repr(radians(value)) for value in numbers.values or ())
    return Fix("degrees to radians", (Edit(numbers.span.start, numbers.span.end, text),), safe=False)
