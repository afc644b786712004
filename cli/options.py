"""Types of options."""

from __future__ import annotations

import math

import click

Vector = tuple[float, float, float]


class VectorType(click.ParamType):  # type: ignore[type-arg,unused-ignore]
    """Three numbers between commas."""

    name = "vector"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> Vector:
        parts = str(value).split(",")
        try:
            numbers = [float(part) for part in parts]
        except ValueError:
            numbers = []
        if len(numbers) != 3 or not all(map(math.isfinite, numbers)):
            self.fail(f"{value!r} is not three numbers between commas, such as 0,0,-9.81", param, ctx)
        x, y, z = numbers
        return x, y, z


VECTOR = VectorType()
