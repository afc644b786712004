"""Names of letters, digits and _ survive a conversion to other formats.

USD (Isaac Sim) takes no other character and renames what has one, after which programs look for
the old name in vain; SDF keeps some names for itself and wants each but once among links and joints.
"""

import re

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.view import JointView, LinkView

_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


@rule(Severity.NOTE, good=arm().replace("shoulder", "shoulder_pitch"), bad=('"shoulder_pitch"', '"shoulder/pitch"'))
def check(context: Context) -> Faults:
    view = context.view
    parts: tuple[LinkView | JointView, ...] = (*view.links, *view.joints)
    for part in parts:
        refusal = _refusal(part.name)
        if part.subject.kind == "joint" and part.name in view.link:
            refusal = refusal or "SDF wants different names for a link and a joint"
        if refusal:
            remedy = "use letters, digits and _ only, and each name once"
            yield Fault(part.name_span, refusal, remedy)


def _refusal(name: str) -> str | None:
    """Return which format does not take the name."""
    if not name or (_PLAIN.fullmatch(name) and not name.startswith("__")):
        return None
    if "::" in name or (name.startswith("__") and name.endswith("__")):
        return "SDF keeps :: and names between __ for itself"
    if "/" in name:
        return "USD and MuJoCo's includes take / for a path, tf for a namespace"
    if name[0].isdigit():
        return "a name in USD, Modelica or Python does not begin with a digit"
    return "USD takes letters, digits and _ only, and renames it" if not name.startswith("__") else None
