"""The options of `robodyn torques` for momentum and energy."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from robodyn.cli.options import PointType

if TYPE_CHECKING:
    from robodyn.dynamics.momenta import View

Callback = Callable[..., Any]


def MOMENTUM(command: Callback) -> Callback:
    """The options --momentum, --about and --frame."""
    text = "Mass centre, momenta, energies, power: report them, and write them to --out."
    point = click.option("--about", type=PointType(), metavar="POINT", help="Of L: origin (default), com or X,Y,Z.")
    frame = click.option("--frame", metavar="LINK", help="Axes and origin of momenta; default the ground's.")
    return click.option("--momentum", is_flag=True, help=text)(point(frame(command)))


def momentum_view(how: dict[str, Any]) -> View | None:
    """How momenta are asked for, taken out of the values of the options; None if they are not."""
    wanted, about, frame = (how.pop(name) for name in ("momentum", "about", "frame"))
    if wanted:
        from robodyn.dynamics.momenta import GROUND, View

        return View("origin" if about is None else about, GROUND if frame is None else frame)
    for name, value in (("--about", about), ("--frame", frame)):
        if value is not None:
            raise click.UsageError(f"{name} goes with --momentum", click.get_current_context())
    return None
