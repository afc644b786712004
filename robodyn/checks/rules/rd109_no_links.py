"""A robot has one link at least.

Often a sign of a file that was written by a failed conversion, or of xacro macros that were never
called.
"""

from robodyn.checks.examples import one_link
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule


@rule(Severity.ERROR, Stage.DOCUMENT, bad='<robot name="part">\n</robot>\n', good=one_link())
def check(context: Context) -> Faults:
    if not context.view.links:
        what = "the robot has no links"
        yield Fault(at=context.view.root.span, what=what, remedy="add a <link>", measured=0, bound=1)
