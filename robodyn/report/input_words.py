"""How a table was read, in sentences: what times count from, and which joints are held."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.loads.result import Result
from robodyn.report.table import printable

_NAMED = 6


def input_words(result: Result, most: int | None = _NAMED) -> Iterator[str]:
    """Yield what a reader of a report has to know of the table to understand its numbers.

    Args:
        most: joints that are named for each place where some are held; None names all.
    """
    if result.origin:
        stamp = f"{result.origin:.6f}".rstrip("0").rstrip(".")
        yield f"Times count from the first stamp of the table, {stamp} s."
    if result.held:
        yield f"Held still, for want of columns: {'; '.join(_places(result, most))}."


def _places(result: Result, most: int | None) -> Iterator[str]:
    """Yield the places where joints are held, with the joints of each."""
    units = {joint.name: "m" if joint.unit == "N" else "rad" for joint in result.joints}
    places: dict[str, list[str]] = {}
    for name, value in result.held.items():
        floating = "m" if name[-2:] in ("_x", "_y", "_z") else ""
        places.setdefault(f"{value:.6g} {units.get(name, floating)}".strip(), []).append(printable(name))
    for place, names in places.items():
        more = "" if most is None or len(names) <= most else f" and {len(names) - most} more"
        yield f"at {place} {', '.join(names[:most])}{more}"
