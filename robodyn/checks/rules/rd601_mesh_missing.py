"""Every mesh is there and can be read.

A mesh that is missing, empty or damaged stops some programs, and leaves others without the shape,
and without a word. `package://` is looked for in --package-path, in ROS_PACKAGE_PATH, in AMENT_PREFIX_PATH, in
COLCON_PREFIX_PATH, in CMAKE_PREFIX_PATH, in the folders above the file, also above the one where a symbolic link leads,
and among the other packages of its workspace or repository. Where none of them is known, as for a file out of its
package, one remark says so for all meshes. Nothing is fetched.
"""

from collections.abc import Iterator

from robodyn.checks.examples import a_shaped_link
from robodyn.checks.meshes.files import MeshName, State, all_facts, mesh_names, mesh_uses
from robodyn.checks.rule import Context, Fault, Faults, Fix, Severity, rule
from robodyn.robot.urdf.packages import package_of
from robodyn.support.wording import count, listed, shown, shown_path


@rule(
    Severity.ERROR,
    good=a_shaped_link(),
    bad=('<box size="0.1 0.1 0.25"/>', "<mesh/>"),
    default=Severity.NOTE,
    explains=("RD603",),
)
def check(context: Context) -> Faults:
    for use in mesh_uses(context):
        if not use.uri:
            yield Fault(use.at, "the mesh names no file", 'write filename="..."')
    names = context.once(mesh_names).values()
    for name in names:
        if name.state is State.MISSING:
            yield _missing(context, name)
        elif name.state is State.REMOTE:
            yield name.fault(
                "is not on this machine", "save it in the package: few programs fetch meshes", Severity.WARNING
            )
    yield from _unknown([name for name in names if name.state is State.UNKNOWN])
    for uri, facts in context.once(all_facts).items():
        name = context.once(mesh_names)[uri]
        if facts.problem is not None and facts.finite:
            yield name.fault(f"cannot be read: {facts.problem}", facts.remedy)


def _missing(context: Context, name: MeshName) -> Fault:
    remedy, fix = "names are relative to this file", None
    package = package_of(name.uri)
    if package is not None and package[0]:
        remedy = f"no such file in the package {shown(package[0])}; or name its folder with --package-path"
    elif package is not None:
        scheme = name.uri.partition("://")[0]
        better = f"{scheme}://{package[1]}"
        remedy = f"the package has no name: write two slashes, {shown_path(better)}"
        fix = _written(context, name, better)
    elif name.uri.startswith(("file://", "/")):
        remedy = "it is a file of one machine: write package://NAME/... or a name relative to this file"
    elif "\\" in name.uri:
        better = name.uri.replace("\\", "/")
        remedy, fix = f"write / between folders: {shown_path(better)}", _written(context, name, better)
    return name.fault("is not there", remedy, fix=fix)


def _written(context: Context, name: MeshName, better: str) -> Fix | None:
    """Return the edit that writes another name, if the mesh is there by that."""
    return None if context.search.find(better) is None else name.renamed(better)


def _unknown(names: list[MeshName]) -> Iterator[Fault]:
    """Yield one remark for all meshes of packages of which nothing is known."""
    if not names:
        return
    packages = [package[0] for name in names if (package := package_of(name.uri)) is not None]
    where = f"of the package {listed(list(dict.fromkeys(packages)))}" if packages else "beside standard input"
    what = f"{count(len(names), 'mesh is', 'meshes are')} not looked at: nothing is known {where}"
    remedy = "say where it is with --package-path" if packages else "check the file by its name"
    yield Fault(names[0].uses[0].at, what, remedy, severity=Severity.NOTE, subject=None)
