"""Meshes are named in the case that their files have.

Windows and macOS find a mesh whose name differs in case, Linux does not: the description works for
its author and for nobody else. The examples stand beside a file `part.stl`.
"""

from robodyn.checks.examples import a_mesh
from robodyn.checks.meshes.files import State, mesh_names
from robodyn.checks.rule import Context, Faults, Severity, rule


@rule(Severity.ERROR, good=a_mesh("part.stl", "visual"), bad=("part.stl", "Part.STL"))
def check(context: Context) -> Faults:
    for name in context.once(mesh_names).values():
        if name.state is not State.OTHER_CASE or name.found is None:
            continue
        fix = name.renamed(name.found)
        yield name.fault("is there in another case", fix.what, fix=fix)
