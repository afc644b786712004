"""Kinds of functions of one sample: what each takes and gives, and its program."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from robodyn.dynamics.coriolis import coriolis_program
from robodyn.dynamics.derivatives import forward_derivatives, inverse_derivatives
from robodyn.dynamics.forward import acceleration_program
from robodyn.dynamics.mass import mass_runner
from robodyn.dynamics.plan import Plan
from robodyn.dynamics.regressor import parameters, regressor_program
from robodyn.programs.program import Program
from robodyn.scene.fit import refuse_load


class Result(NamedTuple):
    """An array that a function returns.

    Attributes:
        name: of the array.
        axes: its dimensions by letters: n of `model.n`, p of the parameters of the regressor.
        meaning: in words, with units.
    """

    name: str
    axes: str
    meaning: str


class Kind(NamedTuple):
    """A kind of function.

    Attributes:
        word: a short name.
        meaning: what it computes, in words.
        sources: the arrays that it takes.
        results: those that it returns.
        program: from the plan to the entries of all results, one after another, each row by row.
    """

    word: str
    meaning: str
    sources: tuple[str, ...]
    results: tuple[Result, ...]
    program: Callable[[Plan], Program]

    def widths(self, plan: Plan) -> dict[str, int]:
        """Return the arguments and how many numbers each has; last the columns that wrenches name, if any do."""
        model, columns = plan.model, plan.scene.columns
        widths = {source: model.nq if source == "q" else model.n for source in self.sources}
        return {**widths, "columns": len(columns)} if columns else widths

    def shapes(self, plan: Plan) -> dict[str, tuple[int, ...]]:
        """Return the shape of each result."""
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
