"""Options that commands share, and their types."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

    from robodyn.scene.scene import Payload

Callback = Callable[..., Any]
Vector = tuple[float, float, float]


def finite_numbers(text: str) -> list[float]:
    """The numbers between commas; none if one of them is no finite number."""
    try:
        numbers = [] if "_" in text else [float(part) for part in text.split(",")]
    except ValueError:
        return []
    return numbers if all(map(math.isfinite, numbers)) else []


class PlaceType(click.ParamType):  # type: ignore[type-arg,unused-ignore]
    """A name that shells complete; whether it is there, and readable, is for those to say who read it."""

    def __init__(self, name: str) -> None:
        """Args: name: "file" or "dir", as shells know them."""
        self.name = name

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        from click.shell_completion import CompletionItem

        return [CompletionItem(incomplete, type=self.name)]


PATH, FOLDER = PlaceType("file"), PlaceType("dir")


class PackagesType(PlaceType):
    """A folder that is there."""

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> str:
        folder = str(value)
        if not os.path.isdir(folder):
            what = "is a file, not a folder" if os.path.isfile(folder) else "there is no such folder"
            self.fail(f"{folder!r}: {what}", param, ctx)
        return folder


class ArgumentType(click.ParamType):  # type: ignore[type-arg,unused-ignore]
    """NAME:=VALUE, as the command xacro takes it."""

    name = "argument"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, str]:
        if isinstance(value, tuple):
            return value
        name, sign, text = str(value).partition(":=")
        if not sign or not name.strip():
            self.fail(f"{value!r} is not NAME:=VALUE, such as prefix:=left_", param, ctx)
        return name.strip(), text


ROBOT_SUFFIXES = (".urdf", ".xacro")


def _kept(ctx: click.Context, param: click.Parameter, value: Any) -> None:
    """Keep the value of an option for those who ask for it, wherever they are called."""
    ctx.meta[f"robodyn.{param.name}"] = value


def _given(name: str) -> tuple[Any, ...]:
    ctx = click.get_current_context(silent=True)
    found: tuple[Any, ...] = () if ctx is None else ctx.meta.get(f"robodyn.{name}", ())
    return found


_KEPT: dict[str, Any] = {"multiple": True, "expose_value": False, "callback": _kept}


def DESCRIPTION(command: Callback) -> Callback:
    """The options --package-path and --xacro-arg, whose values are those of `lookup`."""
    text = "Where packages are looked for first; repeatable."
    folders = click.option(
        "--package-path", "package_paths", type=PackagesType("dir"), metavar="DIR", help=text, **_KEPT
    )
    text = "An argument of a .xacro file; repeatable."
    given = click.option("--xacro-arg", "xacro_args", type=ArgumentType(), metavar="NAME:=VALUE", help=text, **_KEPT)
    return folders(given(command))


def lookup() -> dict[str, Any]:
    """What the options of `DESCRIPTION` say, as `robodyn.load` takes it."""
    return {"package_paths": _given("package_paths"), "xacro_args": dict(_given("xacro_args"))}


class VectorType(click.ParamType):  # type: ignore[type-arg,unused-ignore]
    """Three numbers between commas."""

    name = "vector"

    def __init__(self, example: str) -> None:
        """Args: example: of a value, for messages."""
        self.example = example

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> Vector:
        numbers = finite_numbers(str(value))
        if len(numbers) != 3:
            self.fail(f"{value!r} is not three finite numbers between commas, such as {self.example}", param, ctx)
        x, y, z = numbers
        return x, y, z


VECTOR = VectorType("0,0,-9.81")


class PositiveType(click.ParamType):  # type: ignore[type-arg,unused-ignore]
    """A positive finite number."""

    name = "number"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> float:
        numbers = finite_numbers(str(value))
        if len(numbers) != 1 or numbers[0] <= 0.0:
            self.fail(f"{value} is no positive finite number", param, ctx)
        return numbers[0]


POSITIVE = PositiveType()


class PointType(click.ParamType):  # type: ignore[type-arg,unused-ignore]
    """com, origin, or three numbers between commas."""

    name = "point"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        numbers = finite_numbers(str(value))
        if value in ("com", "origin") or len(numbers) == 3:
            return value if value in ("com", "origin") else tuple(numbers)
        options = [] if ctx is None else [name for each in ctx.command.params for name in each.opts]
        link = "".join(f"; {name} takes the name of a link" for name in ("--frame", "--link") if name in options)
        return self.fail(f"{value!r} is neither com nor origin nor X,Y,Z in m, such as 0,0,0.1{link}", param, ctx)


class AtType(click.ParamType):  # type: ignore[type-arg,unused-ignore]
    """Numbers between commas, or NAME=NUMBER between commas."""

    name = "at"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        text = str(value)
        if "=" not in text:
            numbers = finite_numbers(text)
            if numbers:
                return numbers
        else:
            pairs = [part.rpartition("=") for part in text.split(",")]
            values = finite_numbers(",".join(number for _, _, number in pairs))
            names = [name.strip() for name, _, _ in pairs]
            if len(values) == len(pairs) and all(names) and len(set(names)) == len(names):
                return dict(zip(names, values, strict=True))
            if len(values) == len(pairs) and all(names):
                twice = next(name for k, name in enumerate(names) if name in names[:k])
                self.fail(f"{value!r} names {twice!r} twice", param, ctx)
        return self.fail(f"{value!r} is neither numbers (0.1,-0.2) nor joints (elbow=0.1,wrist=-0.2)", param, ctx)


class PayloadType(click.ParamType):  # type: ignore[type-arg,unused-ignore]
    """LINK=KG or LINK=KG@X,Y,Z."""

    name = "payload"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        from robodyn.scene.scene import Payload

        if isinstance(value, Payload):
            return value
        link, _, text = str(value).rpartition("=")
        mass, at, com = text.partition("@")
        numbers = finite_numbers(mass) + finite_numbers(com if at else "0,0,0")
        if not link or len(numbers) != 4 or "," in mass or numbers[0] <= 0.0:
            self.fail(f"{value!r} is not LINK=KG or LINK=KG@X,Y,Z, such as tool0=2.5@0,0,0.1", param, ctx)
        m, x, y, z = numbers
        return Payload(link, m, (x, y, z))


def SCENE(command: Callback) -> Callback:
    """The options --scene, and --payload, whose values are those of `payloads`."""
    text = "TOML: friction, motors, springs, payloads, wrenches, base; robodyn scene init writes one."
    scene = click.option("--scene", "scene_file", type=PATH, metavar="FILE", help=text)
    text = "A mass on a link, its centre in m in the link's frame; repeatable, beside those of the scene."
    payload = click.option("--payload", "payloads", type=PayloadType(), metavar="LINK=KG[@X,Y,Z]", help=text, **_KEPT)
    return scene(payload(command))


def payloads() -> tuple[Payload, ...]:
    """What --payload says."""
    return _given("payloads")


GRAVITY = click.option("--gravity", type=VECTOR, metavar="X,Y,Z", help="m/s^2 in the base frame; default 0,0,-9.81.")
FORMAT = click.option(
    "--format", "form", type=click.Choice(["text", "json"]), default="text", help="Form of the report; default text."
)


def EXECUTION(command: Callback) -> Callback:
    """The options --executor and --threads."""
    from robodyn.programs.run.choice import EXECUTORS

    text = "numpy starts at once, compiled makes machine code; default auto: the quicker."
    threads = click.option("--threads", type=click.IntRange(min=1), metavar="N", help="For machine code; default all.")
    return click.option("--executor", type=click.Choice(EXECUTORS), default="auto", help=text)(threads(command))
