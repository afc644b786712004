"""Free bodies as drawings: one SVG each, isometric, with its forces, moments and a table of their components."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from math import floor, hypot, log10, sqrt
from typing import NamedTuple

import numpy as np

from robodyn.equations.free_body.bodies import Action, FreeBodies, FreeBody
from robodyn.programs.vectors import Array, length, product
from robodyn.report.sizes import Sizes, free_body_sizes
from robodyn.report.table import is_noise, number
from robodyn.support.wording import shortened

Point = tuple[float, float]
EYES = np.array(((-1, 1, 0), (-1, -1, 2), (1, 1, 1))) / np.sqrt(((2,), (6,), (3,)))
"""Ground axes to right, up, and towards the reader, who looks from (1, 1, 1)."""
COLOURS = {
    "weight": "#2b8a3e",
    "drive": "#d6336c",
    **dict.fromkeys(("inertial", "rotor inertia", "coupled motor", "gyroscopic moment"), "#9c5fd0"),
    **dict.fromkeys(("reaction", "loop forces"), "#2f7fd6"),
    **dict.fromkeys(("viscous friction", "coulomb friction", "load friction"), "#b8680b"),
    **dict.fromkeys(("joint spring", "limit spring", "fluid"), "#11837f"),
    **dict.fromkeys(("external wrench", "contact forces"), "#d9480f"),
}
OTHER = "#6d7583"
"""By kind of action, and of kinds without one; each can be read on white and on black."""
WIDTH, TOP, BOTTOM = 800, 76, 560
"""Of the paper, and where arrows lie, below a title and above a table [px]."""
_SIZE = 15  # of labels
LONGEST, SHORTEST = 120.0, 42.0
"""Arrows in pixels; the largest force and the largest moment are the longest."""
_BESIDE = 12.0
"""Between arrows that leave the same spot in about the same direction [px]."""
_ROW = 22
_HEADS = ((24, "symbol"), (134, "action, by"), (400, "force [N]"), (600, "moment [N m]"))
_PARTS = {"force": "N", "moment": "N m"}
NOTES = (
    "Components in body axes; forces and moments add up to zero. Arrows are to scale, but none is too short to see.",
    "Numbered disc: joint. Quartered disc: mass centre. Dashed arrow with two heads: moment, by the right-hand rule.",
    "Ring with a dot: towards the reader; with a cross: away.",
)
_ASIDE = ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (2, 0), (-2, 0), (3, 0), (-3, 0))


def symbols(action: Action, size: Sizes) -> str:
    """Return the symbols of those of its force and moment that are no noise."""
    parts = zip(_PARTS.items(), action.symbols, strict=True)
    shown = (signed(x) for (part, unit), x in parts if x and not is_noise(length(getattr(action, part)), size[unit]))
    return ", ".join(dict.fromkeys(shown)) or "-"


def signed(symbol: str) -> str:
    """Return a symbol as it is printed, with a true minus."""
    words = {"-ma": "\u2212m a", "-dH": "\u2212dH/dt"}
    return words.get(symbol, symbol.replace("-", "\u2212"))


def svg_text(
    x: float, y: float, text: str, size: float, look: str, *, bold: bool = False, centred: bool = False
) -> str:
    """Return an element of text, in the look of a class of the style or in a colour."""
    shown = f'{"fill" if look[0] == "#" else "class"}="{look}"'
    weight = ' font-weight="bold"' if bold else ""
    where = f'x="{x:.1f}" y="{y:.1f}" text-anchor="{"middle" if centred else "start"}"'
    return f'<text {where} font-size="{size}"{weight} {shown}>{escape(text)}</text>'


STYLE = """<style>
text { font-family: "DejaVu Sans", Verdana, Arial, sans-serif; }
.paper { fill: #ffffff; } .ink { fill: #1c1e22; } .soft { fill: #5c6370; } .line { stroke: #5c6370; }
.body { stroke: #d5dae2; } .edge { stroke: #8b93a1; } .mark { fill: #ffffff; stroke: #1c1e22; }
@media (prefers-color-scheme: dark) {
.paper { fill: #16181d; } .ink { fill: #f0f1f3; } .soft { fill: #a7aebb; } .line { stroke: #a7aebb; }
.body { stroke: #3a404b; } .edge { stroke: #6d7583; } .mark { fill: #16181d; stroke: #f0f1f3; }
}
</style>"""


def drawings(found: FreeBodies, state: str) -> Iterator[tuple[str, str]]:
    """Yield (name of a file, SVG) of every body."""
    size = free_body_sizes(found)
    for body in found.bodies:
        safe = "".join(c if c.isalnum() or c in "-_." else "_" for c in body.name)
        yield f"{body.number:02d}_{safe}.svg", drawing(body, f"{found.robot}, {state}", size)


def drawing(body: FreeBody, title: str, size: Sizes) -> str:
    """Return the SVG of one body, isometric from (1, 1, 1) of the ground's frame, below it its actions in numbers."""
    width, height = WIDTH, BOTTOM + _ROW * (len(body.actions) + len(NOTES)) + 56
    title, name = (
        text if len(text) <= most else f"{text[: most - 3]}..." for text, most in ((title, 95), (body.name, 48))
    )
    line = BOTTOM + 12
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}">',
        STYLE,
        f'<rect class="paper" width="{width}" height="{height}"/>',
        svg_text(24, 36, f"Body {body.number}: {name}", 20, "ink", bold=True),
        svg_text(24, 60, title, 13, "soft"),
        *_scene(body, size),
        f'<line class="line" x1="24" x2="{width - 24}" y1="{line}" y2="{line}" stroke-width="1"/>',
        *(svg_text(x, BOTTOM + 34, head, 13, "soft") for x, head in _HEADS),
    ]
    scales = [max(float(np.abs(getattr(a, part)).max()) for a in body.actions) for part in _PARTS if body.actions]
    whats = shortened([f"{action.what}, by {action.by}" for action in body.actions], most=42)
    for row, (action, what) in enumerate(zip(body.actions, whats, strict=True), start=1):
        y = BOTTOM + 34 + row * _ROW
        parts.append(svg_text(24, y, symbols(action, size), 12, COLOURS.get(action.kind, OTHER), bold=True))
        cells = [what]
        for (part, unit), scale in zip(_PARTS.items(), scales, strict=True):
            vector, cell = getattr(action, part), "0"
            if not is_noise(length(vector), size[unit]):
                power = floor(log10(scale))
                decimals = max(0, 3 - power) if power >= 0 else 2 - power
                form = f".{decimals}f" if -4 <= power < 7 else ".2e"
                components = (f"{x:{form}}" if form == ".2e" or float(f"{x:{form}}") else "0" for x in vector.tolist())
                cell = f"({', '.join(components)})"
            cells.append(cell)
        parts += [svg_text(x, y, cell, 12, "ink") for (x, _), cell in zip(_HEADS[1:], cells, strict=True)]
    for row, note in enumerate(NOTES, start=len(body.actions) + 1):
        parts.append(svg_text(24, BOTTOM + 34 + row * _ROW, note, 12, "soft"))
    return "\n".join([*parts, "</svg>\n"])


def _scene(body: FreeBody, size: Sizes) -> Iterator[str]:
    """Yield the body, which fits between its arrows, these with their labels, and the axes of ground and body."""
    places = [np.zeros(3), body.com, *(point for _, point in body.ends)]
    everything = np.array([on_paper(product(body.pose.R, p)) for p in [*places, *(a.point for a in body.actions)]])
    low, high = everything.min(axis=0), everything.max(axis=0)
    room = (WIDTH - 440.0, BOTTOM - TOP - 310.0)  # labels have the edges
    scale = min((r / s for r, s in zip(room, high - low, strict=True) if s > 1e-9), default=1.0)
    centre = np.array([WIDTH / 2, (TOP + BOTTOM) / 2])
    at = [(float(x), float(y)) for x, y in (everything - (low + high) / 2) * scale + centre]
    (origin, com, *ends), spots = at[: len(places)], at[len(places) :]
    lines = "".join(f"M{com[0]:.1f} {com[1]:.1f}L{x:.1f} {y:.1f}" for x, y in (origin, *ends, *spots))
    path = f'd="{lines}" fill="none" stroke-linecap="round" stroke-linejoin="round"'
    yield from (f'<path class="edge" {path} stroke-width="46"/>', f'<path class="body" {path} stroke-width="43"/>')
    vectors = arrows(body, spots, size)
    for vector in vectors:
        yield from vector.elements()
    if body.mass:
        x, y = com
        quarters = f"M{x:.1f} {y:.1f}h7a7 7 0 0 0 -7 -7zM{x:.1f} {y:.1f}h-7a7 7 0 0 0 7 7z"
        yield f'<circle class="mark" cx="{x:.1f}" cy="{y:.1f}" r="7" stroke-width="1.5"/>'
        yield f'<path class="ink" d="{quarters}"/>'
    marks = [com]  # beside one another where they would coincide
    for spot, joint in zip((origin, *ends), (body.number, *(joint for joint, _ in body.ends)), strict=True):
        tries = [(spot[0] + 20 * dx, spot[1] + 20 * dy) for dx, dy in _ASIDE]
        free = (each for each in tries if all(hypot(each[0] - a, each[1] - b) >= 18 for a, b in marks))
        marks.append(next(free, tries[0]))
        x, y = marks[-1]
        yield f'<circle class="mark" cx="{x:.1f}" cy="{y:.1f}" r="9" stroke-width="1.5"/>'
        yield svg_text(x, y + 4.2, str(joint), 12, "ink", centred=True)
    taken: list[tuple[float, float, float]] = []
    for vector in vectors:  # a label stands beyond the tip, below those that are there already
        label = f"{signed(vector.symbol)} = {number(vector.value)} {vector.unit}"
        half = 0.32 * _SIZE * len(label)  # rather more than less
        x = vector.end[0] + (half + 8) * vector.direction[0]
        x = min(max(x, half + 8), WIDTH - half - 8)
        y = min(max(vector.end[1] + 18 * vector.direction[1], TOP + 18), BOTTOM - 130)
        while any(abs(x - there) < half + wide and abs(y - row) < 20 for there, row, wide in taken):
            y = y + 4 if y < BOTTOM - 8 else TOP + 18
        taken.append((x, y, half))
        if hypot(x - vector.end[0], y - vector.end[1]) > half + 40:
            far = f'x1="{vector.end[0]:.1f}" y1="{vector.end[1]:.1f}" x2="{x:.1f}" y2="{y - 10:.1f}"'
            yield f'<line class="line" {far} stroke-width="1" stroke-dasharray="2 3"/>'
        yield svg_text(x, y + 5, label, _SIZE, vector.colour, bold=True, centred=True)
    for x, R, name in ((70.0, np.eye(3), "ground"), (190.0, body.pose.R, "body")):
        y = BOTTOM - 58.0
        for k, letter in enumerate("xyz"):
            dx, dy = (34 * part for part in on_paper(R[:, k]))
            yield f'<line class="line" x1="{x}" y1="{y}" x2="{x + dx:.1f}" y2="{y + dy:.1f}" stroke-width="2"/>'
            yield svg_text(x + 1.3 * dx, y + 1.3 * dy + 4, letter, 13, "soft", centred=True)
        yield svg_text(x, y + 60, name, 12, "soft", centred=True)


def on_paper(vector: Array) -> Point:
    """Return a vector in ground axes as (right, down)."""
    right, up, _ = product(EYES, vector)
    return float(right), -float(up)


class Arrow(NamedTuple):
    """A vector on paper, with symbol, value and unit for its label.

    Attributes:
        start, end: px; equal for a vector along the line of sight, which then points `towards` the reader or away.
        direction: of unit length.
        turning: a moment, drawn with two heads.
    """

    colour: str
    symbol: str
    value: float
    unit: str
    start: Point
    end: Point
    direction: Point
    towards: bool
    turning: bool

    def elements(self) -> Iterator[str]:
        """Yield the elements of its drawing."""
        (x0, y0), (x1, y1), (dx, dy) = self.start, self.end, self.direction
        if self.start == self.end:
            yield f'<circle cx="{x0:.1f}" cy="{y0:.1f}" r="9" fill="none" stroke="{self.colour}" stroke-width="2.5"/>'
            dot = f'<circle cx="{x0:.1f}" cy="{y0:.1f}" r="3.5" fill="{self.colour}"/>'
            cross = f"M{x0 - 6:.1f} {y0 - 6:.1f}l12 12m0 -12l-12 12"
            yield dot if self.towards else f'<path d="{cross}" stroke="{self.colour}" stroke-width="2"/>'
            return
        dashes = ' stroke-dasharray="7 4"' if self.turning else ""
        stem = f"M{x0:.1f} {y0:.1f}L{x1 - 8 * dx:.1f} {y1 - 8 * dy:.1f}"
        yield f'<path d="{stem}" stroke="{self.colour}" stroke-width="3"{dashes}/>'
        for back in (0, 10) if self.turning else (0,):
            tip, tail = (x1 - back * dx, y1 - back * dy), (x1 - (back + 14) * dx, y1 - (back + 14) * dy)
            corners = tip, (tail[0] - 6 * dy, tail[1] + 6 * dx), (tail[0] + 6 * dy, tail[1] - 6 * dx)
            yield f'<polygon points="{" ".join(f"{a:.1f},{b:.1f}" for a, b in corners)}" fill="{self.colour}"/>'


def arrows(body: FreeBody, spots: list[Point], size: Sizes) -> list[Arrow]:
    """Return the arrows of every force and moment that is no noise beside the largest, each at its spot on paper."""
    found: list[Arrow] = []
    for turning, (name, unit) in enumerate(_PARTS.items()):
        amounts = [length(getattr(action, name)) for action in body.actions]
        for action, amount, (x, y) in zip(body.actions, amounts, spots, strict=True):
            if is_noise(amount, size[unit]):
                continue
            along = product(body.pose.R, getattr(action, name)) / amount
            right, down = on_paper(along)
            long = hypot(right, down) * sqrt(1.5) * max(SHORTEST, LONGEST * amount / max(amounts))
            flat = long >= 14.0  # else it points at the reader or away, and is a disc
            way = (right / hypot(right, down), down / hypot(right, down)) if flat else (0.0, -1.0)
            aside = 0.0
            for other in found:  # arrows that leave about the same spot in about the same direction
                near = hypot(other.start[0] - x, other.start[1] - y) < 3 * _BESIDE
                cosine = way[0] * other.direction[0] + way[1] * other.direction[1]
                aside += _BESIDE * (near and flat == (other.start != other.end) and cosine > 0.97)
            start = (x - way[1] * aside, y + way[0] * aside)
            end = (start[0] + long * way[0], start[1] + long * way[1]) if flat else start
            towards = bool(product(EYES[2], along) > 0)
            colour, symbol = COLOURS.get(action.kind, OTHER), action.symbols[turning]
            found.append(Arrow(colour, symbol, amount, unit, start, end, way, towards, bool(turning)))
    return found
