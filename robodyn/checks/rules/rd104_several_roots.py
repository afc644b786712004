"""Exactly one link has no parent.

All other links hang on it. Readers refuse a second root, or leave out all that hangs on it. Where
another rule of the structure (RD101 to RD107) is broken, its repair comes first and this one is silent.
"""

from robodyn.checks.examples import a_link, arm, longer_arm
from robodyn.checks.reading.tree import first_above
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.support.wording import listed


@rule(Severity.ERROR, good=longer_arm(), bad=arm(more=a_link("fore")))
def check(context: Context) -> Faults:
    view = context.view
    above = first_above(view)
    orderly = len(view.link) == len(view.links) and len(above) == len(view.joints)
    led = all(joint.parent in view.link and joint.child in view.link for joint in view.joints)
    roots = [link for link in view.links if link.name not in above]
    if orderly and led and len(roots) > 1:
        what = f"{len(roots)} links have no parent: {listed([link.name for link in roots])}"
        yield Fault(roots[1].name_span, what, "join them to one tree", len(roots), 1)
