"""Integrators as data: coefficients, the names of those that SciPy has, and the options that choose among them."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, sqrt
from typing import NamedTuple

from robodyn.errors import InputError
from robodyn.support.floats import Floats
from robodyn.support.wording import alternatives

STEP = 1e-3  # s, where neither a step nor a tolerance is given
RTOL = 1e-9  # of an adaptive method, where none is given
LEAST_RTOL = 1e-13  # below, SciPy's methods only follow rounding


@dataclass(frozen=True)
class Method:
    """A Runge-Kutta method `K_i = f(y + h sum_j A_ij K_j)`, `y_1 = y + h sum_i b_i K_i`, or one of SciPy's.

    Attributes:
        order: the error at a given time falls with this power of the step.
        about: what it is good for, in a few words.
        A, b: its table.
        semi: the position moves at the speed that the step ends with (symplectic Euler); K is then the speed's alone.
        leapfrog: half a step at the old speed and half at the new; only where no speed changes an acceleration.
        keeps_momenta: after each step the rates of a free base are set so that its momenta stay; only for free robots.
        scipy: the name of the method that `scipy.integrate.solve_ivp` has; A and b are then empty.
    """

    name: str
    order: int
    about: str
    A: tuple[tuple[float, ...], ...] = ()
    b: tuple[float, ...] = ()
    semi: bool = False
    scipy: str = ""
    leapfrog: bool = False
    keeps_momenta: bool = False

    @property
    def implicit(self) -> bool:
        """Whether a stage needs itself or a later one."""
        return not self.leapfrog and any(x != 0.0 for i, row in enumerate(self.A) for x in row[i:])

    @property
    def nodes(self) -> tuple[float, ...]:
        """c_i, the fraction of a step at which each stage is."""
        return tuple(sum(row) for row in self.A)

    @property
    def moments(self) -> tuple[float, ...]:
        """The nodes, each once."""
        return tuple(dict.fromkeys(self.nodes))

    @property
    def adaptive(self) -> bool:
        return bool(self.scipy)


_R3, _R15 = sqrt(3.0), sqrt(15.0)
_RK4 = (0.0, 0.0, 0.0, 0.0), (0.5, 0.0, 0.0, 0.0), (0.0, 0.5, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)
METHODS: tuple[Method, ...] = (
    Method("euler", 1, "explicit Euler: gains energy; for comparison", ((0.0,),), (1.0,)),
    Method("symplectic-euler", 1, "semi-implicit Euler: the new speed moves the position", ((0.0,),), (1.0,), True),
    Method(
        "verlet",
        2,
        "leapfrog: symplectic, energy does not drift; for motions without forces that depend on speed",
        ((0.5,),),
        (1.0,),
        leapfrog=True,
    ),
    Method("midpoint", 2, "explicit midpoint rule", ((0.0, 0.0), (0.5, 0.0)), (0.0, 1.0)),
    Method("rk4", 4, "the classical Runge-Kutta method", _RK4, (1 / 6, 1 / 3, 1 / 3, 1 / 6)),
    Method(
        "rk4-momenta",
        4,
        "rk4, and after each step the base's speeds that keep the momenta of a free robot",
        _RK4,
        (1 / 6, 1 / 3, 1 / 3, 1 / 6),
        keeps_momenta=True,
    ),
    Method("gauss2", 2, "implicit midpoint rule: reversible, energy does not drift", ((0.5,),), (1.0,)),
    Method(
        "gauss4",
        4,
        "Gauss-Legendre with two stages: reversible, energy does not drift",
        ((1 / 4, 1 / 4 - _R3 / 6), (1 / 4 + _R3 / 6, 1 / 4)),
        (1 / 2, 1 / 2),
    ),
    Method(
        "gauss6",
        6,
        "Gauss-Legendre with three stages: reversible, energy does not drift",
        (
            (5 / 36, 2 / 9 - _R15 / 15, 5 / 36 - _R15 / 30),
            (5 / 36 + _R15 / 24, 2 / 9, 5 / 36 - _R15 / 24),
            (5 / 36 + _R15 / 30, 2 / 9 + _R15 / 15, 5 / 36),
        ),
        (5 / 18, 4 / 9, 5 / 18),
    ),
    Method("dop853", 8, "Dormand and Prince's, SciPy's: steps as long as --rtol allows", scipy="DOP853"),
    Method("radau", 5, "Radau IIA, SciPy's: implicit, for stiff friction and stiff drives", scipy="Radau"),
)
CHECKING = Method("bdf", 5, "backward differences, SciPy's: for another opinion on stiff motions", scipy="BDF")
"""A method that confirms others and is good for nothing else."""


def method_named(name: str) -> Method:
    for method in (*METHODS, CHECKING):
        if method.name == name:
            return method
    known = tuple(method.name for method in METHODS)
    raise InputError(f"there is no method {name!r}", remedy=alternatives(name, known, "methods"))


class TooMuchError(InputError):
    """A motion takes more evaluations of its equations than it may; `time` [s] and `state` are how far it got."""

    def __init__(self, what: str, time: float, state: Floats, remedy: str) -> None:
        super().__init__(what, remedy=remedy)
        self.time, self.state = time, state


class MethodOptions(NamedTuple):
    """A method with its step or its tolerance, and after how `most` evaluations it gives up."""

    method: Method
    step: float
    rtol: float
    most: float = inf


def choose_method(step: float | None, rtol: float | None, name: str | None) -> MethodOptions:
    """The method of this name with this step or tolerance, or with the usual ones; raises if it has no use for them."""
    method = method_named(name or ("rk4" if rtol is None else "dop853"))
    if method.adaptive and step is not None:
        raise InputError(f"{method.name} chooses its own steps", remedy="give --rtol instead of --step")
    if not method.adaptive and rtol is not None:
        raise InputError(f"{method.name} has steps of a fixed length", remedy="give --step instead of --rtol")
    return MethodOptions(method, STEP if step is None else step, max(RTOL if rtol is None else rtol, LEAST_RTOL))
