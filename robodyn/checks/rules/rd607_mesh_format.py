"""RD607: a mesh in a format that a named program does not read."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import a_mesh
from robodyn.checks.mesh_formats import READS, unread
from robodyn.checks.rule import Fault, Rule, Severity, Stage


def check(context: Context) -> Iterator[Fault]:
    """Silent unless a target is named."""
    for target in context.asked.targets:
        for suffix, uses in unread(context, target).items():
            reads = READS[target]
            count = "1 shape has one" if len(uses) == 1 else f"{len(uses)} shapes have one"
            yield Fault(
                at=uses[0].at,
                subject=uses[0].link.subject,
                what=f"{target} does not read {suffix or 'files without a suffix'} and {reads.otherwise}: {count}",
                remedy=f"it reads {' '.join(reads.suffixes)} ({reads.source})",
            )


_KNOWN = "; ".join(
    f"{target}: {' '.join(reads.suffixes)} for {' and '.join(reads.kinds)}, and {reads.otherwise} otherwise"
    f" ({reads.source})"
    for target, reads in READS.items()
)

RULE = Rule(
    code="RD607",
    name="mesh-format",
    severity=Severity.I,
    stage=Stage.DOCUMENT,
    summary="The programs that a description is meant for read its meshes.",
    explanation=f"""With a target named, formats of meshes that it does not read are reported, once each. They read
{_KNOWN}. The examples stand beside the meshes that they name, and are checked for mujoco.""",
    bad=a_mesh("part.dae"),
    good=a_mesh("part.stl"),
    check=check,
)
