"""The equations of motion of a small robot in closed form, in numbers or in letters for them; every entry is checked
against the recursion in numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from robodyn.equations.forms import (
    LETTERS,
    Coefficient,
    Forms,
    Key,
    Polynomial,
    Sums,
    TooLargeError,
    module,
    named,
)
from robodyn.equations.letters import Letter, Lettered
from robodyn.equations.ode import check_equations, identifiers, units_of
from robodyn.errors import InputError
from robodyn.programs.program import Program
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene

MOST_JOINTS = 6
"""Coordinates of joints of a robot whose closed form can be written down; those of a base that moves come on top."""
PRODUCTS = 60_000
"""Of terms that are formed: seconds, and entries of some ten thousand characters."""
REMEDY = "--form ode has numbers at a configuration, robodyn export writes them as code"
STATES = 16
TOLERANCE = 1e-12
FLOOR = 1e-3
"""An entry is compared with the largest of its unit, or with this share of the largest of all, M among them, if that is
more; what is zero within rounding with the largest of M."""
NEGLIGIBLE = 1e-15
"""A smaller share of the largest coefficient of an entry is what rounding leaves of the description's zeros."""
DIGITS = 10
"""Decimals of up to so many digits count as short."""
SHORT = 16 * 2.0**-52
"""A coefficient this near a short decimal, as a share of itself, is taken to be that decimal."""


@dataclass(frozen=True, eq=False)
class Closed:
    """M(q) qdd + the sum of the bias's parts = tau, as SymPy expressions.

    Attributes:
        rates: names of the rates; kinds: "revolute", "prismatic", or "floating" six times for a base that moves, whose
            rates are in its own axes: w_x .. v_z, with the accelerations wd_x .. a_z.
        q, qd, qdd: the symbols, q_<joint> and so on, with `symbols` q_<number of the body>; q None of a base.
        symbols: the letters that occur; gravity's in the axes of the base, of one that moves.
        constants: sums of letters that occur more than once, by symbol; a later one may contain earlier ones.
        M: rows of entries.
        bias: entries of each part, by effect: gravity, coriolis, frictions and so on.
        error: the largest difference from the recursion in numbers, relative to the largest entry of its unit.
    """

    robot: str
    gravity: tuple[float, float, float]
    rates: tuple[str, ...]
    kinds: tuple[str, ...]
    q: tuple[Any, ...]
    qd: tuple[Any, ...]
    qdd: tuple[Any, ...]
    symbols: tuple[Letter, ...]
    constants: Mapping[Any, Any]
    M: tuple[tuple[Any, ...], ...]
    bias: Mapping[str, tuple[Any, ...]]
    error: float

    @property
    def entries(self) -> dict[tuple[str, int, int], Any]:
        """The entries of M's upper triangle and of each part of the bias by ("M" or effect, row, column or -1)."""
        n = len(self.rates)
        found = {("M", i, j): self.M[i][j] for i in range(n) for j in range(i, n)}
        return found | {(name, i, -1): x for name, part in self.bias.items() for i, x in enumerate(part)}


def closed(
    model: Model,
    scene: Scene = DEFAULT,
    symbols: Sequence[str] = (),
    positive: Iterable[str] = (),
) -> Closed:
    """Return the equations of motion in closed form.

    The traced recursion, run on trigonometric polynomials: every entry is a sum of sines and cosines of sums of angles,
    which is unique. Each entry is then compared with the recursion in numbers at random states, half of them at random
    values of the letters.

    Args:
        symbols: kinds of numbers that get letters, of `letters.KINDS`; positive: letters that SymPy may take to be.

    Raises:
        InputError: the robot or its closed form is too large, there are no equations, no such letters, an entry differs
            from the recursion, or SymPy is not installed.

    Accuracy: every entry within 1e-12 of the largest of its unit.
    """
    check_equations(model, scene)
    _check_size(model, scene)
    lettered = Lettered(model, scene, symbols, positive)
    n = model.n
    programs = {"M": lettered.mass()}
    programs |= {effect.name: lettered.share(effect) for effect in lettered.plan.effects if effect.name != "mimic"}
    forms = Forms(lettered.symbols, PRODUCTS)
    try:
        found = {name: forms.outputs(program) for name, program in programs.items()}
    except TooLargeError:
        what = "the closed form of this robot is too long to be read"
        fewer = "letters for fewer kinds, as --symbols m,l, make it shorter; " if symbols else ""
        raise InputError(what, remedy=fewer + REMEDY, file=model.file) from None
    sums = {name: [forms.sums(_snapped(form)) for form in found[name]] for name in found}
    named_by, constants = _constants(each for part in sums.values() for each in part)
    entries = {name: [forms.assembled(each, named_by) for each in part] for name, part in sums.items()}
    error = _error(lettered, programs, entries, constants)
    if error > TOLERANCE:
        raise InputError(f"the closed form is {error:.1e} off the recursion in numbers", remedy=REMEDY, file=model.file)
    upper = iter(entries.pop("M"))
    triangle = {(i, j): next(upper) for i in range(n) for j in range(i, n)}
    used = set[Any]().union(*(x.free_symbols for part in (triangle.values(), *entries.values()) for x in part))
    for symbol in reversed(constants):
        used |= constants[symbol].free_symbols if symbol in used else set()
    names = {} if symbols else _by_joint(model, lettered)
    places = [k for joint in model.independent for k in ([-1] * 6 if joint.kind == "floating" else [joint.coordinate])]
    q, *rates = (
        tuple(names.get(x, x) for x in (lettered.symbols.get((source, k)) for k in columns))
        for source, columns in (("q", places), ("qd", range(n)), ("qdd", range(n)))
    )
    return Closed(
        robot=model.name,
        gravity=scene.gravity,
        rates=model.rates,
        kinds=tuple(joint.kind for joint in model.independent for _ in range(6 if joint.kind == "floating" else 1)),
        q=q,
        qd=rates[0],
        qdd=rates[1],
        symbols=tuple(x for k, x in enumerate(lettered.letters) if lettered.symbols[LETTERS, k] in used),
        constants={symbol: whole for symbol, whole in constants.items() if symbol in used},
        M=tuple(tuple(triangle[min(i, j), max(i, j)].xreplace(names) for j in range(n)) for i in range(n)),
        bias={name: tuple(x.xreplace(names) for x in part) for name, part in entries.items()},
        error=error,
    )


def _check_size(model: Model, scene: Scene) -> None:
    joints = [body.joint for body in model.bodies]
    if any(joint.kind == "floating" for joint in joints[1:]):
        raise InputError("a floating joint between bodies has no closed form here", remedy=REMEDY, file=model.file)
    if (many := model.n - 6 * model.floating) > MOST_JOINTS:
        what = f"{many} coordinates are too many for a closed form, which goes up to {MOST_JOINTS}"
        raise InputError(what, remedy=REMEDY, file=model.file)
    fixed = any(wrench.frame == "world" and not wrench.axes for wrench in scene.wrenches) or any(scene.fluid_velocity)
    if model.floating and fixed:
        what = "wrenches and streams in axes of the world have no closed form for a base that turns"
        raise InputError(what, remedy=REMEDY, file=model.file)


def _by_joint(model: Model, lettered: Lettered) -> dict[Any, Any]:
    """Return symbols q_<joint> and so on for q_<number of the body>."""
    out, names = {}, identifiers(model.rates, "joint")
    for joint in model.independent:
        for source, k in (("q", joint.coordinate), ("qd", joint.rate), ("qdd", joint.rate)):
            if joint.kind != "floating":
                out[lettered.symbols[source, k]] = module().Symbol(f"{source}_{names[joint.rate]}", real=True)
    return out


def _error(
    lettered: Lettered, programs: Mapping[str, Program], entries: Mapping[str, list[Any]], constants: Mapping[Any, Any]
) -> float:
    """Return the largest difference of entries from programs at random states, letters first at their own values, as a
    share of the largest entry of its unit."""
    random, places, model = np.random.default_rng(0), lettered.symbols, lettered.plan.model
    widths = {source: 1 + max((k for name, k in places if name == source), default=-1) for source, _ in places}
    sources = {source: random.uniform(-2.0, 2.0, (STATES, width)) for source, width in widths.items()}
    if lettered.letters:
        sources[LETTERS] = random.uniform(0.5, 1.5, (STATES, len(lettered.letters)))
        sources[LETTERS][: STATES // 2] = [letter.value for letter in lettered.letters]
    states, columns = [sources[source][:, k] for source, k in places], list(places.values())
    for symbol, constant in constants.items():
        states.append(module().lambdify(columns, constant, "numpy")(*states))
        columns.append(symbol)
    units, error = np.array(units_of(model)), 0.0
    pairs = np.array([" ".join(sorted((units[i], units[j]))) for i in range(model.n) for j in range(i, model.n)])
    numbers = {name: np.asarray(NumpyBlocks(x, widths)(sources, STATES), dtype=float) for name, x in programs.items()}
    for name, part in entries.items():
        each = pairs if name == "M" else units
        whole = numbers["M"] * (1.0 if name in ("M", "coriolis") else max(1.0, *map(abs, lettered.plan.scene.gravity)))
        for k, expression in enumerate(part):
            off = np.abs(module().lambdify(columns, expression, "numpy")(*states) - numbers[name][:, k])
            alike = numbers[name][:, each == each[k]]
            for half in (slice(0, STATES // 2), slice(STATES // 2, STATES)):
                unit, own, size = (float(np.abs(x[half]).max()) for x in (alike, numbers[name], whole))
                scale = max(unit, FLOOR * max(own, size) if any(part) else size)
                error = max(error, float(off[half].max()) / (scale or 1.0))
    return error


def _snapped(form: Polynomial) -> Polynomial:
    """Return the short decimals next to coefficients, if rounding alone can tell them apart, and no term that is but
    rounding."""
    out, largest = dict[Key, Coefficient](), max((abs(entry.value) for entry in form.values()), default=0.0)
    for key, entry in form.items():
        short = float(f"{entry.value:.{DIGITS - 1}e}")
        near = abs(short - entry.value) <= SHORT * abs(entry.value)
        if abs(entry.value) >= NEGLIGIBLE * largest:
            out[key] = entry._replace(value=short) if near else entry
    return out


def _constants(sums: Iterable[Sums]) -> tuple[dict[Any, Any], dict[Any, Any]]:
    """Return symbols A_1, A_2, .. for what occurs often, and by symbol what it stands for: sums of letters, alone or
    times other letters, that occur more than once; products of at least three letters that do so more than twice."""
    found = [x[1:] for each in sums for shapes in each.values() for x in shapes.values()]
    times = Counter(found)
    often = {(x, whole) for (x, whole), k in times.items() if (k > 1 if whole.args else k > 2 and x.count_ops() > 1)}
    wholes = Counter(whole for x, whole in times for _ in range(1 if (x, whole) in often else times[x, whole]))
    names, constants = dict[Any, Any](), dict[Any, Any]()
    for product, whole in times:
        for x in (whole,) * (whole.args != () and wholes[whole] > 1) + (product * whole,) * ((product, whole) in often):
            if x not in names:
                symbol = module().Symbol(f"A_{len(names) + 1}", real=True)
                constants[symbol] = x if x == whole else named(product, whole, names)
                names[x] = symbol
    return names, constants
