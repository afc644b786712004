"""The options of `robodyn equations`, and which of them go together."""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import Any

import click

from robodyn.cli.options import AtType

FORMATS = ("text", "latex", "c", "json")
ONLY = {"c": ("ode",), "latex": ("closed", "dae")}
"""Formats that not all forms have."""
_OPTIONS = (
    click.option(
        "--form",
        type=click.Choice(["ode", "dae", "closed"]),
        default="ode",
        help="ode (default): in numbers; dae: with constraints and reactions; closed: in symbols.",
    ),
    click.option("--at", type=AtType(), metavar="Q", help="Joint values in order, or JOINT=Q,...; the rest 0."),
    click.option("--qd", type=AtType(), metavar="QD", help="Velocities, likewise; default at rest."),
    click.option("--tau", type=AtType(), metavar="TAU", help="Torques for --form dae, likewise; default none."),
    click.option("--format", "output", type=click.Choice(FORMATS), default="text", help="Default text."),
)


def ASKED(command: Callable[..., Any]) -> Callable[..., Any]:
    """All of them, in this order."""
    return reduce(lambda inner, option: option(inner), reversed(_OPTIONS), command)


def check_asked(form: str, output: str, **numbers: Any) -> None:
    """Raise if options do not go together; `numbers` are --at, --qd and --tau."""
    context = click.get_current_context()
    forms = ONLY.get(output, (form,))
    if form not in forms:
        raise click.UsageError(f"--format {output} is for --form {' or '.join(forms)}", context)
    given = [name for name, value in numbers.items() if value]
    if given and (form == "closed" or output in ("c", "latex")):
        raise click.UsageError(f"--{given[0]} is for numbers: --form ode or dae as text or json", context)
    if "tau" in given and form != "dae":
        raise click.UsageError("--tau is for --form dae", context)
