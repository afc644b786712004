"""Options that commands share, and their types."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import click

from robodyn.execute.choice import EXECUTORS

Callback = Callable[..., Any]
Vector = tuple[float, float, float]


def finite_numbers(text: str) -> list[float]:
    """The numbers between commas; none if one of them is no finite number."""
    try:
        numbers = [] if "_" in text else [float(part) for part in text.split(",")]
    except ValueError:
        return []
    return numbers if all(map(math.isfinite, numbers)) else []


class VectorType(click.ParamType):  # type: ignore[type-arg,unused-ignore]
    """Three numbers between commas."""

    name = "vector"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> Vector:
        numbers = finite_numbers(str(value))
        if len(numbers) != 3:
            self.fail(f"{value!r} is not three finite numbers between commas, such as 0,0,-9.81", param, ctx)
        x, y, z = numbers
        return x, y, z


VECTOR = VectorType()
SCENE = click.option(
    "--scene", "scene_file", metavar="FILE", help="TOML: friction, rotors, springs, payloads, wrenches, fluid, base."
)
GRAVITY = click.option("--gravity", type=VECTOR, metavar="X,Y,Z", help="m/s^2 in the base frame; default 0,0,-9.81.")
FORMAT = click.option(
    "--format", "form", type=click.Choice(["text", "json"]), default="text", help="Form of the report; default text."
)


def EXECUTION(command: Callback) -> Callback:
    """The options --executor and --threads."""
    text = "numpy starts at once, compiled makes machine code; default auto: the quicker."
    threads = click.option("--threads", type=click.IntRange(min=1), metavar="N", help="For machine code; default all.")
    return click.option("--executor", type=click.Choice(EXECUTORS), default="auto", help=text)(threads(command))
