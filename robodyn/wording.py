"""Values and names in messages: quoted, short, and with the closest valid alternative."""

from __future__ import annotations

from collections.abc import Collection
from itertools import islice

_LONGEST = 60
_LONGEST_PATH = 120
_MOST_NAMES = 8
_MOST_CANDIDATES = 1000


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


def listed(names: Collection[str]) -> str:
    """The first few names and how many more there are."""
    text = ", ".join(shown(name) for name in islice(names, _MOST_NAMES))
    return text if len(names) <= _MOST_NAMES else f"{text}, ... ({len(names)} in all)"


def alternatives(name: str, valid: Collection[str], kind: str) -> str:
    """`did you mean 'x'?` where a valid name is close, otherwise the valid names."""
    if len(name) <= _LONGEST:
        from difflib import get_close_matches

        candidates = [other for other in valid if abs(len(other) - len(name)) <= len(name) // 2 + 1]
        near = get_close_matches(name, candidates[:_MOST_CANDIDATES], n=1)
        if near:
            return f"did you mean {shown(near[0])}?"
    return f"{kind}: {listed(valid)}" if valid else f"there are no {kind}"
