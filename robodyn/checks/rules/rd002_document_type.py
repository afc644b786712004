"""RD002: a document type or an entity."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import one_link
from robodyn.checks.rule import Fault, Rule, Severity, Stage


def check(context: Context) -> Iterator[Fault]:
    for found in context.reading.found("RD002"):
        yield Fault(at=found.at, what=found.what, remedy=found.remedy)


RULE = Rule(
    code="RD002",
    name="document-type",
    severity=Severity.E,
    stage=Stage.TEXT,
    summary="A description has no document type and no entities.",
    explanation="""An entity can name a file of the machine or of another one, or expand to gigabytes. URDF needs
neither, readers differ in what they do, and robodyn neither expands nor fetches any.""",
    bad='<!DOCTYPE robot [<!ENTITY m "2">]>\n' + one_link().replace('"2"', '"&m;"'),
    good=one_link(),
    check=check,
)
