"""Derivatives of torques in compact form: the entries that are not always zero, and where they stand."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from robodyn.dynamics.arrays import arrays_of, results
from robodyn.dynamics.derivatives import InverseDerivatives, inverse_derivatives
from robodyn.dynamics.plan import Plan, plan
from robodyn.dynamics.runners import runner_of
from robodyn.programs.program import Program
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import CONSTANT
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_load
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats


class Entries(NamedTuple):
    """Entries of d tau / dq, d tau / d qd and M; all others are 0 in any state, but for the lower triangle of M.

    Attributes:
        values: (..., k).
        matrix: (k,) 0 for d tau / dq, 1 for d tau / d qd, 2 for M, of which the upper triangle is given.
        row, column: (k,) as in `InverseDerivatives`.
        n: rows and columns of the matrices.
    """

    values: Floats
    matrix: NDArray[np.intp]
    row: NDArray[np.intp]
    column: NDArray[np.intp]
    n: int

    def dense(self) -> InverseDerivatives:
        """Return the three matrices."""
        whole = np.zeros((*self.values.shape[:-1], 3, self.n, self.n), self.values.dtype)
        whole[..., self.matrix, self.row, self.column] = self.values
        mass = self.matrix == 2
        whole[..., 2, self.column[mass], self.row[mass]] = self.values[..., mass]
        return InverseDerivatives(*(whole[..., k, :, :] for k in range(3)))


def inverse_dynamics_derivative_entries(
    model: Model,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    *,
    scene: Scene = DEFAULT,
    columns: Mapping[str, ArrayLike] | None = None,
    out: Floats | None = None,
    executor: str = "auto",
    threads: int | None = None,
    dtype: DTypeLike = np.float64,
) -> Entries:
    """`inverse_dynamics_derivatives` without what the tree of joints makes zero: of a robot with legs, most of it.

    The pattern depends on the model and the scene alone.

    Args:
        model, q, qd, qdd, scene, columns, executor, threads, dtype: as for `inverse_dynamics`.
        out: (..., k) of `dtype`, written to if given.

    Raises:
        InputError: as `inverse_dynamics`.

    Accuracy: each entry is that of `inverse_dynamics_derivatives` to the last bit.
    """
    sources, shape = arrays_of(model, {"q": q, "qd": qd, "qdd": qdd}, scene, columns or {}, dtype)
    runner, places = _runner(plan(model, scene))
    values = results(runner, sources, shape, (len(places[0]),), out, executor, threads, dtype)
    return Entries(values, places[0], places[1], places[2], model.n)


@lru_cache(maxsize=16)
def _runner(a_plan: Plan) -> tuple[Runner, NDArray[np.intp]]:
    """Return what computes the entries, and their matrices, rows and columns."""
    refuse_load(a_plan.scene)
    n, whole = a_plan.model.n, inverse_derivatives(a_plan)
    zeros = {k for k, (op, a, _) in enumerate(whole.operations) if op is CONSTANT and a == 0.0}
    places = [
        (m, i, j)
        for m, i, j in np.ndindex(3, n, n)
        if whole.outputs[(m * n + i) * n + j] not in zeros and (m < 2 or i <= j)
    ]

    program = Program(whole.operations, tuple(whole.outputs[(m * n + i) * n + j] for m, i, j in places))
    return runner_of(program, a_plan), np.array(places, np.intp).reshape(-1, 3).T
