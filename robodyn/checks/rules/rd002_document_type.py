"""A description has no document type and no entities.

An entity can name a file of the machine or of another one, or expand to gigabytes. URDF needs
neither, readers differ in what they do, and robodyn neither expands nor fetches any.
"""

from robodyn.checks.examples import one_link
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule


@rule(
    Severity.ERROR,
    Stage.TEXT,
    bad='<!DOCTYPE robot [<!ENTITY m "2">]>\n' + one_link().replace('"2"', '"&m;"'),
    good=one_link(),
)
def check(context: Context) -> Faults:
    for found in context.reading.found("RD002"):
        yield Fault(at=found.at, what=found.what, remedy=found.remedy)
