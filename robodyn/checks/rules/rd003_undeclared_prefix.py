"""A namespace prefix is declared before it is used.

To a namespace-aware parser (lxml, Qt, browsers) an undeclared prefix is an error, and the whole
file is refused. tinyxml, and with it urdfdom, does not mind, so that the mistake stays unseen.
"""

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule

_EXTENSION = '\n  <drake:joint name="shoulder"/>'


@rule(
    Severity.ERROR,
    Stage.TEXT,
    bad=arm(more=_EXTENSION),
    good=arm(more=_EXTENSION).replace("<robot ", '<robot xmlns:drake="http://drake.mit.edu" '),
)
def check(context: Context) -> Faults:
    for found in context.reading.found("RD003"):
        yield Fault(at=found.at, what=found.what, remedy=found.remedy)
