"""Programs as trigonometric polynomials: every output a sum of sines and cosines of sums of angles, which is unique;
and that sum as a person writes it."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from decimal import Decimal
from typing import Any, NamedTuple

from robodyn.programs.program import Program
from robodyn.programs.scalar import ADD, CONSTANT, COS, DIV, EXP, INPUT, MUL, NEG, SIGN, SIN, SQRT
from robodyn.support.extras import need

Symbols = Mapping[tuple[str, int], Any]
"""By (source, column): of the sources q, qd, qdd and letters."""
LETTERS = "letters"
ROUNDING = 4 * 2.0**-52
"""A coefficient that is a smaller share of what added up to it is zero."""

Angle = tuple[float, ...]
"""Multiples of the generators; the first that is not zero is positive."""
DIGITS = 10
"""Decimals of up to so many digits are written as fractions."""
FACTORED = 10
"""Terms of a sum that is factored, if it can be."""
ALIKE = 1e-13
"""Coefficients that differ by a smaller share differ by rounding alone."""
PRODUCTS = 500_000
"""Of terms, for M and for each effect: some seconds at most."""


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
    return tuple(round(x + sign * y, 14) for x, y in padded)


def upright(kind: str, angle: Angle) -> tuple[Angle, float]:
    """Return the angle with its first multiple positive and without zeros at its end, and the sign of the wave."""
    width = max((k + 1 for k, x in enumerate(angle) if x), default=0)
    angle = angle[:width]
    if next((x for x in angle if x), 0.0) < 0.0:
        return tuple(-x for x in angle), -1.0 if kind == "sin" else 1.0
    return angle, 1.0


def _pruned(terms: Polynomial) -> Polynomial:
    return {key: entry for key, entry in terms.items() if abs(entry.value) > ROUNDING * entry.size}


Wave = tuple[str, Angle]
"""A sine or cosine of an angle, in multiples of the generators."""
UNIT: Wave = ("cos", ())
Monomial = tuple[int, ...]
"""Generators, each as often as its power."""
Shape = tuple[Monomial, tuple[Wave, ...]]
"""What an entry's coefficients are multiplied by: powers of coordinates, and sines and cosines."""
Coefficients = dict[Monomial, float]
"""A polynomial in letters."""


Sums = dict[Monomial, dict[Shape, tuple[Any, Any, Any]]]
"""By product of rates and by shape, a number, a product of letters and a sum of letters."""


class Forms:
    """Programs in the arithmetic of trigonometric polynomials, and these as a person would write them: for each product
    of rates and each product of sines and cosines one coefficient, collected by masses. What is no such polynomial (the
    sign of a speed, a root) becomes a generator of its own, with its argument written out.

    Attributes:
        generators: the symbols, then what became a generator on the way.
    """

    def __init__(self, symbols: Symbols, products: int) -> None:
        """Args: products: of terms that may be formed."""
        self._symbols, self._left = symbols, products
        sources: dict[Any, str] = {}
        for (source, _), symbol in symbols.items():
            sources.setdefault(symbol, source)
        self._sources, self.generators = list(sources.values()), list(sources)
        self._places = {symbol: k for k, symbol in enumerate(self.generators)}

    def outputs(self, program: Program) -> list[Polynomial]:
        """Raises TooLargeError where more products of terms would be formed than are allowed."""
        values: list[Polynomial] = []
        for op, a, b in program.operations:
            if op is INPUT:
                values.append(self._generator(self._symbols[a, b]))
            elif op is CONSTANT:
                values.append(constant(a))
            else:
                values.append(self._operation(op, *(values[k] for k in (a, b) if k is not None)))
        return [values[k] for k in program.outputs]

    def part(self, powers: Monomial, *sources: str) -> Monomial:
        """Return the generators of a product that are symbols of these sources; of none, all but rates and letters."""
        of, apart = self._sources, ("qd", "qdd", LETTERS)
        return tuple(k for k in powers if (of[k] if k < len(of) and of[k] in apart else "") in (sources or ("",)))

    def _operation(self, op: str, a: Polynomial, b: Polynomial | None = None) -> Polynomial:
        if b is None:
            if op is NEG:
                return total({}, a, -1.0)
            return self._turned(op, a) if op in (SIN, COS) else self._opaque(functions()[op](self.expression(a)))
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
            return self._opaque(functions()[op](self.expression(a)))
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
        if expression not in self._places:
            self._places[expression] = len(self.generators)
            self.generators.append(expression)
        return {Key((self._places[expression],), "cos", ()): Coefficient(1.0, 1.0)}

    def sums(self, form: Polynomial) -> Sums:
        waves: dict[tuple[Monomial, ...], dict[Wave, float]] = defaultdict(dict)
        for key, coefficient in form.items():
            rates, letters, others = (self.part(key.powers, *x) for x in (("qd", "qdd"), (LETTERS,), ()))
            waves[rates, others, letters][key.wave, key.angle] = coefficient.value
        found: dict[Monomial, dict[Shape, Coefficients]] = defaultdict(lambda: defaultdict(lambda: defaultdict(float)))
        for (rates, others, letters), sum_of in waves.items():
            for product, value in products(sum_of).items():
                found[rates][others, product][letters] += value
        return {
            rates: {shape: self.coefficient(polynomial) for shape, polynomial in shapes.items()}
            for rates, shapes in found.items()
        }

    def monomial(self, powers: Iterable[int]) -> Any:
        return module().Mul(*(self.generators[k] for k in powers))

    def shape(self, shape: Shape) -> Any:
        sympy, (powers, waves) = module(), shape
        out = self.monomial(powers)
        for name, angle in waves:
            out *= getattr(sympy, name)(sympy.Add(*(number(x) * self.generators[k] for k, x in enumerate(angle))))
        return out

    def coefficient(self, polynomial: Coefficients) -> tuple[Any, Any, Any]:
        """Return a polynomial in letters as a number, a product, and a sum that begins with a positive term and is
        collected by masses."""
        sympy = module()
        common = Counter(next(iter(polynomial)))
        for powers in polynomial:
            common &= Counter(powers)
        scale = min(map(abs, polynomial.values()))
        if not all(float(x / scale).is_integer() for x in polynomial.values()):
            scale = 1.0
        rest = sorted((tuple(sorted((Counter(powers) - common).elements())), x) for powers, x in polynomial.items())
        scale = -scale if rest[0][1] < 0.0 else scale
        masses: dict[int | None, list[Any]] = defaultdict(list)
        for powers, x in rest:
            mass = next((k for k in powers if self.generators[k].name.startswith("m_")), None)
            left = list(powers)
            if mass is not None:
                left.remove(mass)
            masses[mass].append(number(x / scale) * self.monomial(left))
        terms = []
        for mass, parts in masses.items():
            whole = sympy.Add(*parts)
            if len(parts) <= FACTORED and not whole.has(sympy.Float):
                whole = sympy.factor(whole)
            terms.append(whole if mass is None else self.generators[mass] * whole)
        return number(scale), self.monomial(common.elements()), sympy.Add(*terms)

    def assembled(self, sums: Sums, names: Mapping[Any, Any]) -> Any:
        """Return the SymPy expression, with what the terms of a product of rates have in common before them; `names`
        are symbols for sums and products that are written once, elsewhere."""
        sympy = module()
        groups = []
        for rates, shapes in sums.items():
            terms = [
                sympy.Mul(x, named(product, whole, names), self.shape(shape))
                for shape, (x, product, whole) in shapes.items()
            ]
            groups.append(gathered(self.monomial(rates), terms))
        return sympy.Add(*groups)

    def expression(self, form: Polynomial) -> Any:
        """Return the SymPy expression of a form by itself."""
        return self.assembled(self.sums(form), {})


def gathered(rates: Any, terms: Sequence[Any]) -> Any:
    """Return rates times the sum of terms, with the factors that all have, and a minus that all have, before it."""
    sympy, powers = module(), [term.as_coeff_Mul()[1].as_powers_dict() for term in terms]
    common = sympy.Mul(*(
        x ** min(each[x] for each in powers)
        for x in powers[0]
        if (x.is_Symbol or x.is_Add) and len(powers) > 1 and all(x in each for each in powers)
    ))  # fmt: skip
    parts = [part for term in terms for part in sympy.Add.make_args(term)]
    sign = -1 if all(part.as_coeff_Mul()[0] < 0 for part in parts) else 1
    return sympy.Mul(rates, sign, common, sympy.Add(*(term / (sign * common) for term in terms)))


def named(product: Any, whole: Any, names: Mapping[Any, Any]) -> Any:
    """Return a product of letters times a sum, with symbols for both or for the sum where they have names."""
    return names.get(product * whole) or product * names.get(whole, whole)


def products(waves: Mapping[Wave, float]) -> dict[tuple[Wave, ...], float]:
    """Return a sum of sines and cosines as products where these are shorter: pairs of the waves, then, as long as terms
    become fewer, pairs of what remains of terms that have all else in common."""
    out, fewer = _pairs(waves), True
    while fewer:
        groups: dict[tuple[Wave, ...], dict[Wave, tuple[Wave, ...]]] = defaultdict(dict)
        for product in out:
            for k, other in enumerate(product):
                groups[product[:k] + product[k + 1 :]][other] = product
        for common, group in groups.items():
            fewer = False
            if common:
                if common in out:
                    group[UNIT] = common
                shorter = _pairs({other: out[product] for other, product in group.items()})
                fewer = len(shorter) < len(group)
            if fewer:
                for product in group.values():
                    del out[product]
                for product, value in shorter.items():
                    whole = tuple(sorted(common + product))
                    out[whole] = out.get(whole, 0.0) + value
                break
        else:
            fewer = False
    return out


def _pairs(waves: Mapping[Wave, float]) -> dict[tuple[Wave, ...], float]:
    """Return a sum of sines and cosines as products where these are shorter: a constant and cos 2a as squares, then
    pairs of equal coefficients, cos(a + b) + cos(a - b) as 2 cos a cos b and the like, of sums of coordinates a, b."""
    left, out = dict(waves), dict[tuple[Wave, ...], float]()

    def take(value: float, *factors: Wave) -> None:
        found = tuple(sorted(factor for factor in factors if factor[1]))
        out[found] = out.get(found, 0.0) + value

    constant = left.pop(UNIT, 0.0)
    for (kind, angle), value in list(left.items()):
        half = tuple(x / 2 for x in angle)
        if kind == "cos" and abs(value) <= (1.0 + ALIKE) * abs(constant) and all(x.is_integer() for x in half):
            del left[kind, angle]
            square = "cos" if value * constant > 0.0 else "sin"
            take(math.copysign(2.0 * value, constant), (square, half), (square, half))
            rest = constant - math.copysign(value, constant)
            constant = rest if abs(rest) > ALIKE * abs(constant) else 0.0
    if constant:
        take(constant)
    while left:
        (kind, angle), value = (first := next(iter(left))), left.pop(first)
        pairs = []
        for other, x in left.items():
            if other[0] == kind and math.isclose(abs(x), abs(value), rel_tol=ALIKE):
                halves = [[y / 2 for y in combined_angles(angle, other[1], sign)] for sign in (1.0, -1.0)]
                if all(y.is_integer() for half in halves for y in half):
                    pairs.append((sum(abs(y) for half in halves for y in half), other, halves))
        pairs = [pair for pair in pairs if pair[0] < sum(map(abs, (*angle, *pair[1][1])))]
        if not pairs:
            take(value, (kind, angle))
            continue
        _, other, (a, b) = min(pairs)
        same = left.pop(other) * value > 0.0
        if kind == "cos":
            names, value = (("cos", "cos"), 2.0 * value) if same else (("sin", "sin"), -2.0 * value)
        else:
            names, value = (("sin", "cos") if same else ("cos", "sin")), 2.0 * value
        factors = []
        for name, half in zip(names, (tuple(a), tuple(b)), strict=True):
            turned, sign = upright(name, half)
            factors.append((name, turned))
            value *= sign
        take(value, *factors)
    return out


def number(value: float) -> Any:
    """Return a SymPy number: the rational that a short decimal stands for, else a float of 17 digits."""
    sympy = module()
    text = repr(float(value))
    if len(Decimal(text).normalize().as_tuple().digits) <= DIGITS:
        return sympy.Rational(text)
    return sympy.Float(float(value), 17)


def functions() -> dict[str, Callable[[Any], Any]]:
    sympy = module()
    return {SQRT: sympy.sqrt, SIN: sympy.sin, COS: sympy.cos, SIGN: sympy.sign, EXP: sympy.exp}


def module() -> Any:
    """SymPy; an InputError where it is not installed."""
    try:
        import sympy
    except ImportError:
        need("closed forms", "sympy")
        raise
    return sympy
