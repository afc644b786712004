"""Products of inertia are called ixy, ixz and iyz.

The inertia matrix is symmetric and URDF has its upper triangle. Readers ignore iyx, izx and izy;
where one of them stands in place of its twin, the product is taken for 0 or the whole inertial is dropped.
"""

from robodyn.checks.examples import one_link
from robodyn.checks.rule import Context, Edit, Fault, Faults, Fix, Severity, rule
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import numbers

_PAIRS = (("iyx", "ixy"), ("izx", "ixz"), ("izy", "iyz"))


@rule(Severity.WARNING, good=one_link(), bad=('iyz="', 'iyx="0.001" iyz="'))
def check(context: Context) -> Faults:
    for link in context.view.links:
        inertia = None if link.inertial is None else link.inertial.inertia_element
        for lower, upper in _PAIRS:
            if inertia is None or inertia.get(lower) is None:
                continue
            below, above = numbers(inertia, lower, 1).value, numbers(inertia, upper, 1).value
            state = f"{lower} is ignored" if below is None else f"{lower} = {below:g} is ignored"
            if below is not None and above is not None and below != above:
                state += f", and differs from {upper} = {above:g}"
            what = f"{state}: URDF has the upper triangle of the matrix only"
            remedy = f"delete {lower}, and see that {upper} is right"
            fix = None if below is None else _fix(inertia, lower, upper, above == below)
            yield Fault(inertia.attributes[lower].span, what, remedy, below, above, fix=fix)


def _fix(inertia: Element, lower: str, upper: str, same: bool) -> Fix | None:
    """Return the fix: of two that are the same the lower one goes; a lower one alone takes its twin's name."""
    span = inertia.attributes[lower].span
    if inertia.get(upper) is None:
        return Fix(f"call it {upper}", (Edit(span.start, span.start + len(lower), upper),), safe=False)
    if not same:
        return None
    start = len(inertia.positions.data[: span.start].rstrip(b" \t\r\n"))
    return Fix(f"delete {lower}", (Edit(start, span.end, ""),), safe=True)
