"""The equations of motion of a small robot in closed form, every entry checked against the recursion in numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from robodyn.dynamics.mass import mass_runner
from robodyn.equations.ode import bias_plan, check_equations, identifiers
from robodyn.equations.polynomial import Forms, TooLargeError, largest
from robodyn.errors import InputError
from robodyn.programs.program import Program
from robodyn.programs.run.numpy_blocks import Numbers, NumpyBlocks
from robodyn.programs.run.symbolic import expressions, module
from robodyn.programs.scalar import CONSTANT, INPUT
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene

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


class Part(NamedTuple):
    """Expressions of one program's outputs, how far they are from its numbers, and how many are not simplified."""

    entries: list[Any]
    error: float
    plain: int


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
        M=tuple(tuple(mass.entries[n * i : n * i + n]) for i in range(n)),
        bias={name: tuple(part.entries) for name, part in parts.items()},
        plain=sum(part.plain for part in (mass, *parts.values())),
        error=max(part.error for part in (mass, *parts.values())),
    )


def _part(program: Program, symbols: Symbols, units: Sequence[str], products: int) -> Part:
    """Return the outputs of a program in closed form, each checked in numbers; outputs of the same unit compare."""
    states = np.random.default_rng(0).uniform(-2.0, 2.0, (STATES, len(symbols)))
    n = len(symbols) // 2
    numbers = NumpyBlocks(program, {"q": n, "qd": n})({"q": states[:, :n], "qd": states[:, n:]}, STATES)
    simple = _simplified(program, symbols, units, products) or [None] * len(units)
    errors = []
    for k, unit in enumerate(units):
        alike = [other for other, same in enumerate(units) if same == unit]
        scale = max(float(np.abs(numbers[:, alike]).max()), FLOOR * float(np.abs(numbers).max()))
        errors.append(_difference(simple[k], symbols, states, numbers[:, k], scale))
    failed = [k for k, error in enumerate(errors) if not error <= TOLERANCE]
    plain = _plain(program, symbols) if failed else []
    entries = [plain[k] if k in failed else simple[k] for k in range(len(units))]
    return Part(entries, max((x for k, x in enumerate(errors) if k not in failed), default=0.0), len(failed))


def _plain(program: Program, symbols: Symbols) -> list[Any]:
    """Return the outputs as the recursion makes them; raise where they are too long to be written down."""
    lengths: list[int] = []
    for op, a, b in program.operations:
        leaf = op is INPUT or op is CONSTANT
        lengths.append(1 if leaf else 1 + lengths[a] + (0 if b is None else lengths[b]))
    longest = max(lengths[k] for k in program.outputs)
    if longest > LONGEST:
        raise InputError(f"the closed form of this robot has an entry of {longest} operations", remedy=REMEDY)
    return expressions(program, symbols)


def _simplified(program: Program, symbols: Symbols, units: Sequence[str], products: int) -> list[Any] | None:
    """Return the outputs as sums of sines and cosines, if that is not too much work."""
    forms = Forms(symbols, products)
    try:
        found = forms.outputs(program)
    except TooLargeError:
        return None
    of_unit = {unit: [form for form, own in zip(found, units, strict=True) if own == unit] for unit in units}
    least = {unit: NEGLIGIBLE * max(largest(some), FLOOR * largest(found)) for unit, some in of_unit.items()}
    return [forms.expression(form, least[unit]) for form, unit in zip(found, units, strict=True)]


def _difference(expression: Any, symbols: Symbols, states: Numbers, expected: Numbers, scale: float) -> float:
    """The largest difference of an expression from what is expected, as a share of `scale`; inf if there is none."""
    if expression is None:
        return float("inf")
    function = module().lambdify(list(symbols.values()), expression, "numpy")
    worst = float(np.abs(function(*states.T) - expected).max())
    return worst / scale if worst else 0.0


def decimal(expression: Any) -> Any:
    """Return the same expression with floats of 17 digits for its fractions; exponents stay."""
    sympy = module()
    if expression.is_Rational:
        return expression if expression.is_Integer else sympy.Float(expression, 17)
    if expression.is_Pow:
        return sympy.Pow(decimal(expression.base), expression.exp)
    return expression.func(*map(decimal, expression.args)) if expression.args else expression
