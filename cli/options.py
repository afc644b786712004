"""Options that commands share, and their types."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from typing import TYPE_CHECKING, Any, ClassVar

import click

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

    from robodyn.scene.parts import Payload

Callback = Callable[..., Any]
Vector = tuple[float, float, float]
ROBOT_SUFFIXES = (".urdf", ".xacro")


def together(*options: Callback) -> Callback:
    """Return one decorator for several options, which help lists in this order."""
    return lambda command: reduce(lambda inner, option: option(inner), reversed(options), command)


class Grouped(click.Command):
    """A command of many options, which its help lists under titles.

    Attributes:
        groups: title -> names of options; those that stand in none come last.
    """

    groups: ClassVar[Mapping[str, Sequence[str]]] = {}

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        titles = {name: title for title, names in self.groups.items() for name in names}
        rows: dict[str, list[tuple[str, str]]] = {title: [] for title in (*self.groups, "Other options")}
        for each in self.get_params(ctx):
            record = each.get_help_record(ctx)
            if record is not None and isinstance(each, click.Option):
                title = next((titles[name] for name in each.opts if name in titles), "Other options")
                rows[title].append(record)
        for title, records in rows.items():
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)


def _keep(ctx: click.Context, param: click.Parameter, value: Any) -> None:
    ctx.meta[f"robodyn.{param.name}"] = value


def kept(*names: str, **given: Any) -> Callback:
    """Return an option whose value no command takes as an argument, but `kept_value` has, wherever it is called."""
    return click.option(*names, expose_value=False, callback=_keep, **given)


def kept_value(name: str, default: Any) -> Any:
    """Return the value of an option of `kept`."""
    ctx = click.get_current_context(silent=True)
    return default if ctx is None else ctx.meta.get(f"robodyn.{name}", default)


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
    """The name of a file that is written, of a kind that `outputs.py` knows."""

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
    if not os.path.isdir(text):
        what = "is a file, not a folder" if os.path.isfile(text) else "there is no such folder"
        raise ValueError(f"{text!r}: {what}")
    return text


def _argument(text: str) -> tuple[str, str]:
    """Return name and value of NAME:=VALUE, as the command xacro takes it."""
    name, sign, value = text.partition(":=")
    if not sign or not name.strip():
        raise ValueError(f"{text!r} is not NAME:=VALUE, such as prefix:=left_")
    return name.strip(), value


def vector_type(example: str) -> Parsed:
    """Return the type of three numbers between commas; the example is for messages."""

    def vector(text: str) -> Vector:
        numbers = finite_numbers(text)
        if len(numbers) != 3:
            raise ValueError(f"{text!r} is not three finite numbers between commas, such as {example}")
        x, y, z = numbers
        return x, y, z

    return Parsed("vector", vector)


def _positive(text: str) -> float:
    numbers = finite_numbers(text)
    if len(numbers) != 1 or numbers[0] <= 0.0:
        raise ValueError(f"{text} is no positive finite number")
    return numbers[0]


def _point(text: str) -> str | tuple[float, ...]:
    """Return com, origin, or three numbers between commas."""
    numbers = finite_numbers(text)
    if text in ("com", "origin") or len(numbers) == 3:
        return text if text in ("com", "origin") else tuple(numbers)
    ctx = click.get_current_context(silent=True)
    options = [] if ctx is None else [name for each in ctx.command.params for name in each.opts]
    link = "".join(f"; {name} takes the name of a link" for name in ("--frame", "--link") if name in options)
    raise ValueError(f"{text!r} is neither com nor origin nor X,Y,Z in m, such as 0,0,0.1{link}")


def _at(text: str) -> list[float] | dict[str, float]:
    """Return numbers between commas, or by name those of NAME=NUMBER."""
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


def _payload(text: str) -> Payload:
    """Return the payload of LINK=KG or LINK=KG@X,Y,Z."""
    from robodyn.scene.parts import Payload

    link, _, load = text.rpartition("=")
    mass, at, com = load.partition("@")
    numbers = finite_numbers(mass) + finite_numbers(com if at else "0,0,0")
    if not link or len(numbers) != 4 or "," in mass or numbers[0] <= 0.0:
        raise ValueError(f"{text!r} is not LINK=KG or LINK=KG@X,Y,Z, such as tool0=2.5@0,0,0.1")
    m, x, y, z = numbers
    return Payload(link, m, (x, y, z))


PATH, FOLDER = Parsed("file"), Parsed("dir")
TABLE_OUT, SCENE_OUT = Output("a table"), Output("a scene that was identified")
URDF_OUT, COVARIANCE_OUT = Output("a calibrated description"), Output("a covariance")
VECTOR, POSITIVE, POINT, VALUES = (
    vector_type("0,0,-9.81"),
    Parsed("number", _positive),
    Parsed("point", _point),
    Parsed("at", _at),
)
DESCRIPTION = together(
    kept(
        "--package-path",
        "package_paths",
        type=Parsed("dir", _folder),
        metavar="DIR",
        multiple=True,
        help="Where packages are looked for first; repeatable.",
    ),
    kept(
        "--xacro-arg",
        "xacro_args",
        type=Parsed("argument", _argument),
        metavar="NAME:=VALUE",
        multiple=True,
        help="An argument of a .xacro file; repeatable.",
    ),
    kept(
        "--trust-xacro",
        "trust_xacro",
        is_flag=True,
        help="Let the .xacro file that is named run any Python, read any file and all of the environment.",
    ),
)
"""The options whose values are those of `lookup`."""


def lookup() -> dict[str, Any]:
    """Return what the options of `DESCRIPTION` say, as `robodyn.load` takes it."""
    return {
        "package_paths": kept_value("package_paths", ()),
        "xacro_args": dict(kept_value("xacro_args", ())),
        "trust_xacro": kept_value("trust_xacro", False),
    }


SCENE = together(
    DESCRIPTION,
    kept(
        "--scene",
        "scene_file",
        type=PATH,
        metavar="FILE",
        multiple=True,
        help="TOML: friction, motors, payloads, wrenches, base; robodyn scene init writes one. Repeatable: merged.",
    ),
    kept(
        "--payload",
        "payloads",
        type=Parsed("payload", _payload),
        metavar="LINK=KG[@X,Y,Z]",
        multiple=True,
        help="A mass on a link, its centre in m in the link's frame; repeatable, beside those of the scene.",
    ),
    kept("--gravity", type=VECTOR, metavar="X,Y,Z", help="m/s^2 in the base frame; default 0,0,-9.81."),
)
"""The options that `robot_in_scene` takes: of the description, --scene, --payload and --gravity."""
BASE_HELD = kept("--base-held", is_flag=True, help="The base is bolted down, or something carries it: do not warn.")


def scene_names() -> tuple[str, ...]:
    """Return the files that --scene names."""
    found: tuple[str, ...] = kept_value("scene_file", ())
    return found


def scene_name() -> str | None:
    """Return what messages call the files that --scene names."""
    return " + ".join(scene_names()) or None


def payloads() -> tuple[Payload, ...]:
    """Return what --payload says."""
    found: tuple[Payload, ...] = kept_value("payloads", ())
    return found


def gravity() -> Vector | None:
    """Return what --gravity says."""
    found: Vector | None = kept_value("gravity", None)
    return found


AT = click.option("--at", type=VALUES, metavar="Q", help="Joint values in order, or JOINT=Q,...; the rest 0.")
QD = click.option("--qd", type=VALUES, metavar="QD", help="Velocities, likewise; default at rest.")
FORMAT = kept(
    "--format", "form", type=click.Choice(["text", "json"]), default="text", help="Form of the report; default text."
)


def EXECUTION(command: Callback) -> Callback:
    """Return the options --executor and --threads."""
    from robodyn.programs.run.choice import EXECUTORS

    text = "numpy starts at once, compiled makes machine code; default auto: the quicker."
    threads = click.option("--threads", type=click.IntRange(min=1), metavar="N", help="For machine code; default all.")
    executor = click.option("--executor", type=click.Choice(EXECUTORS), default="auto", help=text)
    decorated: Callback = together(executor, threads)(command)
    return decorated
