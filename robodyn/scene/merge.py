"""Several files of one scene: tables are put together, lists are joined, and a key that stands in two is an error."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from robodyn.errors import SceneError
from robodyn.scene.toml_table import read_toml

Path = tuple[str, ...]
_KEY = re.compile(
    r"""[ \t]*((?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*')(?:[ \t]*\.[ \t]*(?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*'))*)[ \t]*"""
)
_PART = re.compile(r"""[A-Za-z0-9_-]+|"([^"]*)"|'([^']*)'""")


def merged(parts: Sequence[tuple[bytes, str]]) -> dict[str, Any]:
    """Return the tables of several TOML texts as those of one, each given with the name of its file.

    Raises:
        SceneError: one is no TOML, or a key stands in two of them; with both places.
    """
    whole: dict[str, Any] = {}
    before: list[tuple[bytes, str]] = []
    for data, file in parts:
        for path in _put(whole, read_toml(data, file), ()):
            first = next(each for each in before if _has(read_toml(each[0], each[1]), path))
            name = ".".join(path)
            what = f"{name} is given in {first[1]}:{_line(first[0], path) or '?'} too"
            raise SceneError(what, remedy="leave it out of one of them", file=file, line=_line(data, path))
        before.append((data, file))
    return whole


def _put(whole: dict[str, Any], more: Mapping[str, Any], above: Path) -> Iterator[Path]:
    """Put tables into others; yield the keys that both have."""
    for key, value in more.items():
        old, path = whole.get(key), (*above, key)
        if key not in whole:
            whole[key] = value
        elif isinstance(old, dict) and isinstance(value, dict):
            yield from _put(old, value, path)
        elif _is_tables(old) and _is_tables(value):
            whole[key] = [*whole[key], *value]
        else:
            yield path


def _is_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(each, dict) for each in value)


def _has(values: Any, path: Path) -> bool:
    for key in path:
        if not isinstance(values, dict) or key not in values:
            return False
        values = values[key]
    return True


def _line(data: bytes, path: Path) -> int | None:
    """Return the line of a key, or of the last of the tables that hold it and have one of their own."""
    found: int | None = None
    best = 0
    above: Path = ()
    for number, text in enumerate(data.decode("utf-8", errors="replace").splitlines(), start=1):
        stripped = text.strip()
        head = stripped.startswith("[")
        match = _KEY.match(stripped.lstrip("[") if head else text)
        if match is None:
            continue
        parts = tuple(bare or double or single for bare, double, single in _parts(match[1]))
        if head:
            above = parts
        elif match.end() >= len(text) or text[match.end()] != "=":
            continue
        whole = parts if head else (*above, *parts)
        if len(whole) > best and path[: len(whole)] == whole:
            found, best = number, len(whole)
    return found


def _parts(key: str) -> Iterator[tuple[str, str, str]]:
    for part in _PART.finditer(key):
        double, single = part[1] or "", part[2] or ""
        yield ("" if part[0][0] in "\"'" else part[0]), double, single
