"""The options that say how a trajectory's table is to be read."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import Any, get_args

import click

from robodyn.cli.options import PlaceType
from robodyn.support.input_file import read_input
from robodyn.trajectory.reading import MODES
from robodyn.trajectory.units import AngleUnit, TimeUnit

Callback = Callable[..., Any]
_READING = "robodyn.reading"


class ColumnsType(PlaceType):
    """OURS=THEIRS, or a TOML file of such pairs."""

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> list[tuple[str, str]]:
        ours, equals, theirs = str(value).partition("=")
        if not equals or os.path.isfile(str(value)):
            return list(self._pairs(str(value), param, ctx).items())
        if not ours.strip() or not theirs.strip():
            self.fail(f"{value!r} is not OURS=THEIRS, such as q_elbow='Elbow angle'", param, ctx)
        return [(ours.strip(), theirs.strip())]

    def _pairs(self, file: str, param: click.Parameter | None, ctx: click.Context | None) -> dict[str, str]:
        if sys.version_info >= (3, 11):
            import tomllib
        else:
            import tomli as tomllib
        try:
            found = tomllib.loads(read_input(file).decode())
        except OSError as error:
            self.fail(f"{file!r} is not OURS=THEIRS, nor a file: {error.strerror}", param, ctx)
        except ValueError as error:
            self.fail(f"{file}: is not TOML: {error}", param, ctx)
        for ours, theirs in found.items():
            if not isinstance(theirs, str):
                self.fail(
                    f"{file}: {ours!r} is {theirs!r:.60}, not a name; write 'q_elbow = \"Elbow angle\"'", param, ctx
                )
        return found


def READING(command: Callback) -> Callback:
    """The options whose values are those of `reading`."""
    hold = "Joints without columns: at rest (near zero), a position, or JOINT=POSITION,...; repeatable."
    derived, more = "Of missing columns; default auto.", "Leave out columns that the robot does not know."
    angle = "Of joints whose columns do not tell; default rad."
    options = (
        click.option("--hold", metavar="rest|POSITION|...", multiple=True, help=hold, **_HOW),
        TABLE,
        click.option("--angle-unit", type=click.Choice(get_args(AngleUnit)), help=angle, **_HOW),
        click.option("--derivatives", type=click.Choice(MODES), default="auto", help=derived, **_HOW),
        click.option("--ignore-extra", is_flag=True, help=more, **_HOW),
    )
    for option in reversed(options):
        command = option(command)
    return command


def TABLE(command: Callback) -> Callback:
    """Those of them that hold for any table: --map and --time-unit."""
    pairs = "OURS=THEIRS|FILE"
    columns = "The table's name of a column, as q_elbow='Elbow angle'; or a TOML file of these; repeatable."
    time = "Of stamps whose columns do not tell; default s."
    names = click.option(
        "--map", "columns", type=ColumnsType("file"), metavar=pairs, multiple=True, help=columns, **_HOW
    )
    return names(click.option("--time-unit", type=click.Choice(get_args(TimeUnit)), help=time, **_HOW)(command))


def _kept(ctx: click.Context, param: click.Parameter, value: Any) -> None:
    ctx.meta.setdefault(_READING, {})[param.name] = value


_HOW: dict[str, Any] = {"expose_value": False, "callback": _kept}


def reading() -> dict[str, Any]:
    """Return what the options of `READING` say, as `robodyn.read_motion` takes it."""
    ctx = click.get_current_context(silent=True)
    given = dict({} if ctx is None else ctx.meta.get(_READING, {}))
    hold, columns = given.pop("hold", ()), given.pop("columns", ())
    return {**given, "hold": ",".join(hold) or None, "columns": dict(pair for pairs in columns for pair in pairs)}


def given() -> str:
    """Return the first of the options of `READING` that is given, empty if none is."""
    default = {"derivatives": "auto"}
    names = [name for name, value in reading().items() if value and value != default.get(name)]
    return f"--{'map' if names[0] == 'columns' else names[0].replace('_', '-')}" if names else ""
