"""DAE files have the axes that their shapes are drawn with.

A COLLADA file says which of its axes points up. Pinocchio 4.1, trimesh 4, yourdfpy (all run on one box)
and robodyn keep the axes as they are in the file, as RViz and Gazebo do; Blender and other editors turn what is Y_UP by
90 degrees. So a link that stands upright in the editor lies down in the simulator. The examples stand beside the meshes
that they name.
"""

from __future__ import annotations

import re
from pathlib import Path

from robodyn.checks.examples import a_mesh
from robodyn.checks.meshes.files import MeshName, mesh_names
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.support.input_file import open_input
from robodyn.support.wording import count, shown_path

_UP = re.compile(rb"<up_axis>\s*([XY])_UP")
_HEAD = 1 << 14
"""Bytes in which COLLADA files say it."""


@rule(Severity.NOTE, good=a_mesh("z_up.dae", "visual"), bad=("z_up", "y_up"))
def check(context: Context) -> Faults:
    turned = [name for name in context.once(mesh_names).values() if _up(name) is not None]
    if turned:
        first = turned[0]
        more = f" (and {count(len(turned) - 1, 'more mesh', 'more meshes')})" if turned[1:] else ""
        what = f"the mesh {shown_path(first.uri)} says that its {_up(first)} points up{more}: editors turn it"
        remedy = "programs for robots do not: export it with Z up"
        yield Fault(first.uses[0].at, what, remedy, subject=None)


def _up(name: MeshName) -> str | None:
    """Return the axis that points up by a DAE file, if it is not Z."""
    if name.path is None or name.path.suffix.lower() != ".dae":
        return None
    try:
        with open_input(Path(name.path)) as stream:
            found = _UP.search(stream.read(_HEAD))
    except OSError:
        return None
    return None if found is None else found[1].decode()
