"""The equations of motion of a small robot in closed form, every entry checked against the recursion in numbers."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from decimal import Decimal
from typing import Any, NamedTuple

import numpy as np

from robodyn.dynamics.inverse import mass_runner
from robodyn.equations.ode import bias_plan, check_equations, identifiers
from robodyn.errors import InputError
from robodyn.programs.program import Program
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.programs.scalar import ADD, CONSTANT, COS, DIV, EXP, INPUT, MUL, NEG, SIGN, SIN, SQRT, SUB
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.extras import need

ROUNDING = 4 * 2.0**-52
"""A coefficient that is a smaller share of what added up to it is zero."""

Angle = tuple[float, ...]
"""Multiples of the generators; the first that is not zero is positive."""
DIGITS = 10
"""Decimals of up to so many digits count as short."""
SHORT = 16 * 2.0**-52
"""A coefficient this near a short decimal, as a share of itself, is taken to be that decimal."""


class Key(NamedTuple):
    """`powers` are generators, each as often as its power; `wave` is "cos", or "sin" with an angle that is not zero."""

    powers: tuple[int, ...]
    wave: str
    angle: Angle


ONE = Key((), "cos", ())


class Coefficient(NamedTuple):
    """A coefficient, and the sum of the magnitudes that added up to it."""

    value: float
    size: float


Polynomial = dict[Key, Coefficient]


class TooLargeError(Exception):
    """More products of terms would be needed than are allowed."""


def constant(value: float) -> Polynomial:
    return {ONE: Coefficient(value, abs(value))} if value else {}


def total(a: Polynomial, b: Polynomial, sign: float = 1.0) -> Polynomial:
    terms = dict(a)
    for key, (value, size) in b.items():
        old = terms.get(key, Coefficient(0.0, 0.0))
        terms[key] = Coefficient(old.value + sign * value, old.size + size)
    return _pruned(terms)


def wave(kind: str, angle: Angle) -> Polynomial:
    turned, sign = upright(kind, angle)
    if not turned:
        return constant(1.0) if kind == "cos" else {}
    return {Key((), kind, turned): Coefficient(sign, 1.0)}


def linear(a: Polynomial) -> tuple[Angle, float] | None:
    """Return the multiples of generators and the constant that a sums up, if it is no more than that."""
    multiples: dict[int, float] = {}
    offset = 0.0
    for key, (value, _) in a.items():
        if key.angle or len(key.powers) > 1:
            return None
        if key.powers:
            multiples[key.powers[0]] = value
        else:
            offset = value
    width = max(multiples, default=-1) + 1
    return tuple(multiples.get(k, 0.0) for k in range(width)), offset


def _waves(left: Key, right: Key) -> list[tuple[str, Angle, float]]:
    """Return the product of two waves as a sum: wave, angle, share."""
    if not left.angle or not right.angle:
        other = left if left.angle else right
        return [(other.wave, other.angle, 1.0)]
    sum_of, difference = combined_angles(left.angle, right.angle, 1.0), combined_angles(left.angle, right.angle, -1.0)
    if left.wave == right.wave:
        share = 0.5 if left.wave == "cos" else -0.5
        pairs = [("cos", difference, 0.5), ("cos", sum_of, share)]
    else:
        pairs = [("sin", sum_of, 0.5), ("sin", difference, 0.5 if left.wave == "sin" else -0.5)]
    out = []
    for kind, angle, share in pairs:
        turned, sign = upright(kind, angle)
        if turned or kind == "cos":
            out.append((kind, turned, sign * share))
    return out


def combined_angles(a: Angle, b: Angle, sign: float) -> Angle:
    width = max(len(a), len(b))
    padded = zip(a + (0.0,) * (width - len(a)), b + (0.0,) * (width - len(b)), strict=True)
    return tuple(x + sign * y for x, y in padded)


def upright(kind: str, angle: Angle) -> tuple[Angle, float]:
    """Return the angle with its first multiple positive and without zeros at its end, and the sign of the wave."""
    width = max((k + 1 for k, x in enumerate(angle) if x), default=0)
    angle = angle[:width]
    if next((x for x in angle if x), 0.0) < 0.0:
        return tuple(-x for x in angle), -1.0 if kind == "sin" else 1.0
    return angle, 1.0


def _pruned(terms: Polynomial) -> Polynomial:
    return {key: entry for key, entry in terms.items() if abs(entry.value) > ROUNDING * entry.size}


class Forms:
    """Programs in the arithmetic of `robodyn.equations.closed`. What is no such polynomial (the sign of a speed, a
    root) becomes a generator of its own, with its argument in closed form."""

    def __init__(self, symbols: Mapping[tuple[str, int], Any], products: int) -> None:
        """Args: symbols: of the inputs; those but q stand apart in results. products: of terms that may be formed."""
        self._symbols, self._left = symbols, products
        self._generators: dict[Any, int] = {symbol: k for k, symbol in enumerate(dict.fromkeys(symbols.values()))}
        self._rates = {symbol for (source, _), symbol in symbols.items() if source != "q"}

    @property
    def generators(self) -> list[Any]:
        """The symbols, then what became a generator on the way."""
        return list(self._generators)

    def outputs(self, program: Program) -> list[Polynomial]:
        values: list[Polynomial] = []
        for op, a, b in program.operations:
            if op is INPUT:
                values.append(self._generator(self._symbols[a, b]))
            elif op is CONSTANT:
                values.append(constant(a))
            else:
                values.append(self._operation(op, *(values[k] for k in (a, b) if k is not None)))
        return [values[k] for k in program.outputs]

    def expression(self, form: Polynomial, least: float = 0.0) -> Any:
        """Return the SymPy expression of a form by products of rates, without coefficients smaller than `least`."""
        sympy, symbols = module(), list(self._generators)
        groups: defaultdict[Any, list[Any]] = defaultdict(list)
        for key, coefficient in form.items():
            if abs(coefficient.value) < least:
                continue
            powers = [symbols[k] for k in key.powers]
            rates = sympy.Mul(*(x for x in powers if x in self._rates))
            rest = sympy.Mul(*(x for x in powers if x not in self._rates))
            if key.angle:
                angle = sympy.Add(*(number(x) * symbols[k] for k, x in enumerate(key.angle)))
                rest *= getattr(sympy, key.wave)(angle)
            # the short decimal next to a coefficient, if rounding alone can tell them apart
            value = coefficient.value
            short = float(f"{value:.{DIGITS - 1}e}")
            groups[rates].append(number(short if abs(short - value) <= SHORT * abs(value) else value) * rest)
        return sympy.Add(*(rates * sympy.Add(*terms) for rates, terms in groups.items()))

    def _operation(self, op: str, a: Polynomial, b: Polynomial | None = None) -> Polynomial:
        if b is None:
            if op is NEG:
                return total({}, a, -1.0)
            return self._turned(op, a) if op in (SIN, COS) else self._opaque(operations()[op](self.expression(a)))
        if op is MUL:
            return self._product(a, b)
        if op is DIV:
            angle, divisor = linear(b) or ((1.0,), 0.0)
            inverse = self._opaque(1 / self.expression(b)) if angle else constant(1.0 / divisor)
            return self._product(a, inverse)
        return total(a, b, 1.0 if op is ADD else -1.0)

    def _product(self, a: Polynomial, b: Polynomial) -> Polynomial:
        self._left -= len(a) * len(b)
        if self._left < 0:
            raise TooLargeError
        values: defaultdict[Key, list[float]] = defaultdict(lambda: [0.0, 0.0])
        for left, (x, x_size) in a.items():
            for right, (y, y_size) in b.items():
                powers = tuple(sorted(left.powers + right.powers))
                for wave, angle, share in _waves(left, right):
                    entry = values[Key(powers, wave, angle)]
                    entry[0] += share * x * y
                    entry[1] += abs(share) * x_size * y_size
        return _pruned({key: Coefficient(*entry) for key, entry in values.items()})

    def _turned(self, op: str, a: Polynomial) -> Polynomial:
        """Return the sine or cosine of a; a constant in the angle turns one into the other."""
        known = linear(a)
        if known is None:
            return self._opaque(operations()[op](self.expression(a)))
        angle, offset = known
        sine, cosine = wave("sin", angle), wave("cos", angle)
        first, second = (cosine, sine) if op is COS else (sine, cosine)
        turned = self._product(second, constant(math.sin(offset)))
        return total(self._product(first, constant(math.cos(offset))), turned, -1.0 if op is COS else 1.0)

    def _opaque(self, expression: Any) -> Polynomial:
        if expression.is_number:
            return constant(float(expression))
        return self._generator(expression)

    def _generator(self, expression: Any) -> Polynomial:
        k = self._generators.setdefault(expression, len(self._generators))
        return {Key((k,), "cos", ()): Coefficient(1.0, 1.0)}


Symbols = Mapping[tuple[str, int], Any]

MOST_JOINTS = 6
"""Coordinates of a robot whose closed form can be written down."""
PRODUCTS = 500_000
"""Of terms, for M and for each effect: some seconds at most."""
LONGEST = 20_000
"""Operations of an entry that is not simplified."""
REMEDY = "--form ode has numbers at a configuration, robodyn export writes them as code"
STATES = 16
TOLERANCE = 1e-12
FLOOR = 1e-3
"""An entry is compared with the largest of its unit, or with this share of the largest of all if that is more."""
NEGLIGIBLE = 1e-15
"""A smaller share of the largest coefficient of its unit is what rounding leaves of the description's zeros."""


@dataclass(frozen=True, eq=False)
class Closed:
    """M(q) qdd + the sum of the bias's parts = tau, as SymPy expressions.

    Attributes:
        joints: names of the coordinates; kinds: "revolute" or "prismatic".
        q, qd: the symbols, q_<joint> and qd_<joint>.
        M: rows of entries.
        bias: entries of each part, by effect: gravity, coriolis, frictions and so on.
        plain: how many entries are left as the recursion makes them, unsimplified.
        error: the largest difference from the recursion in numbers, relative to the largest entry of its unit.
    """

    robot: str
    gravity: tuple[float, float, float]
    joints: tuple[str, ...]
    kinds: tuple[str, ...]
    q: tuple[Any, ...]
    qd: tuple[Any, ...]
    M: tuple[tuple[Any, ...], ...]
    bias: Mapping[str, tuple[Any, ...]]
    plain: int
    error: float


def closed(model: Model, scene: Scene = DEFAULT, products: int = PRODUCTS) -> Closed:
    """Return the equations of motion in closed form.

    The traced recursion, run on trigonometric polynomials: every entry is a sum of sines and cosines of sums of angles,
    which is unique. Each entry is then compared with the recursion in numbers at random states; one that differs, or
    that needs too much work, is left as the recursion makes it.

    Args:
        products: of terms that may be formed for M and for each effect.

    Raises:
        InputError: the robot is too large, its base moves, there are no equations, or SymPy is not installed.

    Accuracy: every entry within 1e-12 of the largest of its unit.
    """
    check_equations(model, scene)
    if model.nq != model.n:
        raise InputError("a floating joint has no closed form here", remedy=REMEDY, file=model.file)
    if model.n > MOST_JOINTS:
        what = f"{model.n} coordinates are too many for a closed form, which goes up to {MOST_JOINTS}"
        raise InputError(what, remedy=REMEDY, file=model.file)
    n, names = model.n, identifiers(model.rates, "joint")
    symbols = {
        (source, i): module().Symbol(f"{source}_{name}", real=True)
        for source in ("q", "qd")
        for i, name in enumerate(names)
    }
    kinds = [joint.kind for joint in model.independent]
    pairs = [f"{min(a, b)} {max(a, b)}" for a in kinds for b in kinds]
    mass = _part(mass_runner(model, scene).program, symbols, pairs, products)
    plan = bias_plan(model, scene)
    effects = [effect for effect in plan.effects if effect.name != "mimic"]
    parts = {effect.name: _part(plan.share(effect), symbols, kinds, products) for effect in effects}
    return Closed(
        robot=model.name,
        gravity=scene.gravity,
        joints=model.rates,
        kinds=tuple(kinds),
        q=tuple(symbols["q", i] for i in range(n)),
        qd=tuple(symbols["qd", i] for i in range(n)),
        M=tuple(tuple(mass[0][n * i : n * i + n]) for i in range(n)),
        bias={name: tuple(entries) for name, (entries, _, _) in parts.items()},
        plain=sum(plain for _, _, plain in (mass, *parts.values())),
        error=max(error for _, error, _ in (mass, *parts.values())),
    )


def _part(program: Program, symbols: Symbols, units: Sequence[str], products: int) -> tuple[list[Any], float, int]:
    """Return the outputs of a program in closed form, how far they are from its numbers, and how many are as the
    recursion makes them; outputs of the same unit compare."""
    states = np.random.default_rng(0).uniform(-2.0, 2.0, (STATES, len(symbols)))
    n = len(symbols) // 2
    numbers = NumpyBlocks(program, {"q": n, "qd": n})({"q": states[:, :n], "qd": states[:, n:]}, STATES)
    forms, found = Forms(symbols, products), list[Polynomial]()
    with suppress(TooLargeError):
        found = forms.outputs(program)
    alike = {unit: [k for k, other in enumerate(units) if other == unit] for unit in units}
    sizes = [max((abs(x.value) for x in form.values()), default=0.0) for form in found]
    errors: dict[int, float] = {}
    entries: list[Any] = [None] * len(units)
    for k, (form, unit) in enumerate(zip(found, units, strict=False)):
        least = NEGLIGIBLE * max(*(sizes[i] for i in alike[unit]), FLOOR * max(sizes))
        expression = forms.expression(form, least)
        scale = max(float(np.abs(numbers[:, alike[unit]]).max()), FLOOR * float(np.abs(numbers).max()))
        off = np.abs(module().lambdify(list(symbols.values()), expression, "numpy")(*states.T) - numbers[:, k])
        error = float(off.max()) / (scale or 1.0)
        if error <= TOLERANCE:
            entries[k], errors[k] = expression, error
    if len(errors) < len(units):
        lengths: list[int] = []
        for op, a, b in program.operations:
            leaf = op is INPUT or op is CONSTANT
            lengths.append(1 if leaf else 1 + lengths[a] + (0 if b is None else lengths[b]))
        longest = max(lengths[k] for k in program.outputs)
        if longest > LONGEST:
            raise InputError(f"the closed form of this robot has an entry of {longest} operations", remedy=REMEDY)
        plain = expressions(program, symbols)
        entries = [entries[k] if k in errors else plain[k] for k in range(len(units))]
    return entries, max(errors.values(), default=0.0), len(units) - len(errors)


def decimal(expression: Any) -> Any:
    """Return the same expression with floats of 17 digits for its fractions; exponents stay."""
    sympy = module()
    if expression.is_Rational:
        return expression if expression.is_Integer else sympy.Float(expression, 17)
    if expression.is_Pow:
        return sympy.Pow(decimal(expression.base), expression.exp)
    return expression.func(*map(decimal, expression.args)) if expression.args else expression


def expressions(program: Program, symbols: Symbols) -> list[Any]:
    """Return the outputs of a program as SymPy expressions of its inputs, which are symbols or expressions."""
    return program.evaluated(lambda source, column: symbols[source, column], number, operations())


def number(value: float) -> Any:
    """Return a SymPy number: the rational that a short decimal stands for, else a float of 17 digits."""
    sympy = module()
    text = repr(float(value))
    if len(Decimal(text).normalize().as_tuple().digits) <= DIGITS:
        return sympy.Rational(text)
    return sympy.Float(float(value), 17)


def operations() -> dict[str, Callable[..., Any]]:
    sympy = module()
    return {
        ADD: sympy.Add,
        MUL: sympy.Mul,
        SUB: lambda a, b: a - b,
        DIV: lambda a, b: a / b,
        NEG: lambda a: -a,
        SQRT: sympy.sqrt,
        SIN: sympy.sin,
        COS: sympy.cos,
        SIGN: sympy.sign,
        EXP: sympy.exp,
    }


def module() -> Any:
    """SymPy; an InputError where it is not installed."""
    try:
        import sympy
    except ImportError:
        need("closed forms", "sympy")
        raise
    return sympy
