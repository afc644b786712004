"""From results to JSON: dataclasses become objects with their fields as keys, arrays lists of rows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from operator import attrgetter
from pathlib import PurePath
from typing import Any


def written(document: Mapping[str, Any]) -> str:
    """Return a document as text.

    Raises:
        ValueError: a number is not finite; where that may be so, `finite` says null instead.
    """
    import json

    return json.dumps(encode(document), indent=2, allow_nan=False) + "\n"


def encode(value: Any) -> Any:
    """Return a value as JSON has it: dataclasses and mappings as objects, other collections and arrays as lists."""
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if hasattr(value, "tolist"):
        return value.tolist()
    if is_dataclass(value):
        return {each.metadata.get("json", each.name): encode(getattr(value, each.name)) for each in fields(value)}
    if isinstance(value, Mapping):
        return {key: encode(each) for key, each in value.items()}
    if isinstance(value, (tuple, list)):
        return [encode(each) for each in value]
    return value.value if isinstance(value, Enum) else str(value) if isinstance(value, PurePath) else value


def select(source: Any, keys: str, **given: Any) -> dict[str, Any]:
    """Return an object with these keys in this order.

    Args:
        source: whose attributes of these names are the values; `key:path` takes another, such as `origin:pose.p`.
        given: values that are not attributes.
    """
    found = {}
    for each in keys.split():
        key, _, path = each.partition(":")
        found[key] = encode(given.pop(key) if key in given else attrgetter(path or key)(source))
    assert not given, f"without a place: {', '.join(given)}"
    return found


def finite(value: float | None) -> float | None:
    """Return the value, or None where JSON has no number for it."""
    return value if value is not None and abs(value) < float("inf") else None
