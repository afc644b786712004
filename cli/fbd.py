"""`robodyn fbd`: a robot in one state, taken apart into free bodies."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import click

from robodyn.cli.fbd_state import STATE, state_of
from robodyn.cli.files import check_names, robot_in_scene
from robodyn.cli.options import DESCRIPTION, FOLDER, FORMAT, GRAVITY, PATH, SCENE, Vector
from robodyn.cli.reading_options import READING
from robodyn.cli.screen import page, show
from robodyn.equations.free_body.bodies import free_bodies
from robodyn.report.json_free_body import free_bodies_json
from robodyn.report.text_free_body import free_bodies_text


@click.command("fbd", short_help="Free-body diagrams: all forces and moments on each body.")
@click.argument("urdf", type=PATH)
@STATE
@READING
@DESCRIPTION
@SCENE
@GRAVITY
@click.option("--svg", type=FOLDER, metavar="FOLDER", help="Write a drawing of each body there.")
@FORMAT
def command(
    urdf: str, scene_file: str | None, gravity: Vector | None, svg: str | None, form: str, **given: Any
) -> None:
    """Free-body diagrams: all forces and moments on each body, and what each joint transmits.
    The state is given by --at, --qd and --qdd, or is a row of a trajectory.

    \b
    Examples:
      robodyn fbd robots/scara.urdf --at 0.3,-0.5,0.05 --qdd elbow=2
      robodyn fbd robots/puma.urdf --traj robots/puma_reach.csv --time 0.5 --svg drawings
    """
    check_names([urdf, given["traj"], scene_file], None)
    model, scene = robot_in_scene(urdf, scene_file, gravity)
    words, state, warnings = state_of(model, scene, **given)
    found = free_bodies(model, scene=scene, **state)
    found = replace(found, warnings=(*warnings, *found.warnings))
    written = ""
    if svg is not None:
        from robodyn.cli.drawings import write_drawings
        from robodyn.report.svg_free_body import drawings

        written = f"\nwritten: {write_drawings(svg, drawings(found, words))} drawings in {svg}\n"
    show(free_bodies_json(found, words) if form == "json" else free_bodies_text(found, words, page()) + written)
