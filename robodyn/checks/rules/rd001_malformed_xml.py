"""RD001: the file is not well-formed XML with the root element <robot>."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import one_link
from robodyn.checks.rule import Fault, Rule, Severity, Stage


def check(context: Context) -> Iterator[Fault]:
    for found in context.reading.found("RD001"):
        yield Fault(at=found.at, what=found.what, remedy=found.remedy)


RULE = Rule(
    code="RD001",
    name="malformed-xml",
    severity=Severity.E,
    stage=Stage.TEXT,
    summary="The file must be well-formed XML with the root element <robot>.",
    explanation="""Readers that recover from broken XML guess at what was meant, and drop links without a word.
Nothing after the first such place is checked.""",
    bad=one_link().replace("</link>", ""),
    good=one_link(),
    check=check,
)
