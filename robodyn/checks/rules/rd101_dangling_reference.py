"""RD101: a joint whose parent or child is no link."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import arm
from robodyn.checks.reading import unexpanded
from robodyn.checks.rule import Fault, Rule, Severity, Stage
from robodyn.checks.view import View, value_span
from robodyn.support.wording import alternatives, shown


def check(context: Context) -> Iterator[Fault]:
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
            yield Fault(at=at, subject=joint.subject, what=what, remedy=remedy)


def _explained(view: View) -> bool:
    """Whether no name is missing but those of links that other rules report: unnamed, duplicate, not expanded."""
    named = [link.name for link in view.links if not unexpanded(link.name)]
    missing = {name for joint in view.joints for name in (joint.parent, joint.child) if name} - view.link.keys()
    nameless = any(not joint.parent or not joint.child for joint in view.joints)
    return not view.links or (not nameless and len(missing) <= len(view.links) - len({*named} - {""}))


RULE = Rule(
    code="RD101",
    name="dangling-reference",
    severity=Severity.E,
    stage=Stage.DOCUMENT,
    summary="The parent and the child of every joint are links of the robot.",
    explanation="""Readers refuse the file, or leave out the joint and everything that hangs on it.""",
    bad=arm().replace('child link="upper"', 'child link="uper"'),
    good=arm(),
    check=check,
)
