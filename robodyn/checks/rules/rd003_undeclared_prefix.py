"""RD003: a namespace prefix that is not declared."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import arm
from robodyn.checks.rule import Fault, Rule, Severity, Stage

_EXTENSION = '\n  <drake:joint name="shoulder"/>'


def check(context: Context) -> Iterator[Fault]:
    for found in context.reading.found("RD003"):
        yield Fault(at=found.at, what=found.what, remedy=found.remedy)


RULE = Rule(
    code="RD003",
    name="undeclared-prefix",
    severity=Severity.E,
    stage=Stage.TEXT,
    summary="A namespace prefix is declared before it is used.",
    explanation="""To a namespace-aware parser (lxml, Qt, browsers) an undeclared prefix is an error, and the whole
file is refused. tinyxml, and with it urdfdom, does not mind, so that the mistake stays unseen.""",
    bad=arm(more=_EXTENSION),
    good=arm(more=_EXTENSION).replace("<robot ", '<robot xmlns:drake="http://drake.mit.edu" '),
    check=check,
)
