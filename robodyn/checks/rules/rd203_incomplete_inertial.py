"""An <inertial> has a <mass> and an <inertia> with all six entries.

urdfdom drops an incomplete <inertial>, and the link has no mass; other readers take 0 or 1 for
what is missing.
"""

from robodyn.checks.examples import INERTIA, one_link
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.parts import INERTIA as ENTRIES


@rule(Severity.ERROR, good=one_link(), bad=(INERTIA, ""), explains=("RD901",))
def check(context: Context) -> Faults:
    for link in context.view.links:
        inertial = link.inertial
        if inertial is None:
            continue
        absent = [name for name, entry in zip(ENTRIES, inertial.entries, strict=True) if not entry.given]
        lacking = []
        if inertial.mass_element is None:
            lacking.append((inertial.element, "<inertial> has no <mass>", '<mass value="..."/>'))
        elif not inertial.mass.given:
            lacking.append((inertial.mass_element, "<mass> has no value", 'value="..."'))
        if inertial.inertia_element is None:
            lacking.append((inertial.element, "<inertial> has no <inertia>", "<inertia ixx=... izz=.../>"))
        elif absent:
            lacking.append((inertial.inertia_element, f"<inertia> has no {', '.join(absent)}", f'{absent[0]}="..."'))
        for element, what, remedy in lacking:
            yield Fault(element.span, what, f"write {remedy}")
