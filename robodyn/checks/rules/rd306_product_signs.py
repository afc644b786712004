"""RD306: products of inertia with the wrong sign."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.causes import faults
from robodyn.checks.context import Context
from robodyn.checks.mirror_examples import ORIGIN_IMAGE, two_arms
from robodyn.checks.rule import Fault, Rule, Severity, Stage

_WRONG = '<inertia ixx="0.02" ixy="0.004" ixz="-0.002" iyy="0.03" iyz="0.003" izz="0.025"/>'


def check(context: Context) -> Iterator[Fault]:
    yield from faults(context, "RD306")


RULE = Rule(
    code="RD306",
    name="product-signs",
    severity=Severity.W,
    stage=Stage.DOCUMENT,
    summary="Products of inertia have the sign of a matrix entry.",
    explanation="""URDF's ixy is an entry of the inertia matrix, minus the integral of x y dm. Many CAD programs
print plus that integral, and then all three signs are wrong. The diagonal is right, so that few tools notice; the
principal moments are not. RD206 and RD207 name the cause of tensors that no body has; this rule reports those that a
body could have, but not this link, by its mirror twin or its shapes.""",
    bad=two_arms(right=f'{ORIGIN_IMAGE}<mass value="2"/>{_WRONG}'),
    good=two_arms(),
    check=check,
)
