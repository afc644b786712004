"""The SRDF beside a description is for this robot.

MoveIt says "Semantic description is not specified for the same robot as the URDF" where the names in
the two <robot> differ. Most often the SRDF was copied from another robot. With names that are merely spelled otherwise
this is a remark; where most of the links and joints that it names are not in the robot, an error. Looked at is the
SRDF of the description's name beside it or in a folder config or srdf; the examples are SRDFs
of an arm.
"""

from robodyn.checks import examples
from robodyn.checks.ros.srdf import srdf
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import value_span
from robodyn.support.wording import shown


@rule(Severity.WARNING, good=examples.srdf(), bad=('robot name="arm"', 'robot name="leg"'))
def check(context: Context) -> Faults:
    """Silent without an SRDF."""
    found = context.once(srdf)
    if found is None:
        return
    at, given, own = value_span(found.root, "name"), found.root.get("name") or "", context.view.root.get("name") or ""
    if found.is_of_another:
        names = len({(used.kind, used.name) for used in found.used})
        what = f"{len(found.missing)} of the {names} links and joints that it names are not in the robot {shown(own)}"
        remedy = "write the SRDF of this robot, or rename the file if it is another one's"
        yield Fault(at, what, remedy, len(found.missing), 0.0, None, severity=Severity.ERROR, document=found.document)
    elif own and given != own:
        what = f"the SRDF is for the robot {shown(given)}, the description is of {shown(own)}"
        severity = Severity.NOTE if _alike(given, own) else None
        yield Fault(at, what, f"write name={shown(own)}", subject=None, severity=severity, document=found.document)


def _alike(one: str, other: str) -> bool:
    """Return whether one name is the other but for its case, what stands between its words, and an ending."""
    first, second = ("".join(filter(str.isalnum, name.casefold())) for name in (one, other))
    return bool(first) and bool(second) and (first.startswith(second) or second.startswith(first))
