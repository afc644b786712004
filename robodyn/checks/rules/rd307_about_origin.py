"""RD307: a tensor about the link's origin."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.causes import faults
from robodyn.checks.context import Context
from robodyn.checks.mirror_examples import ORIGIN_IMAGE, two_arms
from robodyn.checks.rule import Fault, Rule, Severity, Stage

_WRONG = '<inertia ixx="0.105" ixy="0.006" ixz="-0.038" iyy="0.13" iyz="0.017" izz="0.05"/>'


def check(context: Context) -> Iterator[Fault]:
    yield from faults(context, "RD307")


RULE = Rule(
    code="RD307",
    name="about-origin",
    severity=Severity.W,
    stage=Stage.DOCUMENT,
    summary="The tensor is about the centre of mass.",
    explanation="""URDF wants the tensor about the centre of mass, where the origin of <inertial> is. About the
link's origin it is larger by m (|c|^2 1 - c c^T), the term of the parallel axis theorem. Such a tensor is physical,
and so it takes the link's shapes (where all are primitives) or its mirror twin to see it.""",
    bad=two_arms(right=f'{ORIGIN_IMAGE}<mass value="2"/>{_WRONG}'),
    good=two_arms(),
    check=check,
)
