"""Data that cannot change after it is made: read-only copies of mappings, sequences and arrays."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import fields
from functools import cache
from numbers import Real
from typing import Any, TypeVar

V = TypeVar("V")


class FrozenMapping(Mapping[str, V]):
    """A read-only copy of a mapping, in its order; order does not count when two are compared."""

    __slots__ = ("_values",)

    def __init__(self, values: Mapping[str, V]) -> None:
        self._values = dict(values)

    def __getitem__(self, key: str) -> V:
        return self._values[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __hash__(self) -> int:
        return hash(frozenset(self._values.items()))

    def __repr__(self) -> str:
        return repr(self._values)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._values,)


def frozen(value: Any) -> Any:
    """Return the value with read-only copies of mappings, sequences and arrays, also inside each other."""
    if isinstance(value, Mapping):
        return FrozenMapping({key: frozen(each) for key, each in value.items()})
    if isinstance(value, (list, tuple)):
        parts = [frozen(each) for each in value]
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    if hasattr(value, "flags") and value.ndim:
        copy = value.copy(order="K")
        copy.flags.writeable = False
        return copy
    return value


def frozen_value(value: Any) -> Any:
    """Return the value in one way of writing: mappings read-only and sorted, sequences tuples, numbers floats, no
    signed 0."""
    if isinstance(value, Mapping):
        return FrozenMapping({key: frozen_value(value[key]) for key in sorted(value)})
    if isinstance(value, (list, tuple)):
        return tuple(frozen_value(each) for each in value)
    if hasattr(value, "tolist"):
        return frozen_value(value.tolist())
    if isinstance(value, Real) and not isinstance(value, bool):
        number = float(value)
        return math.nan if math.isnan(number) else number + 0.0
    return value


class Frozen:
    """A base of frozen dataclasses, which keep read-only copies of what they are given, and so do copies of them."""

    __slots__ = ()
    _kept = staticmethod(frozen)

    def __post_init__(self) -> None:
        for name in _names(type(self)):  # type: ignore[arg-type]
            object.__setattr__(self, name, self._kept(getattr(self, name)))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), tuple(getattr(self, name) for name in _names(type(self)))  # type: ignore[arg-type]


@cache
def _names(kind: type[Any]) -> tuple[str, ...]:
    return tuple(field.name for field in fields(kind))


class FrozenValue(Frozen):
    """A base of dataclasses that are compared by content: equal ones are the same to the bit, and in every order."""

    __slots__ = ("_hash",)
    _kept = staticmethod(frozen_value)
    _hash: int

    def __post_init__(self) -> None:
        super().__post_init__()
        # Computed once, for programs are looked up by their scene at every call.
        object.__setattr__(self, "_hash", hash(tuple(vars(self).values())))
