"""Colours are four numbers from 0 to 1: red, green, blue and opacity.

urdfdom drops a colour with a number outside; others show it white, or black. Numbers to 255 are the
most frequent cause. An opacity of 0 is a shape that nobody sees, which some do on purpose.
"""

from robodyn.checks.examples import arm
from robodyn.checks.reading.grammar import own_elements
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import numbers
from robodyn.support.wording import figure

_RED = '\n  <material name="red"><color rgba="0.8 0.1 0.1 1"/></material>'


@rule(Severity.WARNING, good=arm(more=_RED), bad=("0.8 0.1 0.1", "204 26 26"), explains=("RD901",))
def check(context: Context) -> Faults:
    for element, _, subject in context.once(own_elements):
        rgba = numbers(element, "rgba", 4) if element.tag == "color" else None
        if rgba is None or rgba.values is None or all(0 <= value <= 1 for value in rgba.values):
            continue
        worst = max(rgba.values, key=lambda value: abs(value - 0.5))
        bytewise = worst > 1 and all(0 <= value <= 255 for value in rgba.values)
        first = " ".join(f"{figure(value / 255)}" for value in rgba.values[:3])
        remedy = f'divide by 255: "{first} 1"' if bytewise and worst > 2 else "write four numbers from 0 to 1"
        what = f"the color has {figure(worst)}, which is not from 0 to 1: urdfdom drops it"
        yield Fault(rgba.span, what, remedy, worst, 1.0 if worst > 1 else 0.0, subject=subject)
