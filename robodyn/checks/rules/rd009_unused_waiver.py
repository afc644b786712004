"""RD009: a waiver of something that is not there."""

from __future__ import annotations

from collections.abc import Iterable

from robodyn.checks.context import Context
from robodyn.checks.examples import INERTIA, one_link
from robodyn.checks.rule import Edit, Fault, Fix, Rule, Severity, Stage
from robodyn.checks.waivers import Waiver


def check(context: Context) -> Iterable[Fault]:
    """Nothing: only when the other rules have run is it known which waivers they needed; the run then asks `unused`."""
    return ()


def unused(waiver: Waiver, code: str) -> Fault:
    return Fault(
        at=waiver.at,
        what=f"the waiver of {code} has nothing to waive",
        remedy="delete it, or put it above the element that the finding is in",
        fix=Fix("delete the waiver", (Edit(*waiver.erased, ""),), safe=True) if len(waiver.codes) == 1 else None,
    )


RULE = Rule(
    code="RD009",
    name="unused-waiver",
    severity=Severity.W,
    stage=Stage.DOCUMENT,
    summary="A waiver allows a finding that is there.",
    explanation="""A waiver that outlives its finding would hide the next one. It is reported if its rule has run and
has found nothing in the element that the waiver is about.""",
    bad=one_link(f'<!-- robodyn: allow RD208 no tensor is published --><mass value="2"/>{INERTIA}'),
    good=one_link(f'<mass value="2"/>{INERTIA}'),
    check=check,
)
