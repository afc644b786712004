"""What `doctor` found as text for a person."""

from __future__ import annotations

from itertools import groupby

from robodyn.measure.doctor import Line, healthy
from robodyn.report.table import printable


def doctor_text(lines: tuple[Line, ...]) -> str:
    """Return a line each with its verdict, group by group, and a sentence on the whole."""
    wide = max(len(line.name) for line in lines)
    parts = [_group(name, list(group), wide) for name, group in groupby(lines, key=lambda line: line.group)]
    broken = [line.name for line in lines if line.verdict == "broken"]
    missing = [line.name for line in lines if line.verdict == "missing"]
    end = "everything that is needed works" if healthy(lines) else f"to be repaired: {', '.join(broken)}"
    if missing:
        end += f"; missing: {', '.join(missing)}"
    return "\n".join([*parts, f"{end}\n"])


def _group(name: str, lines: list[Line], wide: int) -> str:
    rows = [f"  {line.name:<{wide}}  {line.verdict:<7}  {_said(line)}" for line in lines]
    return "".join(f"{printable(row.rstrip())}\n" for row in (name, *rows))


def _said(line: Line) -> str:
    return ": ".join(text for text in (line.found, line.remark) if text)
