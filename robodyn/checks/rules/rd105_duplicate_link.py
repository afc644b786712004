"""No two links have the same name.

Readers refuse the file, or keep one of the two and lose the other without a word.
"""

from collections.abc import Mapping, Sequence

from robodyn.checks.examples import a_link, arm, longer_arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.view import JointView, LinkView


@rule(Severity.ERROR, good=longer_arm(), bad=arm(more=a_link("upper")))
def check(context: Context) -> Faults:
    return namesakes("link", context.view.links, context.view.link)


def namesakes(kind: str, parts: Sequence[LinkView | JointView], first: Mapping[str, LinkView | JointView]) -> Faults:
    """Yield the parts whose name another one before them has."""
    for part in parts:
        before = first.get(part.name, part)
        if before is not part:
            what = f"a second {kind} of this name; the first is in line {before.element.line}"
            yield Fault(part.name_span, what, "rename or remove one of them")
