"""Numbers are finite, decimal, no larger than 1e30, and as many as the attribute holds.

NaN and infinity, decimal commas, units, and too few or too many numbers. urdfdom then drops the
whole element, an <inertial> for example, and reports success; other readers take a part of the text. A
<safety_controller> without k_velocity and a <dynamics> without damping and friction make it refuse the file.
"""

from robodyn.checks.examples import INERTIA, one_link
from robodyn.checks.reading.grammar import own_elements
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import numbers
from robodyn.robot.urdf.xml_reader import unexpanded

_LONGEST = 2000
"""Characters of an attribute of numbers."""


@rule(Severity.ERROR, good=one_link(f'<origin xyz="0 0.1 0"/><mass value="2"/>{INERTIA}'), bad=("0.1", "0,1"))
def check(context: Context) -> Faults:
    for element, kind, subject in context.once(own_elements):
        if kind.some and not any(name in element.values for name in kind.some):
            what = f"<{element.tag}> has neither {' nor '.join(kind.some)}, and urdfdom refuses the file"
            yield Fault(element.span, what, f"write one of them, or delete <{element.tag}>", subject=subject)
        for name, count in kind.attributes.items():
            if not count:
                continue
            found, text = numbers(element, name, count), element.get(name) or ""
            if len(text) > _LONGEST:
                what = f"{name} of <{element.tag}> has {len(text)} characters"
                yield Fault(found.span, what, f"write {count} numbers", subject=subject)
            elif found.problem is not None and not unexpanded(text):
                what = f"{name} of <{element.tag}> {found.problem}"
                yield Fault(found.span, what, found.problem.remedy, subject=subject)
            elif not found.given and name in kind.needed:
                what = f"<{element.tag}> has no attribute '{name}'"
                yield Fault(found.span, what, f'write {name}="..."', subject=subject)
