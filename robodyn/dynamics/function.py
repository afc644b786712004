"""Dynamics of one sample at a time: callables for control loops, optimizers and solvers of ODEs."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property, lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robodyn.dynamics.arrays import DOUBLE, check_out, numbers
from robodyn.dynamics.derivatives import forward_derivatives, inverse_derivatives
from robodyn.dynamics.forward import acceleration_program
from robodyn.dynamics.inverse import coriolis_program, mass_runner
from robodyn.dynamics.plan import Plan, plan
from robodyn.dynamics.regressor import parameters, regressor_program
from robodyn.errors import InputError
from robodyn.programs.program import Program
from robodyn.programs.run.llvm.machine import compiler_problem
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_load, refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.wording import alternatives


class Result(NamedTuple):
    """An array that a function returns; `axes` are n of `model.n`, or p of the regressor's parameters."""

    name: str
    axes: str
    meaning: str


class Kind(NamedTuple):
    """A kind of function, by a short word; its program has the entries of all results, each row by row."""

    word: str
    meaning: str
    sources: tuple[str, ...]
    results: tuple[Result, ...]
    program: Callable[[Plan], Program]

    def widths(self, plan: Plan) -> dict[str, int]:
        """How many numbers each argument has; last the columns that wrenches name, if any do."""
        model, columns = plan.model, plan.scene.columns
        widths = {source: model.nq if source == "q" else model.n for source in self.sources}
        return {**widths, "columns": len(columns)} if columns else widths

    def shapes(self, plan: Plan) -> dict[str, tuple[int, ...]]:
        sizes = {"n": plan.model.n}
        if any("p" in result.axes for result in self.results):
            sizes["p"] = len(list(parameters(plan)))
        return {result.name: tuple(sizes[axis] for axis in result.axes) for result in self.results}


def _bias(plan: Plan) -> Program:
    refuse_load(plan.scene)
    at_rest = frozenset(("qdd", i) for i in range(plan.model.n))
    return replace(plan, zero_columns=plan.zero_columns | at_rest).torques()


_FORCES, _MASSES = "[N m or N]", "[kg m^2, kg m or kg]"
_MASS_MATRIX = Result("M", "nn", f"the mass matrix with rotors {_MASSES}")
KINDS = {
    "inverse_dynamics": Kind(
        "torques",
        "the torques of a motion",
        ("q", "qd", "qdd"),
        (Result("tau", "n", f"what the actuators supply along the joints' axes {_FORCES}"),),
        Plan.torques,
    ),
    "mass_matrix": Kind(
        "mass_matrix",
        "the mass matrix",
        ("q",),
        (_MASS_MATRIX,),
        lambda plan: mass_runner(plan.model, plan.scene).program,
    ),
    "bias_forces": Kind(
        "bias",
        "the torques of a motion without acceleration",
        ("q", "qd"),
        (Result("b", "n", f"with tau = M qdd + b {_FORCES}"),),
        _bias,
    ),
    "coriolis_matrix": Kind(
        "coriolis",
        "the Coriolis matrix",
        ("q", "qd"),
        (Result("C", "nn", "C qd are the centrifugal and Coriolis torques, M' - 2 C is skew-symmetric [M's, by s]"),),
        coriolis_program,
    ),
    "forward_dynamics": Kind(
        "forward",
        "the acceleration that torques make",
        ("q", "qd", "tau"),
        (Result("qdd", "n", "[rad/s^2 or m/s^2]"),),
        acceleration_program,
    ),
    "inverse_dynamics_derivatives": Kind(
        "derivatives",
        "how torques change",
        ("q", "qd", "qdd"),
        (
            Result("dtau_dq", "nn", "d tau / d q [N m/rad, N/rad, N or N/m]"),
            Result("dtau_dqd", "nn", "d tau / d qd [the same, times s]"),
            _MASS_MATRIX,
        ),
        inverse_derivatives,
    ),
    "forward_dynamics_derivatives": Kind(
        "forward_derivatives",
        "how accelerations change",
        ("q", "qd", "tau"),
        (
            Result("dqdd_dq", "nn", "d qdd / d q [1/s^2, 1/(m s^2) or m/s^2]"),
            Result("dqdd_dqd", "nn", "d qdd / d qd [the same, times s]"),
            Result("M_inverse", "nn", "d qdd / d tau [1/(kg m^2), 1/(kg m) or 1/kg]"),
        ),
        forward_derivatives,
    ),
    "regressor": Kind(
        "regressor",
        "torques as a matrix times the parameters in which they are linear",
        ("q", "qd", "qdd"),
        (
            Result("Y", "np", "with tau = Y theta + rest"),
            Result("rest", "n", f"what springs, wrenches, fluids and friction by load add {_FORCES}"),
        ),
        regressor_program,
    ),
}
"""By the name that the function of arrays has in `robodyn`."""


OF_ONE_SAMPLE = {name: kind for name, kind in KINDS.items() if len({result.axes for result in kind.results}) == 1}
"""Those whose results are one array, or can be stacked."""


class Function:
    """A function of one sample: call it with arrays of doubles, in the order of `arguments`.

    `f(q, qd, qdd)` returns a new array, `f(q, qd, qdd, out=tau)` writes to one, which may be an argument, allocates
    nothing and returns it. Where all arguments are contiguous arrays of float64 of the right shape the call is one of
    machine code; any other numbers are converted first, in some microseconds. Functions can be pickled, with their
    model and scene, and are built again where they are read.

    Attributes:
        kind: what it computes. arguments: name and width of each argument. shape: of the result.
        address: of the C function `int64_t f(const double *q, ..., double *result)`, which returns 0, or 1 where the
            root of the sum of squares of all angles exceeds 1.6e6 rad or is not finite, and nothing is written; to be
            called as long as this object lives. None where there is no compiler, and the function is slow.
    """

    def __init__(
        self, a_plan: Plan, kind: str, arguments: dict[str, int], shape: tuple[int, ...], program: Program
    ) -> None:
        self.kind, self.arguments, self.shape = kind, arguments, shape
        self.address: int | None = None
        self._plan, self._program = a_plan, program
        self._code: Callable[..., int] | None = None

    @cached_property
    def _blocks(self) -> NumpyBlocks:
        return NumpyBlocks(self._program, self.arguments)

    def __reduce__(self) -> tuple[Callable[..., Function], tuple[Model, str]]:
        return partial(function, scene=self._plan.scene), (self._plan.model, self.kind)

    def __repr__(self) -> str:
        return f"<{self.kind}({', '.join(f'{name}[{width}]' for name, width in self.arguments.items())})>"

    def __call__(self, *given: ArrayLike, out: Floats | None = None) -> Floats:
        """Return the result of one sample; InputError where the number of arguments, a shape or `out` does not fit."""
        if len(given) != len(self.arguments):
            raise InputError(f"{self.kind} of one sample has arguments {', '.join(self.arguments)}: {len(given)} given")
        sources = {}
        for (name, width), values in zip(self.arguments.items(), given, strict=True):
            array = numbers(name, values, DOUBLE).copy(order="C")
            if array.shape != (width,):
                raise InputError(f"{name} has shape {array.shape}, not {(width,)}: it is one sample")
            sources[name] = array
        result = self._result(sources)
        if out is None:
            return result
        check_out(out, self.shape, DOUBLE)
        out[...] = result
        return out

    def _result(self, sources: Mapping[str, Floats]) -> Floats:
        """Return the result of arrays of the right shape, by machine code unless there is none or it declines them."""
        result: Floats = np.empty(self.shape, np.float64)
        if self._code is None or self._code(*(x.ctypes.data for x in (*sources.values(), result))):
            result[...] = self._blocks({name: array[None] for name, array in sources.items()}, 1).reshape(self.shape)
        return result


def function(model: Model, kind: str, *, scene: Scene = DEFAULT) -> Function:
    """Return the function of one sample that computes the same as `robodyn.<kind>` with this scene, as accurately.

    Args:
        kind: "inverse_dynamics", "bias_forces", "forward_dynamics", "mass_matrix", "coriolis_matrix",
            "inverse_dynamics_derivatives" or "forward_dynamics_derivatives"; the matrices of the last two are stacked,
            (3, n, n).
        scene: where its wrenches name columns, these are one more argument, in the order of `scene.columns`.

    Raises:
        InputError: there is no such kind.
        SceneError: the scene does not fit the model.
    """
    if not isinstance(kind, str) or kind not in OF_ONE_SAMPLE:
        remedy = alternatives(str(kind), tuple(OF_ONE_SAMPLE), "functions")
        raise InputError(f"there is no function {kind!r} of one sample", remedy=remedy)
    refuse_others(model, scene)
    return _function(plan(model, scene), kind)


@lru_cache(maxsize=32)
def _function(a_plan: Plan, kind: str) -> Function:
    chosen = OF_ONE_SAMPLE[kind]
    shapes = list(chosen.shapes(a_plan).values())
    shape = shapes[0] if len(shapes) == 1 else (len(shapes), *shapes[0])
    program, widths = chosen.program(a_plan), chosen.widths(a_plan)
    slow = Function(a_plan, kind, widths, shape, program)
    if compiler_problem():
        return slow
    from robodyn.programs.run.llvm.build import built
    from robodyn.programs.run.llvm.python_call import callable_of, sample_kernel

    content = ("one sample", program.operations, program.outputs, tuple(widths.items()))
    try:
        kernel = built("arrays", content, lambda: sample_kernel(program, widths))
        call = callable_of(kernel.address, list(widths.values()), shape, slow, kernel)
    except (OSError, RuntimeError):
        return slow
    # an instance of a class of its own, whose call is that code
    own: dict[str, Any] = {"__call__": call, "__doc__": Function.__doc__, "__slots__": ()}
    fast: Function = type("Function", (Function,), own)(a_plan, kind, widths, shape, program)
    fast.address = kernel.address_of("sample")
    slow._code = ctypes.CFUNCTYPE(ctypes.c_int64, *[ctypes.c_void_p] * (len(widths) + 1))(fast.address)
    return fast
