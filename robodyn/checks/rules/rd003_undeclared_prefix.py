"""A namespace prefix is declared before it is used.

To a namespace-aware parser (lxml, Qt, browsers) an undeclared prefix is an error, and the whole
file is refused. tinyxml, and with it urdfdom, does not mind, so that the mistake stays unseen.
"""

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Faults, Severity, Stage, rule, text_faults

_EXTENSION = '\n  <drake:joint name="shoulder"/>'


@rule(
    Severity.ERROR,
    Stage.TEXT,
    good=arm(more=_EXTENSION).replace("<robot ", '<robot xmlns:drake="http://drake.mit.edu" '),
    bad=arm(more=_EXTENSION),
)
def check(context: Context) -> Faults:
    return text_faults(context, "RD003")
