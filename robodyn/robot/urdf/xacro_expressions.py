"""Expressions of xacro, computed from their syntax: what is not listed here is refused, and all is bounded.

Values are numbers, text, and lists, tuples and dictionaries of these; functions are not called by others, and have no
attributes. Each step is counted, and whatever could make something large is asked for its size first.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial, reduce
from string import Formatter
from typing import Any, NamedTuple

from robodyn.support.wording import shown

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
_SPOKEN = {"Lambda": "a lambda", "NamedExpr": "an assignment", "Await": "an await", "Yield": "a yield"}


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
        if re.search(r"%\([^)]*\(", left):
            raise RefusedError("a format with brackets in a key")
        for found in re.finditer(r"%(?:\([^)]*\))?([^a-zA-Z%]*)", left):
            check_width(found[1])
        sized(left.count("%") * measured(right), 100 * MOST_TEXT, "a text of {} characters")
    return checked(BINARY[kind](left, right))


def check_width(specification: str) -> None:
    """Raise where a format pads, or writes digits, without bound; digits are those of all scripts to Python."""
    widths = re.findall(r"\d+", specification)
    if "*" in specification or any(len(width) > 4 or int(width) > _WIDEST for width in widths):
        raise RefusedError(f"a format of more than {_WIDEST} characters")


def check_growth(text: str, name: str, given: tuple[Any, ...], named: dict[str, Any]) -> None:
    values = [*given, *named.values()]
    if name in ("center", "ljust", "rjust", "zfill"):
        widths = [value for value in values if isinstance(value, int)]
        sized(max([0, *widths]), _WIDEST, "a text that is padded to {} characters")
    elif name == "format":
        for _, field, specification, _ in Formatter().parse(text):
            if set(field or "") & set(".[") or "{" in (specification or ""):
                raise RefusedError("a format with a dot, a bracket or a format in a field")
            check_width(specification or "")
        sized(text.count("{") * measured(values), 100 * MOST_TEXT, "a text of {} characters")
    elif name == "replace" and len(given) > 1 and all(isinstance(each, str) for each in given[:2]):
        sized(len(text) + text.count(given[0]) * len(given[1]), MOST_TEXT, "a text of {} characters")


def _counted(*bounds: Any) -> range:
    found = range(*bounds)
    if max(map(abs, (found.start, found.stop))) >= 1 << 62 or len(found) > MOST_ITEMS:
        raise RefusedError(f"a range of more than {MOST_ITEMS} items")
    return found


def _rounded(value: Any, digits: Any = None) -> Any:
    if isinstance(digits, int):
        sized(abs(digits), _WIDEST, "a number that is rounded to {} digits")
    return round(value, digits)


def _total(items: Any, start: Any = 0) -> Any:
    items = list(items)
    if all(isinstance(item, (int, float, complex)) for item in items):
        return sum(items, start)
    return reduce(partial(binary, ast.Add), items, start)


_GROWING = ("factorial", "comb", "perm", "prod", "lcm")
"""Functions of whole numbers whose values are soon large."""
PLAIN: list[tuple[Any, Callable[..., Any]]] = [
    *((each, each) for each in (list, dict, tuple, len, str, float, int, bool, repr, abs, all, any, isinstance, ord)),
    *((each, each) for each in (min, max, sorted)),
    *((each, lambda *given, _each=each, **named: list(_each(*given, **named))) for each in (enumerate, zip, reversed)),
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
MOST_STEPS = 1_000_000
"""Operations of one expression."""
MOST_SOURCE = 20_000
"""Characters of an expression."""


class _Method(NamedTuple):
    owner: Any
    name: str


_UNARY: dict[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.Not: operator.not_,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Invert: operator.invert,
}
_COMPARED: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda left, right: left in right,
    ast.NotIn: lambda left, right: left not in right,
}
_NAMED: dict[type, str] = {
    str: "capitalize casefold center count endswith find format index isalnum isalpha isascii isdecimal "
    "isdigit isidentifier islower isnumeric isspace istitle isupper join ljust lower lstrip partition removeprefix "
    "removesuffix replace rfind rindex rjust rpartition rsplit rstrip split splitlines startswith strip swapcase title "
    "upper zfill",
    list: "append copy count extend index insert pop remove reverse sort",
    tuple: "count index",
    dict: "copy get items keys pop setdefault update values",
    float: "is_integer",
}
_METHODS = {kind: frozenset(names.split()) for kind, names in _NAMED.items()}


class Evaluator:
    """Computes expressions.

    Args:
        functions: what stands for each that may be called, as `PLAIN`.
        namespace: the type of xacro's name spaces, whose attributes are what is in them.
    """

    def __init__(self, functions: Sequence[tuple[Any, Callable[..., Any]]], namespace: type) -> None:
        self._functions = {id(name): (name, call) for name, call in [*PLAIN, (map, self._map), *functions]}
        self._namespace = namespace
        self._steps = 0

    def evaluate(self, source: str, names: Mapping[str, Any]) -> Any:
        """Return the value of an expression; RefusedError of what is not allowed or too large, and what Python raises
        of it."""
        source = source.strip()
        if len(source) > MOST_SOURCE:
            raise RefusedError(f"an expression of more than {MOST_SOURCE} characters")
        try:
            expression = ast.parse(source, mode="eval").body
        except (MemoryError, RecursionError):  # how Python's parser says so
            raise RefusedError("an expression that is nested too deeply") from None
        within = self._steps > 0  # of another, which asks for a property that is not computed yet
        try:
            return checked(self._of(expression, [names]))
        finally:
            self._steps = self._steps if within else 0

    def _of(self, node: ast.expr, scopes: list[Any]) -> Any:
        """Return the value of a part of an expression; `scopes` are names and their values, the innermost last."""
        self._steps += 1
        if self._steps > MOST_STEPS:
            raise RefusedError(f"an expression of more than {MOST_STEPS} steps")
        rule = getattr(self, f"_{type(node).__name__}", None)
        if rule is None:
            raise RefusedError(f"{_SPOKEN.get(type(node).__name__, type(node).__name__)} in an expression")
        return rule(node, scopes)

    def _Constant(self, node: ast.Constant, _: list[Any]) -> Any:
        if not isinstance(node.value, (str, int, float, complex, type(None))):
            raise RefusedError(f"{type(node.value).__name__} in an expression")
        return checked(node.value)

    def _Name(self, node: ast.Name, scopes: list[Any]) -> Any:
        if node.id.startswith("__"):
            raise RefusedError(f"the name {shown(node.id)}")
        for scope in reversed(scopes):
            try:
                return scope[node.id]
            except KeyError:
                continue
        raise NameError(f"name {node.id!r} is not defined")

    def _BinOp(self, node: ast.BinOp, scopes: list[Any]) -> Any:
        if type(node.op) not in BINARY:
            raise RefusedError("a product of matrices in an expression")
        return binary(type(node.op), self._of(node.left, scopes), self._of(node.right, scopes))

    def _UnaryOp(self, node: ast.UnaryOp, scopes: list[Any]) -> Any:
        return _UNARY[type(node.op)](self._of(node.operand, scopes))

    def _BoolOp(self, node: ast.BoolOp, scopes: list[Any]) -> Any:
        ends = operator.not_ if isinstance(node.op, ast.And) else bool
        value = None
        for part in node.values:
            value = self._of(part, scopes)
            if ends(value):
                break
        return value

    def _Compare(self, node: ast.Compare, scopes: list[Any]) -> Any:
        left, found = self._of(node.left, scopes), True
        for kind, part in zip(node.ops, node.comparators, strict=True):
            right = self._of(part, scopes)
            found = _COMPARED[type(kind)](checked(left), checked(right))
            if not found:
                break
            left = right
        return found

    def _IfExp(self, node: ast.IfExp, scopes: list[Any]) -> Any:
        return self._of(node.body if self._of(node.test, scopes) else node.orelse, scopes)

    def _List(self, node: ast.List, scopes: list[Any]) -> Any:
        return checked([self._of(each, scopes) for each in node.elts])

    def _Tuple(self, node: ast.Tuple, scopes: list[Any]) -> Any:
        return checked(tuple(self._of(each, scopes) for each in node.elts))

    def _Dict(self, node: ast.Dict, scopes: list[Any]) -> Any:
        found: dict[Any, Any] = {}
        for key, value in zip(node.keys, node.values, strict=True):
            if key is None:
                raise RefusedError("two stars in an expression")
            found[self._of(key, scopes)] = self._of(value, scopes)
        return checked(found)

    def _Subscript(self, node: ast.Subscript, scopes: list[Any]) -> Any:
        value, key = self._of(node.value, scopes), self._of(node.slice, scopes)
        if isinstance(value, type):
            raise RefusedError(f"the type {value.__name__} with brackets")
        return value[key]

    def _Slice(self, node: ast.Slice, scopes: list[Any]) -> Any:
        ends = (node.lower, node.upper, node.step)
        return slice(*(None if part is None else self._of(part, scopes) for part in ends))

    def _Attribute(self, node: ast.Attribute, scopes: list[Any]) -> Any:
        """Return a member of a name space or of a table of YAML, a method that is listed, or a part of a number."""
        value, name = self._of(node.value, scopes), node.attr
        if name.startswith("_"):
            raise RefusedError(f"the attribute {shown(name)}, which begins with an underscore,")
        if isinstance(value, self._namespace):
            try:
                return value[name]  # type: ignore[index]
            except KeyError:
                raise NameError(f"name {name!r} is not defined") from None
        if isinstance(value, type):
            raise RefusedError(f"the attribute {shown(name)} of the type {value.__name__}")
        kind = type(value)
        known = next((methods for base, methods in _METHODS.items() if issubclass(kind, base)), frozenset[str]())
        if name in known:
            return _Method(value, name)
        if type(value).__name__ == DOTTED:
            return value[name]
        if name in ("real", "imag") and isinstance(value, (int, float, complex)):
            return getattr(value, name)
        if hasattr(kind, name) and not isinstance(value, dict):
            raise RefusedError(f"the attribute {shown(name)} of {kind.__name__}")
        raise AttributeError(f"{kind.__name__!r} object has no attribute {name!r}")

    def _Call(self, node: ast.Call, scopes: list[Any]) -> Any:
        function = self._of(node.func, scopes)
        given = tuple(self._of(each, scopes) for each in node.args)
        named = {keyword.arg or "": self._of(keyword.value, scopes) for keyword in node.keywords}
        if "" in named or callable(named.get("key")):
            raise RefusedError("two stars, or a function for a key, in a call")
        return self._called(function, *given, **named)

    def _called(self, function: Any, /, *given: Any, **named: Any) -> Any:
        checked([*given, *named.values()])
        if isinstance(function, _Method):
            return checked(self._method(function.owner, function.name, given, named))
        known = self._functions.get(id(function))
        if known is None:
            name = getattr(function, "__name__", None)
            if callable(function) and isinstance(name, str):
                raise RefusedError(f"the function {name}()")
            raise TypeError(f"{type(function).__name__!r} object is not callable")
        return checked(known[1](*given, **named))

    def _map(self, function: Any, *items: Any) -> list[Any]:
        return [self._called(function, *each) for each in zip(*items, strict=False)]

    def _method(self, owner: Any, name: str, given: tuple[Any, ...], named: dict[str, Any]) -> Any:
        checked(owner)
        kind = next((base for base, methods in _METHODS.items() if isinstance(owner, base) and name in methods), None)
        if kind is None or isinstance(owner, self._namespace):
            raise TypeError(f"{name}() of {type(owner).__name__}")
        if kind is str:
            check_growth(owner, name, given, named)
            if name == "join":
                given = tuple(list(checked(each)) for each in given)
                sized(sum(map(len, map(str, *given))) + len(owner) * len(*given), MOST_TEXT, "a text of {} characters")
        found = getattr(owner, name)(*given, **named)
        checked(owner)
        return list(found) if kind is dict and name in ("items", "keys", "values") else found

    def _ListComp(self, node: ast.ListComp | ast.GeneratorExp, scopes: list[Any]) -> list[Any]:
        local: dict[str, Any] = {}
        inner, found = [*scopes, local], list[Any]()

        def run(depth: int) -> None:
            if depth == len(node.generators):
                found.append(self._of(node.elt, inner))
                sized(len(found), MOST_ITEMS, "a comprehension of {} items")
                return
            loop = node.generators[depth]
            for item in list(checked(self._of(loop.iter, inner if depth else scopes))):
                self._steps += 1
                _bind(loop.target, item, local)
                if all(self._of(test, inner) for test in loop.ifs):
                    run(depth + 1)

        run(0)
        return found

    _GeneratorExp = _ListComp

    def _JoinedStr(self, node: ast.JoinedStr, scopes: list[Any]) -> str:
        return str(checked("".join(str(self._of(part, scopes)) for part in node.values)))

    def _FormattedValue(self, node: ast.FormattedValue, scopes: list[Any]) -> str:
        value = self._of(node.value, scopes)
        if node.conversion > 0:
            value = Formatter().convert_field(value, chr(node.conversion))
        specification = "" if node.format_spec is None else self._of(node.format_spec, scopes)
        check_width(specification)
        return format(checked(value), specification)


def _bind(target: ast.expr, value: Any, names: dict[str, Any]) -> None:
    if isinstance(target, ast.Name):
        names[target.id] = value
    elif isinstance(target, (ast.Tuple, ast.List)):
        values = list(value)
        if len(values) != len(target.elts):
            raise ValueError(f"{len(target.elts)} names for {len(values)} values")
        for part, one in zip(target.elts, values, strict=True):
            _bind(part, one, names)
    else:
        raise RefusedError("a comprehension that sets more than names")
