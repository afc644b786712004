"""`robodyn info`: a robot description at a glance."""

from __future__ import annotations

import sys

import click

from robodyn.cli.files import STANDARD_INPUT, check_names
from robodyn.cli.options import FOLDER, FORMAT, PATH
from robodyn.cli.screen import page, show
from robodyn.overview import overview
from robodyn.report.json_overview import overview_json
from robodyn.report.text_overview import overview_text


@click.command("info", short_help="A robot at a glance: tree, joints, masses, meshes.")
@click.argument("urdf", type=PATH)
@click.option(
    "--package-path", multiple=True, type=FOLDER, metavar="DIR", help="Where package:// names are looked up first."
)
@FORMAT
def command(urdf: str, package_path: tuple[str, ...], form: str) -> None:
    """A robot at a glance: tree, joints, masses, degrees of freedom, meshes, and what to run next.
    A file named - is standard input; a .xacro file is expanded first.

    \b
    Example:
      robodyn info robots/puma.urdf
    """
    check_names([urdf], None)
    found = overview(sys.stdin.buffer.read() if urdf == STANDARD_INPUT else urdf, package_path)
    show(overview_json(found) if form == "json" else overview_text(found, page()))
