"""`robodyn inertia`: what meshes weigh, and how that mass is spread."""

from __future__ import annotations

from typing import Any

import click

from robodyn.cli.files import check_names
from robodyn.cli.options import VECTOR, Vector
from robodyn.cli.screen import page, show
from robodyn.inertia.urdf_text import inertial_element
from robodyn.inertia.view import View
from robodyn.part import mass_properties
from robodyn.report.json_inertia import inertia_json
from robodyn.report.text_inertia import inertia_text


class Point(click.ParamType):  # type: ignore[type-arg,unused-ignore]
    """com, origin, or three numbers between commas."""

    name = "point"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        return value if value in ("com", "origin") else VECTOR.convert(value, param, ctx)


@click.command("inertia")
@click.argument("meshes", nargs=-1, required=True, metavar="MESH...")
@click.option("--density", type=float, metavar="RHO", help="kg/m^3; default 1000, and said.")
@click.option("--mass", type=float, metavar="M", help="kg, in place of a density.")
@click.option("--unit", type=click.Choice(["m", "mm", "cm", "in"]), help="Of the file; default what it says, or m.")
@click.option("--type", "file_type", metavar="TYPE", help="stl, obj, ply and so on; default by the suffix.")
@click.option("--about", type=Point(), default="com", metavar="POINT", help="com (default), origin or X,Y,Z in m.")
@click.option("--rpy", type=VECTOR, default="0,0,0", metavar="R,P,Y", help="Turns the axes; rad.")
@click.option("--shell", type=float, metavar="THICKNESS", help="Take the surface as a sheet of so many metres.")
@click.option("--exact", is_flag=True, help="Integrate in exact arithmetic.")
@click.option("--strict", is_flag=True, help="Refuse a mesh that needs repair.")
@click.option("--repair/--no-repair", default=True, help="--no-repair: the signed integral of the surface as it is.")
@click.option("--format", "form", type=click.Choice(["text", "json", "urdf"]), default="text", help="Default text.")
def command(meshes: tuple[str, ...], about: Any, rpy: Vector, form: str, **how: Any) -> None:
    """Mass, centre of mass and inertia of what each mesh encloses.
    A file named - is standard input.

    \b
    Example:
      robodyn inertia link.stl --unit mm --density 2700 --format urdf
    """
    check_names([*meshes], None)
    view = View(about, rpy)
    parts = [mass_properties(mesh, **how) for mesh in meshes]
    if form == "urdf":
        show("\n".join(inertial_element(part.body, "") for part in parts) + "\n")
    else:
        show(inertia_json(parts, view) if form == "json" else inertia_text(parts, view, page()))
