"""`robodyn equations`: the equations of motion of a robot, in numbers, or in closed form."""

from __future__ import annotations

from functools import partial
from typing import Any

import click

from robodyn.cli import options
from robodyn.cli.files import check_names, robot_in_scene
from robodyn.cli.options import AT, PATH, QD, SCENE, VALUES, Call, option, refuse_where, takes, together
from robodyn.cli.screen import answer
from robodyn.equations.closed import closed
from robodyn.equations.dae.dae import dae
from robodyn.equations.ode import ode
from robodyn.errors import InputError
from robodyn.report.equations.dae import dae_json, dae_sections
from robodyn.report.equations.equations import closed_json, closed_sections, ode_json, ode_sections
from robodyn.report.equations.latex import closed_latex, dae_latex
from robodyn.report.equations.python import closed_python
from robodyn.support.wording import shown

_WRITERS: dict[str, Any] = {
    "ode": (ode_sections, ode_json, None, None),
    "dae": (dae_sections, dae_json, dae_latex, None),
    "closed": (closed_sections, closed_json, closed_latex, closed_python),
}
"""By form the functions for text, JSON, LaTeX and Python."""


class _Format(click.Choice):  # type: ignore[type-arg,unused-ignore]
    def get_invalid_choice_message(self, value: Any, ctx: click.Context | None) -> str:
        other = "; robodyn export --to c writes C" if value == "c" else ""
        return super().get_invalid_choice_message(value, ctx).rstrip(".") + other


def letters_of(symbols: tuple[str, ...] | None, assume: tuple[str, ...]) -> tuple[tuple[str, ...], list[str]]:
    """Return kinds of letters, and the names of those that are assumed to be positive."""
    positive = []
    for text in assume:
        name, _, zero = text.replace(" ", "").partition(">")
        if not name or zero != "0":
            raise InputError(f"no assumption {shown(text)}", remedy="as in --assume 'l_1>0'")
        positive.append(name)
    return symbols or (), positive


SYMBOLS = together(
    options.SYMBOLS,
    option("--assume LETTER>0*", "A letter that is positive, which SymPy may use, as l_1>0. Repeatable."),
)


@click.command("equations", short_help="Derive the equations of motion in numbers, letters or LaTeX.")
@click.argument("urdf", type=PATH)
@takes(
    option(
        "--form",
        "ode (default): in numbers; dae: with constraints and reactions; closed: in symbols (default with --symbols).",
        ("ode", "dae", "closed"),
        "equations",
    ),
    SYMBOLS,
    AT,
    QD,
    option("--tau TAU", "Torques for --form dae, likewise; default none.", VALUES),
    option("--format", "Default text.", _Format(("text", "latex", "json", "python")), "form", default="text"),
    SCENE,
)
def command(
    call: Call, urdf: str, equations: str | None, symbols: tuple[str, ...] | None, assume: tuple[str, ...], tau: Any
) -> None:
    """Derive M(q) qdd + bias = tau: in numbers at a configuration, or in closed form for small robots; and Newton's and
    Euler's laws of all bodies with constraints and reactions. A file named - is standard input.

    \b
    Examples:
      robodyn equations robots/puma.urdf --at 0.1,-0.5,0.3 --qd waist=1
      robodyn equations robots/two_link_planar.urdf --form closed --format latex
      robodyn equations robots/puma.urdf --symbols
      robodyn equations robots/scara.urdf --form dae --at 0.3,-0.5,0.05 --qd elbow=2
    """
    equations = equations or ("ode" if symbols is None else "closed")
    forms = {"latex": ("closed", "dae"), "python": ("closed",)}.get(call.form, (equations,))
    given = [name for name, value in (("at", call.at), ("qd", call.qd), ("tau", tau)) if value]
    in_letters = equations == "closed" or call.form == "latex"
    refuse_where(
        (equations not in forms, f"--format {call.form} is for --form {' or '.join(forms)}"),
        (given and in_letters, f"--{given[0] if given else ''} is for numbers: --form ode or dae as text or json"),
        (tau and equations != "dae", "--tau is for --form dae"),
        (symbols is not None and equations != "closed", "--symbols is for --form closed"),
        (assume and symbols is None, "--assume is for --symbols"),
    )
    kinds, positive = letters_of(symbols, assume)
    check_names()
    model, scene = robot_in_scene(call, urdf, loops=equations == "dae")
    found: Any
    if equations == "dae":
        found = dae(model, scene, call.at, call.qd or (), tau or ())
    elif equations == "closed":
        found = closed(model, scene, symbols=kinds, positive=positive)
    else:
        found = ode(model, scene, call.at or (), call.qd or ())
    sections, json, latex, python = _WRITERS[equations]
    writers = {"json": json, "latex": latex, "python": python}
    others: Any = {name: partial(write, found) for name, write in writers.items() if write}
    answer(call, sections(found), **others)
