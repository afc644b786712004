"""What a command is called with: types and options that commands share, and their values in one `Call`."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import reduce, wraps
from typing import TYPE_CHECKING, Any, NoReturn, get_args

import click

from robodyn.errors import InputError
from robodyn.support.extras import need
from robodyn.support.input_file import read_input

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

    from robodyn.scene.scene import Payload
    from robodyn.trajectory.columns.signals import AngleUnit, TimeUnit

Callback = Callable[..., Any]
Decorator = Callable[[Callback], Callback]
Vector = tuple[float, float, float]
ROBOT_SUFFIXES = (".urdf", ".xacro", ".xml", ".mjcf", ".sdf")
TABLE_SUFFIXES = (".csv", ".tsv", ".parquet", ".pq", ".npz", ".db3", ".mcap", ".bag")
"""Suffixes that only such files have."""
REPORT_FORMS = {".html": "html", ".htm": "html", ".md": "markdown"}
"""The form of a report by the suffix of its file."""


class Pairs(list[tuple[str, str]]):
    """Pairs of names, and the file that they were read from."""

    file: str | None = None


@dataclass(frozen=True)
class Call:
    """What commands are told in the same words; an option that a command does not have has its default.

    Attributes:
        package_paths, xacro_args, trust_xacro: how a description is read; those from hold to ignore_extra: a table.
        at, qd: positions and velocities, in order or by name; accuracy: a relative error.
        out: the file of the result; report: of the report; form: of what is printed.
        fail_on_limits: whether an exceeded limit makes the exit status 1.
    """

    package_paths: tuple[str, ...] = ()
    xacro_args: tuple[tuple[str, str], ...] = ()
    trust_xacro: bool = False
    scene_files: tuple[str, ...] = ()
    payloads: tuple[Payload, ...] = ()
    gravity: Vector | None = None
    base_held: bool = False
    hold: tuple[str, ...] = ()
    columns: tuple[Pairs, ...] = ()
    time_unit: TimeUnit | None = None
    angle_unit: AngleUnit | None = None
    derivatives: str = "auto"
    encoder_error: float = 0.0
    topic: str | None = None
    ignore_extra: bool = False
    at: Any = None
    qd: Any = None
    executor: str = "auto"
    threads: int | None = None
    accuracy: float | None = None
    out: str | None = None
    report: str | None = None
    form: str = "text"
    fail_on_limits: bool = False

    @property
    def lookup(self) -> dict[str, Any]:
        """How a description is read, as `robodyn.load` takes it."""
        args = dict(self.xacro_args)
        return {"package_paths": self.package_paths, "xacro_args": args, "trust_xacro": self.trust_xacro}

    @property
    def reading(self) -> dict[str, Any]:
        """How a table is read, as `robodyn.read_motion` takes it."""
        columns = dict(pair for pairs in self.columns for pair in pairs)
        found = {name: getattr(self, name) for name in _READING}
        return {**found, "hold": ",".join(self.hold) or None, "columns": columns}

    @property
    def reading_given(self) -> str:
        """The first option on how a table is read that is given, empty if none is."""
        names = [name for name in _READING if getattr(self, name) != getattr(Call, name)]
        return f"--{'map' if names[0] == 'columns' else names[0].replace('_', '-')}" if names else ""

    @property
    def scene_name(self) -> str | None:
        """What messages call the files that --scene names."""
        return " + ".join(self.scene_files) or None

    @property
    def pictured(self) -> bool:
        """Whether there is a report with figures."""
        return self.report is not None and report_form(self.report) == "html"


_COMMON = {field.name for field in fields(Call)}
_READING = ("time_unit", "angle_unit", "derivatives", "encoder_error", "ignore_extra", "topic", "hold", "columns")


def option(declaration: str, text: str, kind: Any = None, name: str | None = None, **how: Any) -> Decorator:
    """Return click's option of "--name" (a flag), "--name METAVAR" or, if it may be given again, "--name METAVAR*".

    Args:
        kind: its type, or the words that it can be; text: for help; name: of the parameter, where that is another.
    """
    flag, _, metavar = declaration.partition(" ")
    if metavar:
        how |= {"metavar": metavar.removesuffix("*"), "multiple": metavar.endswith("*")}
    how = {"is_flag": True if not metavar and kind is None else None, "help": text} | how
    kind = click.Choice(kind) if isinstance(kind, (tuple, list)) else kind
    return click.option(flag, *([name] if name else []), type=kind, **how)


def together(*options: Decorator) -> Decorator:
    """Return one decorator for several options, which help lists in this order."""
    return lambda command: reduce(lambda inner, option: option(inner), reversed(options), command)


def takes(*options: Decorator) -> Decorator:
    """Return a decorator that gives a function a `Call` of the options that commands share, and the others by name."""

    def decorate(function: Callback) -> Callback:
        @wraps(function)
        def called(**values: Any) -> Any:
            shared = {name: values.pop(name) for name in _COMMON & values.keys()}
            return function(Call(**shared), **values)

        return together(*options)(called)

    return decorate


def refuse(what: str) -> NoReturn:
    """Raise that a command cannot be called so."""
    raise click.UsageError(what, click.get_current_context())


def refuse_where(*cases: tuple[object, str]) -> None:
    """Refuse the call by the first of these that holds."""
    for holds, what in cases:
        if holds:
            refuse(what)


class Parsed(click.ParamType):  # type: ignore[type-arg,unused-ignore]
    """What a function makes of the text, which says in a ValueError why it cannot."""

    def __init__(self, name: str, parse: Callable[[str], Any] = str) -> None:
        """Args: name: "file" or "dir" where shells complete names of those; whether they are there, say who read it."""
        self.name, self._parse = name, parse

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        try:
            return self._parse(value) if isinstance(value, str) else value
        except ValueError as problem:
            return self.fail(str(problem), param, ctx)

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        from click.shell_completion import CompletionItem

        return [CompletionItem(incomplete, type=self.name)] if self.name in ("file", "dir") else []


class Output(Parsed):
    """The name of a file that is written, of a kind that `files` knows."""

    def __init__(self, kind: str, parse: Callable[[str], Any] = str) -> None:
        super().__init__("file", parse)
        self.kind = kind


def finite_numbers(text: str) -> list[float]:
    """Return the numbers between commas; none if one of them is no finite number."""
    try:
        numbers = [] if "_" in text else [float(part) for part in text.split(",")]
    except ValueError:
        return []
    return numbers if all(map(math.isfinite, numbers)) else []


def _folder(text: str) -> str:
    if os.path.isdir(text):
        return text
    raise ValueError(f"{text!r}: {'is a file, not a folder' if os.path.isfile(text) else 'there is no such folder'}")


def _argument(text: str) -> tuple[str, str]:
    name, sign, value = text.partition(":=")
    if not sign or not name.strip():
        raise ValueError(f"{text!r} is not NAME:=VALUE, such as prefix:=left_")
    return name.strip(), value


def vector_type(example: str) -> Parsed:
    """Return the type of three numbers between commas; the example is for messages."""

    def vector(text: str) -> Vector:
        match finite_numbers(text):
            case [x, y, z]:
                return x, y, z
        raise ValueError(f"{text!r} is not three finite numbers between commas, such as {example}")

    return Parsed("vector", vector)


def _positive(text: str) -> float:
    numbers = finite_numbers(text)
    if len(numbers) != 1 or numbers[0] <= 0.0:
        raise ValueError(f"{text} is no positive finite number")
    return numbers[0]


def _point(text: str) -> str | tuple[float, ...]:
    numbers = finite_numbers(text)
    if text in ("com", "origin") or len(numbers) == 3:
        return text if text in ("com", "origin") else tuple(numbers)
    ctx = click.get_current_context(silent=True)
    options = [] if ctx is None else [name for each in ctx.command.params for name in each.opts]
    link = "".join(f"; {name} takes the name of a link" for name in ("--frame", "--link") if name in options)
    raise ValueError(f"{text!r} is neither com nor origin nor X,Y,Z in m, such as 0,0,0.1{link}")


def _at(text: str) -> list[float] | dict[str, float]:
    if "=" not in text:
        numbers = finite_numbers(text)
        if numbers:
            return numbers
    else:
        pairs = [part.rpartition("=") for part in text.split(",")]
        values = finite_numbers(",".join(number for _, _, number in pairs))
        names = [name.strip() for name, _, _ in pairs]
        if len(values) == len(pairs) and all(names):
            twice = [name for k, name in enumerate(names) if name in names[:k]]
            if twice:
                raise ValueError(f"{text!r} names {twice[0]!r} twice")
            return dict(zip(names, values, strict=True))
    raise ValueError(f"{text!r} is neither numbers (0.1,-0.2) nor joints (elbow=0.1,wrist=-0.2)")


def _names(text: str) -> tuple[str, ...]:
    names = tuple(name.strip() for name in text.split(","))
    if not all(names):
        raise ValueError(f"{text!r} is not names between commas, such as shoulder,elbow")
    return names


def _kinds(text: str) -> tuple[str, ...]:
    if text.lower().endswith(ROBOT_SUFFIXES):
        raise ValueError(f"{text!r} is a file; put it before --symbols, or say which symbols, as --symbols m,l")
    return tuple(kind.strip() for kind in text.split(",") if kind.strip())


def _payload(text: str) -> Payload:
    from robodyn.scene.scene import Payload

    link, _, load = text.rpartition("=")
    mass, at, com = load.partition("@")
    numbers = finite_numbers(mass) + finite_numbers(com if at else "0,0,0")
    if not link or len(numbers) != 4 or "," in mass or numbers[0] <= 0.0:
        raise ValueError(f"{text!r} is not LINK=KG or LINK=KG@X,Y,Z, such as tool0=2.5@0,0,0.1")
    m, x, y, z = numbers
    return Payload(link, m, (x, y, z))


def _carried(text: str) -> Payload | tuple[str, Vector]:
    """Return a mass on a link, or the place of one that is looked for."""
    if "=" in text:
        return _payload(text)
    link, at, point = text.partition("@")
    numbers = finite_numbers(point if at else "0,0,0")
    if not link or len(numbers) != 3:
        raise ValueError(f"{text!r} is not LINK or LINK@X,Y,Z, such as tool0@0,0,0.1, nor LINK=KG")
    x, y, z = numbers
    return link, (x, y, z)


def _box(text: str) -> dict[str, tuple[float, float]]:
    """Return the range of each joint, least..largest or one value."""
    found: dict[str, tuple[float, float]] = {}
    for part in text.split(","):
        name, _, ends = (piece.strip() for piece in part.partition("="))
        numbers = finite_numbers(ends.replace("..", ","))
        if not name or len(numbers) not in (1, 2):
            raise ValueError(f"{part!r} is no range, such as elbow=-1..1.5")
        if name in found:
            raise ValueError(f"{text!r} names {name!r} twice")
        found[name] = numbers[0], numbers[-1]
    return found


def _columns(text: str) -> Pairs:
    ours, equals, theirs = (part.strip() for part in text.partition("="))
    if equals and not os.path.isfile(text):
        if not ours or not theirs:
            raise ValueError(f"{text!r} is not OURS=THEIRS, such as q_elbow='Elbow angle'")
        return Pairs([(ours, theirs)])
    from robodyn.scene.toml_table import read_toml

    try:
        found = Pairs(read_toml(read_input(text), text).items())
    except OSError as error:
        raise ValueError(f"{text!r} is not OURS=THEIRS, nor a file: {error.strerror}") from None
    except InputError as error:
        raise ValueError(str(error)) from None
    for ours, name in found:
        if not isinstance(name, str):
            raise ValueError(f"{text}: {ours!r} is {name!r:.60}, not a name; write 'q_elbow = \"Elbow angle\"'")
    found.file = text
    return found


def report_form(path: str) -> str:
    suffix = os.path.splitext(path)[1].lower()
    if suffix not in REPORT_FORMS:
        raise InputError("unknown type of report by this suffix", remedy="name it .html or .md", file=path)
    return REPORT_FORMS[suffix]


def _report(path: str) -> str:
    """Return the name of the file, if a report can go there: said before anything is computed."""
    if report_form(path) == "html":
        need("HTML reports", "jinja2", "uplot-python", file=path)
    folder = os.path.dirname(path) or "."
    if not os.path.isdir(folder):
        raise InputError("cannot be written: there is no such folder", remedy="make the folder first", file=path)
    return path


PATH, FOLDER, FOLDER_THERE = Parsed("file"), Parsed("dir"), Parsed("dir", _folder)
TABLE_OUT, SCENE_OUT = Output("a table"), Output("a scene that was identified")
MOTORS_OUT = Output("a scene of chosen motors")
URDF_OUT, COVARIANCE_OUT = Output("a calibrated description"), Output("a covariance")
NAMES = Parsed("joints", _names)
CARRIED, BOX = Parsed("payload", _carried), Parsed("box", _box)
POSITIVE, POINT, VALUES = Parsed("number", _positive), Parsed("point", _point), Parsed("at", _at)
DESCRIPTION = together(
    option("--package-path DIR*", "Where packages are looked for first; repeatable.", FOLDER_THERE, "package_paths"),
    option(
        "--xacro-arg NAME:=VALUE*",
        "An argument of a .xacro file; repeatable.",
        Parsed("argument", _argument),
        "xacro_args",
    ),
    option(
        "--trust-xacro", "Let the .xacro file that is named run any Python, read any file and all of the environment."
    ),
)
SCENE_FILES = option(
    "--scene FILE*",
    "TOML: friction, motors, payloads, wrenches, base; robodyn scene init writes one. Repeatable: merged.",
    PATH,
    "scene_files",
)
GRAVITY = option("--gravity X,Y,Z", "m/s^2 in the base frame; default 0,0,-9.81.", vector_type("0,0,-9.81"))
SCENE = together(
    DESCRIPTION,
    SCENE_FILES,
    option(
        "--payload LINK=KG[@X,Y,Z]*",
        "A mass on a link, its centre in m in the link's frame; repeatable, beside those of the scene.",
        Parsed("payload", _payload),
        "payloads",
    ),
    GRAVITY,
)
BASE_HELD = option("--base-held", "The base is bolted down, or something carries it: do not warn.")
REPORT_OUT = Output("a report", _report)
REPORT = option(
    "--report FILE",
    "Write a report for people: .html with plots and data in one file, or .md for a pull request.",
    REPORT_OUT,
)
AT = option("--at Q", "Joint values in order, or JOINT=Q,...; the rest 0.", VALUES)
QD = option("--qd QD", "Velocities, likewise; default at rest.", VALUES)
SYMBOLS = option(
    "--symbols [KINDS]",
    "Formulas in letters for masses m, lengths l, centres c, inertias I, gravity g; some, as m,l, or all.",
    Parsed("symbols", _kinds),
    is_flag=False,
    flag_value="m,l,c,I,g",
)
FORMAT = option("--format", "Form of the report; default text.", ("text", "json"), "form", default="text")


def TABLE(command: Callback) -> Callback:
    """Return those options of `READING` that hold for any table."""
    from robodyn.trajectory.columns.signals import TimeUnit

    return together(
        option(
            "--map OURS=THEIRS|FILE*",
            "The table's name of a column, as q_elbow='Elbow angle'; or a TOML file of these; repeatable.",
            Parsed("file", _columns),
            "columns",
        ),
        option("--time-unit", "Of stamps whose columns do not tell; default s.", get_args(TimeUnit)),
    )(command)


def READING(command: Callback) -> Callback:
    """Return the options that tell how a motion is read."""
    from robodyn.trajectory.columns.signals import AngleUnit
    from robodyn.trajectory.options import MODES

    return together(
        option(
            "--hold rest|POSITION|...*",
            "Joints without columns: at rest (near zero), a position, or JOINT=POSITION,...; repeatable.",
        ),
        TABLE,
        option("--angle-unit", "Of joints whose columns do not tell; default rad.", get_args(AngleUnit)),
        option("--derivatives", "Of missing columns; anew: of all.", MODES, default="auto"),
        option(
            "--encoder-error RAD",
            "Largest error of encoders that repeats with the angle (m of slides): into the error bars.",
            click.FloatRange(min=0.0),
            default=0.0,
        ),
        option("--topic NAME", "Of a ROS bag, if several topics are about joints."),
        option("--ignore-extra", "Leave out columns that the robot does not know."),
    )(command)
