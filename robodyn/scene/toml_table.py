"""Typed values out of TOML: the dataclasses of `scene` are the schema of its tables.

1. `read_toml` makes tables of the text of a file, and `merged` makes one of several files.
2. `TomlTable.read` makes a dataclass of a table: each field is the key of its name, its type says what may stand there.
3. Whatever is wrong is one line with the file and the line of the key, by `line_of`.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import MISSING, fields
from functools import cache
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

from robodyn.errors import SceneError
from robodyn.support.input_file import beyond, limits
from robodyn.support.wording import nearest, shown

T = TypeVar("T")
Path = tuple[str | int, ...]
"""Keys from the top of a file on; of a table in a list its number from 0."""
Sources = Sequence[tuple[bytes, str]]
"""Texts, each with the name of its file."""
_LARGEST = sys.float_info.max
WHOLE = "the scene"
OF_THE_SCENE = (
    *("gravity", "friction", "slip_speed", "rotor", "motor", "coupled", "spring", "payload", "wrench", "fluid", "base"),
    *("initial", "drive", "between_rows", "joint_limits", "limit_spring", "loop", "baumgarte"),
    *("actuated", "passive", "share", "weights", "contact", "contact_cost", "uncertainty", "gear"),
)
"""The keys that stand above all tables, or are tables themselves."""
_WRITTEN = {3: "write {} = [x, y, z]", 6: "write {} = [ixx, ixy, ixz, iyy, iyz, izz]"}
_TEXTS = re.compile(
    rb"""\"{3}(?:\\.|[^\\])*?(?:\"{3}|\Z)|'{3}.*?(?:'{3}|\Z)|"(?:\\.|[^"\\\n])*"|'[^'\n]*'|#[^\n]*""", re.DOTALL
)
"""Strings and comments."""
_BETWEEN_KEYS = re.compile(rb"[=,{}\[\]\n]")
_PLACE = re.compile(r" \(at (?:line (\d+), column \d+|end of document)\)$")
_PART = r"""(?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*')"""
_LINE = re.compile(rf"[ \t]*(\[{{0,2}})[ \t]*({_PART}(?:[ \t]*\.[ \t]*{_PART})*)[ \t]*[=\]]")


def read_toml(data: bytes, file: str) -> dict[str, Any]:
    """Return the tables of TOML text; SceneError with the line if it is none, or beyond a limit."""
    if len(data) > limits().toml_bytes:
        raise beyond("toml_bytes", "too many bytes", SceneError, file=file)
    plain, most = _TEXTS.sub(lambda text: b"_" + b"\n" * text[0].count(b"\n"), data), limits().nesting
    if plain.count(b".") >= most:  # each part of a dotted key takes memory for all parts before it
        for piece in _BETWEEN_KEYS.split(plain):
            if piece.count(b".") >= most:
                line = plain.count(b"\n", 0, plain.find(piece)) + 1
                raise beyond("nesting", "a key of too many parts", SceneError, file=file, line=line)
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
    at = int(place[1]) if place and place[1] else None
    why = text[: place.start()] if at is not None and place else text
    remedy = "each key and each [table] stands once" if "twice" in why or "overwrite" in why else None
    raise SceneError(f"is not TOML: {why[:1].lower()}{why[1:]}", remedy=remedy, file=file, line=at)


def merged(sources: Sources) -> dict[str, Any]:
    """Return the tables of several TOML texts as one; SceneError with both places of a key that stands in two of
    them."""
    whole: dict[str, Any] = {}
    for k, (data, file) in enumerate(sources):
        for path in _put(whole, read_toml(data, file), ()):
            first, line = place_of(sources[:k], path)
            what = f"{'.'.join(map(str, path))} is given in {first}:{line or '?'} too"
            again = place_of([(data, file)], path)[1]
            raise SceneError(what, remedy="leave it out of one of them", file=file, line=again)
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


def place_of(sources: Sources, path: Path) -> tuple[str, int | None]:
    """Return the file and the line of a key, or of the nearest table around it that has a line of its own."""
    best = 0
    found: tuple[str, int | None] = " + ".join(file for _, file in sources), None
    tables: dict[Path, int] = {}
    for data, file in sources:
        above: Path = ()
        for line, text in enumerate(data.decode("utf-8", errors="replace").splitlines(), start=1):
            match = _LINE.match(text)
            if match is None:
                continue
            whole: Path = () if match[1] else above
            parts = re.findall(_PART, match[2])
            for k, part in enumerate(parts, start=1):
                whole = (*whole, part.strip("\"'"))
                if k == len(parts) and match[1] == "[[":
                    tables[whole] = tables.get(whole, -1) + 1
                if whole in tables:
                    whole = (*whole, tables[whole])
            above = whole if match[1] else above
            if len(whole) > best and path[: len(whole)] == whole:
                best, found = len(whole), (file, line)
    return found


class TomlTable:
    """A TOML table from which keys are taken one by one; `finish` complains of those left over.

    Args:
        values: the table; whatever else stands in its place is an error.
        what: as messages call it.
        path: where it is in the sources.
    """

    def __init__(self, values: Any, what: str, sources: Sources, path: Path = ()) -> None:
        self.what, self._sources, self._path = what, sources, path
        if not isinstance(values, Mapping):
            head, _, name = what.partition(" ")
            above = f"write {head} above lines of key = value"
            remedy = above if not name or head[:2] == "[[" else f"write {name} = {{ key = value }}"
            raise self._error(f"{what} is {values!r:.60}, not a table", remedy)
        self.values = dict(values)
        self._known: list[str] = []

    @property
    def folder(self) -> str:
        return os.path.dirname(place_of(self._sources, self._path)[0])

    def error(self, what: str, remedy: str | None = None, key: str = "") -> SceneError:
        """Return the error of this table, or of a key in it."""
        return self._error(f"{self.what}: {what}", remedy, key)

    def _error(self, what: str, remedy: str | None, key: str = "") -> SceneError:
        file, line = place_of(self._sources, (*self._path, key))
        return SceneError(what, remedy=remedy, file=file, line=line)

    def take(self, key: str, default: Any = ...) -> Any:
        """Return what stands at a key, which is taken away."""
        self._known.append(key)
        value = self.values.pop(key, default)
        if value is ...:
            raise self.error(f'"{key}" is missing')
        return value

    def value(self, key: str, kind: Any, default: Any = ...) -> Any:
        """Return the value of a key, of this type: float, str, bool, tuples of these, unions with str (the name of a
        column) and None, with a `Rule`; a default is not looked at."""
        value = self.take(key, default)
        return value if value is default else self.converted(key, value, kind)

    def converted(self, key: str, value: Any, kind: Any, remedy: str | None = None) -> Any:
        """Return a value of TOML as this type has it."""
        if get_origin(kind) is Annotated:
            kind, rule = get_args(kind)
            value = self.converted(key, value, kind, rule.remedy)
            if not rule.holds(value):
                written = f'"{value}"' if isinstance(value, str) else value
                written = f"{value:g}" if isinstance(value, float) else written
                raise self.error(f'"{key}" is {written}', rule.remedy, key)
            return value
        if get_origin(kind) is tuple:
            items = get_args(kind)
            many = items[-1] is ...
            if not isinstance(value, list) or (not many and len(value) != len(items)):
                nouns = "numbers" if float in items else "numbers or names of columns"
                written = f'write {key} = ["a", "b"]' if items[0] is str else _WRITTEN.get(len(items), "").format(key)
                what = "a list" if many else f"{len(items)} {nouns}"
                raise self.error(f'"{key}" is {value!r:.60}, not {what}', remedy or written or None, key)
            return tuple(self.converted(key, each, items[0], remedy) for each in value)
        kinds = [each for each in get_args(kind) or [kind] if each is not type(None)]
        if len(kinds) == 1 and kinds != [kind]:
            return self.converted(key, value, kinds[0], remedy)
        if str in kinds and isinstance(value, str) and value:
            return value
        if bool in kinds and isinstance(value, bool):
            return value
        number = float in kinds and isinstance(value, (int, float)) and not isinstance(value, bool)
        if number and -_LARGEST <= value <= _LARGEST:
            return float(value)
        what = "a finite number" if float in kinds else "a name" if str in kinds else "true or false"
        raise self.error(f'"{key}" is {value!r:.60}, not {what}', remedy, key)

    def field(self, kind: type, name: str, *default: Any) -> Any:
        """Return the value of the key that a field of a dataclass is, read by its type; without it its default."""
        own = next(each for each in fields(kind) if each.name == name)
        otherwise: Any = ... if own.default is MISSING else own.default
        return self.value(name, _hints(kind)[name], *(default or [otherwise]))

    def table(self, key: str, default: Any = ..., what: str = "") -> Any:
        """Return the `TomlTable` at a key; None where that is the default."""
        values = self.take(key, default)
        return None if values is None else self._inner(key, values, what or f"[{key}]")

    def tables(self, key: str, what: str = "") -> list[tuple[str, TomlTable]]:
        """Return the tables in the table of a key, by name."""
        outer = self.table(key, {}, what)
        for name, value in outer.values.items():
            if name in OF_THE_SCENE and not isinstance(value, Mapping):
                raise outer.misplaced(name)
        named = f"{what[:-1]}.{{}}]" if what else f"[{key}] {{}}"
        return [(name, outer._inner(name, value, named.format(name))) for name, value in outer.values.items()]

    def list(self, key: str) -> list[TomlTable]:
        values = self.take(key, [])
        if not isinstance(values, list):
            raise self.error(f'"{key}" is not a list of tables', f"write [[{key}]] above each", key)
        name = ".".join(map(str, (*self._path, key)))
        return [self._inner(key, each, f"[[{name}]] number {k + 1}", k) for k, each in enumerate(values)]

    def _inner(self, key: str, values: Any, what: str, *number: int) -> TomlTable:
        return TomlTable(values, what, self._sources, (*self._path, key, *number))

    def read(self, kind: type[T], /, **given: Any) -> T:
        """Return a dataclass, each field given or the key of its name, read by its type; no other key may be left."""
        for each in fields(kind):  # type: ignore[arg-type]
            if each.name not in given:
                given[each.name] = self.field(kind, each.name)
        self.finish()
        return kind(**given)

    def misplaced(self, key: str) -> SceneError:
        """Return the error of a key of the scene that stands below the header of a table."""
        what = f'"{key}" is a key of the whole scene, and below the header of a table it belongs to that table'
        return self.error(what, f"write {key} = ... above the first [table]", key)

    def finish(self) -> None:
        """Raise if a key is left over."""
        known = self._known
        for key in self.values:
            if key in OF_THE_SCENE and key not in known and self.what != WHOLE:
                raise self.misplaced(key)
            near = nearest(key, known)
            meant = f"; did you mean {shown(near[0])}?" if len(near) == 1 else ""
            raise self.error(f'unknown key "{key}"', f"valid keys: {', '.join(map(shown, known))}{meant}", key)


@cache
def _hints(kind: type) -> dict[str, Any]:
    unread = {"Uncertainty": Any}  # which a scene has, and cold starts without one do not import
    return get_type_hints(kind, localns=unread, include_extras=True)
