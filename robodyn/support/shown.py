"""How results show themselves: in at most three lines, and in notebooks also as a short table."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from math import isfinite

from robodyn.errors import printable
from robodyn.support.wording import figure

Cell = str | float | None
_NEGLIGIBLE, _ROWS = 2e-9, 60
"""Beside the largest number of its column; rows that are shown."""


class Shown:
    """A base of classes that say `_lines` and a `_table` of themselves."""

    __slots__ = ()

    def _lines(self) -> Sequence[str]:
        """What it is, in one to three lines."""
        raise NotImplementedError

    def _table(self) -> tuple[Sequence[str], Sequence[Sequence[Cell]]]:
        """Titles of columns, and rows."""
        raise NotImplementedError

    def __repr__(self) -> str:
        lines = "\n ".join(map(printable, self._lines()))
        return f"<{lines}>"

    def _repr_html_(self) -> str:
        head, rows = self._table()
        columns = zip(*rows, strict=True)
        scales = [max((abs(x) for x in each if isinstance(x, float) and isfinite(x)), default=0.0) for each in columns]
        shown = [
            "".join(f"<td>{escape(_text(cell, scale))}</td>" for cell, scale in zip(row, scales, strict=True))
            for row in rows[:_ROWS]
        ]
        shown += [f'<td colspan="{len(head)}">and {len(rows) - _ROWS} more</td>'] if len(rows) > _ROWS else []
        titles = "".join(f"<th>{escape(title)}</th>" for title in head)
        body = "".join(f"<tr>{row}</tr>" for row in shown)
        table = f"<table><thead><tr>{titles}</tr></thead><tbody>{body}</tbody></table>" if rows else ""
        return f"<p>{'<br>'.join(escape(printable(line)) for line in self._lines())}</p>{table}"


def _text(cell: Cell, scale: float) -> str:
    if isinstance(cell, float) and isfinite(cell):
        return "0" if abs(cell) <= _NEGLIGIBLE * scale else figure(cell, 4)
    return printable(cell) if isinstance(cell, str) else "-"
