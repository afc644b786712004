"""RD310: entries of the tensor in another order."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.causes import faults
from robodyn.checks.context import Context
from robodyn.checks.mirror_examples import ORIGIN_IMAGE, two_arms
from robodyn.checks.rule import Fault, Rule, Severity, Stage

_WRONG = '<inertia ixx="0.02" ixy="0.002" ixz="-0.004" iyy="0.03" iyz="-0.003" izz="0.025"/>'


def check(context: Context) -> Iterator[Fault]:
    yield from faults(context, "RD310")


RULE = Rule(
    code="RD310",
    name="entry-order",
    severity=Severity.W,
    stage=Stage.DOCUMENT,
    summary="The entries are in URDF's order: ixx ixy ixz iyy iyz izz.",
    explanation="""MuJoCo's fullinertia is ixx iyy izz ixy ixz iyz, Voigt's order ixx iyy izz iyz ixz ixy, and a
triangle by columns ixx ixy iyy ixz iyz izz; a matrix of nine entries, row by row, has iyx in fourth place. Pasting
one for another gives a tensor that no body has, or wrong products. RD206 and RD207 name the cause of tensors that no
body has; this rule reports those that a body could have, but not this link, by its mirror twin or its shapes.""",
    bad=two_arms(right=f'{ORIGIN_IMAGE}<mass value="2"/>{_WRONG}'),
    good=two_arms(),
    check=check,
)
