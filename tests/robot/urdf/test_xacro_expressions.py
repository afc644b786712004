"""Expressions of xacro: what descriptions use means what Python makes of it; all that leads out of them is refused."""

from __future__ import annotations

import builtins
import math
import random
from typing import Any

import pytest

from robodyn.robot.urdf.xacro_expressions import MOST_ITEMS, MOST_TEXT, Evaluator, RefusedError, checked

pytestmark = pytest.mark.filterwarnings("ignore::SyntaxWarning")


class NameSpace(dict[str, Any]):
    """As xacro's: what is in it are its attributes."""

    __getattr__ = dict.__getitem__  # type: ignore[assignment]


class YamlDictWrapper(dict[str, Any]):
    """As xacro's of this name."""

    __getattr__ = dict.__getitem__  # type: ignore[assignment]


BUILTINS = (
    "list dict map len str float int bool min max round sorted range abs all any complex divmod enumerate filter "
    "frozenset hash isinstance issubclass ord repr reversed slice set sum tuple type vars zip"
)
NAMES: dict[str, Any] = {
    **{name: getattr(builtins, name) for name in BUILTINS.split()},
    **{name: value for name, value in vars(math).items() if not name.startswith("_")},
    "math": NameSpace({name: value for name, value in vars(math).items() if not name.startswith("_")}),
    "limits": YamlDictWrapper({"elbow": YamlDictWrapper({"lower": -1.5, "upper": 2}), "names": ["a", "b"]}),
    "table": {"a": 1, "b": [1, 2, 3]},
    "prefix": "left_",
    "mass": 2.5,
    "n": 3,
}


def evaluate(source: str) -> Any:
    return Evaluator([], NameSpace).evaluate(source, NAMES)


def by_python(source: str) -> Any:
    return eval(source, {**NAMES, "__builtins__": {}})


USED = [
    "mass * 9.81 + n",
    "7 // 2 + 7 % 4 - (1 << 3) + (6 & 3 | 8 ^ 1) + ~1",
    "sin(pi / 2) + radians(90) + atan2(1, 2) + hypot(3, 4) + math.sqrt(2)",
    "prefix + 'link' if n == 3 and not mass < 1 or False else ''",
    "1 < n <= 3 != 4",
    "limits.elbow.lower + limits['elbow']['upper']",
    "limits.elbow.get('velocity', 1.0)",
    "table['b'][::-1][0:2]",
    "[x * 2 for x in range(5) if x % 2]",
    "' '.join(str(round(x, 3)) for x in [0.1, 0.25])",
    "list(map(float, '1 2 3'.split()))",
    "sorted(['bb', 'a']) + [max([1, 3], default=0), min(1, 2)]",
    "list(zip([1, 2], 'ab')) + list(enumerate('xy', 1)) + list(reversed([1, 2]))",
    "dict(c=1)",
    "'%0.3f %s %d%%' % (mass, prefix, n)",
    "'{:.3f} {} {0!r}'.replace('{0!r}', '').format(mass, prefix)",
    "f'{prefix}{n:03d} {mass!r:>8} {n:{n}d}'",
    "isinstance(prefix, str) and type(n) == int",
    "len(prefix.split('_')) * [0]",
    "int('3') + float('1e-3') + bool(0) + abs(-1) + ord('a')",
    "2**10 + 2**-1 + (-8)**2",
    "str(True) + repr('x') + str(None) + str((1, 2))",
    "n.real + (1j).imag",
    "'a,b;c'.replace(';', ',').upper().partition(',')",
]


@pytest.mark.parametrize("source", USED)
def test_what_descriptions_use_means_what_python_makes_of_it(source: str) -> None:
    assert evaluate(source) == by_python(source)


ATOMS = ["1", "2.5", "n", "mass", "prefix", "'x'", "[1, 2, 3]", "table['b']", "limits.elbow.lower", "(1, 'y')", "True"]
FORMS = [
    "({} + {})", "({} - {})", "({} * {})", "({} / {})", "({} % {})", "({} // {})", "({} == {})", "({} < {})",
    "({} and {})", "({} or {})", "({} if {} else 0)", "[{}, {}]", "str({}) + str({})", "max({}, {})", "({} in {})",
    "[x for x in {} if {}]", "len({}) + {}", "'%s %s' % ({}, {})", "f'{{{}}} {{{}}}'", "round({}, {})", "({})[{}]",
    "sorted({}) + [{}]", "dict(a={}, b={})['a']", "'{{}} {{}}'.format({}, {})", "sum({}) + sum({})",
]  # fmt: skip


def random_expression(draw: random.Random, depth: int) -> str:
    if depth == 0:
        return draw.choice(ATOMS)
    return draw.choice(FORMS).format(random_expression(draw, depth - 1), random_expression(draw, draw.randrange(depth)))


def outcome(compute: Any) -> tuple[str, str]:
    try:
        return "value", repr(compute())
    except Exception as error:
        return "error", type(error).__name__


def test_random_expressions_are_as_python_has_them() -> None:
    """Value, its type, and the kind of error; of 1000, so many have a value that neither is tested in vain."""
    draw, kinds = random.Random(28), []
    while len(kinds) < 1000:
        source = random_expression(draw, draw.randint(1, 3))
        if source.count("'") > 2 and "f'" in source:
            continue  # quotes in formatted text are new in Python 3.12
        expected = outcome(lambda: by_python(source))  # noqa: B023
        assert outcome(lambda: evaluate(source)) == expected, source  # noqa: B023
        kinds.append(expected[0])
    assert min(kinds.count("value"), kinds.count("error")) > 150


OUT = [
    "().__class__",
    "(lambda: 1)()",
    "[c for c in ().__class__.__base__.__subclasses__()]",
    "'{0.__class__.__init__.__globals__}'.format(n)",
    "'{0.real.__class__}'.format(n)",
    "'{x.__class__}'.format_map({'x': 1})",
    "list(map(str.format, ['{0.__class__}'], [1]))",
    "str.format('{0.__class__}', 1)",
    "f\"{''.__class__}\"",
    "sin.__self__",
    "[].append.__self__",
    "math.__loader__",
    "limits.__class__",
    "__import__('os')",
    "__builtins__",
    "type('X', (), {})",
    "vars()",
    "list(map(vars, [math]))",
    "dict.update(math, {'pi': 3})",
    "dict.fromkeys('ab')",
    "int.from_bytes([255], 'big')",
    "list[int]",
    "b'bytes'",
    "'a'.encode()",
    "'a'.translate({})",
    "(x := 5)",
    "(yield)",
    "[x for x.y in [1]]",
    "getattr(1, 'real')",
    "eval('1')",
    "open('/etc/passwd')",
    "import os",
    "n = 1",
    "-" * 10_000 + "1",
    "1" + "+1" * 9_000,
    "x" * 30_000,
]
"""Ways out of a list of names, which others have found; none gives a value."""


@pytest.mark.parametrize("source", OUT)
def test_ways_out_are_closed(source: str) -> None:
    with pytest.raises((RefusedError, NameError, SyntaxError, TypeError)):
        evaluate(source)


LARGE = [
    "9**9**9",
    "1 << 10**10",
    "2**4000 * 2**4000",
    "list(range(10**12))",
    "'a' * 10**9",
    "[x for a in range(10**4) for x in range(10**4)]",
    pytest.param("[0 for a in range(10**5) for b in range(10**5) if False]", marks=pytest.mark.slow),
    "factorial(10**7)",
    "list(map(factorial, [10**7]))",
    "prod([2**2000] * 1000)",
    "lcm(*[2**(i + 1) + 1 for i in range(1500)])",
    "round(5, -10**9)",
    "'%999999999d' % 1",
    "'%*d' % (10**9, 1)",
    "'%(a(b)c)999999999d' % {'a(b)c': 1}",
    "'%(a)s' * 90000 % {'a': 'b' * 100000}",
    "'{:{}}'.format(1, 10**9)",
    "'{:\uff19\uff19\uff19\uff19\uff19\uff19\uff19}'.format(1)",
    "f'{1:\u0669\u0669\u0669\u0669\u0669}'",
    "'a'.zfill(10**9)",
    "('a' * 100000).replace('', 'b' * 100000)",
    "('a' * 100000).join(['b'] * 90000)",
    "[[[[[[0] * 10] * 10] * 10] * 10] * 10] * 10",
    "[x for x in [[]] if x.append(x) is None]",
    "int('9' * 4000)",
]


@pytest.mark.parametrize("source", LARGE)
def test_nothing_becomes_large(source: str) -> None:
    with pytest.raises(RefusedError):
        evaluate(source)


def test_shared_parts_count_as_often_as_they_are_written() -> None:
    """As aliases of YAML make them: twenty lists stand for a million."""
    value: Any = [0, 1]
    for _ in range(20):
        value = [value, value]
    with pytest.raises(RefusedError, match=f"more than {MOST_ITEMS} items"):
        checked(value)
    with pytest.raises(RefusedError, match=f"more than {MOST_TEXT} characters"):
        checked(["x" * 100_000] * 11)
    assert checked(["x" * 100_000] * 10)
