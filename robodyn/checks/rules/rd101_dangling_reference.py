"""The parent and the child of every joint are links of the robot.

Readers refuse the file, or leave out the joint and everything that hangs on it.
"""

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.view import View
from robodyn.robot.urdf.xml_reader import unexpanded
from robodyn.support.wording import alternatives, shown


@rule(Severity.ERROR, good=arm(), bad=('link="upper"', 'link="uper"'))
def check(context: Context) -> Faults:
    links = context.view.link
    if _explained(context.view):
        return
    for joint in context.view.joints:
        for role, name in (("parent", joint.parent), ("child", joint.child)):
            if name in links or unexpanded(name):
                continue
            element = joint.element.find(role)
            at = joint.element.span if element is None else value_span(element, "link")
            what = f"its {role} is link {shown(name)}, which does not exist" if name else f"it names no {role} link"
            remedy = alternatives(name, links, "links") if name else f'write <{role} link="..."/>'
            yield Fault(at, what, remedy)


def _explained(view: View) -> bool:
    """Whether no name is missing but those of links that other rules report: unnamed, duplicate, not expanded."""
    named = [link.name for link in view.links if not unexpanded(link.name)]
    missing = {name for joint in view.joints for name in (joint.parent, joint.child) if name} - view.link.keys()
    nameless = any(not joint.parent or not joint.child for joint in view.joints)
    return not view.links or (not nameless and len(missing) <= len(view.links) - len({*named} - {""}))
