"""Letters for the numbers of a description: masses, lengths, mass centres, inertias and gravity, named by link.

Numbers that are 0 stay 0, and equal numbers of equal meaning share a letter: moments of inertia of one link, and all
numbers of links that the same link carries in the same way, as the two arrays of a satellite.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from robodyn.dynamics.effects.effect import Effect, Sample
from robodyn.dynamics.plan import Plan, applied, at_rest, loads
from robodyn.equations.forms import LETTERS as SOURCE
from robodyn.equations.forms import PRODUCTS, Forms, TooLargeError, module
from robodyn.equations.ode import bias_plan
from robodyn.errors import InputError
from robodyn.programs.derivative import jacobian
from robodyn.programs.program import Program, trace
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import ZERO, Array, Scalar, skew
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.solids.inertia.laws import Inertia
from robodyn.support.wording import alternatives, shown

KINDS = ("m", "l", "c", "I", "g")
"""Masses; offsets of joints; mass centres; inertia matrices about them, in the axes of the link; gravity."""
MEANINGS = {
    "m": "mass of {} [kg]",
    "l": "from the joint of {} to the next, along {} [m]",
    "c": "mass centre of {}, {} [m]",
    "I": "inertia of {} about its mass centre, {} [kg m^2]",
    "g": "gravity [m/s^2]",
}
ROUNDING = 1e-12
"""Numbers are equal, or zero, within this part of the largest of their vector or matrix."""
AXES = "xyz"


@dataclass(frozen=True)
class Letter:
    """A letter: `name` as in I_1xx, its value in SI units, what it stands for."""

    name: str
    kind: str
    value: float
    meaning: str


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
        """Args: kinds: of the letters; none leaves all numbers but the gravity on a base that moves. positive: names of
        letters that SymPy may take to be.

        Raises: InputError for a kind that is none of KINDS, or a positive name of no letter or of one that is not.
        """
        for kind in kinds:
            if kind not in KINDS:
                raise InputError(f"no symbols {shown(kind)}", remedy=alternatives(kind, KINDS, "symbols"))
        self.plan, self._kinds, bodies = bias_plan(model, scene), kinds, list(enumerate(model.bodies))
        self.letters: list[Letter] = []
        self._of: dict[tuple[Any, ...], list[int]] = {}
        masses = [float(body.inertia.m) for _, body in bodies]
        self._masses = [
            self._entry("m", i, f"m_{i}", m, m, body.name) for (i, body), m in zip(bodies, masses, strict=True)
        ]
        self._offsets = [self._offset(i) for i, _ in bodies]
        self._centres = [self._vector("c", i, f"c_{i}", body.inertia.centre_of_mass, body.name) for i, body in bodies]
        self._about = [self._inertia(i) for i, _ in bodies]
        self._gravity = self._of_gravity(scene)
        names = {}
        for i, axis in enumerate(AXES * 2 if model.floating else ""):
            letter = "w" if i < 3 else "v"
            names["qd", i], names["qdd", i] = f"{letter}_{axis}", f"{'wd' if i < 3 else 'a'}_{axis}"
        for k, body in enumerate(model.bodies):
            joint = body.joint
            if joint.kind in ("revolute", "prismatic") and joint.mimics is None:
                names["q", joint.coordinate] = f"q_{k}"
                names["qd", joint.rate], names["qdd", joint.rate] = f"qd_{k}", f"qdd_{k}"
        names |= {(SOURCE, k): letter.name for k, letter in enumerate(self.letters)}
        given, values = set(positive), {letter.name: letter.value for letter in self.letters}
        for name in sorted(given):
            if name not in values:
                raise InputError(f"no symbol {shown(name)}", remedy=alternatives(name, list(values), "symbols"))
            if values[name] <= 0.0:
                raise InputError(f"{name} is {values[name]:g}, not positive", remedy="leave the assumption out")
        self.symbols = {
            place: module().Symbol(name, real=True, positive=name in given or None) for place, name in names.items()
        }

    def sample(self, tape: Tape) -> Sample:
        """The sample whose scalars are inputs of the tape, letters among them; a base that moves stands upright."""
        sample = self.plan.sample(tape)
        if sample.model.floating:
            sample = replace(sample, q=(*[0.0] * 6, 1.0, *sample.q[7:]))
        accelerations = tuple(tape.input("qdd", i) for i in range(sample.model.n))
        return replace(sample, model=self._model(sample.model, tape), qdd=accelerations)

    def program(self, outputs: Callable[[Tape, Sample], Iterable[Scalar]]) -> Program:
        """Return the program of scalars that are made of a sample."""
        return trace(lambda tape: outputs(tape, self.sample(tape)))

    def written(self, program: Program, longest: float = math.inf, products: int = PRODUCTS) -> list[Any]:
        """Return the outputs of a program as SymPy expressions, each by itself.

        Raises: TooLargeError where more `products` of terms would be formed, or an output is of more than `longest`.
        """
        forms = Forms(self.symbols, products)
        found = forms.outputs(program)
        if max(map(len, found), default=0) > longest:
            raise TooLargeError
        return [forms.expression(form) for form in found]

    def mass(self) -> Program:
        """M, the derivative of the torques by the accelerations: of each row what is not left of the diagonal."""

        def outputs(tape: Tape, sample: Sample) -> Iterable[Scalar]:
            moving = replace(sample, qd=(0.0,) * sample.model.n)
            effects = [effect for effect in Plan(self.plan.model, self.plan.scene).effects if not effect.by_load]
            terms = replace(applied(effects, moving, self.plan.scene), gravity=ZERO)
            rows = jacobian(loads(moving, terms).tau, [{rate: 1.0} for rate in sample.qdd])
            return [x for i, row in enumerate(rows) for x in row[i:]]

        return self.program(outputs)

    def share(self, effect: Effect) -> Program:
        """The part of the bias that one effect makes."""

        def outputs(tape: Tape, sample: Sample) -> Iterable[Scalar]:
            still = replace(sample, qdd=(0.0,) * sample.model.n)
            scene = replace(self.plan.scene, gravity=tuple(self.gravity(tape)))
            if effect.by_load:
                others = [other for other in self.plan.effects if other is not effect]
                whole, rest = (loads(still, applied(each, still, scene)).tau for each in (self.plan.effects, others))
                return [a - b for a, b in zip(whole, rest, strict=True)]
            return loads(still, effect.add(effect.background(at_rest(still), still, scene), still, scene)).tau

        return self.program(outputs)

    def _model(self, model: Model, tape: Tape) -> Model:
        """Return the same model with inputs of the tape for its letters; its arrays are of objects."""
        bodies = []
        for i, body in enumerate(model.bodies):
            (mass, centre, about), p = self.mass_properties(i, tape), self._array(self._offsets[i], tape)
            moment = centre * mass
            S = skew(centre)
            inertia = Inertia(mass, moment, about - (S @ S) * mass)
            joint = replace(body.joint, p=p, R=snapped(body.joint.R), axis=snapped(body.joint.axis))
            bodies.append(replace(body, inertia=inertia, joint=joint))
        return replace(model, bodies=tuple(bodies))

    def mass_properties(self, i: int, tape: Tape) -> tuple[Scalar, Array, Array]:
        """Return mass, mass centre and inertia matrix about it of body i, in its axes."""
        centre, about = (self._array(x[i], tape) for x in (self._centres, self._about))
        return self._scalar(self._masses[i], tape), centre, about.reshape(3, 3)

    def gravity(self, tape: Tape) -> Array:
        return self._array(self._gravity, tape)

    def _inertia(self, i: int) -> list[Any]:
        body = self.plan.model.bodies[i]
        I, scale = np.asarray(body.inertia.about_centre, dtype=float), float(np.abs(body.inertia.I).max())
        entries: list[Any] = [0.0] * 9
        for a in range(3):
            for b in range(a, 3):
                axes = AXES[a] + AXES[b]
                entry = self._entry("I", i, f"I_{i}{axes}", float(I[a, b]), scale, body.name, axes)
                entries[3 * a + b] = entries[3 * b + a] = entry
        return entries

    def _of_gravity(self, scene: Scene) -> list[Any]:
        """Return one letter along an axis; all three where the base turns, in its axes."""
        if not (self.plan.model.floating and any(scene.gravity)):
            return self._vector("g", 0, "g", scene.gravity, "")
        for axis, value in zip(AXES, scene.gravity, strict=True):
            self.letters.append(Letter(f"g_{axis}", "g", float(value), MEANINGS["g"]))
        return [(1.0, len(self.letters) - 3 + k) for k in range(3)]

    def _offset(self, i: int) -> list[Any]:
        body = self.plan.model.bodies[i]
        j = body.parent
        if j < 0:
            return list(map(float, body.joint.p))
        siblings = [k for k, other in enumerate(self.plan.model.bodies) if other.parent == j]
        name = f"l_{j}" if len(siblings) == 1 or i == siblings[0] else f"l_{j}_{i}"
        return self._vector("l", i, name, body.joint.p, self.plan.model.bodies[j].name)

    def _vector(self, kind: str, i: int, name: str, values: Any, of: str) -> list[Any]:
        scale = max(abs(float(x)) for x in values)
        alone = kind in "gl" and sum(abs(float(x)) > ROUNDING * scale for x in values) == 1
        return [
            self._entry(kind, i, name + axis * (not alone), float(x), scale, of, axis)
            for x, axis in zip(values, AXES, strict=True)
        ]

    def _entry(self, kind: str, i: int, name: str, value: float, scale: float, of: str, axes: str = "") -> Any:
        """Return a number of body i, or (sign, index of a letter) where it has one: its own, or that of an equal number
        of equal meaning, of a body that the same body carries."""
        if abs(value) <= ROUNDING * scale:
            return 0.0
        if kind not in self._kinds:
            return value
        parent, moment = self.plan.model.bodies[i].parent, kind == "I" and axes[0] == axes[1]
        alike, signed = (kind, "moment" if moment else axes, parent, i if parent < 0 else -1), not moment
        for index in self._of.get(alike, ()):
            other = self.letters[index].value
            if abs(value - other) <= ROUNDING * scale:
                return (1.0, index)
            if signed and abs(value + other) <= ROUNDING * scale:
                return (-1.0, index)
        sign = -1.0 if kind in "gl" and value < 0.0 else 1.0
        self.letters.append(Letter(name, kind, sign * value, MEANINGS[kind].format(of, axes)))
        self._of.setdefault(alike, []).append(len(self.letters) - 1)
        return (sign, len(self.letters) - 1)

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
