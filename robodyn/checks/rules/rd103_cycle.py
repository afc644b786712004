"""Going from child to parent leads to the root.

Links in a cycle hang on nothing. Some readers do not notice and recurse until memory ends.
"""

from robodyn.checks.examples import a_joint, a_link, arm
from robodyn.checks.reading.tree import first_above
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.structure import cycles
from robodyn.support.wording import listed, shown


@rule(
    Severity.ERROR,
    good=arm(more=a_link("a") + a_link("b") + a_joint("to_b", "a", "b") + a_joint("to_a", "upper", "a")),
    bad=('<parent link="upper"/>', '<parent link="b"/>'),
)
def check(context: Context) -> Faults:
    above = first_above(context.view)
    for cycle in cycles({child: joint.parent for child, joint in above.items()}):
        first = min((above[link] for link in cycle), key=lambda joint: joint.element.start)
        element = first.element.find("parent")
        assert element is not None, "the joint names a parent"
        if len(cycle) == 1:
            what = f"link {shown(cycle[0])} is its parent and its child"
        else:
            what = f"it is in a cycle of {len(cycle)} links, each the parent of the one before: {listed(cycle)}"
        yield Fault(value_span(element, "link"), what, "a URDF is a tree: correct a parent")
