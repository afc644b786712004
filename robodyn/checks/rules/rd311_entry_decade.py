"""RD311: one entry off by a power of ten."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.causes import faults
from robodyn.checks.context import Context
from robodyn.checks.mirror_examples import ORIGIN_IMAGE, two_arms
from robodyn.checks.rule import Fault, Rule, Severity, Stage

_WRONG = '<inertia ixx="0.02" ixy="-0.0004" ixz="0.002" iyy="0.03" iyz="-0.003" izz="0.025"/>'


def check(context: Context) -> Iterator[Fault]:
    yield from faults(context, "RD311")


RULE = Rule(
    code="RD311",
    name="entry-decade",
    severity=Severity.W,
    stage=Stage.DOCUMENT,
    summary="No entry is off by a power of ten.",
    explanation="""A slip of the exponent in one entry. Without a twin to compare with, only a moment can be told
from others, and only where one entry and one power of ten make the tensor possible. RD206 and RD207 name the cause
of tensors that no body has; this rule reports those that a body could have, but not this link, by its mirror twin or
its shapes.""",
    bad=two_arms(right=f'{ORIGIN_IMAGE}<mass value="2"/>{_WRONG}'),
    good=two_arms(),
    check=check,
)
