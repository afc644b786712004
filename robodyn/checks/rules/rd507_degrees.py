"""Angles are in radians: no limit and no rpy is beyond one turn.

An rpy of 90 is a turn by 90 rad, that is 14 turns and 117 degrees: the part stands askew and
nothing else tells. A limit of 180 is none. A joint that does turn more than once between its limits is the
exception.
"""

from collections.abc import Iterator
from math import degrees, pi, radians

from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Context, Edit, Fault, Faults, Fix, Severity, rule
from robodyn.robot.urdf.numbers import Numbers
from robodyn.robot.urdf.view import OriginView, Subject

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
    for joint in context.view.joints:
        yield from _pose(joint.origin, joint.subject)
        if joint.type == "revolute" and joint.limit is not None:
            for numbers in (joint.limit.lower, joint.limit.upper):
                if numbers.value is not None and abs(numbers.value) < context.thresholds.most_range:
                    yield from _angles(numbers, joint.subject, _TURNS)
    for link in context.view.links:
        poses = [link.inertial.origin] if link.inertial is not None else []
        for origin in (*poses, *(geometry.origin for geometry in link.geometries)):
            yield from _pose(origin, link.subject)


def _pose(origin: OriginView, subject: Subject) -> Iterator[Fault]:
    if origin.rpy.values is not None:
        yield from _angles(origin.rpy, subject)


def _angles(numbers: Numbers, subject: Subject, certain: float = _TURN) -> Iterator[Fault]:
    largest = max(numbers.values or (0.0,), key=abs)
    if abs(largest) > _TURN:
        doubtful = abs(largest) <= certain
        yield Fault(
            numbers.span,
            f"{numbers.attribute} is {largest:g} rad, or {degrees(largest):.5g} degrees: more than a turn",
            "narrow it, or make the joint continuous" if doubtful else "write radians",
            subject=subject,
            measured=abs(largest),
            bound=2 * pi,
            severity=Severity.NOTE if doubtful else Severity.WARNING,
            cause="written in degrees" if _round(numbers) and not doubtful else None,
            fix=_fix(numbers) if _round(numbers) and not doubtful else None,
        )


def _round(numbers: Numbers) -> bool:
    return all(value % _STEP == 0 for value in numbers.values or ())


def _fix(numbers: Numbers) -> Fix:
    text = " ".join(repr(radians(value)) for value in numbers.values or ())
    return Fix("degrees to radians", (Edit(numbers.span.start, numbers.span.end, text),), safe=False)
