"""`robodyn inertia`: what meshes, links and robots weigh, and how that mass is spread."""

from __future__ import annotations

from collections.abc import Sequence
from os.path import isfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click
import numpy as np
from click.core import ParameterSource

from robodyn.cli import options
from robodyn.cli.files import STANDARD_INPUT, check_names
from robodyn.cli.options import (
    PATH,
    POSITIVE,
    Call,
    Parsed,
    finite_numbers,
    option,
    refuse,
    refuse_where,
    takes,
    vector_type,
)
from robodyn.cli.progress import counted
from robodyn.cli.screen import answer, complain
from robodyn.errors import InputError, MeshError
from robodyn.programs.vectors import rotation_from_rpy
from robodyn.report.document import Document
from robodyn.solids.inertia.properties import Pose, View, inertial_element
from robodyn.solids.mass_properties import Part, combined, mass_properties
from robodyn.support.floats import Floats
from robodyn.support.wording import count

if TYPE_CHECKING:
    from robodyn.robot.urdf.parts import Kind

T = TypeVar("T")


def _place(text: str) -> Pose:
    numbers = finite_numbers(text)
    if len(numbers) not in (3, 6):
        raise ValueError(f"{text!r} is not three or six finite numbers between commas, such as 0,0,0.1")
    roll, pitch, yaw = numbers[3:] or (0.0, 0.0, 0.0)
    return rotation_from_rpy(roll, pitch, yaw), np.array(numbers[:3])


_LOOKUP = {"package_paths", "xacro_args", "trust_xacro"}
_OF_ROBOTS = {"link", "at", "compare", "geometry", *_LOOKUP}
_OF_ROBOTS |= {"qd", "links", "frame", "terms", "momentum", "symbols", "moving_base"}
_VIEW = {"about", "rpy", "form", "file_type", "report", *_LOOKUP}
_READING = {"geometry", "exact", "strict", "repair", "cavities"}
_OF_SHAPES = {*_VIEW, *_READING, "link", "density", "mass"}
_USES = {
    "a whole robot": ("a URDF", {*_VIEW, "at", "qd", "links", "frame", "terms", "momentum"}),
    "letters": (
        "a URDF",
        {*_VIEW, "symbols", "links", "frame", "terms", "momentum", "moving_base"} - {"report"},
    ),
    "a link as declared": ("a URDF with --link NAME", {*_VIEW, "link"}),
    "a link's shapes": ("a URDF with --link NAME --geometry visual", _OF_SHAPES),
    "--compare": ("a URDF with --compare", {*_READING, *_LOOKUP, "compare", "form", "file_type", "report"}),
}
"""Of each use of the command with a robot: how it is called, and which options it has."""


@click.command("inertia", short_help="Compute mass and inertia of meshes, links and robots.")
@click.argument("files", nargs=-1, type=PATH, required=True, metavar="MESH...|URDF")
@takes(
    option("--density RHO*", "kg/m^3, once or for each mesh; default 1000.", float),
    option("--mass M*", "kg, once (with --combine: of the whole) or for each mesh.", float),
    option(
        "--unit", "Of the file, once or for each; default what it says, or m.", ("m", "mm", "cm", "in"), multiple=True
    ),
    option("--type TYPE", "stl, obj, ply, urdf and so on; default by the suffix.", name="file_type"),
    option("--shell THICKNESS", "Take the surface as a sheet of so many metres.", float),
    option("--exact", "Integrate in exact arithmetic."),
    option("--accuracy E", "Take the cheapest arithmetic for this relative error.", POSITIVE),
    option("--strict", "Refuse a mesh that needs repair or is doubtful."),
    option("--cavities", "Shells in others are cavities, however they are wound."),
    option("--symmetry/--no-symmetry", "Seek planes and axes; default for few triangles.", default=None),
    option("--symmetrize", "Average over the planes and axes that hold."),
    option("--tessellation/--no-tessellation", "What facets leave out; default for few.", default=None),
    option("--repair/--no-repair", "--no-repair: the signed integral of the surface as it is.", default=True),
    option("--combine", "All meshes as one rigid body."),
    option("--place X,Y,Z[,R,P,Y]*", "For each mesh in turn, in m and rad.", Parsed("place", _place)),
    option("--link NAME", "One link, in its own frame."),
    options.AT,
    option("--links A,B,C", "Some links as one body.", options.NAMES),
    option("--frame LINK", "Whose frame; default base (or ground).", default="base"),
    option("--terms", "Each link's share, by rotation law and parallel axis theorem."),
    option("--momentum", "Linear momentum, and angular about the point, at --qd."),
    options.QD,
    options.SYMBOLS,
    option("--moving-base", "With --symbols --momentum: the base moves, at w and v in its axes."),
    option("--compare", "Declared inertias against the links' shapes."),
    option("--geometry", "Which shapes, also for --link.", ("visual", "collision")),
    options.DESCRIPTION,
    option("--about POINT", "com (default), origin or X,Y,Z.", options.POINT, default="com"),
    option("--rpy R,P,Y", "Turns the axes; rad.", vector_type("0,0,1.57"), default="0,0,0"),
    option(
        "--format", "Default text; latex with --symbols.", ("text", "json", "urdf", "latex"), "form", default="text"
    ),
    options.REPORT,
)
def command(
    call: Call,
    files: tuple[str, ...],
    density: tuple[float, ...],
    mass: tuple[float, ...],
    unit: tuple[str, ...],
    file_type: str | None,
    shell: float | None,
    exact: bool,
    strict: bool,
    cavities: bool,
    symmetry: bool | None,
    symmetrize: bool,
    tessellation: bool | None,
    repair: bool,
    combine: bool,
    place: tuple[Pose, ...],
    link: str | None,
    links: tuple[str, ...] | None,
    frame: str,
    terms: bool,
    momentum: bool,
    symbols: tuple[str, ...] | None,
    moving_base: bool,
    compare: bool,
    geometry: Kind | None,
    about: Any,
    rpy: options.Vector,
) -> int:
    """Compute mass, centre of mass and inertia of what each mesh encloses, of meshes combined, of a link or of a robot.
    A file named - is standard input. A mesh that fails stops no other, and makes the exit status 2.

    \b
    Examples:
      robodyn inertia link.stl --unit mm --density 2700 --format urdf
      robodyn inertia a.stl b.stl --combine --place 0,0,0 --place 0,0,0.1,0,0,1.57
      robodyn inertia robot.urdf --at 0.1,-0.5,0.3
      robodyn inertia robot.urdf --at elbow=0.3 --links arm,hand --about origin --frame arm --terms
      robodyn inertia robot.urdf --symbols --about origin --format latex
      robodyn inertia robot.urdf --link forearm --report forearm.html
      robodyn inertia robot.urdf --link forearm --geometry collision --density 2700 --format urdf
      robodyn inertia robot.urdf --compare --package-path ~/ros/src
    """
    check_names()
    refuse_where(
        (call.form == "latex" and symbols is None, "--format latex is for a URDF with --symbols"),
        (call.form == "urdf" and symbols is not None, "--format urdf is for numbers, without --symbols"),
        (call.qd and not momentum, "--qd is for --momentum"),
        (moving_base and not momentum, "--moving-base is for --symbols --momentum"),
    )
    view = View(about, rpy)
    if file_type == "urdf" or any(name.lower().endswith(options.ROBOT_SUFFIXES) for name in files):
        from robodyn.cli.inertia_robot import compared, one_link, robot
        from robodyn.robot.masses.shapes import How

        of_robot, of_link = ("a whole robot", "letters"), ("a link as declared", "a link's shapes")
        use = of_robot[symbols is not None] if link is None else of_link[geometry is not None]
        check_use("--compare" if compare else use)
        if len(files) > 1:
            refuse("a URDF stands alone: one robot at a time, and no meshes beside it")
        how = How(exact=exact, repair=repair, strict=strict, cavities=cavities)
        if compare:
            return compared(call, files[0], geometry or "visual", how)
        if link is not None:
            rho, m = one_each(density, files, "--density")[0], one_each(mass, files, "--mass")[0]
            return one_link(call, files[0], view, link, geometry, rho, m, how)
        where = "base" if frame == "ground" else frame
        return robot(call, files[0], view, symbols, links or (), where, terms, momentum, moving_base)
    check_use("--combine" if combine else "meshes one by one")
    if combine or call.form == "urdf":
        symmetry, tessellation = symmetry or False, tessellation or False
    whole = mass[0] if combine and len(mass) == 1 else None
    if whole is not None and density:
        raise InputError("both a density and a mass are given", remedy="give one of them")
    units = one_each(unit, files, "--unit")
    densities, masses = one_each(density, files, "--density"), one_each(() if whole else mass, files, "--mass")
    settings = {"file_type": file_type, "shell": shell, "strict": strict, "cavities": cavities, "repair": repair}
    settings |= {"symmetry": symmetry, "symmetrize": symmetrize, "tessellation": tessellation, "exact": exact}
    outcomes = _measured(list(zip(files, densities, masses, units, strict=True)), call.accuracy, settings)
    parts = [each for each in outcomes if isinstance(each, Part)]
    for each in outcomes:
        if isinstance(each, MeshError):
            complain(each)
    failed = len(parts) < len(outcomes)
    if failed and (combine or len(files) == 1):
        return 2

    from robodyn.report.inertia import combination_sections, inertia_sections

    together = combined(parts, place, whole) if combine else None

    def document(pictures: bool) -> Document:
        from robodyn.report.inertia_pages import combination_page, parts_page
        from robodyn.solids.mesh.read.load import load_triangles

        shapes: list[Floats | None] = []  # none where they are not wanted or cannot be read a second time
        for name, of_file, part in zip(files, units, outcomes, strict=True):
            if isinstance(part, Part):
                triangles = None
                if pictures and name != STANDARD_INPUT and isfile(name):
                    triangles = load_triangles(name, file_type=file_type, unit=of_file)
                shapes.append(None if triangles is None else triangles.array() * triangles.scale)
        return combination_page(together, view, shapes) if together else parts_page(outcomes, view, shapes)

    def json() -> str:
        from robodyn.report.inertia_pages import combination_json, inertia_json

        return combination_json(together, view) if together else inertia_json(outcomes, view)

    def urdf() -> str:  # a comment stands for a part that there is not
        bodies = [together] if together else outcomes
        return "".join(
            f"<!-- {str(each).replace('--', '- -')} -->\n"
            if isinstance(each, MeshError)
            else inertial_element(each.body) + "\n"
            for each in bodies
        )

    sections = combination_sections(together, view) if together else inertia_sections(parts, view)
    answer(call, sections, document if parts else None, json=json, urdf=urdf)
    return 2 if failed else 0


def one_each(values: Sequence[T], files: Sequence[str], option: str) -> list[T | None]:
    """Return the values of an option for each file, given once for all or once for each."""
    if len(values) in (0, 1):
        return [values[0] if values else None] * len(files)
    if len(values) != len(files):
        what = f"{option} is given {len(values)} times for {count(len(files), 'mesh', 'meshes')}"
        raise InputError(what, remedy="give it once, or once for each mesh")
    return list(values)


def _measured(
    rows: Sequence[tuple[str, float | None, float | None, str | None]], accuracy: float | None, how: dict[str, Any]
) -> list[Part | MeshError]:
    if accuracy is not None:
        from robodyn.measure.accuracy.meshes import needs_rationals, with_promise

        how["exact"] |= needs_rationals(accuracy)
    outcomes: list[Part | MeshError] = []
    with counted([Path(name) for name, *_ in rows]) as done:
        for name, rho, m, unit in rows:
            try:
                part = mass_properties(name, density=rho, mass=m, unit=unit, **how)
                outcomes.append(part if accuracy is None else with_promise(part, accuracy))
            except MeshError as error:
                outcomes.append(error)
            done()
    return outcomes


def check_use(use: str) -> None:
    """Refuse the options that mean nothing in this use of the command."""
    ctx = click.get_current_context()
    for each in ctx.command.params:
        name = each.name or ""
        if not isinstance(each, click.Option) or ctx.get_parameter_source(name) is not ParameterSource.COMMANDLINE:
            continue
        of_meshes = name not in _OF_ROBOTS and (name != "place" or use == "--combine")
        if not (name in _USES[use][1] if use in _USES else of_meshes):
            written = (each.secondary_opts if ctx.params.get(name) is False else each.opts)[0]
            meshes = [] if name in _OF_ROBOTS else [f"meshes{' with --combine' * (name in ('place', 'combine'))}"]
            others = dict.fromkeys(call for call, names in _USES.values() if name in names)
            refuse(f"{written} is not for {use}, but for {' or '.join([*meshes, *others])}")
