"""`robodyn equations`: the equations of motion of a robot, in numbers, in closed form or as C."""

from __future__ import annotations

from typing import Any

import click

from robodyn.cli.equations_dae import dae_report
from robodyn.cli.equations_options import ASKED, check_asked
from robodyn.cli.files import check_names, robot_in_scene
from robodyn.cli.options import DESCRIPTION, GRAVITY, PATH, SCENE, Vector
from robodyn.cli.screen import page, show
from robodyn.equations.c_source import c_source
from robodyn.equations.closed import closed
from robodyn.equations.ode import ode
from robodyn.report.json_equations import closed_json, ode_json
from robodyn.report.latex_equations import closed_latex
from robodyn.report.text_equations import closed_text, ode_text


@click.command("equations", short_help="Equations of motion in numbers, letters, LaTeX or C.")
@click.argument("urdf", type=PATH)
@ASKED
@DESCRIPTION
@SCENE
@GRAVITY
def command(
    urdf: str, form: str, at: Any, qd: Any, tau: Any, output: str, scene_file: str | None, gravity: Vector | None
) -> None:
    """M(q) qdd + bias = tau: in numbers at a configuration, in closed form for small robots, or as C functions; and
    Newton's and Euler's laws of all bodies with constraints and reactions. A file named - is standard input.

    \b
    Examples:
      robodyn equations robots/puma.urdf --at 0.1,-0.5,0.3 --qd waist=1
      robodyn equations robots/two_link_planar.urdf --form closed --format latex
      robodyn equations robots/scara.urdf --form dae --at 0.3,-0.5,0.05 --qd elbow=2
      robodyn equations robots/puma560.urdf --format c > puma560.c
    """
    check_asked(form, output, at=at, qd=qd, tau=tau)
    check_names([urdf, scene_file], None)
    model, scene = robot_in_scene(urdf, scene_file, gravity, loops=form == "dae")
    if output == "c":
        show(c_source(model, scene))
    elif form == "dae":
        show(dae_report(model, scene, at, qd, tau, output))
    elif form == "closed":
        written = {"text": closed_text, "json": closed_json, "latex": closed_latex}[output]
        show(written(closed(model, scene)))
    else:
        found = ode(model, scene, at or (), qd or ())
        show(ode_json(found) if output == "json" else ode_text(found, page()))
