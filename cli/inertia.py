"""`robodyn inertia`: what meshes, links and robots weigh, and how that mass is spread."""

from __future__ import annotations

from typing import Any

import click

from robodyn.cli.files import check_names
from robodyn.cli.inertia_options import COMBINE, MESH, ROBOT, VIEW, WEIGHT
from robodyn.cli.options import PATH, ROBOT_SUFFIXES, Vector
from robodyn.cli.reports import REPORT
from robodyn.solids.inertia.conversions import View


@click.command("inertia", short_help="Compute mass and inertia of meshes, links and robots.")
@click.argument("files", nargs=-1, type=PATH, required=True, metavar="MESH...|URDF")
@WEIGHT
@MESH
@COMBINE
@ROBOT
@VIEW
@REPORT
def command(files: tuple[str, ...], about: Any, rpy: Vector, **options: Any) -> int:
    """Compute mass, centre of mass and inertia of what each mesh encloses, of meshes combined, of a link or of a robot.
    A file named - is standard input. A mesh that fails stops no other, and makes the exit status 2.

    \b
    Examples:
      robodyn inertia link.stl --unit mm --density 2700 --format urdf
      robodyn inertia a.stl b.stl --combine --place 0,0,0 --place 0,0,0.1,0,0,1.57
      robodyn inertia robot.urdf --at 0.1,-0.5,0.3
      robodyn inertia robot.urdf --at elbow=0.3 --about origin
      robodyn inertia robot.urdf --link forearm --report forearm.html
      robodyn inertia robot.urdf --link forearm --geometry collision --density 2700 --format urdf
      robodyn inertia robot.urdf --compare --package-path ~/ros/src
    """
    check_names()
    view, ctx = View(about, rpy), click.get_current_context()
    if options["file_type"] == "urdf" or any(name.lower().endswith(ROBOT_SUFFIXES) for name in files):
        from robodyn.cli.inertia_robot import robot

        return robot(files, view, ctx)
    from robodyn.cli.inertia_meshes import meshes

    return meshes(files, view, ctx, **options)
