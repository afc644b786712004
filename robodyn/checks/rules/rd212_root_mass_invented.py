"""RD212: a root that has a shape and no mass."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import arm
from robodyn.checks.rule import Fault, Rule, Severity, Stage

_SHAPE = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
_MASS = '<inertial><mass value="4"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>'


def check(context: Context) -> Iterator[Fault]:
    root = context.tree.root
    shapes = [shape for shape in root.geometries if shape.kind == "collision"]
    if root.inertial is None and shapes:
        yield Fault(
            at=root.name_span,
            subject=root.subject,
            what="the root has a collision shape and no <inertial>: MuJoCo gives it the mass of water in that shape",
            remedy="write its <inertial>, or nothing if the base always stands still",
        )


RULE = Rule(
    code="RD212",
    name="root-mass-invented",
    severity=Severity.W,
    stage=Stage.TREE,
    summary="A root with a collision shape has an <inertial>.",
    explanation="""MuJoCo takes the mass of a body without an inertial from its shapes, at the density of water, and
other programs take none: the same floating robot weighs differently in each. A base that stands still is not
affected.""",
    bad=arm().replace('<link name="base"/>', f'<link name="base">{_SHAPE}</link>'),
    good=arm().replace('<link name="base"/>', f'<link name="base">{_MASS}{_SHAPE}</link>'),
    check=check,
)
