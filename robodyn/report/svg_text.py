"""Words of a drawing: symbols, colours, text, and the table of a free body's forces and moments."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from math import floor, log10

import numpy as np

from robodyn.free_body.types import Action, Floats, FreeBody
from robodyn.report.sizes import Sizes
from robodyn.report.table import is_noise

COLOURS = {
    "weight": "#2b8a3e",
    "inertial": "#9c5fd0",
    "reaction": "#2f7fd6",
    "drive": "#d6336c",
    "viscous friction": "#b8680b",
    "coulomb friction": "#b8680b",
    "rotor inertia": "#9c5fd0",
    "joint spring": "#11837f",
    "limit spring": "#11837f",
    "external wrench": "#d9480f",
    "fluid": "#11837f",
}
"""By kind of action; each can be read on white and on black."""
_ROW = 22
_PARTS = ("force", "moment")
_HEADS = ((24, "symbol"), (134, "action, by"), (400, "force [N]"), (600, "moment [N m]"))
_NOTES = (
    "Components in body axes; forces and moments add up to zero. Arrows are to scale, but none is too short to see.",
    "Numbered disc: joint. Quartered disc: mass centre. Dashed arrow with two heads: moment, by the right-hand rule.",
    "Ring with a dot: towards the reader; with a cross: away.",
)


def table_height(body: FreeBody) -> int:
    """Of `component_table` [px]."""
    return _ROW * (len(body.actions) + len(_NOTES)) + 56


def component_table(body: FreeBody, top: float, width: float, size: Sizes) -> Iterator[str]:
    """Every action with its components, and what the marks mean, below a line at `top`."""
    y = top + 34
    yield f'<line class="line" x1="24" x2="{width - 24}" y1="{top + 12}" y2="{top + 12}" stroke-width="1"/>'
    for x, head in _HEADS:
        yield svg_text(x, y, head, 13, "soft")
    scales = [max((float(np.abs(getattr(a, name)).max()) for a in body.actions), default=0.0) for name in _PARTS]
    for action in body.actions:
        y += _ROW
        cells = _cells(action, scales, size)
        yield svg_text(24, y, cells[0], 12, None, bold=True, fill=COLOURS[action.kind])
        for (x, _), cell in zip(_HEADS[1:], cells[1:], strict=True):
            yield svg_text(x, y, cell, 12, "ink")
    for note in _NOTES:
        y += _ROW
        yield svg_text(24, y, note, 12, "soft")


def _cells(action: Action, scales: list[float], size: Sizes) -> tuple[str, str, str, str]:
    vectors = []
    symbols = []
    for name, unit, scale, symbol in zip(_PARTS, ("N", "N m"), scales, action.symbols, strict=True):
        vector = getattr(action, name)
        shown = not is_noise(float(np.linalg.norm(vector)), size[unit])
        vectors.append(_components(vector, scale) if shown else "0")
        if shown and symbol and signed(symbol) not in symbols:
            symbols.append(signed(symbol))
    what = f"{action.what}, by {action.by}"
    return ", ".join(symbols) or "-", short(what, 38), vectors[0], vectors[1]


def _components(vector: Floats, scale: float) -> str:
    """As many decimals as show three or four digits of the largest component on the body."""
    power = floor(log10(scale))
    if not -4 <= power < 7:
        return "({})".format(", ".join(f"{x:.2e}" for x in vector))
    decimals = max(0, 3 - power) if power >= 0 else 2 - power
    rounded = [round(x, decimals) for x in vector.tolist()]
    return "({})".format(", ".join(f"{x:.{decimals}f}" if x else "0" for x in rounded))


def signed(symbol: str) -> str:
    """A symbol as it is printed, with a true minus."""
    words = {"-ma": "\u2212m a", "-dH": "\u2212dH/dt"}
    return words.get(symbol, symbol.replace("-", "\u2212"))


def short(text: str, most: int) -> str:
    """The text, cut to so many characters."""
    return text if len(text) <= most else text[: most - 3] + "..."


def svg_text(
    x: float,
    y: float,
    text: str,
    size: float,
    kind: str | None,
    *,
    bold: bool = False,
    anchor: str = "start",
    fill: str = "",
) -> str:
    """An element of text, in the look of a class of the style or in a colour."""
    look = f'class="{kind}"' if kind else f'fill="{fill}"'
    weight = ' font-weight="bold"' if bold else ""
    where = f'x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"'
    return f'<text {where} font-size="{size}"{weight} {look}>{escape(text)}</text>'
