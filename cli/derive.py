"""`robodyn derive`: the worked solution of a robot's dynamics, step by step."""

from __future__ import annotations

from typing import Any

import click

from robodyn.cli.equations import SYMBOLS, letters_of
from robodyn.cli.files import check_names, robot_in_scene
from robodyn.cli.options import AT, PATH, QD, SCENE, VALUES, Call, option, takes
from robodyn.cli.screen import answer, show_file
from robodyn.equations.derive import derive
from robodyn.report.equations.derive import derive_latex, derive_page, derive_sections


@click.command("derive", short_help="Work out the equations of motion step by step.")
@click.argument("urdf", type=PATH)
@takes(
    AT,
    QD,
    option("--qdd QDD", "Accelerations, likewise; default none.", VALUES),
    SYMBOLS,
    option("--format", "Default text.", ("text", "latex", "html"), "form", default="text"),
    SCENE,
)
def command(call: Call, urdf: str, qdd: Any, symbols: tuple[str, ...] | None, assume: tuple[str, ...]) -> None:
    """Work out the dynamics by Newton and Euler: frames, velocities, accelerations, momenta, free bodies, Euler's laws,
    the differential-algebraic equations, elimination, drives, the ordinary differential equations, and the same by the
    recursive order formulation. As formulas up to six joints, in numbers with --at.

    \b
    Examples:
      robodyn derive robots/two_link_planar.urdf --symbols
      robodyn derive robots/puma.urdf --at 0.1,-0.5,0.3 --qd waist=1
      robodyn derive robots/scara.urdf --format html > scara.html
    """
    check_names()
    model, scene = robot_in_scene(call, urdf, loops=True)
    found = derive(model, scene, call.at, call.qd, qdd, *letters_of(symbols, assume))
    if call.form == "html":
        from robodyn.report.renderers.pages import html

        show_file(html(derive_page(found)))
    else:
        answer(call, derive_sections(found), latex=lambda: derive_latex(found))
