"""RD607: a mesh in a format that a named program does not read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from os.path import splitext
from typing import NamedTuple

from robodyn.checks.context import Context
from robodyn.checks.mesh_files import MeshUse, mesh_names
from robodyn.checks.rule import Fault, Rule, Severity, Stage


class Reads(NamedTuple):
    """Suffixes that a program reads, how that is known, and the kinds of shapes for which it is so."""

    suffixes: tuple[str, ...]
    source: str
    kinds: tuple[str, ...] = ("visual", "collision")


READS: Mapping[str, Reads] = {
    "mujoco": Reads((".stl", ".obj", ".msh"), "MuJoCo 4.0, run"),
    "drake": Reads((".obj", ".gltf", ".vtk"), "Drake 1.51, run", ("collision",)),
    "gz": Reads((".stl", ".dae", ".obj", ".gltf", ".glb", ".fbx"), "gz-common 6, MeshManager"),
}


def check(context: Context) -> Iterator[Fault]:
    """Silent unless a target is named."""
    for target in context.asked.targets:
        if target not in READS:
            continue
        for suffix, uses in _refused(context, READS[target]).items():
            count = "1 shape is" if len(uses) == 1 else f"{len(uses)} shapes are"
            yield Fault(
                at=uses[0].at,
                subject=uses[0].link.subject,
                what=f"{target} does not read {suffix or 'files without a suffix'}: {count} refused or left out",
                remedy=f"it reads {' '.join(READS[target].suffixes)} ({READS[target].source})",
            )


def _refused(context: Context, reads: Reads) -> dict[str, list[MeshUse]]:
    """The shapes that a program does not read, by their suffix."""
    refused: dict[str, list[MeshUse]] = {}
    for name in context.once(mesh_names).values():
        suffix = splitext(name.uri)[1].lower()
        uses = [use for use in name.uses if use.geometry.kind in reads.kinds]
        if uses and suffix not in reads.suffixes:
            refused.setdefault(suffix, []).extend(uses)
    return refused


def _named(name: str) -> str:
    return f"""<robot name="part">
  <link name="part">
    <visual><geometry><mesh filename="{name}"/></geometry></visual>
  </link>
</robot>
"""


_KNOWN = "; ".join(
    f"{target}: {' '.join(reads.suffixes)} for {' and '.join(reads.kinds)} ({reads.source})"
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
    bad=_named("part.dae"),
    good=_named("part.stl"),
    check=check,
)
