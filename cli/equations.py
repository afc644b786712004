"""`robodyn equations`: the equations of motion of a robot, in numbers, or in closed form."""

from __future__ import annotations

from typing import Any

import click

from robodyn.cli.files import check_names, robot_in_scene
from robodyn.cli.options import AT, PATH, QD, SCENE, VALUES, Call, option, refuse_where, takes
from robodyn.cli.screen import answer
from robodyn.equations.closed import closed
from robodyn.equations.dae.dae import dae
from robodyn.equations.ode import ode
from robodyn.report.dae import dae_json, dae_sections
from robodyn.report.equations import closed_json, closed_sections, ode_json, ode_sections
from robodyn.report.renderers.latex import closed_latex, dae_latex

_WRITERS: dict[str, Any] = {
    "ode": (ode_sections, ode_json, None),
    "dae": (dae_sections, dae_json, dae_latex),
    "closed": (closed_sections, closed_json, closed_latex),
}
"""By form the functions for text, JSON and LaTeX."""


class _Format(click.Choice):  # type: ignore[type-arg,unused-ignore]
    def get_invalid_choice_message(self, value: Any, ctx: click.Context | None) -> str:
        other = "; robodyn export --to c writes C" if value == "c" else ""
        return super().get_invalid_choice_message(value, ctx).rstrip(".") + other


@click.command("equations", short_help="Derive the equations of motion in numbers, letters or LaTeX.")
@click.argument("urdf", type=PATH)
@takes(
    option(
        "--form",
        "ode (default): in numbers; dae: with constraints and reactions; closed: in symbols.",
        ("ode", "dae", "closed"),
        "equations",
        default="ode",
    ),
    AT,
    QD,
    option("--tau TAU", "Torques for --form dae, likewise; default none.", VALUES),
    option("--format", "Default text.", _Format(("text", "latex", "json")), "form", default="text"),
    SCENE,
)
def command(call: Call, urdf: str, equations: str, tau: Any) -> None:
    """Derive M(q) qdd + bias = tau: in numbers at a configuration, or in closed form for small robots; and Newton's and
    Euler's laws of all bodies with constraints and reactions. A file named - is standard input.

    \b
    Examples:
      robodyn equations robots/puma.urdf --at 0.1,-0.5,0.3 --qd waist=1
      robodyn equations robots/two_link_planar.urdf --form closed --format latex
      robodyn equations robots/scara.urdf --form dae --at 0.3,-0.5,0.05 --qd elbow=2
    """
    forms = ("closed", "dae") if call.form == "latex" else (equations,)
    given = [name for name, value in (("at", call.at), ("qd", call.qd), ("tau", tau)) if value]
    in_letters = equations == "closed" or call.form == "latex"
    refuse_where(
        (equations not in forms, f"--format {call.form} is for --form {' or '.join(forms)}"),
        (given and in_letters, f"--{given[0] if given else ''} is for numbers: --form ode or dae as text or json"),
        (tau and equations != "dae", "--tau is for --form dae"),
    )
    check_names()
    model, scene = robot_in_scene(call, urdf, loops=equations == "dae")
    found: Any
    if equations == "dae":
        found = dae(model, scene, call.at, call.qd or (), tau or ())
    else:
        found = closed(model, scene) if equations == "closed" else ode(model, scene, call.at or (), call.qd or ())
    sections, json, latex = _WRITERS[equations]
    answer(call, sections(found), json=lambda: json(found), latex=lambda: latex(found))
