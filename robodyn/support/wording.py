"""Values and names in messages: quoted, short, and with the closest valid alternative."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from dataclasses import MISSING, fields
from itertools import islice
from math import isfinite
from typing import Any

from robodyn.errors import printable

_LONGEST = 60
_LONGEST_PATH = 120
_MOST_NAMES = 8
_MOST_CANDIDATES = 1000
_SLIPS, _PART = 2, 3
"""Letters in which a name may differ from the one that was meant, and that two names share to be like each other."""
_SURMISES = "it may be that ", "one of these: "
Cell = str | float | None
_NEGLIGIBLE, _ROWS = 2e-9, 60
"""Of tables in notebooks: beside the largest number of its column; rows that are shown."""


def shown(text: str) -> str:
    """Quoted and at most about 60 characters long."""
    return f"'{text}'" if len(text) <= _LONGEST else f"'{text[:_LONGEST]}...' ({len(text)} characters)"


def shown_path(path: str) -> str:
    """Quoted, and of a long one the end, which tells files apart."""
    return f"'{path}'" if len(path) <= _LONGEST_PATH else f"'...{path[-_LONGEST_PATH:]}' ({len(path)} characters)"


def figure(value: float, digits: int = 3) -> str:
    """Rounded to so many significant digits; without an exponent from 0.001 to a million."""
    rounded = float(f"{value:.{digits}g}")
    return f"{rounded:.15g}" if 1e-3 <= abs(rounded) < 1e6 else f"{rounded:.{digits}g}"


def place(point: Iterable[float]) -> str:
    """Return the coordinates of a point in brackets, to four digits."""
    return "(" + ", ".join(f"{value + 0.0:.4g}" for value in point) + ")"


def listed(names: Collection[str]) -> str:
    """Return the first few names and how many more there are."""
    text = ", ".join(shown(name) for name in islice(names, _MOST_NAMES))
    return text if len(names) <= _MOST_NAMES else f"{text}, ... ({len(names)} in all)"


def relative_path(file: str) -> str:
    """Return the path from the current folder, where that is shorter."""
    if file.startswith("<"):
        return file
    try:
        return min(os.path.relpath(file), file, key=len)
    except ValueError:  # on another drive
        return file


def listed_paths(paths: Collection[str]) -> str:
    """Return the first few paths, from the current folder, and how many more there are."""
    text = ", ".join(shown_path(relative_path(path)) for path in islice(paths, _MOST_NAMES))
    return text if len(paths) <= _MOST_NAMES else f"{text}, ... ({len(paths)} in all)"


def count(amount: int, noun: str, plural: str = "") -> str:
    """Return a number with its noun in the singular or the plural, which ends in s if it is not given."""
    return f"{amount} {noun if amount == 1 else plural or f'{noun}s'}"


def one_of(what: Iterable[str]) -> str | None:
    """Return what may be the cause in words: "one of these: ..."; None if there is nothing."""
    different = list(dict.fromkeys(what))
    if len(different) < 2:
        return f"{_SURMISES[0]}{different[0]}" if different else None
    return f"{_SURMISES[1]}{'; '.join(different)}"


def surmised(cause: str) -> bool:
    """Return whether it is from `one_of`: what may be, not what is."""
    return cause.startswith(_SURMISES)


def alternatives(name: str, valid: Collection[str], kind: str) -> str:
    """`did you mean 'x'?` where valid names are near, otherwise the valid names."""
    near = [shown(other) for other in nearest(name, valid)]
    if len(near) > 3:
        return f"{kind} like it: {listed(nearest(name, valid))}"
    if near:
        return f"did you mean {' or '.join([', '.join(near[:-1]), near[-1]] if near[1:] else near)}?"
    return f"{kind}: {listed(valid)}" if valid else f"there are no {kind}"


def slip_of(name: str, known: Collection[str]) -> str | None:
    """Return the known name that this is but for a slip of one or two letters, if it is a word of letters (no
    position_x)."""
    if name in known or not name.isalpha():
        return None
    return next((other for other in known if _edits(name, other) <= _SLIPS), None)


def _edits(one: str, other: str) -> int:
    """Return how many letters must be put in, taken out or changed to make one word the other."""
    if abs(len(one) - len(other)) > _SLIPS:
        return _SLIPS + 1
    row: list[int] = [*range(len(other) + 1)]
    for i, letter in enumerate(one):
        before, row[0] = row[0], i + 1
        for j, wanted in enumerate(other):
            before, row[j + 1] = row[j + 1], min(before + (letter != wanted), row[j] + 1, row[j + 1] + 1)
    return row[-1]


def nearest(name: str, valid: Collection[str]) -> list[str]:
    """Return the valid name that is spelled almost so, in any case, or else those that hold it, are held, or have such
    a part."""
    if not 0 < len(name) <= _LONGEST:
        return []
    from difflib import get_close_matches

    folded = name.casefold()
    candidates = [other for other in valid if abs(len(other) - len(name)) <= len(name) // 2 + 1][:_MOST_CANDIDATES]
    spelled = {other.casefold(): other for other in reversed(candidates)}
    close = get_close_matches(folded, spelled, n=1)
    if close:
        return [spelled[close[0]]]
    long = [other for other in islice(valid, _MOST_CANDIDATES) if min(len(other), len(name)) >= _PART]
    held = [other for other in long if folded in other.casefold() or other.casefold() in folded]
    if held or len(name) < _PART:
        return held
    parts = {other: re.split(r"[^a-z]+", other.casefold()) for other in long}
    return [
        other for other in long if any(len(part) > _PART and _edits(folded, part) <= _SLIPS for part in parts[other])
    ]


def shortened(names: Sequence[str], most: int) -> list[str]:
    """Return different names, cut in the middle to so many characters, unless no cut tells them apart."""
    found = {name: name for name in names}
    alike, places = list(found), sorted(range(1, most - 3), key=lambda head: (abs(2 * head - (most - 3)), head))
    for head in [*places, None]:
        for name in alike:
            short = head is None or len(name) <= most
            found[name] = name if short else f"{name[:head]}...{name[len(name) - (most - 3 - (head or 0)) :]}"
        counts = Counter(found.values())
        alike = [name for name, short in found.items() if counts[short] > 1]
        if not alike:
            break
    return [found[name] for name in names]


def call_of(value: Any) -> str:
    """Return the call that makes a value of a dataclass, with what differs from the defaults."""
    given = []
    for each in fields(value):
        usual = each.default if each.default_factory is MISSING else each.default_factory()
        if (own := getattr(value, each.name)) != usual:
            given.append(f"{each.name}={own!r}")
    return f"{type(value).__name__}({', '.join(given)})"


def toml_key(name: str) -> str:
    """Return a name as a key of TOML."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else toml_string(name)


def toml_string(text: str) -> str:
    """Return a text as a string of TOML."""
    escaped = re.sub(r'["\\\x00-\x1f\x7f-\x9f\u2028\u2029]', lambda found: f"\\u{ord(found[0]):04x}", text)
    return f'"{escaped}"'


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
        from html import escape

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
