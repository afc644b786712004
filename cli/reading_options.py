"""The options that say how a trajectory's table is to be read."""

from __future__ import annotations

import os
from typing import Any, get_args

import click

from robodyn.cli.options import Parsed, kept, kept_value, together
from robodyn.errors import InputError
from robodyn.support.input_file import read_input
from robodyn.trajectory.reading import MODES
from robodyn.trajectory.units import AngleUnit, TimeUnit


class _Pairs(list[tuple[str, str]]):
    """Pairs of names, and the file that they were read from."""

    file: str | None = None


def _columns(text: str) -> _Pairs:
    """Return the pairs of OURS=THEIRS, or of a TOML file of such pairs."""
    ours, equals, theirs = text.partition("=")
    if not equals or os.path.isfile(text):
        found = _Pairs(_pairs(text).items())
        found.file = text
        return found
    if not ours.strip() or not theirs.strip():
        raise ValueError(f"{text!r} is not OURS=THEIRS, such as q_elbow='Elbow angle'")
    return _Pairs([(ours.strip(), theirs.strip())])


def _pairs(file: str) -> dict[str, str]:
    from robodyn.scene.toml_table import read_toml

    try:
        found = read_toml(read_input(file), file)
    except OSError as error:
        raise ValueError(f"{file!r} is not OURS=THEIRS, nor a file: {error.strerror}") from None
    except InputError as error:
        raise ValueError(str(error)) from None
    for ours, theirs in found.items():
        if not isinstance(theirs, str):
            raise ValueError(f"{file}: {ours!r} is {theirs!r:.60}, not a name; write 'q_elbow = \"Elbow angle\"'")
    return found


TABLE = together(
    kept(
        "--map",
        "columns",
        type=Parsed("file", _columns),
        metavar="OURS=THEIRS|FILE",
        multiple=True,
        help="The table's name of a column, as q_elbow='Elbow angle'; or a TOML file of these; repeatable.",
    ),
    kept(
        "--time-unit",
        type=click.Choice(get_args(TimeUnit)),
        help="Of stamps whose columns do not tell; default s.",
    ),
)
"""Those options of `READING` that hold for any table."""
READING = together(
    kept(
        "--hold",
        metavar="rest|POSITION|...",
        multiple=True,
        help="Joints without columns: at rest (near zero), a position, or JOINT=POSITION,...; repeatable.",
    ),
    TABLE,
    kept(
        "--angle-unit", type=click.Choice(get_args(AngleUnit)), help="Of joints whose columns do not tell; default rad."
    ),
    kept("--derivatives", type=click.Choice(MODES), default="auto", help="Of missing columns; anew: of all."),
    kept(
        "--encoder-error",
        type=click.FloatRange(min=0.0),
        default=0.0,
        metavar="RAD",
        help="Largest error of encoders that repeats with the angle (m of slides): into the error bars.",
    ),
    kept("--topic", metavar="NAME", help="Of a ROS bag, if several topics are about joints."),
    kept("--ignore-extra", is_flag=True, help="Leave out columns that the robot does not know."),
)
"""The options whose values are those of `reading`."""
_DEFAULTS = {
    "time_unit": None,
    "angle_unit": None,
    "derivatives": "auto",
    "encoder_error": 0.0,
    "ignore_extra": False,
    "topic": None,
}


def reading() -> dict[str, Any]:
    """Return what the options of `READING` say, as `robodyn.read_motion` takes it."""
    columns = dict(pair for pairs in kept_value("columns", ()) for pair in pairs)
    asked = {name: kept_value(name, default) for name, default in _DEFAULTS.items()}
    return {**asked, "hold": ",".join(kept_value("hold", ())) or None, "columns": columns}


def given() -> str:
    """Return the first of the options of `READING` that is given, empty if none is."""
    names = [name for name, value in reading().items() if value and value != _DEFAULTS.get(name)]
    return f"--{'map' if names[0] == 'columns' else names[0].replace('_', '-')}" if names else ""
