"""Letters for the numbers of a description: masses, lengths, mass centres, inertias and gravity, named by link.

Numbers that are 0 stay 0, and equal numbers of equal meaning share a letter: moments of inertia of one link, and all
numbers of links that the same link carries in the same way, as the two arrays of a satellite.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from robodyn.dynamics.effects.effect import Effect, Sample
from robodyn.dynamics.plan import Plan, applied, at_rest, loads
from robodyn.equations.closed import PRODUCTS, Angle, Forms, Polynomial, TooLargeError, combined_angles, module, number, upright
from robodyn.equations.ode import bias_plan
from robodyn.errors import InputError
from robodyn.programs.derivative import jacobian
from robodyn.programs.program import Program, trace
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import ZERO, Array, Scalar, skew
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.solids.inertia.laws import Inertia
from robodyn.support.wording import alternatives

KINDS = ("m", "l", "c", "I", "g")
"""Masses; offsets of joints; mass centres; inertia matrices about them, in the axes of the link; gravity."""
MEANINGS = {
    "m": "mass of {} [kg]",
    "l": "from the joint of {} to the next, along {} [m]",
    "c": "mass centre of {}, {} [m]",
    "I": "inertia of {} about its mass centre, {} [kg m^2]",
    "g": "gravity [m/s^2]",
}
FACTORED = 10
"""Terms of a sum that is factored, if it can be."""
ROUNDING = 1e-12
"""Numbers are equal, or zero, within this part of the largest of their vector or matrix."""
SOURCE = "letters"
AXES = "xyz"


@dataclass(frozen=True)
class Letter:
    """A letter: `name` as in I_1xx, its value in SI units, what it stands for."""

    name: str
    kind: str
    value: float
    meaning: str


class Letters:
    """The letters of a model: in their order, and the place of each in its bodies.

    Attributes:
        all: the letters.
    """

    def __init__(self, model: Model, scene: Scene, kinds: Sequence[str] = KINDS) -> None:
        """Raises InputError for a kind that is none of KINDS."""
        for kind in kinds:
            if kind not in KINDS:
                raise InputError(f"no symbols {kind!r}", remedy=alternatives(kind, KINDS, "symbols"))
        self._kinds, self._model = kinds, model
        self.all: list[Letter] = []
        self._of: dict[tuple[Any, ...], list[int]] = {}
        self._masses = [self._body(i) for i in range(len(model.bodies))]
        self._offsets = [self._offset(i) for i in range(len(model.bodies))]
        self._gravity = self._vector("g", "g", scene.gravity, ("gravity",), "")

    @property
    def values(self) -> list[float]:
        return [letter.value for letter in self.all]

    def model(self, model: Model, tape: Tape) -> Model:
        """Return the same model with inputs of the tape for its letters; its arrays are of objects."""
        bodies = []
        for i, (body, p) in enumerate(zip(model.bodies, self._offsets, strict=True)):
            mass, centre, about = self.mass_properties(i, tape)
            moment = centre * mass
            S = skew(centre)
            inertia = Inertia(mass, moment, about - (S @ S) * mass)
            joint = replace(body.joint, p=self._array(p, tape), R=snapped(body.joint.R), axis=snapped(body.joint.axis))
            bodies.append(replace(body, inertia=inertia, joint=joint))
        return replace(model, bodies=tuple(bodies))

    def masses(self, tape: Tape) -> list[tuple[Scalar, Array, Array]]:
        """Return of each body mass, mass centre, and inertia matrix about it, in the body's axes."""
        return [self.mass_properties(i, tape) for i in range(len(self._masses))]

    def mass_properties(self, i: int, tape: Tape) -> tuple[Scalar, Array, Array]:
        """Return mass, mass centre and inertia matrix about it of body i."""
        m, c, I = self._masses[i]
        return self._scalar(m, tape), self._array(c, tape), self._array(I, tape).reshape(3, 3)

    def gravity(self, tape: Tape) -> Array:
        return self._array(self._gravity, tape)

    def _body(self, i: int) -> tuple[Any, list[Any], list[Any]]:
        body = self._model.bodies[i]
        m, c, I = float(body.inertia.m), body.inertia.centre_of_mass, np.asarray(body.inertia.about_centre, dtype=float)
        twin = (body.parent,) if body.parent >= 0 else ()
        scale = float(np.abs(body.inertia.I).max())
        entries: list[Any] = [0.0] * 9
        for a in range(3):
            for b in range(a, 3):
                kind = "moment" if a == b else AXES[a] + AXES[b]
                entry = self._entry(
                    "I",
                    f"I_{i}{AXES[a]}{AXES[b]}",
                    float(I[a, b]),
                    scale,
                    ("I", kind, *twin),
                    (body.name, AXES[a] + AXES[b]),
                )
                entries[3 * a + b] = entries[3 * b + a] = entry
        mass = self._entry("m", f"m_{i}", m, m, ("m", *twin), (body.name,))
        return mass, self._vector("c", f"c_{i}", c, ("c", *twin), body.name), entries

    def _offset(self, i: int) -> list[Any]:
        body = self._model.bodies[i]
        j = body.parent
        if j < 0:
            return list(map(float, body.joint.p))
        siblings = [k for k, other in enumerate(self._model.bodies) if other.parent == j]
        name = f"l_{j}" if len(siblings) == 1 or i == siblings[0] else f"l_{j},{i}"
        return self._vector("l", name, body.joint.p, ("l", j), self._model.bodies[j].name, short=True)

    def _vector(
        self, kind: str, name: str, values: Any, alike: tuple[Any, ...], of: str, short: bool = False
    ) -> list[Any]:
        scale = max(abs(float(x)) for x in values)
        some = [k for k in range(3) if abs(values[k]) > ROUNDING * scale]
        out: list[Any] = [0.0] * 3
        for k in some:
            suffix = "" if len(some) == 1 and (short or kind == "g") else AXES[k]
            out[k] = self._entry(kind, name + suffix, float(values[k]), scale, (*alike, k), (of, AXES[k]))
        return out

    def _entry(
        self, kind: str, name: str, value: float, scale: float, alike: tuple[Any, ...], words: tuple[str, ...]
    ) -> Any:
        """Return a number, or (sign, index of a letter) where it has one."""
        if abs(value) <= ROUNDING * scale:
            return 0.0
        if kind not in self._kinds:
            return value
        signed = kind != "I" or alike[1] != "moment"
        for index in self._of.get(alike, ()):
            other = self.all[index].value
            if abs(value - other) <= ROUNDING * scale:
                return (1.0, index)
            if signed and abs(value + other) <= ROUNDING * scale:
                return (-1.0, index)
        sign = -1.0 if kind in "gl" and value < 0.0 else 1.0
        self.all.append(Letter(name, kind, sign * value, MEANINGS[kind].format(*words)))
        self._of.setdefault(alike, []).append(len(self.all) - 1)
        return (sign, len(self.all) - 1)

    def _scalar(self, entry: Any, tape: Tape) -> Scalar:
        return entry[0] * tape.input(SOURCE, entry[1]) if isinstance(entry, tuple) else entry

    def _array(self, entries: Sequence[Any], tape: Tape) -> Array:
        out = np.empty(len(entries), dtype=object)
        out[:] = [self._scalar(entry, tape) for entry in entries]
        return out


def snapped(values: Any) -> Array:
    """Return entries that rounding alone tells from 0, 1 or -1 as these."""
    nearest = np.round(np.asarray(values, dtype=float))
    close = np.abs(values - nearest) <= ROUNDING
    return np.where(close, nearest + 0.0, values).astype(object)


class Lettered:
    """A robot in a scene with letters for its numbers: what the recursions make of it, as SymPy expressions that a
    person would write.

    Joint i carries body i, so that its coordinate is q_i; the rates of a base that moves are w_x .. v_z in its own
    axes, and gravity is then a vector g_x, g_y, g_z in these.

    Attributes:
        letters: in the order m, l, c, I, g.
        symbols: by (source, column) of the sources q, qd, qdd and letters.
    """

    def __init__(
        self, model: Model, scene: Scene = DEFAULT, kinds: Sequence[str] = KINDS, positive: Iterable[str] = ()
    ) -> None:
        """Args: kinds: of the letters; none leaves all numbers. positive: names of symbols that SymPy may take to be.

        Raises: InputError for a kind that is none of KINDS, or a positive name that is none of a symbol.
        """
        self.plan, self._letters = bias_plan(model, scene), Letters(model, scene, kinds)
        self.letters, names = tuple(self._letters.all), {}
        first = 6 if model.floating else 0
        for i, axis in enumerate(("x", "y", "z") * 2 if first else ""):
            letter = "w" if i < 3 else "v"
            names["qd", i], names["qdd", i] = f"{letter}_{axis}", f"{'wd' if i < 3 else 'a'}_{axis}"
        for k, body in enumerate(model.bodies):
            joint = body.joint
            if joint.kind in ("revolute", "prismatic") and joint.mimics is None:
                names["q", joint.coordinate] = f"q_{k}"
                names["qd", joint.rate], names["qdd", joint.rate] = f"qd_{k}", f"qdd_{k}"
        names |= {(SOURCE, k): letter.name for k, letter in enumerate(self.letters)}
        given = set(positive)
        if unknown := sorted(given - set(names.values())):
            raise InputError(f"no symbol {unknown[0]}", remedy=alternatives(unknown[0], [*names.values()], "symbols"))
        self.symbols = {
            place: module().Symbol(name, real=True, positive=name in given or None) for place, name in names.items()
        }

    def sample(self, tape: Tape) -> Sample:
        """The sample whose scalars are inputs of the tape, letters among them; a base that moves stands upright."""
        sample = self.plan.sample(tape)
        if sample.model.floating:
            sample = replace(sample, q=(*[0.0] * 6, 1.0, *sample.q[7:]))
        accelerations = tuple(tape.input("qdd", i) for i in range(sample.model.n))
        return replace(sample, model=self._letters.model(sample.model, tape), qdd=accelerations)

    def gravity(self, tape: Tape) -> Array:
        return self._letters.gravity(tape)

    def masses(self, tape: Tape) -> list[tuple[Scalar, Array, Array]]:
        return self._letters.masses(tape)

    def mass_properties(self, i: int, tape: Tape) -> tuple[Scalar, Array, Array]:
        return self._letters.mass_properties(i, tape)

    def program(self, outputs: Callable[[Tape, Sample], Iterable[Scalar]]) -> Program:
        """Return the program of scalars that are made of a sample."""
        return trace(lambda tape: outputs(tape, self.sample(tape)))

    def written(self, program: Program, allowed: int = PRODUCTS, longest: int | None = None) -> list[Any]:
        """Return the outputs of a program as SymPy expressions, each by itself.

        Raises: TooLargeError where more products of terms would be formed than are allowed, or an output has more terms
            than `longest`.
        """
        forms = Forms(self.symbols, allowed)
        found = forms.outputs(program)
        if longest is not None and max(map(len, found), default=0) > longest:
            raise TooLargeError
        writer = Writer(forms, self)
        return [writer.expression(form) for form in found]

    def mass(self) -> Program:
        """M, row by row: the derivative of the torques by the accelerations."""

        def outputs(tape: Tape, sample: Sample) -> Iterable[Scalar]:
            moving = replace(sample, qd=(0.0,) * sample.model.n)
            effects = Plan(self.plan.model, self.plan.scene).effects
            terms = replace(applied(effects, moving, self.plan.scene), gravity=ZERO)
            rows = jacobian(loads(moving, terms).tau, [{rate: 1.0} for rate in sample.qdd])
            return [x for row in rows for x in row]

        return self.program(outputs)

    def share(self, effect: Effect) -> Program:
        """The part of the bias that one effect makes."""

        def outputs(tape: Tape, sample: Sample) -> Iterable[Scalar]:
            still = replace(sample, qdd=(0.0,) * sample.model.n)
            terms = effect.add(effect.background(at_rest(still), still, self.plan.scene), still, self.plan.scene)
            if terms.gravity.any():
                terms = replace(terms, gravity=self.gravity(tape))
            return loads(still, terms).tau

        return self.program(outputs)


Wave = tuple[str, Angle]
"""A sine or cosine of an angle, in multiples of the generators."""
UNIT: Wave = ("cos", ())
Monomial = tuple[int, ...]
"""Generators, each as often as its power."""
Shape = tuple[Monomial, tuple[Wave, ...]]
"""What an entry's coefficients are multiplied by: powers of coordinates, and sines and cosines."""
Coefficients = dict[Monomial, float]
"""A polynomial in letters."""


class Writer:
    """Writes polynomials of `closed` as a person would: for each product of rates and each product of sines and cosines
    one coefficient, collected by masses."""

    def __init__(self, forms: Forms, lettered: Lettered) -> None:
        self._symbols: list[Any] = forms.generators
        places = {symbol: source for (source, _), symbol in lettered.symbols.items()}
        self._sources = [places.get(symbol, "") for symbol in self._symbols]

    def grouped(self, form: Polynomial) -> dict[Monomial, dict[Shape, Coefficients]]:
        """Return the coefficients of a form by rates, then by shape."""
        waves: dict[tuple[Monomial, ...], dict[Wave, float]] = defaultdict(dict)
        for key, coefficient in form.items():
            rates, letters, others = (self._part(key.powers, kind) for kind in ("rates", "letters", ""))
            waves[rates, others, letters][key.wave, key.angle] = coefficient.value
        out: dict[Monomial, dict[Shape, Coefficients]] = defaultdict(lambda: defaultdict(lambda: defaultdict(float)))
        for (rates, others, letters), sum_of in waves.items():
            for product, value in products(sum_of).items():
                out[rates][others, product][letters] += value
        return out

    def _part(self, powers: Monomial, kind: str) -> Monomial:
        kinds = {"qd": "rates", "qdd": "rates", SOURCE: "letters"}
        return tuple(k for k in powers if kinds.get(self._sources[k], "") == kind)

    def monomial(self, powers: Iterable[int]) -> Any:
        return module().Mul(*(self._symbols[k] for k in powers))

    def shape(self, shape: Shape) -> Any:
        sympy, (powers, waves) = module(), shape
        out = self.monomial(powers)
        for name, angle in waves:
            out *= getattr(sympy, name)(sympy.Add(*(number(x) * self._symbols[k] for k, x in enumerate(angle))))
        return out

    def coefficient(self, polynomial: Coefficients) -> tuple[Any, Any]:
        """Return a polynomial in letters as a factor and a sum whose first term is positive, collected by masses."""
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
            mass = next((k for k in powers if self._symbols[k].name.startswith("m_")), None)
            left = list(powers)
            if mass is not None:
                left.remove(mass)
            masses[mass].append(number(x / scale) * self.monomial(left))
        terms = []
        for mass, parts in masses.items():
            whole = sympy.Add(*parts)
            if mass is not None and len(parts) <= FACTORED:
                whole = sympy.factor(whole)
            terms.append(whole if mass is None else self._symbols[mass] * whole)
        return number(scale) * self.monomial(common.elements()), sympy.Add(*terms)

    def expression(self, form: Polynomial, names: Mapping[Any, Any] = MappingProxyType({})) -> Any:
        """Return the SymPy expression of a form; `names` are symbols for sums that are written once, elsewhere."""
        sympy = module()
        groups = []
        for rates, shapes in self.grouped(form).items():
            terms = []
            for shape, polynomial in shapes.items():
                factor, whole = self.coefficient(polynomial)
                terms.append(factor * names.get(whole, whole) * self.shape(shape))
            groups.append(gathered(self.monomial(rates), terms))
        return sympy.Add(*groups)


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


def products(waves: Mapping[Wave, float]) -> dict[tuple[Wave, ...], float]:
    """Return a sum of sines and cosines as products where these are shorter: a constant and cos 2a as squares, then
    pairs of equal coefficients, cos(a + b) + cos(a - b) as 2 cos a cos b and the like, of sums of coordinates a, b."""
    left, out = dict(waves), dict[tuple[Wave, ...], float]()

    def take(value: float, *factors: Wave) -> None:
        found = tuple(sorted(factor for factor in factors if factor[1]))
        out[found] = out.get(found, 0.0) + value

    constant = left.pop(UNIT, 0.0)
    for (kind, angle), value in list(left.items()):
        half = tuple(x / 2 for x in angle)
        if kind == "cos" and abs(value) <= abs(constant) and all(x.is_integer() for x in half):
            del left[kind, angle]
            square = "cos" if value * constant > 0.0 else "sin"
            take(math.copysign(2.0 * value, constant), (square, half), (square, half))
            constant -= math.copysign(value, constant)
    if constant:
        take(constant)
    while left:
        (kind, angle), value = (first := next(iter(left))), left.pop(first)
        pairs = []
        for other, x in left.items():
            if other[0] == kind and abs(x) == abs(value):
                halves = [[y / 2 for y in combined_angles(angle, other[1], sign)] for sign in (1.0, -1.0)]
                if all(y.is_integer() for half in halves for y in half):
                    pairs.append((sum(abs(y) for half in halves for y in half), other, halves))
        pairs = [pair for pair in pairs if pair[0] < sum(map(abs, (*angle, *pair[1][1])))]
        if not pairs:
            take(value, (kind, angle))
            continue
        _, other, (a, b) = min(pairs)
        same = left.pop(other) == value
        if kind == "cos":
            names, value = (("cos", "cos"), 2.0 * value) if same else (("sin", "sin"), -2.0 * value)
        else:
            names, value = (("sin", "cos") if same else ("cos", "sin")), 2.0 * value
        factors = []
        for name, half in zip(names, (a, b), strict=True):
            turned, sign = upright(name, tuple(half))
            factors.append((name, turned))
            value *= sign
        take(value, *factors)
    return out
