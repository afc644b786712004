"""`robodyn info`: a robot description at a glance."""

from __future__ import annotations

import click

from robodyn.checks.overview import overview
from robodyn.cli.files import check_names, robot_source
from robodyn.cli.options import DESCRIPTION, FORMAT, PATH, Call, takes
from robodyn.cli.screen import answer
from robodyn.report.check import overview_json, overview_sections


@click.command("info", short_help="Show a robot at a glance: tree, joints, masses, meshes.")
@click.argument("urdf", type=PATH)
@takes(DESCRIPTION, FORMAT)
def command(call: Call, urdf: str) -> None:
    """Show a robot at a glance: tree, joints, masses, degrees of freedom, meshes, and what to run next.
    A file named - is standard input; a .xacro file is expanded first.

    \b
    Example:
      robodyn info robots/puma.urdf
    """
    check_names()
    found = overview(robot_source(urdf), **call.lookup)
    answer(call, overview_sections(found), json=lambda: overview_json(found))
