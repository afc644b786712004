"""A slide is prismatic.

A lift whose type is revolute turns by as many radians as it was to rise metres, and no reader
complains. Reported are revolute joints that begin at 0, end within 0.4 rad (23 degrees) of it, and do not exceed
0.2 rad/s: what a finger or a lift does in metres. Of 86 published robots none does it in radians: their joints of so
small a range are at least 1.6 times as fast, and most of them turn to both sides.
"""

from math import degrees

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import value_span

_RANGE, _SPEED = 0.4, 0.2
_FROM_ZERO = 0.1
"""How far from 0 the range begins, as a part of it."""
_JOINT = '<axis xyz="0 0 1"/><limit lower="0" upper="0.3" effort="200" velocity="0.05"/>'


@rule(Severity.WARNING, good=arm(_JOINT, "prismatic"), bad=('type="prismatic"', 'type="revolute"'), explains=("RD804",))
def check(context: Context) -> Faults:
    for joint in context.view.joints:
        if joint.type != "revolute" or joint.limit is None:
            continue
        ends, speed = joint.limit.range, joint.limit.velocity.value
        if ends is None or speed is None or not 0 < speed <= _SPEED:
            continue
        size = ends[1] - ends[0]
        if 0 < size <= _RANGE and min(map(abs, ends)) <= _FROM_ZERO * size:
            what = (
                f"it is revolute, but goes from {ends[0]:g} to {ends[1]:g} at {speed:g} as a slide does in metres; in "
                f"radians that is {degrees(size):.3g} degrees at {degrees(speed):.3g} a second"
            )
            yield Fault(value_span(joint.element, "type"), what, 'write type="prismatic" if it slides', size, _RANGE)
