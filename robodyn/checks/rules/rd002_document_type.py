"""A description has no document type and no entities.

An entity can name a file of the machine or of another one, or expand to gigabytes. URDF needs
neither, readers differ in what they do, and robodyn neither expands nor fetches any.
"""

from robodyn.checks.examples import one_link
from robodyn.checks.rule import Context, Faults, Severity, Stage, rule, text_faults


@rule(
    Severity.ERROR,
    Stage.TEXT,
    good=one_link(),
    bad='<!DOCTYPE robot [<!ENTITY m "2">]>\n' + one_link().replace('"2"', '"&m;"'),
)
def check(context: Context) -> Faults:
    return text_faults(context, "RD002")
