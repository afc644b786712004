"""The options of `robodyn equations`, and which of them go together."""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import Any

import click

from robodyn.cli.options import AtType

FORMATS = ("text", "latex", "c", "json")
ONLY = {"c": "ode", "latex": "closed"}
"""Formats that one form alone has."""
_OPTIONS = (
    click.option(
        "--form", type=click.Choice(["ode", "closed"]), default="ode", help="In numbers (default) or in symbols."
    ),
    click.option("--at", type=AtType(), metavar="Q", help="Joint values in order, or JOINT=Q,...; the rest 0."),
    click.option("--qd", type=AtType(), metavar="QD", help="Velocities, likewise; default at rest."),
    click.option("--format", "output", type=click.Choice(FORMATS), default="text", help="Default text."),
)


def ASKED(command: Callable[..., Any]) -> Callable[..., Any]:
    """All of them, in this order."""
    return reduce(lambda inner, option: option(inner), reversed(_OPTIONS), command)


def check_asked(form: str, output: str, at: Any, qd: Any) -> None:
    """Raise if options do not go together."""
    context = click.get_current_context()
    if ONLY.get(output, form) != form:
        raise click.UsageError(f"--format {output} is for --form {ONLY[output]}", context)
    if (at or qd) and (form == "closed" or output == "c"):
        raise click.UsageError(f"{'--at' if at else '--qd'} is for numbers: --form ode as text or json", context)
