"""A robot has one link at least.

Often a sign of a file that was written by a failed conversion, or of xacro macros that were never
called.
"""

from robodyn.checks.examples import one_link
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule


@rule(Severity.ERROR, good=one_link(), bad='<robot name="part">\n</robot>\n')
def check(context: Context) -> Faults:
    if not context.view.links:
        what = "the robot has no links"
        yield Fault(context.view.root.span, what, "add a <link>", 0, 1, subject=None)
