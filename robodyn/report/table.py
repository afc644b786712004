"""Tables of text whose numbers stand with their decimal points below one another."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple, TypeVar
from unicodedata import combining, east_asian_width

_NUMBER = re.compile(r"((?:\+- )?[-+<>]?\d+)(\.\d+)?(e[-+]\d+)?")
_GAP = 2
NOTHING = ("", "-")
"""Cells that may stand among numbers."""
NOISE = 1e-12
"""What is smaller beside the largest of its case is rounding noise: other on another processor, and shown as 0."""
NEGLIGIBLE = 2e-9
"""Beside the largest of its case what is smaller comes of the rounding of inputs, as right angles of nine digits have,
and is shown as 0."""

Content = tuple[Sequence[str], Sequence[Sequence[str]]]
"""Titles of columns, and rows."""
T = TypeVar("T")
Columns = list[tuple[str, Callable[[T], str]]]
"""Of each column its title, and what it says of a thing."""


def by_columns(columns: Columns[T], things: Iterable[T]) -> Content:
    return filled([title for title, _ in columns], [[cell(each) for _, cell in columns] for each in things])


def filled(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Content:
    """Return a table without the columns whose cells are all empty."""
    kept = [k for k in range(len(head)) if not rows or any(row[k] for row in rows)]
    return [head[k] for k in kept], [[row[k] for k in kept] for row in rows]


class Page(NamedTuple):
    """How text is shown: its width in characters (None: any), and whether headers are emphasised."""

    width: int | None = None
    bold: bool = False

    def table(self, content: Content) -> str:
        """Return rows below a header: columns of numbers (or empty cells and -) are aligned by decimal point with units
        behind; columns beyond the page's width follow in tables below, each with the first column."""
        head, rows = content
        columns = [_column([title, *(row[k] for row in rows)]) for k, title in enumerate(head)]
        pages: list[list[list[str]]] = [[columns[0]]]
        for column in columns[1:]:
            used = sum(_width(other[0]) + _GAP for other in pages[-1])
            if self.width is not None and used + _width(column[0]) > self.width and len(pages[-1]) > 1:
                pages.append([columns[0]])
            pages[-1].append(column)
        tables = []
        for page in pages:
            first, *lines = [(" " * _GAP).join(line).rstrip() for line in zip(*page, strict=True)]
            tables.append("\n".join([f"\x1b[1m{first}\x1b[0m" if self.bold else first, *lines]) + "\n")
        return "\n".join(tables)


PLAIN = Page()


def number(x: float, scale: float = 0.0) -> str:
    """Return four digits, and 0 for what is negligible beside `scale`."""
    size, scale = abs(x), abs(scale)
    if is_noise(size, scale):
        return "0"
    if 999.95 <= size < 1e7:
        return f"{x:.0f}"
    return f"{x:#.4g}" if size >= 1e-3 else f"{x:.3e}"


def percent(share: float) -> str:
    """Return a share of 100 without digits behind the point."""
    return "<1" if 0.0 < share < 0.5 else f"{share:.0f}"


def is_noise(size: float, scale: float) -> bool:
    """Return whether a magnitude vanishes beside the largest of its case."""
    return size <= NEGLIGIBLE * scale


def moment(when: float, value: float, scale: float) -> str:
    """Return the time or the row at which a value is at its largest; - for noise, which may be so anywhere."""
    return "-" if is_noise(abs(value), scale) else f"{when:.6g}" if isinstance(when, float) else str(when)


def drift_text(drift: float, scale: float) -> str:
    """Return two digits of what should be zero; 0 for rounding noise."""
    return "0" if drift <= NOISE * scale else f"{drift:.1e}"


def relative_text(error: float) -> str:
    """Return a relative error with one digit; of one that is rounding noise only that it is."""
    return f"{error:.0e}" if error > NOISE else f"<{NOISE:.0e}"


def gravity_text(gravity: Sequence[float]) -> str:
    return "gravity ({:g}, {:g}, {:g}) m/s^2".format(*gravity)


def axis_text(direction: Iterable[float], number: str = "{:.4g}", gap: str = ", ") -> str:
    """Return x, -x and so on for a unit vector along a coordinate axis, the components of another."""
    parts = list(direction)
    for letter, value in zip("xyz", parts, strict=True):
        if abs(value) == 1.0:
            return letter if value > 0 else f"-{letter}"
    return f"({gap.join(map(number.format, parts))})"


def point_text(point: Iterable[float], reach: float = 0.0) -> str:
    """Return coordinates in brackets; 0 for what vanishes beside `reach`."""
    return f"({', '.join(number(x, reach) for x in point)})"


def printable(text: str) -> str:
    """Return the text with control characters escaped."""
    return text if text.isprintable() else "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def first_names(names: Sequence[str], most: int) -> str:
    """Return the first names, and how many more there are."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(map(printable, names[:most])) + more


def is_numeric(cells: Sequence[str]) -> bool:
    """Return whether every cell begins with a number, or is empty or -."""
    return all(cell in NOTHING or _NUMBER.match(cell) for cell in cells)


def numeric_columns(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[bool]:
    return [is_numeric([row[k] for row in rows]) for k in range(len(head))]


def _column(cells: Sequence[str]) -> list[str]:
    title, *cells = [printable(cell) for cell in cells]
    if not is_numeric(cells):
        return _left([title, *cells])
    matches = [_NUMBER.match(cell) for cell in cells]
    before = [match.group(1) if match else "" for match in matches]
    after = [cell[len(whole) :] for cell, whole in zip(cells, before, strict=True)]
    digits = [("" if match is None else (match.group(2) or "") + (match.group(3) or "")) for match in matches]
    units = [rest[len(part) :] for rest, part in zip(after, digits, strict=True)]
    whole, part = max(map(len, before)), max(map(len, digits))
    body = _left([f"{a:>{whole}}{b:<{part}}{unit}" for a, b, unit in zip(before, digits, units, strict=True)])
    wide = max(_width(title), _width(body[0]))
    return [" " * (wide - _width(line)) + line for line in (title, *body)]


def _left(cells: Sequence[str]) -> list[str]:
    wide = max(map(_width, cells))
    return [cell + " " * (wide - _width(cell)) for cell in cells]


def _width(text: str) -> int:
    if text.isascii():
        return len(text)
    return sum(0 if combining(char) else 2 if east_asian_width(char) in "WF" else 1 for char in text)
