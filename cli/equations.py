"""`robodyn equations`: the equations of motion of a robot, in numbers, or in closed form."""

from __future__ import annotations

from typing import Any

import click

from robodyn.cli.files import check_names, robot_in_scene
from robodyn.cli.options import AT, PATH, QD, SCENE, VALUES, together
from robodyn.cli.reports import answer
from robodyn.equations.closed import closed
from robodyn.equations.dae.dae import dae
from robodyn.equations.ode import ode
from robodyn.report.dae import dae_json, dae_sections
from robodyn.report.equations import closed_json, closed_sections, ode_json, ode_sections
from robodyn.report.renderers.latex import closed_latex, dae_latex

FORMATS = ("text", "latex", "json")
ONLY = {"latex": ("closed", "dae")}
"""Formats that not all forms have."""
_WRITERS: dict[str, Any] = {
    "ode": (ode_sections, ode_json, None),
    "dae": (dae_sections, dae_json, dae_latex),
    "closed": (closed_sections, closed_json, closed_latex),
}
"""By form the functions for text, JSON and LaTeX."""


class _Format(click.Choice):  # type: ignore[type-arg,unused-ignore]
    """The formats; of C it says who writes it."""

    def get_invalid_choice_message(self, value: Any, ctx: click.Context | None) -> str:
        other = "; robodyn export --to c writes C" if value == "c" else ""
        return super().get_invalid_choice_message(value, ctx).rstrip(".") + other


ASKED = together(
    click.option(
        "--form",
        type=click.Choice(["ode", "dae", "closed"]),
        default="ode",
        help="ode (default): in numbers; dae: with constraints and reactions; closed: in symbols.",
    ),
    AT,
    QD,
    click.option("--tau", type=VALUES, metavar="TAU", help="Torques for --form dae, likewise; default none."),
    click.option("--format", "output", type=_Format(FORMATS), default="text", help="Default text."),
)


def check_asked(form: str, output: str, **numbers: Any) -> None:
    """Raise if options do not go together; `numbers` are --at, --qd and --tau."""
    context = click.get_current_context()
    forms = ONLY.get(output, (form,))
    if form not in forms:
        raise click.UsageError(f"--format {output} is for --form {' or '.join(forms)}", context)
    given = [name for name, value in numbers.items() if value]
    if given and (form == "closed" or output == "latex"):
        raise click.UsageError(f"--{given[0]} is for numbers: --form ode or dae as text or json", context)
    if "tau" in given and form != "dae":
        raise click.UsageError("--tau is for --form dae", context)


@click.command("equations", short_help="Derive the equations of motion in numbers, letters or LaTeX.")
@click.argument("urdf", type=PATH)
@ASKED
@SCENE
def command(urdf: str, form: str, at: Any, qd: Any, tau: Any, output: str) -> None:
    """Derive M(q) qdd + bias = tau: in numbers at a configuration, or in closed form for small robots; and Newton's and
    Euler's laws of all bodies with constraints and reactions. A file named - is standard input.

    \b
    Examples:
      robodyn equations robots/puma.urdf --at 0.1,-0.5,0.3 --qd waist=1
      robodyn equations robots/two_link_planar.urdf --form closed --format latex
      robodyn equations robots/scara.urdf --form dae --at 0.3,-0.5,0.05 --qd elbow=2
    """
    check_asked(form, output, at=at, qd=qd, tau=tau)
    check_names()
    model, scene = robot_in_scene(urdf, loops=form == "dae")
    found: Any
    if form == "dae":
        found = dae(model, scene, at, qd or (), tau or ())
    else:
        found = closed(model, scene) if form == "closed" else ode(model, scene, at or (), qd or ())
    sections, json, latex = _WRITERS[form]
    answer(sections(found), form=output, json=lambda: json(found), latex=lambda: latex(found))
