"""Taking typed values out of a table of scene.toml."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import Any

from robodyn.errors import SceneError
from robodyn.scene import Entry, Vector
from robodyn.wording import shown

_LARGEST = sys.float_info.max


class SceneTable:
    """A TOML table from which keys are taken one by one; `finish` complains of those left over."""

    def __init__(self, values: Any, what: str, file: str) -> None:
        if not isinstance(values, Mapping):
            raise SceneError(f"{what} is {values!r}, not a table", remedy="write key = value pairs", file=file)
        self.values, self.what, self.file = dict(values), what, file
        self.known: list[str] = []

    def error(self, what: str, remedy: str | None = None) -> SceneError:
        return SceneError(f"{self.what}: {what}", remedy=remedy, file=self.file)

    def take(self, key: str, default: Any) -> Any:
        self.known.append(key)
        value = self.values.pop(key, default)
        if value is ...:
            raise self.error(f'"{key}" is missing')
        return value

    def number(self, key: str, default: Any = ...) -> Any:
        value = self.take(key, default)
        return value if value is default else self._number(key, value)

    def _number(self, key: str, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not -_LARGEST <= value <= _LARGEST:
            raise self.error(f'"{key}" is {value!r:.60}, not a finite number')
        return float(value)

    def numbers(self, key: str, count: int, default: Any = ...) -> Any:
        value = self.take(key, default)
        if value is default:
            return value
        if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != count:
            raise self.error(f'"{key}" is {value!r}, not {count} numbers')
        return tuple(self._number(key, entry) for entry in value)

    def vector(self, key: str, default: Any = ...) -> Vector:
        vector: Vector = self.numbers(key, 3, default)
        return vector

    def vectors(self, key: str, most: int) -> tuple[Vector, ...]:
        value = self.take(key, ())
        if not isinstance(value, Sequence) or isinstance(value, str) or len(value) > most:
            raise self.error(f'"{key}" is {value!r:.60}, not at most {most} vectors of 3 numbers')
        return tuple(SceneTable({key: each}, self.what, self.file).vector(key) for each in value)

    def entries(self, key: str) -> tuple[Entry, Entry, Entry]:
        value = self.take(key, (0.0, 0.0, 0.0))
        if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 3:
            raise self.error(f'"{key}" is {value!r}, not three numbers or names of columns')
        x, y, z = (entry if isinstance(entry, str) and entry else self._number(key, entry) for entry in value)
        return x, y, z

    def entry(self, key: str, default: Any = ...) -> Any:
        """A number or the name of a column."""
        value = self.take(key, default)
        return value if value is default or (isinstance(value, str) and value) else self._number(key, value)

    def text(self, key: str, default: Any = ..., choices: Sequence[str] = ()) -> str:
        value = self.take(key, default)
        if not isinstance(value, str) or not value:
            raise self.error(f'"{key}" is {value!r}, not a name')
        if choices and value not in choices:
            raise self.error(f'"{key}" is "{value}"', remedy=f"one of: {', '.join(choices)}")
        return value

    def tables(self, key: str) -> list[tuple[str, SceneTable]]:
        values = SceneTable(self.take(key, {}), f"[{key}]", self.file).values
        return [(name, SceneTable(value, f"[{key}] {name}", self.file)) for name, value in values.items()]

    def list(self, key: str) -> list[SceneTable]:
        values = self.take(key, [])
        if not isinstance(values, list):
            raise self.error(f'"{key}" is not a list of tables', remedy=f"write [[{key}]] above each")
        return [SceneTable(value, f"[[{key}]] number {k}", self.file) for k, value in enumerate(values, 1)]

    def finish(self) -> None:
        for key in self.values:
            raise self.error(f'unknown key "{key}"', remedy=f"valid keys: {', '.join(map(shown, self.known))}")
