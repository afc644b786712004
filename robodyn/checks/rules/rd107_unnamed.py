"""The robot and every link and joint have a name.

Joints refer to links by name, and programs to joints. urdfdom refuses a robot or a joint without
one.
"""

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import value_span


@rule(Severity.ERROR, good=arm(), bad=('name="shoulder" ', ""))
def check(context: Context) -> Faults:
    view = context.view
    links, joints = (part.element for part in view.links), (part.element for part in view.joints)
    for element in (view.root, *links, *joints):
        if not element.get("name"):
            state = "no name" if element.get("name") is None else "an empty name"
            yield Fault(value_span(element, "name"), f"<{element.tag}> has {state}", 'write name="..."', subject=None)
