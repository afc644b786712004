"""The robot and every link and joint have a name.

Joints refer to links by name, and programs to joints. urdfdom refuses a robot or a joint without
one.
"""

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import value_span
from robodyn.support.wording import shown


@rule(Severity.ERROR, good=arm(), bad=('name="shoulder" ', ""))
def check(context: Context) -> Faults:
    view = context.view
    links, joints = (part.element for part in view.links), (part.element for part in view.joints)
    for element in (view.root, *links, *joints):
        if not element.get("name"):
            state = "no name" if element.get("name") is None else "an empty name"
            child = element.find("child")
            to = f" to link {shown(child.values['link'])}" if child is not None and child.get("link") else ""
            what = f"<{element.tag}>{to} has {state}"
            yield Fault(value_span(element, "name"), what, 'write name="..."', subject=None)
