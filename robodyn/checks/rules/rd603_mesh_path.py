"""RD603: a mesh at a place that other machines do not have."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path

from robodyn.checks.context import Context
from robodyn.checks.examples import a_mesh
from robodyn.checks.mesh_files import STDIN, MeshName, State, mesh_names, package_of
from robodyn.checks.rule import Fault, Rule, Severity, Stage

_DRIVE = re.compile(r"[A-Za-z]:[\\/]")


def check(context: Context) -> Iterator[Fault]:
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
    if package is None and "://" not in uri and _leaves(context.reading.file, uri):
        return "leads out of this file's package"
    if "\\" in uri and name.state is State.FOUND:
        return "has \\ between folders, which Windows alone reads"
    return None


def _leaves(file: str, uri: str) -> bool:
    """Whether a relative name leads out of the folder with the package.xml above the file, if there is one."""
    if file == STDIN or ".." not in uri:
        return False
    folder = Path(os.path.abspath(file)).parent
    root = next((path for path in (folder, *folder.parents) if (path / "package.xml").is_file()), None)
    return root is not None and root not in Path(os.path.normpath(folder / uri)).parents


RULE = Rule(
    code="RD603",
    name="mesh-path",
    severity=Severity.W,
    stage=Stage.DOCUMENT,
    summary="Meshes are named within their package.",
    explanation="""An absolute path, a `file://` and a name that leads out of the package mean a file of one machine.
The description cannot be installed or shared. A name with \\ between folders is found on Windows alone. Also the
folder with the package.xml above a file is a package.""",
    bad=a_mesh("package://part/../meshes/part.stl", "visual"),
    good=a_mesh("package://part/meshes/part.stl", "visual"),
    check=check,
)
