"""The options of `robodyn inertia`, what their values look like, and which of them go together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import click
import numpy as np
from click.core import ParameterSource

from robodyn.cli.options import AT, DESCRIPTION, POINT, POSITIVE, Parsed, finite_numbers, kept, together, vector_type
from robodyn.errors import InputError
from robodyn.programs.vectors import rotation_from_rpy
from robodyn.solids.inertia.conversions import inertial_element
from robodyn.solids.inertia.properties import MassProperties, Pose
from robodyn.support.wording import count

T = TypeVar("T")


def _place(text: str) -> Pose:
    """Return three or six numbers between commas: where a frame stands, and its roll, pitch and yaw."""
    numbers = finite_numbers(text)
    if len(numbers) not in (3, 6):
        raise ValueError(f"{text!r} is not three or six finite numbers between commas, such as 0,0,0.1")
    roll, pitch, yaw = numbers[3:] or (0.0, 0.0, 0.0)
    return rotation_from_rpy(roll, pitch, yaw), np.array(numbers[:3])


VIEW = together(
    click.option("--about", type=POINT, default="com", metavar="POINT", help="com (default), origin or X,Y,Z."),
    click.option("--rpy", type=vector_type("0,0,1.57"), default="0,0,0", metavar="R,P,Y", help="Turns the axes; rad."),
    kept("--format", "form", type=click.Choice(["text", "json", "urdf"]), default="text", help="Default text."),
)
WEIGHT = together(
    click.option(
        "--density", type=float, multiple=True, metavar="RHO", help="kg/m^3, once or for each mesh; default 1000."
    ),
    click.option(
        "--mass",
        type=float,
        multiple=True,
        metavar="M",
        help="kg, once (with --combine: of the whole) or for each mesh.",
    ),
)
MESH = together(
    click.option(
        "--unit",
        type=click.Choice(["m", "mm", "cm", "in"]),
        multiple=True,
        help="Of the file, once or for each; default what it says, or m.",
    ),
    click.option("--type", "file_type", metavar="TYPE", help="stl, obj, ply, urdf and so on; default by the suffix."),
    click.option("--shell", type=float, metavar="THICKNESS", help="Take the surface as a sheet of so many metres."),
    click.option("--exact", is_flag=True, help="Integrate in exact arithmetic."),
    click.option(
        "--accuracy", type=POSITIVE, metavar="E", help="Take the cheapest arithmetic for this relative error."
    ),
    click.option("--strict", is_flag=True, help="Refuse a mesh that needs repair or is doubtful."),
    click.option("--cavities", is_flag=True, help="Shells in others are cavities, however they are wound."),
    click.option("--symmetry/--no-symmetry", default=None, help="Seek planes and axes; default for few triangles."),
    click.option("--symmetrize", is_flag=True, help="Average over the planes and axes that hold."),
    click.option("--tessellation/--no-tessellation", default=None, help="What facets leave out; default for few."),
    click.option(
        "--repair/--no-repair", default=True, help="--no-repair: the signed integral of the surface as it is."
    ),
)
COMBINE = together(
    click.option("--combine", is_flag=True, help="All meshes as one rigid body."),
    click.option(
        "--place",
        type=Parsed("place", _place),
        multiple=True,
        metavar="X,Y,Z[,R,P,Y]",
        help="For each mesh in turn, in m and rad.",
    ),
)
ROBOT = together(
    click.option("--link", metavar="NAME", help="One link, in its own frame."),
    AT,
    click.option("--compare", is_flag=True, help="Declared inertias against the links' shapes."),
    click.option("--geometry", type=click.Choice(["visual", "collision"]), help="Which shapes, also for --link."),
    DESCRIPTION,
)

_LOOKUP = {"package_paths", "xacro_args", "trust_xacro"}
OF_ROBOTS = {"link", "at", "compare", "geometry", *_LOOKUP}
_VIEW = {"about", "rpy", "form", "file_type", "report", *_LOOKUP}
_READING = {"geometry", "exact", "strict", "repair", "cavities"}
_OF_SHAPES = {*_VIEW, *_READING, "link", "density", "mass"}
_USES = {
    "a whole robot": ("a URDF", {*_VIEW, "at"}),
    "a link as declared": ("a URDF with --link NAME", {*_VIEW, "link"}),
    "a link's shapes": ("a URDF with --link NAME --geometry visual", _OF_SHAPES),
    "--compare": ("a URDF with --compare", {*_READING, *_LOOKUP, "compare", "form", "file_type", "report"}),
}
"""Of each use of the command with a robot: how it is called, and which options it has."""


def urdf_lines(body: MassProperties) -> str:
    """Return a body as the <inertial> of a link."""
    return inertial_element(body, "") + "\n"


def one_each(values: Sequence[T], files: Sequence[str], option: str) -> list[T | None]:
    """Return the values of an option for each file, given once for all or once for each."""
    if len(values) in (0, 1):
        return [values[0] if values else None] * len(files)
    if len(values) != len(files):
        what = f"{option} is given {len(values)} times for {count(len(files), 'mesh', 'meshes')}"
        raise InputError(what, remedy="give it once, or once for each mesh")
    return list(values)


def check_use(use: str, ctx: click.Context) -> None:
    """Refuse the options that mean nothing in this use of the command."""
    for option in ctx.command.params:
        name = option.name or ""
        given = isinstance(option, click.Option) and ctx.get_parameter_source(name) is ParameterSource.COMMANDLINE
        if given and not (name in _USES[use][1] if use in _USES else _of_meshes(use, name)):
            raise click.UsageError(f"{_written(option, ctx)} is not for {use}, but for {_calls(name)}", ctx)


def _calls(name: str) -> str:
    """Return with what an option goes."""
    meshes = [] if name in OF_ROBOTS else ["meshes with --combine" if name in ("place", "combine") else "meshes"]
    return " or ".join([*meshes, *(call for call, names in _USES.values() if name in names)])


def _of_meshes(use: str, name: str) -> bool:
    return name not in OF_ROBOTS and (name != "place" or use == "--combine")


def _written(option: click.Parameter, ctx: click.Context) -> str:
    return (option.secondary_opts if ctx.params.get(option.name or "") is False else option.opts)[0]
