"""Files of meshes: there, closed, in metres, in a format that is read."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from robodyn.checks.context import STDIN
from robodyn.checks.examples import a_joint, a_link, a_mesh, a_shaped_link, arm
from robodyn.checks.importers import READS, unread
from robodyn.checks.meshes.files import MeshFacts, MeshName, all_facts, mesh_names, mesh_slips, mesh_uses
from robodyn.checks.rule import ERROR, NOTE, WARNING, Context, Fault, Faults, Fix, Severity, rule
from robodyn.robot.urdf.sources import EXPANDED, home_of, package_name, package_of
from robodyn.robot.urdf.view import value_span
from robodyn.support.input_file import open_input
from robodyn.support.wording import alternatives, count, figure, nearest, shown, shown_path


@rule(
    "RD601",
    ERROR,
    good=a_shaped_link(),
    bad=('<box size="0.1 0.1 0.25"/>', "<mesh/>"),
    default=NOTE,
    explains=("RD603",),
)
def mesh_missing(context: Context) -> Faults:
    """Every mesh is there and can be read.

    A mesh that is missing, empty or damaged stops some programs, and leaves others without the shape. `package://` is
    looked for in --package-path, in ROS_PACKAGE_PATH, in AMENT_PREFIX_PATH, in COLCON_PREFIX_PATH, in
    CMAKE_PREFIX_PATH, in the folders above the file, also above the one where a symbolic link leads, and among the
    other packages of its workspace or repository; then the rest of the name is tried in the folders above. A package of
    which nothing is known is a warning, once for all its meshes that are not found; an error where the file's own
    package or one beside it has a name that differs by a slip. Nothing is fetched."""
    for use in mesh_uses(context):
        if not use.geometry.uri:
            yield Fault(use.at, "the mesh names no file", 'write filename="..."')
    names = context.once(mesh_names).values()
    for name in names:
        if name.state == "not there":
            yield _missing(context, name)
        elif name.state == "on another machine":
            remedy = "save it in the package: few programs fetch meshes"
            yield name.fault("is not on this machine", remedy, WARNING)
    yield from _of_strange_packages(context)
    for uri, facts in context.once(all_facts).items():
        name = context.once(mesh_names)[uri]
        if facts.problem is not None and facts.finite:
            yield name.fault(f"cannot be read: {facts.problem}", facts.remedy)


def _of_strange_packages(context: Context) -> Faults:
    """The names in packages of which nothing is known: a fault for each that is meant by another, or hides a mesh."""
    strange: dict[str, list[MeshName]] = {}
    for name in context.once(mesh_names).values():
        package = package_of(name.uri)
        known = package is None or not package[0] or context.search.share(package[0]) is not None
        if name.state == "in an unknown package" or (name.path is not None and not known):
            strange.setdefault("" if package is None else package[0], []).append(name)
    neighbours = context.search.neighbours if strange else []
    for stranger, names in strange.items():
        at, unseen = names[0].uses[0].at, [name for name in names if name.path is None]
        unknown = f"nothing is known of the package {shown(stranger)}"
        meant = _misspelt(stranger, neighbours)
        if meant is not None:
            renamed = [name.renamed(name.uri.replace(stranger, meant, 1)) for name in names]
            fix = Fix(f"write package://{meant}/", tuple(edit for one in renamed for edit in one.edits), safe=True)
            there = all(context.search.find(name.uri.replace(stranger, meant, 1)) is not None for name in names)
            remedy = f"did you mean {shown(meant)}?"
            yield Fault(at, unknown, remedy, subject=None, fix=fix if there else None)
        elif stranger and unseen:
            what = f"{count(len(unseen), 'mesh is', 'meshes are')} not looked at: {unknown}"
            near = nearest(stranger, neighbours)
            remedies = [alternatives(stranger, near, "packages")] if near else []
            remedy = " ".join([*remedies, "say where it is with --package-path"])
            yield Fault(at, what, remedy, severity=WARNING, subject=None)
        elif unseen:
            many = count(len(unseen), "mesh is", "meshes are")
            what = f"{many} not looked at: nothing is known beside standard input"
            yield Fault(at, what, "check the file by its name", severity=NOTE, subject=None)


def _misspelt(package: str, others: Sequence[str]) -> str | None:
    """The package that a name is a slip of: ur5_description is none of ur3_description."""
    from difflib import get_close_matches

    digits = re.findall(r"\d", package)
    return next((one for one in get_close_matches(package, others, 3, 0.9) if re.findall(r"\d", one) == digits), None)


def _missing(context: Context, name: MeshName) -> Fault:
    remedy, better = "names are relative to this file", None
    package = package_of(name.uri)
    if package is not None and package[0]:
        remedy = f"no such file in the package {shown(package[0])}; or name its folder with --package-path"
    elif package is not None:
        better = f"{name.uri.partition('://')[0]}://{package[1]}"
        remedy = f"the package has no name: write two slashes, {shown_path(better)}"
    elif name.uri.startswith(("file://", "/")):
        remedy = "it is a file of one machine: write package://NAME/... or a name relative to this file"
    elif "\\" in name.uri:
        better = name.uri.replace("\\", "/")
        remedy = f"write / between folders: {shown_path(better)}"
    there = better is not None and context.search.find(better) is not None
    return name.fault("is not there", remedy, fix=name.renamed(better) if better and there else None)


@rule("RD602", ERROR, good=a_mesh("part.stl", "visual"), bad=("part.stl", "Part.STL"))
def mesh_case(context: Context) -> Faults:
    """Meshes are named in the case that their files have.

    Windows and macOS find a mesh whose name differs in case, Linux does not: the description works for its author and
    for nobody else. The examples stand beside a file `part.stl`."""
    for name in context.once(mesh_names).values():
        if name.state != "there in another case" or name.found is None:
            continue
        fix = name.renamed(name.found)
        yield name.fault("is there in another case", fix.what, fix=fix)


_DRIVE = re.compile(r"[A-Za-z]:[\\/]")


@rule(
    "RD603",
    WARNING,
    good=a_mesh("package://part/meshes/part.stl", "visual"),
    bad=a_mesh("package://part/../meshes/part.stl", "visual"),
)
def mesh_path(context: Context) -> Faults:
    r"""Meshes are named within their package.

    An absolute path, a `file://` and a name that leads out of the package, which is also the folder with the
    package.xml above a file, mean a file of one machine. Most programs find none that is relative to the package or a
    folder above the file, or whose package has another name. A name with \ between folders is found on Windows alone.
    """
    for name in context.once(mesh_names).values():
        if (why := _why(context, name)) is not None:
            yield name.fault(why, "write package://NAME/... or a name relative to this file")


def _why(context: Context, name: MeshName) -> str | None:
    uri, root = name.uri, context.search.home
    if uri.startswith("/") or _DRIVE.match(uri) or uri.startswith("\\\\"):
        return "is an absolute path"
    if uri.startswith("file://"):
        return "is a file:// of this machine"
    package = package_of(uri)
    if package is not None and os.path.normpath(package[1]).startswith(".."):
        return "leads out of its package"
    if package is None and "://" not in uri and ".." in uri and root and context.reading.file != STDIN:
        places = [Path(os.path.normpath(folder.absolute() / uri)) for folder in context.search.folders]
        if all(root not in place.parents for place in places):
            return "leads out of this file's package"
    if name.state != "there":
        return None
    return "has \\ between folders, which Windows alone reads" if "\\" in uri else _found_elsewhere(context, name)


def _found_elsewhere(context: Context, name: MeshName) -> str | None:
    """Why most programs do not find a mesh that is there: it is of another package, or beside another folder."""
    package, search = package_of(name.uri), context.search
    assert name.path is not None, "it is found"
    if package is not None and package[0] and search.share(package[0]) is None:
        holder = home_of(*name.path.parents)
        called = None if holder is None else package_name(holder)
        known = called and _misspelt(package[0], search.neighbours) is None
        return f"names the package {shown(package[0])}, but is in the package {shown(called or '')}" if known else None
    relative = "://" not in name.uri and not os.path.isabs(name.uri) and context.reading.file != STDIN
    if not relative or context.reading.file.endswith(EXPANDED):
        return None
    around = [folder for folder in search.around if name.path == folder / name.uri]
    if not around or name.path in {folder / name.uri for folder in search.folders}:
        return None
    return f"is not relative to this file's folder, but to {shown_path(os.path.relpath(around[0], search.folders[0]))}"


_REMEDY = "repair it where mass, collision or simulation is computed from it; `robodyn inertia` says what to do"


@rule("RD604", WARNING, good=a_mesh("closed.stl"), bad=("closed", "open"))
def mesh_surface(context: Context) -> Faults:
    """Meshes are closed, wound outwards, free of overlaps, and their coordinates are numbers.

    Mass and signed distance need a surface that encloses a volume. Reported are coordinates that are no numbers; shells
    wound inwards that are no cavities; STL files that hold more triangles than their header counts; surfaces with one
    side only; faces wound against their neighbours; open edges, by the boundary chain; and shells that reach into
    another, as far as a few points of each show. The last is a remark; the three before it are a warning where a link
    takes its mass from the mesh, being a <collision> of one without <inertial>, and remarks otherwise. Of an open
    surface it is said, with the numbers that `robodyn inertia` goes by, whether its gaps are small enough to be filled,
    a remark then, or what is missing. The examples stand beside `open.stl`, a box without lid, and `closed.stl`."""
    for uri, facts in context.once(all_facts).items():
        name = context.once(mesh_names)[uri]
        found = _wrong(facts, name)
        if found is not None and name.state != "there in another case":
            yield name.fault(found[0], _REMEDY, found[1])


def _wrong(facts: MeshFacts, name: MeshName) -> tuple[str, Severity] | None:
    gives_mass = any(use.geometry.kind == "collision" and use.link.inertial is None for use in name.uses)
    severity, is_open = WARNING if gives_mass else NOTE, not facts.closed and facts.problem is None
    inverted = "is inside out" if facts.volume < 0 else f"has {facts.inverted} shells that are inside out"
    missing = f"is not closed: {figure(100 * facts.missing, 2)} % of its surface is missing"
    said = (
        (not facts.finite, WARNING, f"has a coordinate that is no number: {facts.problem}"),
        (facts.inverted, WARNING, inverted),
        (facts.doubt, WARNING, f"may not be whole: {facts.doubt}"),
        (facts.one_sided, severity, f"has {facts.one_sided} faces in surfaces with one side only: it encloses nothing"),
        (facts.mixed, severity, "has faces wound against their neighbours"),
        (is_open and facts.left, severity, f"{missing}, in gaps that are too large to be filled"),
        (is_open and facts.mended is None, severity, "is not closed"),
        (is_open and facts.mended, NOTE, f"is open by small gaps only ({facts.mended}): filled, it encloses a volume"),
        (is_open, NOTE, "is closed but for faces without area, or given twice"),
        (facts.overlapping, NOTE, "has shells that overlap: what they share counts twice where they are not united"),
    )
    return next(((what, how_bad) for holds, how_bad, what in said if holds), None)


_MESH = '<mesh filename="millimetres.stl" scale="0.001 0.001 0.001"/>'
_SCALED = arm('<origin xyz="0 0 0.3"/>', "fixed", a_link("part", "", f"<visual><geometry>{_MESH}</geometry></visual>"))
_SCALED = _SCALED.replace(
    "\n</robot>", a_joint("mount", "upper", "part", '<origin xyz="0 0 0.3"/>', "fixed") + "\n</robot>"
)


@rule("RD605", ERROR, good=_SCALED, bad=("0.001 0.001 0.001", "1 1 1"))
def mesh_unit(context: Context) -> Faults:
    """Meshes have the size of their robot.

    STL and OBJ have no unit, URDF reads them as metres, and CAD writes millimetres. A mesh longer than 20 m and 20
    times the longest distance between joints; or shorter than 1 mm in a robot 100 times as large; or about 1000 times
    larger or smaller than the link's other mesh; or with factors that differ by 1000 between axes, or of 1000 for a
    file that is not there, has the wrong unit; a flat one of more than 20 m is a floor. The other rules leave it out.
    The examples stand beside a file `millimetres.stl` of a part 200 mm long."""
    reported = set()
    for geometry, slip in context.once(mesh_slips).items():
        assert geometry.shape is not None, "it is a mesh"
        scale = geometry.shape.get("scale")
        if (slip.name.uri, scale) in reported:
            continue
        reported.add((slip.name.uri, scale))
        what = f"the mesh {shown_path(slip.name.uri)} has the wrong unit: {slip.how}"
        at = value_span(geometry.shape, "filename" if scale is None else "scale")
        remedy = "if the file is in metres, leave the scale out; otherwise multiply it by 1000"
        if slip.factor > 1:
            remedy = 'if the file is in millimetres, write scale="0.001 0.001 0.001"'
        yield Fault(at, what, remedy, slip.longest, slip.longest / slip.factor)


_KNOWN = "; ".join(
    f"{target}: {' '.join(reads.suffixes)} for {' and '.join(reads.kinds)}, and {reads.otherwise} otherwise"
    f" ({reads.source})"
    for target, reads in READS.items()
)


@rule(
    "RD607",
    NOTE,
    explanation=f"""With a target named, formats of meshes that it does not read are reported, once each. They read
{_KNOWN}. The examples stand beside the meshes that they name, and are checked for mujoco.""",
    good=a_mesh("part.stl"),
    bad=("stl", "dae"),
)
def mesh_format(context: Context) -> Faults:
    """The programs that a description is meant for read its meshes."""
    for target in context.asked.targets:
        for suffix, uses in unread(context, target).items():
            reads = READS[target]
            named = count(len(uses), "shape has one", "shapes have one")
            what = f"{target} does not read {suffix or 'files without a suffix'} and {reads.otherwise}: {named}"
            yield Fault(uses[0].at, what, f"it reads {' '.join(reads.suffixes)} ({reads.source})")


_UP = re.compile(rb"<up_axis>\s*([XY])_UP")
_HEAD = 1 << 14  # bytes in which COLLADA files say it


@rule("RD624", NOTE, good=a_mesh("z_up.dae", "visual"), bad=("z_up", "y_up"))
def axis_up(context: Context) -> Faults:
    """DAE files have the axes that their shapes are drawn with.

    A COLLADA file says which of its axes points up. Pinocchio, trimesh, yourdfpy and robodyn keep the axes as they are
    in the file, as RViz and Gazebo do; Blender and other editors turn what is Y_UP by 90 degrees. So a link that stands
    upright in the editor lies down in the simulator. The examples stand beside the meshes that they name."""
    turned = []
    for name in context.once(mesh_names).values():
        if name.path is not None and name.path.suffix.lower() == ".dae":
            with suppress(OSError), open_input(Path(name.path)) as stream:
                if (found := _UP.search(stream.read(_HEAD))) is not None:
                    turned.append((name, found[1].decode()))
    if turned:
        first, up = turned[0]
        more = f" (and {count(len(turned) - 1, 'more mesh', 'more meshes')})" if turned[1:] else ""
        what = f"the mesh {shown_path(first.uri)} says that its {up} points up{more}: editors turn it"
        remedy = "programs for robots do not: export it with Z up"
        yield Fault(first.uses[0].at, what, remedy, subject=None)
