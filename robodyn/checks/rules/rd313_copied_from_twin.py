"""RD313: a tensor copied from the mirror twin."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.causes import faults
from robodyn.checks.context import Context
from robodyn.checks.mirror_examples import ORIGIN_IMAGE, TENSOR, two_arms
from robodyn.checks.rule import Fault, Rule, Severity, Stage


def check(context: Context) -> Iterator[Fault]:
    yield from faults(context, "RD313")


RULE = Rule(
    code="RD313",
    name="copied-from-twin",
    severity=Severity.W,
    stage=Stage.DOCUMENT,
    summary="A right link's tensor is the mirror image of the left one's, not a copy.",
    explanation="""A reflection turns the sign of two products of inertia. A tensor that equals its twin's entry by
entry, in mirrored axes, was copied; it is right only where the same part is mounted on both sides, turned and not
mirrored, and a waiver says so.""",
    bad=two_arms(right=f'{ORIGIN_IMAGE}<mass value="2"/>{TENSOR}'),
    good=two_arms(),
    check=check,
)
