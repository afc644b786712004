"""The options of `robodyn torques`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from robodyn.cli.batch_options import BATCH
from robodyn.cli.momentum_options import MOMENTUM
from robodyn.cli.options import DESCRIPTION, EXECUTION, FORMAT, GRAVITY, PATH, POSITIVE, SCENE
from robodyn.cli.reading_options import READING
from robodyn.cli.reports import REPORT

_OPTIONS = (
    DESCRIPTION,
    SCENE,
    GRAVITY,
    click.option("--out", type=PATH, metavar="FILE", help="Write the torques: .csv, .parquet, .npz; of many a FOLDER."),
    click.option("--base-held", is_flag=True, help="The base is bolted down, or something carries it: do not warn."),
    click.option("--reactions", is_flag=True, help="Write the wrenches of the base and of every joint to --out too."),
    click.option("--sizing", is_flag=True, help="Add duty, motors, bearings, foundation; as a scene with motors does."),
    MOMENTUM,
    READING,
    click.option("--explain", is_flag=True, help="Say why each effect is on or off, and what it costs."),
    click.option("--fail-on-limits", is_flag=True, help="Exit with 1 if a limit of robot or motor is exceeded."),
    click.option("--accuracy", type=POSITIVE, metavar="E", help="Take the cheapest arithmetic of this relative error."),
    click.option("--example", is_flag=True, help="First write an example motion to TRAJECTORY, within all limits."),
    REPORT,
    BATCH,
    EXECUTION,
    FORMAT,
)


def OPTIONS(command: Callable[..., Any]) -> Callable[..., Any]:
    """All of them, in this order."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command
