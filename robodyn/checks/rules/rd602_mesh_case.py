"""RD602: a mesh named in another case than its file."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.mesh_files import State, mesh_names
from robodyn.checks.rule import Edit, Fault, Fix, Rule, Severity, Stage
from robodyn.wording import shown_path


def check(context: Context) -> Iterator[Fault]:
    for name in context.once(mesh_names).values():
        if name.state is not State.OTHER_CASE or name.found is None:
            continue
        use = name.uses[0]
        edits = tuple(Edit(use.at.start, use.at.end, name.found) for use in name.uses)
        yield Fault(
            at=use.at,
            subject=use.link.subject,
            what=f"the mesh {shown_path(name.uri)} is there in another case{name.others}",
            remedy=f"write {shown_path(name.found)}",
            fix=Fix("the name of the mesh as the file has it", edits, safe=True),
        )


def _named(name: str) -> str:
    return f"""<robot name="part">
  <link name="part">
    <visual><geometry><mesh filename="{name}"/></geometry></visual>
  </link>
</robot>
"""


RULE = Rule(
    code="RD602",
    name="mesh-case",
    severity=Severity.E,
    stage=Stage.DOCUMENT,
    summary="Meshes are named in the case that their files have.",
    explanation="""Windows and macOS find a mesh whose name differs in case, Linux does not: the description works for
its author and for nobody else. The examples stand beside a file `part.stl`.""",
    bad=_named("Part.STL"),
    good=_named("part.stl"),
    check=check,
)
