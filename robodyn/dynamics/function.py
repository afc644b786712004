"""Dynamics of one sample at a time: callables for control loops, optimizers and solvers of ODEs."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping
from functools import cached_property, lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robodyn.dynamics import kinds
from robodyn.dynamics.arrays import DOUBLE, numbers
from robodyn.dynamics.plan import Plan, plan
from robodyn.errors import InputError
from robodyn.programs.program import Program
from robodyn.programs.run.llvm.machine import compiler
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.wording import alternatives

KINDS = {name: kind for name, kind in kinds.KINDS.items() if len({result.axes for result in kind.results}) == 1}
"""Those whose results are one array, or can be stacked."""


class Function:
    """A function of one sample: call it with arrays of doubles, in the order of `arguments`.

    `f(q, qd, qdd)` returns a new array, `f(q, qd, qdd, out=tau)` writes to one, allocates nothing and returns it. Where
    all arguments are contiguous arrays of float64 of the right shape the call is one of machine code, and any other
    numbers are converted first, in some microseconds. Results may be written over arguments. Functions can be pickled,
    with their model and scene, and are built again where they are read.

    Attributes:
        kind: what it computes.
        arguments: name and width of each argument.
        shape: of the result.
        address: of the C function `int64_t f(const double *q, ..., double *result)`, which returns 0, or 1 where the
            root of the sum of squares of all angles exceeds 1.6e6 rad or is not finite, and nothing is written. Only
            as long as this object lives is there anything to call. None where there is no compiler, and the
            function is slow.
    """

    def __init__(
        self, a_plan: Plan, kind: str, arguments: Mapping[str, int], shape: tuple[int, ...], program: Program
    ) -> None:
        self.kind, self.arguments, self.shape = kind, dict(arguments), shape
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
        """Return the result of one sample.

        Raises:
            InputError: too many or too few arguments, a shape that does not fit, an `out` that cannot be written to.
        """
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
        if not isinstance(out, np.ndarray) or (out.shape, out.dtype) != (self.shape, result.dtype):
            raise InputError(f"out is no array of float64 of shape {self.shape}")
        if not out.flags.writeable:
            raise InputError("out is read-only")
        out[...] = result
        return out

    def _result(self, sources: Mapping[str, Floats]) -> Floats:
        """Return the result of arrays of the right shape, by machine code unless there is none or it declines them."""
        result: Floats = np.empty(self.shape, np.float64)
        if self._code is None or self._code(*(x.ctypes.data for x in (*sources.values(), result))):
            result[...] = self._blocks({name: array[None] for name, array in sources.items()}, 1).reshape(self.shape)
        return result


def function(model: Model, kind: str, *, scene: Scene = DEFAULT) -> Function:
    """Return the function of one sample that computes the same as `robodyn.<kind>` with this scene.

    Args:
        kind: "inverse_dynamics", "bias_forces", "forward_dynamics", "mass_matrix", "coriolis_matrix",
            "inverse_dynamics_derivatives" or "forward_dynamics_derivatives"; the matrices of the last two are stacked,
            (3, n, n).
        scene: where its wrenches name columns, these are one more argument, in the order of `scene.columns`.

    Raises:
        InputError: there is no such kind.
        SceneError: the scene does not fit the model.

    Accuracy: as `robodyn.<kind>`, compiled.
    """
    if not isinstance(kind, str) or kind not in KINDS:
        raise InputError(
            f"there is no function {kind!r} of one sample", remedy=alternatives(str(kind), tuple(KINDS), "functions")
        )
    refuse_others(model, scene)
    return _function(plan(model, scene), kind)


@lru_cache(maxsize=32)
def _function(a_plan: Plan, kind: str) -> Function:
    chosen = KINDS[kind]
    shapes = list(chosen.shapes(a_plan).values())
    shape = shapes[0] if len(shapes) == 1 else (len(shapes), *shapes[0])
    slow = Function(a_plan, kind, chosen.widths(a_plan), shape, chosen.program(a_plan))
    return slow if compiler().problem else _compiled(slow)


def _compiled(slow: Function) -> Function:
    """Return the same function by machine code: an instance of a class of its own, whose call is that code."""
    from robodyn.programs.run.llvm.build import built
    from robodyn.programs.run.llvm.one_sample import sample_kernel
    from robodyn.programs.run.llvm.python_call import callable_of

    program, widths = slow._program, slow.arguments
    content = ("one sample", program.operations, program.outputs, tuple(widths.items()))
    try:
        kernel = built("arrays", content, lambda: sample_kernel(program, widths))
        call = callable_of(kernel.address, list(widths.values()), slow.shape, slow, kernel)
    except (OSError, RuntimeError):
        return slow
    own: dict[str, Any] = {"__call__": call, "__doc__": Function.__doc__, "__slots__": ()}
    fast = type("Function", (Function,), own)(slow._plan, slow.kind, widths, slow.shape, program)
    fast.address = kernel.address_of("sample")
    slow._code = ctypes.CFUNCTYPE(ctypes.c_int64, *[ctypes.c_void_p] * (len(widths) + 1))(fast.address)
    return fast  # type: ignore[no-any-return]
