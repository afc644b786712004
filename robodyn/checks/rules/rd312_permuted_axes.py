"""RD312: a tensor in axes of other names."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.causes import faults
from robodyn.checks.context import Context
from robodyn.checks.mirror_examples import ORIGIN_IMAGE, two_arms
from robodyn.checks.rule import Fault, Rule, Severity, Stage

_WRONG = '<inertia ixx="0.03" ixy="-0.004" ixz="-0.003" iyy="0.02" iyz="0.002" izz="0.025"/>'


def check(context: Context) -> Iterator[Fault]:
    yield from faults(context, "RD312")


RULE = Rule(
    code="RD312",
    name="permuted-axes",
    severity=Severity.W,
    stage=Stage.DOCUMENT,
    summary="The tensor is in the axes of the link, not in another program's.",
    explanation="""Programs differ in which axis points up or forward. A tensor with x, y and z exchanged has the
right principal moments about the wrong axes. RD206 and RD207 name the cause of tensors that no body has; this rule
reports those that a body could have, but not this link, by its mirror twin or its shapes.""",
    bad=two_arms(right=f'{ORIGIN_IMAGE}<mass value="2"/>{_WRONG}'),
    good=two_arms(),
    check=check,
)
