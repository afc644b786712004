"""Free bodies as drawings: one SVG each, with its forces, moments and a table of their components."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from math import floor, hypot, log10
from typing import NamedTuple

import numpy as np

from robodyn.equations.free_body.types import Action, FreeBodies, FreeBody
from robodyn.programs.vectors import length, product
from robodyn.report.pictures.arrows import Arrow, Box, Point, Segment, arrows, on_paper, place, text_width
from robodyn.report.sizes import Sizes, free_body_sizes
from robodyn.report.table import is_noise, number
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
        shown = not is_noise(_magnitude(vector), size[unit])
        vectors.append(_components(vector, scale) if shown else "0")
    return symbols(action, size), what, vectors[0], vectors[1]


def symbols(action: Action, size: Sizes) -> str:
    """Return the symbols of those of its force and moment that are no noise."""
    parts = zip((action.force, action.moment), ("N", "N m"), action.symbols, strict=True)
    shown = (
        signed(symbol) for vector, unit, symbol in parts if symbol and not is_noise(_magnitude(vector), size[unit])
    )
    return ", ".join(dict.fromkeys(shown)) or "-"


def _magnitude(vector: Floats) -> float:
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


class Paper(NamedTuple):
    """The room of a drawing [px]: arrows lie between `top` and `bottom`, and leave the edges of the page to labels."""

    width: int
    top: int
    bottom: int
    edges: tuple[float, float]


SHEET = Paper(800, 76, 560, (440.0, 310.0))
"""Of a file: with a title above and a table below."""
PAGE = Paper(520, 0, 440, (400.0, 290.0))
"""Of a report, which has its own title and table."""
_SIZE = 15
PAPERS = ("#ffffff", "#16181d")
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
    """Return the SVG of one body: isometric, seen from (1, 1, 1) of the ground's frame, which stands upright.

    Args:
        size: of forces and moments on the robot, beside which noise vanishes.
    """
    width, height = SHEET.width, SHEET.bottom + table_height(body)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}">',
        STYLE,
        f'<rect class="paper" width="{width}" height="{height}"/>',
        svg_text(24, 36, f"Body {body.number}: {short(body.name, 48)}", 20, "ink", bold=True),
        svg_text(24, 60, short(title, 95), 13, "soft"),
        *_scene(body, size, SHEET),
        *component_table(body, SHEET.bottom, width, size),
        "</svg>\n",
    ]
    return "\n".join(parts)


def page_drawing(body: FreeBody, size: Sizes) -> str:
    """Return the drawing without words around it, for a page whose width it takes."""
    box = f"0 0 {PAGE.width} {PAGE.bottom + 8}"
    return "\n".join((f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}">', *_scene(body, size, PAGE), "</svg>"))


def _scene(body: FreeBody, size: Sizes, paper: Paper) -> Iterator[str]:
    """Yield the body, its arrows with their labels, and the axes of ground and body."""
    points, spots = _layout(body, paper)
    vectors, marks = arrows(body, spots, size), _apart(points)
    yield from _shape([*points, *spots.values()])
    yield from map(_arrow, vectors)
    yield from _marks(body, marks)
    yield from _labels(marks, vectors, paper)
    yield from _triad(70.0, paper.bottom - 58.0, np.eye(3), "ground")
    yield from _triad(190.0, paper.bottom - 58.0, body.pose.R, "body")


def _layout(body: FreeBody, paper: Paper) -> tuple[list[Point], dict[int, Point]]:
    """Return origin, mass centre and ends on paper, and where each action is; the body fits between its arrows."""
    places = [np.zeros(3), body.com, *(point for _, point in body.ends)]
    everything = np.array([on_paper(product(body.pose.R, p)) for p in [*places, *(a.point for a in body.actions)]])
    low, high = everything.min(axis=0), everything.max(axis=0)
    spread = high - low
    room = np.array([paper.width, paper.bottom - paper.top]) - paper.edges
    scale = min((r / s for r, s in zip(room, spread, strict=True) if s > 1e-9), default=1.0)
    centre = np.array([paper.width / 2, (paper.top + paper.bottom) / 2])
    at = [(float(x), float(y)) for x, y in (everything - (low + high) / 2) * scale + centre]
    return at[: len(places)], dict(enumerate(at[len(places) :]))


def _shape(points: list[Point]) -> list[str]:
    """Return a bar from the mass centre to the origin and to every end."""
    origin, com, *ends = points
    lines = "".join(f"M{com[0]:.1f} {com[1]:.1f}L{x:.1f} {y:.1f}" for x, y in (origin, *ends))
    path = f'd="{lines}" fill="none" stroke-linecap="round" stroke-linejoin="round"'
    return [f'<path class="edge" {path} stroke-width="46"/>', f'<path class="body" {path} stroke-width="43"/>']


def _apart(points: list[Point]) -> list[Point]:
    """Return where the marks of origin, mass centre and ends go: beside one another where they would coincide."""
    origin, com, *ends = points
    taken = [com]
    for x, y in (origin, *ends):
        tries = [(x + 20 * dx, y + 20 * dy) for dx, dy in _ASIDE]
        free = [at for at in tries if all(hypot(at[0] - a, at[1] - b) >= 18 for a, b in taken)]
        taken.append((free or tries)[0])
    return [taken[1], com, *taken[2:]]


_ASIDE = ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (2, 0), (-2, 0), (3, 0), (-3, 0))


def _marks(body: FreeBody, points: list[Point]) -> Iterator[str]:
    """Yield discs at joints with their numbers, and a quartered disc at the mass centre."""
    origin, (x, y), *ends = points
    numbers = (body.number, *(number for number, _ in body.ends))
    if body.mass:
        yield f'<circle class="mark" cx="{x:.1f}" cy="{y:.1f}" r="7" stroke-width="1.5"/>'
        quarters = f"M{x:.1f} {y:.1f}h7a7 7 0 0 0 -7 -7zM{x:.1f} {y:.1f}h-7a7 7 0 0 0 7 7z"
        yield f'<path class="ink" d="{quarters}"/>'
    for (px, py), joint in zip((origin, *ends), numbers, strict=True):
        yield f'<circle class="mark" cx="{px:.1f}" cy="{py:.1f}" r="9" stroke-width="1.5"/>'
        yield svg_text(px, py + 4.2, str(joint), 12, "ink", anchor="middle")


def _arrow(arrow: Arrow) -> str:
    colour = COLOURS[arrow.kind]
    (x0, y0), (x1, y1) = arrow.start, arrow.end
    if arrow.start == arrow.end:
        ring = f'<circle cx="{x0:.1f}" cy="{y0:.1f}" r="9" fill="none" stroke="{colour}" stroke-width="2.5"/>'
        if arrow.towards:
            return f'{ring}<circle cx="{x0:.1f}" cy="{y0:.1f}" r="3.5" fill="{colour}"/>'
        cross = f"M{x0 - 6:.1f} {y0 - 6:.1f}l12 12m0 -12l-12 12"
        return f'{ring}<path d="{cross}" stroke="{colour}" stroke-width="2"/>'
    dx, dy = arrow.direction
    dashes = ' stroke-dasharray="7 4"' if arrow.turning else ""
    stem = f'd="M{x0:.1f} {y0:.1f}L{x1 - 8 * dx:.1f} {y1 - 8 * dy:.1f}" stroke="{colour}" stroke-width="3"'
    heads = [_head(x1 - back * dx, y1 - back * dy, dx, dy, colour) for back in ((0, 10) if arrow.turning else (0,))]
    return f"<path {stem}{dashes}/>{''.join(heads)}"


def _head(x: float, y: float, dx: float, dy: float, colour: str) -> str:
    back_x, back_y = x - 14 * dx, y - 14 * dy
    corners = (x, y), (back_x - 6 * dy, back_y + 6 * dx), (back_x + 6 * dy, back_y - 6 * dx)
    return f'<polygon points="{" ".join(f"{a:.1f},{b:.1f}" for a, b in corners)}" fill="{colour}"/>'


def _labels(points: list[Point], vectors: list[Arrow], paper: Paper) -> Iterator[str]:
    """Yield symbol and size of each arrow beside its tip."""
    lines: list[Segment] = [(vector.start, vector.end) for vector in vectors]
    discs = [*points, *(vector.start for vector in vectors if vector.start == vector.end)]
    taken = [Box(x - 11, y - 11, x + 11, y + 11) for x, y in discs]
    taken.append(Box(0, paper.bottom - 112, 250, paper.bottom))
    taken += [Box(x - 8, y - 8, x + 8, y + 8) for x, y in (vector.end for vector in vectors)]
    page = Box(8, paper.top, paper.width - 8, paper.bottom)
    for vector in vectors:
        label = f"{signed(vector.symbol)} = {number(vector.value)} {vector.unit}"
        size = (text_width(label, _SIZE), 20.0)
        box = place(vector.end, vector.direction, size, taken, lines, page)
        taken.append(box)
        near = (min(max(vector.end[0], box.left), box.right), min(max(vector.end[1], box.top), box.bottom))
        if abs(near[0] - vector.end[0]) + abs(near[1] - vector.end[1]) > 30:
            ends = f'x1="{vector.end[0]:.1f}" y1="{vector.end[1]:.1f}" x2="{near[0]:.1f}" y2="{near[1]:.1f}"'
            yield f'<line class="line" {ends} stroke-width="1" stroke-dasharray="2 3"/>'
        middle = (box.left + box.right) / 2
        colour = COLOURS[vector.kind]
        yield svg_text(middle, box.bottom - 5, label, _SIZE, None, bold=True, anchor="middle", fill=colour)


def _triad(x: float, y: float, R: Floats, name: str) -> Iterator[str]:
    """Yield the axes of a frame."""
    for k, letter in enumerate("xyz"):
        dx, dy = (34 * part for part in on_paper(R[:, k]))
        yield f'<line class="line" x1="{x}" y1="{y}" x2="{x + dx:.1f}" y2="{y + dy:.1f}" stroke-width="2"/>'
        yield svg_text(x + 1.3 * dx, y + 1.3 * dy + 4, letter, 13, "soft", anchor="middle")
    yield svg_text(x, y + 60, name, 12, "soft", anchor="middle")
