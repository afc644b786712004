"""Meshes are named within their package.

An absolute path, a `file://` and a name that leads out of the package mean a file of one machine.
The description cannot be installed or shared. A name with \\ between folders is found on Windows alone. Also the
folder with the package.xml above a file is a package.
"""

import os
import re
from pathlib import Path

from robodyn.checks.examples import a_mesh
from robodyn.checks.meshes.files import STDIN, MeshName, State, mesh_names
from robodyn.checks.rule import Context, Faults, Severity, rule
from robodyn.robot.urdf.packages import package_of

_DRIVE = re.compile(r"[A-Za-z]:[\\/]")


@rule(
    Severity.WARNING,
    good=a_mesh("package://part/meshes/part.stl", "visual"),
    bad=a_mesh("package://part/../meshes/part.stl", "visual"),
)
def check(context: Context) -> Faults:
    for name in context.once(mesh_names).values():
        why = _why(context, name)
        if why is not None:
            yield name.fault(why, "write package://NAME/... or a name relative to this file")


def _why(context: Context, name: MeshName) -> str | None:
    uri = name.uri
    if uri.startswith("/") or _DRIVE.match(uri) or uri.startswith("\\\\"):
        return "is an absolute path"
    if uri.startswith("file://"):
        return "is a file:// of this machine"
    package = package_of(uri)
    if package is not None and os.path.normpath(package[1]).startswith(".."):
        return "leads out of its package"
    if package is None and "://" not in uri and _leaves(context, uri):
        return "leads out of this file's package"
    if "\\" in uri and name.state is State.FOUND:
        return "has \\ between folders, which Windows alone reads"
    return None


def _leaves(context: Context, uri: str) -> bool:
    """Return whether a relative name leads out of the package that the file is in, if there is one."""
    root = context.search.home
    if context.reading.file == STDIN or ".." not in uri or root is None:
        return False
    places = [Path(os.path.normpath(folder.absolute() / uri)) for folder in context.search.folders]
    return all(root not in place.parents for place in places)
