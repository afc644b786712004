"""YAML as plain values within limits: no aliases, no tags, nothing that is more than it weighs.

A scalar without quotes is null, a number in decimals, or text; no dates, no 12:30:45, no yes and no.
"""

from __future__ import annotations

import re
from typing import Any

from robodyn.errors import TrajectoryError
from robodyn.support.input_limits import beyond, limits

_WHOLE = re.compile(r"[-+]?[0-9]{1,18}")
_NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")
_FURTHER = re.compile(r"([-+]?)\.(inf|Inf|INF|nan|NaN|NAN)")
_NOTHING = ("", "~", "null", "Null", "NULL")


def yaml_documents(text: bytes, file: str) -> list[Any]:
    """Return the documents: mappings, lists, numbers, texts and None.

    Raises:
        TrajectoryError: it is no YAML, has an alias, or is beyond a limit; with the line.
    """
    import yaml

    building = _Building(file)
    try:
        for event in yaml.parse(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader)):
            building.add(event, event.start_mark.line + 1)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        what = " ".join(str(getattr(error, "problem", None) or error).split())
        line = None if mark is None else mark.line + 1
        raise TrajectoryError(f"is not YAML: {what:.200}", remedy="write it again", file=file, line=line) from None
    return building.documents


class _Building:
    """Values that are being built from the events of a parser."""

    def __init__(self, file: str) -> None:
        self.documents: list[Any] = []
        self._file, self._events = file, 0
        self._open: list[tuple[Any, list[Any]]] = [(None, self.documents)]

    def add(self, event: Any, line: int) -> None:
        kind = type(event).__name__
        self._events += 1
        if self._events > limits().message_values:
            raise beyond("message_values", "too many values", TrajectoryError, file=self._file, line=line)
        if kind == "AliasEvent":
            what = f"*{event.anchor} stands for another part"
            raise TrajectoryError(what, remedy="write the values themselves", file=self._file, line=line)
        if kind == "ScalarEvent":
            self._put(_scalar(event.value) if event.implicit[0] else event.value)
        elif kind in ("SequenceStartEvent", "MappingStartEvent"):
            if len(self._open) > limits().nesting:
                raise beyond("nesting", "nested too deeply", TrajectoryError, file=self._file, line=line)
            self._open.append((kind, []))
        elif kind in ("SequenceEndEvent", "MappingEndEvent"):
            began, values = self._open.pop()
            self._put(values if began == "SequenceStartEvent" else self._mapping(values, line))

    def _put(self, value: Any) -> None:
        self._open[-1][1].append(value)

    def _mapping(self, values: list[Any], line: int) -> dict[Any, Any]:
        keys = values[::2]
        if any(isinstance(key, (list, dict)) for key in keys):
            raise TrajectoryError("a key is no text", remedy="write it again", file=self._file, line=line)
        return dict(zip(keys, values[1::2], strict=True))


def _scalar(text: str) -> Any:
    if text in _NOTHING:
        return None
    if _WHOLE.fullmatch(text):
        return int(text)
    if _NUMBER.fullmatch(text):
        return float(text)
    further = _FURTHER.fullmatch(text)
    return text if further is None else float(further[1] + further[2])
