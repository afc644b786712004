"""No link is the child of two joints.

A URDF is a tree. Of a closed chain one joint is left out, and made of what the simulator has for
it.
"""

from robodyn.checks.examples import a_joint, a_link, arm, longer_arm
from robodyn.checks.reading.tree import first_above
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import value_span
from robodyn.support.wording import shown


@rule(
    Severity.ERROR,
    good=longer_arm(),
    bad=arm(more=a_link("fore") + a_joint("elbow", "upper", "fore") + a_joint("strut", "base", "fore")),
)
def check(context: Context) -> Faults:
    above = first_above(context.view)
    for joint in context.view.joints:
        first = above.get(joint.child, joint)
        if first is joint or (joint.name and joint.name == first.name):
            continue
        element = joint.element.find("child")
        assert element is not None, "the joint names a child"
        what = (
            f"its child, link {shown(joint.child)}, hangs on joint {shown(first.name)} (line {first.element.line}) too"
        )
        yield Fault(value_span(element, "link"), what, "a link has one parent: remove one joint, or correct its child")
