"""Taking typed values out of a table of scene.toml."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, fields
from typing import Any, TypeVar

from robodyn.errors import SceneError
from robodyn.scene.parts import Entry, Vector
from robodyn.support.input_limits import beyond, limits
from robodyn.support.wording import nearest, shown

T = TypeVar("T")
_LARGEST = sys.float_info.max
WHOLE = "the scene"
OF_THE_SCENE = (
    *("gravity", "friction", "slip_speed", "rotor", "motor", "coupled", "spring", "payload", "wrench", "fluid", "base"),
    *("initial", "drive", "between_rows", "joint_limits", "limit_spring", "loop", "baumgarte"),
    *("actuated", "passive", "share", "weights", "contact", "contact_cost", "uncertainty"),
)
"""The keys that stand above all tables, or are tables themselves."""
_WRITTEN = {3: "write {} = [x, y, z]", 6: "write {} = [ixx, ixy, ixz, iyy, iyz, izz]"}
_TEXTS = re.compile(
    rb"""\"{3}(?:\\.|[^\\])*?(?:\"{3}|\Z)|'{3}.*?(?:'{3}|\Z)|"(?:\\.|[^"\\\n])*"|'[^'\n]*'|#[^\n]*""", re.DOTALL
)
"""Strings and comments."""
_BETWEEN_KEYS = re.compile(rb"[=,{}\[\]\n]")
_PLACE = re.compile(r" \(at (?:line (\d+), column \d+|end of document)\)$")


def read_toml(data: bytes, file: str) -> dict[str, Any]:
    """Return the tables of TOML text.

    Raises:
        SceneError: it is none, with the line; or it is beyond a limit.
    """
    _check_size(data, file)
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib
    try:
        return tomllib.loads(data.decode("utf-8"))
    except ValueError as error:
        text = str(error)
    except RecursionError:
        text = "nested too deeply"
    place = _PLACE.search(text)
    line = int(place[1]) if place and place[1] else None
    why = text[: place.start()] if line is not None and place else text
    remedy = "each key and each [table] stands once" if "twice" in why or "overwrite" in why else None
    raise SceneError(f"is not TOML: {why[:1].lower()}{why[1:]}", remedy=remedy, file=file, line=line)


def _check_size(data: bytes, file: str) -> None:
    """Raise for more than is read: each part of a dotted key takes memory for all parts before it."""
    if len(data) > limits().toml_bytes:
        raise beyond("toml_bytes", "too many bytes", SceneError, file=file)
    plain, most = _TEXTS.sub(lambda text: b"_" + b"\n" * text[0].count(b"\n"), data), limits().nesting
    if plain.count(b".") >= most:
        for piece in _BETWEEN_KEYS.split(plain):
            if piece.count(b".") >= most:
                line = plain.count(b"\n", 0, plain.find(piece)) + 1
                raise beyond("nesting", "a key of too many parts", SceneError, file=file, line=line)


class SceneTable:
    """A TOML table from which keys are taken one by one; `finish` complains of those left over."""

    def __init__(self, values: Any, what: str, file: str) -> None:
        if not isinstance(values, Mapping):
            head, _, name = what.partition(" ")
            above = f"write {head} above lines of key = value"
            remedy = above if not name or head[:2] == "[[" else f"write {name} = {{ key = value }}"
            raise SceneError(f"{what} is {values!r:.60}, not a table", remedy=remedy, file=file)
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

    def nonnegative(self, key: str, default: Any = ..., remedy: str = "it is positive or zero") -> Any:
        value = self.number(key, default)
        if value is not None and value < 0:
            raise self.error(f'"{key}" is {value:g}', remedy=remedy)
        return value

    def numbers(self, key: str, count: int, default: Any = ...) -> Any:
        value = self.take(key, default)
        if value is default:
            return value
        if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != count:
            raise self.error(f'"{key}" is {value!r}, not {count} numbers', _WRITTEN.get(count, "").format(key) or None)
        return tuple(self._number(key, entry) for entry in value)

    def vector(self, key: str, default: Any = ...) -> Vector:
        vector: Vector = self.numbers(key, 3, default)
        return vector

    def vectors(self, key: str, most: int) -> tuple[Vector, ...]:
        value = self.take(key, ())
        if not isinstance(value, Sequence) or isinstance(value, str) or len(value) > most:
            raise self.error(f'"{key}" is {value!r:.60}, not at most {most} vectors of 3 numbers')
        return tuple(SceneTable({key: each}, self.what, self.file).vector(key) for each in value)

    def names(self, key: str) -> tuple[str, ...] | None:
        """Return a list of different names, None where there is none."""
        value = self.take(key, None)
        if value is None:
            return None
        if not isinstance(value, list) or any(not isinstance(name, str) or not name for name in value):
            raise self.error(f'"{key}" is {value!r:.60}, not a list of names', remedy=f'write {key} = ["a", "b"]')
        if len(set(value)) < len(value):
            raise self.error(f'"{key}" names a joint twice', remedy="name each once")
        return tuple(value)

    def flag(self, key: str, default: bool, remedy: str = "true or false") -> bool:
        value = self.take(key, default)
        if not isinstance(value, bool):
            raise self.error(f'"{key}" is {value!r:.60}', remedy=remedy)
        return value

    def entries(self, key: str, default: Any = (0.0, 0.0, 0.0)) -> tuple[Entry, Entry, Entry]:
        value = self.take(key, default)
        if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 3:
            raise self.error(f'"{key}" is {value!r}, not three numbers or names of columns')
        x, y, z = (entry if isinstance(entry, str) and entry else self._number(key, entry) for entry in value)
        return x, y, z

    def entry(self, key: str, default: Any = ...) -> Any:
        """Return a number or the name of a column."""
        value = self.take(key, default)
        return value if value is default or (isinstance(value, str) and value) else self._number(key, value)

    def text(self, key: str, default: Any = ..., choices: Sequence[str] = ()) -> str:
        value = self.take(key, default)
        if choices and value not in choices:
            what = f'"{value}"' if isinstance(value, str) else repr(value)
            raise self.error(f'"{key}" is {what}', remedy=f"one of: {', '.join(choices)}")
        if not isinstance(value, str) or not value:
            raise self.error(f'"{key}" is {value!r}, not a name')
        return value

    def tables(self, key: str) -> list[tuple[str, SceneTable]]:
        values = SceneTable(self.take(key, {}), f"[{key}]", self.file)
        for name, value in values.values.items():
            if name in OF_THE_SCENE and not isinstance(value, Mapping):
                raise values.misplaced(name)
        return [(name, SceneTable(value, f"[{key}] {name}", self.file)) for name, value in values.values.items()]

    def list(self, key: str) -> list[SceneTable]:
        values = self.take(key, [])
        if not isinstance(values, list):
            raise self.error(f'"{key}" is not a list of tables', remedy=f"write [[{key}]] above each")
        return [SceneTable(value, f"[[{key}]] number {k}", self.file) for k, value in enumerate(values, 1)]

    def read(self, kind: type[T], **choices: Sequence[str]) -> T:
        """Return a dataclass, each field of which is the key of its name, read by its type; no other key may be left.

        Args:
            choices: of fields that are texts.
        """
        given: dict[str, Any] = {}
        for each in fields(kind):  # type: ignore[arg-type]
            default: Any = ... if each.default is MISSING else each.default
            if each.name in choices:
                given[each.name] = self.text(each.name, default, choices[each.name])
            else:
                given[each.name] = _READERS[str(each.type)](self, each.name, default)
        self.finish()
        return kind(**given)

    def misplaced(self, key: str) -> SceneError:
        """Return the error of a key of the scene that stands below the header of a table."""
        what = f'"{key}" is a key of the whole scene, and below the header of a table it belongs to that table'
        return self.error(what, remedy=f"write {key} = ... above the first [table]")

    def finish(self) -> None:
        for key in self.values:
            if key in OF_THE_SCENE and key not in self.known and self.what != WHOLE:
                raise self.misplaced(key)
            near = nearest(key, self.known)
            valid = ", ".join(map(shown, self.known))
            meant = f"; did you mean {shown(near[0])}?" if len(near) == 1 else ""
            raise self.error(f'unknown key "{key}"', remedy=f"valid keys: {valid}{meant}")


_READERS: Mapping[str, Callable[[SceneTable, str, Any], Any]] = {
    "str": SceneTable.text,
    "float": SceneTable.number,
    "float | None": SceneTable.number,
    "Vector": SceneTable.vector,
    "Entry": SceneTable.entry,
    "Entry | None": SceneTable.entry,
    "tuple[Entry, Entry, Entry]": SceneTable.entries,
    "tuple[float, float, float, float, float, float]": lambda table, key, default: table.numbers(key, 6, default),
}
"""How a field of a dataclass is read, by its type."""
