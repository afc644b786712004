"""Words of a drawing: symbols, colours, text, and the table of a free body's forces and moments."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from math import floor, log10

import numpy as np

from robodyn.equations.free_body.types import Action, FreeBody
from robodyn.programs.vectors import length
from robodyn.report.sizes import Sizes
from robodyn.report.table import is_noise
from robodyn.support.floats import Floats
from robodyn.support.wording import shortened

COLOURS = {
    "weight": "#2b8a3e",
    "inertial": "#9c5fd0",
    "reaction": "#2f7fd6",
    "drive": "#d6336c",
    "viscous friction": "#b8680b",
    "coulomb friction": "#b8680b",
    "load friction": "#b8680b",
    "rotor inertia": "#9c5fd0",
    "coupled motor": "#9c5fd0",
    "gyroscopic moment": "#9c5fd0",
    "joint spring": "#11837f",
    "limit spring": "#11837f",
    "external wrench": "#d9480f",
    "loop forces": "#2f7fd6",
    "contact forces": "#d9480f",
    "fluid": "#11837f",
}
"""By kind of action; each can be read on white and on black."""
_ROW = 22
_LETTERS = 42
"""So many of what an action is and by whom have room in the table."""
_PARTS = ("force", "moment")
_HEADS = ((24, "symbol"), (134, "action, by"), (400, "force [N]"), (600, "moment [N m]"))
NOTES = (
    "Components in body axes; forces and moments add up to zero. Arrows are to scale, but none is too short to see.",
    "Numbered disc: joint. Quartered disc: mass centre. Dashed arrow with two heads: moment, by the right-hand rule.",
    "Ring with a dot: towards the reader; with a cross: away.",
)


def table_height(body: FreeBody) -> int:
    """Return the height of `component_table` [px]."""
    return _ROW * (len(body.actions) + len(NOTES)) + 56


def component_table(body: FreeBody, top: float, width: float, size: Sizes) -> Iterator[str]:
    """Yield every action with its components, and what the marks mean, below a line at `top`."""
    y = top + 34
    yield f'<line class="line" x1="24" x2="{width - 24}" y1="{top + 12}" y2="{top + 12}" stroke-width="1"/>'
    for x, head in _HEADS:
        yield svg_text(x, y, head, 13, "soft")
    scales = [max((float(np.abs(getattr(a, name)).max()) for a in body.actions), default=0.0) for name in _PARTS]
    whats = shortened([f"{action.what}, by {action.by}" for action in body.actions], _LETTERS)
    for action, what in zip(body.actions, whats, strict=True):
        y += _ROW
        cells = _cells(action, what, scales, size)
        yield svg_text(24, y, cells[0], 12, None, bold=True, fill=COLOURS[action.kind])
        for (x, _), cell in zip(_HEADS[1:], cells[1:], strict=True):
            yield svg_text(x, y, cell, 12, "ink")
    for note in NOTES:
        y += _ROW
        yield svg_text(24, y, note, 12, "soft")


def _cells(action: Action, what: str, scales: list[float], size: Sizes) -> tuple[str, str, str, str]:
    vectors = []
    for name, unit, scale in zip(_PARTS, ("N", "N m"), scales, strict=True):
        vector = getattr(action, name)
        shown = not is_noise(_length(vector), size[unit])
        vectors.append(_components(vector, scale) if shown else "0")
    return symbols(action, size), what, vectors[0], vectors[1]


def symbols(action: Action, size: Sizes) -> str:
    """Return the symbols of those of its force and moment that are no noise."""
    parts = zip((action.force, action.moment), ("N", "N m"), action.symbols, strict=True)
    shown = (signed(symbol) for vector, unit, symbol in parts if symbol and not is_noise(_length(vector), size[unit]))
    return ", ".join(dict.fromkeys(shown)) or "-"


def _length(vector: Floats) -> float:
    return length(vector)


def _components(vector: Floats, scale: float) -> str:
    """Return components with as many decimals as show three or four digits of the largest component on the body."""
    power = floor(log10(scale))
    if not -4 <= power < 7:
        return "({})".format(", ".join(f"{x:.2e}" for x in vector))
    decimals = max(0, 3 - power) if power >= 0 else 2 - power
    rounded = [round(x, decimals) for x in vector.tolist()]
    return "({})".format(", ".join(f"{x:.{decimals}f}" if x else "0" for x in rounded))


def signed(symbol: str) -> str:
    """Return a symbol as it is printed, with a true minus."""
    words = {"-ma": "\u2212m a", "-dH": "\u2212dH/dt"}
    return words.get(symbol, symbol.replace("-", "\u2212"))


def short(text: str, most: int) -> str:
    """Return the text, cut to so many characters."""
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
    """Return an element of text, in the look of a class of the style or in a colour."""
    look = f'class="{kind}"' if kind else f'fill="{fill}"'
    weight = ' font-weight="bold"' if bold else ""
    where = f'x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"'
    return f'<text {where} font-size="{size}"{weight} {look}>{escape(text)}</text>'
