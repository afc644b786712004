"""Names of robots and joints as identifiers that C, Python and SymPy accept."""

from __future__ import annotations

import re
from collections.abc import Iterable


def identifier(name: str, otherwise: str) -> str:
    """The letters and digits of a name, with single underscores for all else; `otherwise` in front of a digit."""
    words = [word for word in re.split(r"[^A-Za-z0-9]+", name) if word]
    text = "_".join(words) or otherwise
    return text if text[0].isalpha() else f"{otherwise}_{text}"


def identifiers(names: Iterable[str], otherwise: str) -> tuple[str, ...]:
    """An identifier for each name; those that would be alike, but for capitals, are numbered."""
    out: list[str] = []
    taken: set[str] = set()
    for name in names:
        first = text = identifier(name, otherwise)
        number = 1
        while text.lower() in taken:
            number += 1
            text = f"{first}_{number}"
        taken.add(text.lower())
        out.append(text)
    return tuple(out)
