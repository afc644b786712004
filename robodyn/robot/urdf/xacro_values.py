"""What values in expressions of xacro may become: how large, by which operators, and by which of Python's functions."""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable
from functools import partial, reduce
from string import Formatter
from typing import Any

MOST_ITEMS = 100_000
"""Items of a value, with those within it, however often the same one occurs."""
MOST_TEXT = 1_000_000
"""Characters of a text, or of all texts within a value."""
MOST_BITS = 4_096
"""Bits of a whole number."""
_WIDEST = 1_000
"""Characters to which a number or a text is padded, and digits of a number."""
DOTTED = "YamlDictWrapper"
"""xacro's type of dictionaries whose items are attributes as well."""

ADDRESS = re.compile(r"(?:<|&lt;)[^<>]{0,200} at 0x[0-9a-fA-F]")
"""What Python writes of an object that has no text of its own: another one in each process."""


class RefusedError(Exception):
    """Something asks for what no description needs, or for too much of it; what else helps than to trust the file."""

    def __init__(self, what: str, remedy: str = "") -> None:
        super().__init__(what)
        self.remedy = remedy


BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
    ast.BitAnd: operator.and_,
}


def checked(value: Any) -> Any:
    """Return the value; raise where it is too large, each item counted as often as it would be written."""
    measured(value)
    return value


def measured(value: Any) -> int:
    """Return about how many characters a value is when it is written."""
    items, text, waiting = 0, 0, [value]
    while waiting:
        one = waiting.pop()
        items += 1
        inner: list[Any] = []
        if isinstance(one, str):
            text += len(one)
            if ADDRESS.search(one):
                raise RefusedError("the address of a function")
        elif isinstance(one, (bytes, bytearray)):
            raise RefusedError("binary data")
        elif isinstance(one, int):
            sized(one.bit_length(), MOST_BITS, "a whole number of {} bits")
        elif isinstance(one, list):
            inner = list(list.__iter__(one))
        elif isinstance(one, (tuple, set, frozenset)):
            inner = list(one)
        elif isinstance(one, dict) and type(one).__name__ in ("dict", DOTTED):
            inner = [*dict.keys(one), *dict.values(one)]
        waiting += inner
        sized(items + len(inner), MOST_ITEMS, "a value of {} items")
        sized(text, MOST_TEXT, "a text of {} characters")
    return text + 32 * items


def sized(count: int, most: int, what: str) -> None:
    """Raise where something, such as "a text of {} characters", would have more than `most` of them."""
    if count > most:
        raise RefusedError(what.format(f"more than {most}"))


def binary(kind: type[ast.operator], left: Any, right: Any) -> Any:
    """Return what an operator makes of two values that are not too large, if the result is neither."""
    checked(left)
    checked(right)
    whole = isinstance(left, int) and isinstance(right, int)
    if kind is ast.Pow and whole:
        sized(left.bit_length() * max(right, 0), MOST_BITS, "a power of {} bits")
    elif kind is ast.LShift and whole:
        sized(left.bit_length() + max(right, 0), MOST_BITS, "a shifted number of {} bits")
    elif kind is ast.Mult:
        for repeated, times in ((left, right), (right, left)):
            if isinstance(times, int) and isinstance(repeated, (str, bytes, list, tuple)):
                most = MOST_TEXT if isinstance(repeated, (str, bytes)) else MOST_ITEMS
                sized(len(repeated) * max(times, 0), most, "a repetition of {} items")
    elif kind is ast.Mod and isinstance(left, str):
        check_percent(left, right)
    return checked(BINARY[kind](left, right))


def check_percent(text: str, values: Any) -> None:
    """Raise where a format with % writes without bound."""
    if re.search(r"%\([^)]*\(", text):
        raise RefusedError("a format with brackets in a key")
    for found in re.finditer(r"%(?:\([^)]*\))?([^a-zA-Z%]*)", text):
        check_width(found[1])
    sized(text.count("%") * measured(values), 100 * MOST_TEXT, "a text of {} characters")


def check_fields(text: str, values: list[Any]) -> None:
    """Raise where str.format takes values apart, or writes without bound."""
    for _, field, specification, _ in Formatter().parse(text):
        if set(field or "") & set(".[") or "{" in (specification or ""):
            raise RefusedError("a format with a dot, a bracket or a format in a field")
        check_width(specification or "")
    sized(text.count("{") * measured(values), 100 * MOST_TEXT, "a text of {} characters")


def check_width(specification: str) -> None:
    """Raise where a format pads, or writes digits, without bound; digits are those of all scripts to Python."""
    widths = re.findall(r"\d+", specification)
    if "*" in specification or any(len(width) > 4 or int(width) > _WIDEST for width in widths):
        raise RefusedError(f"a format of more than {_WIDEST} characters")


def check_growth(text: str, name: str, given: tuple[Any, ...], named: dict[str, Any]) -> None:
    """Raise where a method would make a text too long."""
    values = [*given, *named.values()]
    if name in ("center", "ljust", "rjust", "zfill"):
        widths = [value for value in values if isinstance(value, int)]
        sized(max([0, *widths]), _WIDEST, "a text that is padded to {} characters")
    elif name == "format":
        check_fields(text, values)
    elif name == "replace" and len(given) > 1 and all(isinstance(each, str) for each in given[:2]):
        sized(len(text) + text.count(given[0]) * len(given[1]), MOST_TEXT, "a text of {} characters")


def _counted(*bounds: Any) -> range:
    found = range(*bounds)
    if max(map(abs, (found.start, found.stop))) >= 1 << 62 or len(found) > MOST_ITEMS:
        raise RefusedError(f"a range of more than {MOST_ITEMS} items")
    return found


def _rounded(value: Any, digits: Any = None) -> Any:
    if digits is not None and isinstance(digits, int):
        sized(abs(digits), _WIDEST, "a number that is rounded to {} digits")
    return round(value, digits)


def _total(items: Any, start: Any = 0) -> Any:
    items = list(items)
    if all(isinstance(item, (int, float, complex)) for item in items):
        return sum(items, start)
    return reduce(partial(binary, ast.Add), items, start)


_ITERATORS = (enumerate, zip, reversed)
_GROWING = ("factorial", "comb", "perm", "prod", "lcm")
"""Functions of whole numbers whose values are soon large."""
PLAIN: list[tuple[Any, Callable[..., Any]]] = [
    *((each, each) for each in (list, dict, tuple, len, str, float, int, bool, repr, abs, all, any, isinstance, ord)),
    *((each, each) for each in (min, max, sorted)),
    *((each, lambda *given, _each=each, **named: list(_each(*given, **named))) for each in _ITERATORS),
    (range, _counted),
    (round, _rounded),
    (sum, _total),
    (type, operator.attrgetter("__class__")),
    *(
        (function, function)
        for name, function in vars(math).items()
        if callable(function) and not name.startswith("_") and name not in _GROWING
    ),
]
"""What stands for each function or type that may be called: itself, or one that is bounded."""
