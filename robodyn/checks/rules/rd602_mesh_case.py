"""RD602: a mesh named in another case than its file."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import a_mesh
from robodyn.checks.mesh_files import State, mesh_names
from robodyn.checks.rule import Fault, Rule, Severity, Stage


def check(context: Context) -> Iterator[Fault]:
    for name in context.once(mesh_names).values():
        if name.state is not State.OTHER_CASE or name.found is None:
            continue
        fix = name.renamed(name.found)
        yield name.fault("is there in another case", fix.what, fix=fix)


RULE = Rule(
    code="RD602",
    name="mesh-case",
    severity=Severity.E,
    stage=Stage.DOCUMENT,
    summary="Meshes are named in the case that their files have.",
    explanation="""Windows and macOS find a mesh whose name differs in case, Linux does not: the description works for
its author and for nobody else. The examples stand beside a file `part.stl`.""",
    bad=a_mesh("Part.STL", "visual"),
    good=a_mesh("part.stl", "visual"),
    check=check,
)
