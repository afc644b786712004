"""No two joints have the same name.

Readers refuse the file, or keep one of the two and lose the other without a word.
"""

from robodyn.checks.examples import longer_arm
from robodyn.checks.rule import Context, Faults, Severity, rule
from robodyn.checks.rules.rd105_duplicate_link import namesakes


@rule(Severity.ERROR, good=longer_arm(), bad=("elbow", "shoulder"))
def check(context: Context) -> Faults:
    return namesakes("joint", context.view.joints, context.view.joint)
