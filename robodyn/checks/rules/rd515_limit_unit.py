"""Limits are in rad/s, N m, m and m/s.

A speed of 120 is 120 rad/s, 1146 turns a minute: at a joint, deg/s were meant. Reported are turning
joints of which the speed is at least 8 times that of all others and among theirs when it is divided by 57.3, or all of
which have round speeds from 45 on, and one of which turns within a range (a top, a wheel and a propeller may turn
fast); efforts at least 100 times those of all others and among theirs when they are
divided by 1000, which are N mm; and slides of more than 5 m that are 20 times the robot's longest offset between
joints, or as fast per second, which are in mm. Powers of ten and all nines are stand-ins, and left to RD803.
"""

from robodyn.checks.bodies.limit_units import limit_slips
from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule


@rule(
    Severity.WARNING,
    good=arm('<axis xyz="0 1 0"/><limit lower="0" upper="0.3" effort="30" velocity="0.2"/>', "prismatic"),
    bad=('upper="0.3"', 'upper="300"'),
)
def check(context: Context) -> Faults:
    for slip in context.once(limit_slips):
        name, value = slip.numbers.attribute, slip.numbers.value
        assert value is not None, "it is a slip of it"
        what = f"{name} is {value:g} {slip.meant}, which looks like {slip.wrote}: {slip.why}"
        remedy = f"write {value / slip.factor:.6g} if that is so"
        yield Fault(slip.numbers.span, what, remedy, value, value / slip.factor)
