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


def yaml_documents(text: bytes, file: str) -> list[Any]:
    """The documents: mappings, lists, numbers, texts and None; raises where it is no YAML or beyond a limit."""
    import yaml

    documents: list[Any] = []
    containers: list[tuple[str, list[Any]]] = [("", documents)]
    try:
        for number, event in enumerate(yaml.parse(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader)), 1):
            kind, at = type(event).__name__, {"file": file, "line": event.start_mark.line + 1}
            if number > limits().message_values:
                raise beyond("message_values", "too many values", TrajectoryError, **at)
            if kind == "AliasEvent":
                what = f"*{event.anchor} stands for another part"
                raise TrajectoryError(what, remedy="write the values themselves", **at)
            if kind == "ScalarEvent":
                containers[-1][1].append(_scalar(event.value) if event.implicit[0] else event.value)
            elif kind in ("SequenceStartEvent", "MappingStartEvent"):
                if len(containers) > limits().nesting:
                    raise beyond("nesting", "nested too deeply", TrajectoryError, **at)
                containers.append((kind, []))
            elif kind in ("SequenceEndEvent", "MappingEndEvent"):
                began, values = containers.pop()
                if began == "MappingStartEvent" and any(isinstance(key, (list, dict)) for key in values[::2]):
                    raise TrajectoryError("a key is no text", remedy="write it again", **at)
                mapping = began == "MappingStartEvent"
                containers[-1][1].append(dict(zip(values[::2], values[1::2], strict=True)) if mapping else values)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        what = " ".join(str(getattr(error, "problem", None) or error).split())
        line = None if mark is None else mark.line + 1
        raise TrajectoryError(f"is not YAML: {what:.200}", remedy="write it again", file=file, line=line) from None
    return documents


def _scalar(text: str) -> Any:
    if text in ("", "~", "null", "Null", "NULL"):
        return None
    if _WHOLE.fullmatch(text):
        return int(text)
    if _NUMBER.fullmatch(text):
        return float(text)
    further = _FURTHER.fullmatch(text)
    return text if further is None else float(further[1] + further[2])
