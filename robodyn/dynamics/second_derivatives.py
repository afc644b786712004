"""Second derivatives of inverse dynamics for arrays of samples."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from robodyn.dynamics.arrays import arrays_of, results
from robodyn.dynamics.derivatives import inverse_derivatives, moves
from robodyn.dynamics.plan import Plan, plan
from robodyn.dynamics.runners import runner_of
from robodyn.errors import InputError
from robodyn.programs.derivative import again, jacobian
from robodyn.programs.program import Program, traced
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_load
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats

MOST_OPERATIONS = 100_000
"""Longer programs are refused: they take a minute to derive and minutes to compile."""
MOST_BEFORE = 30_000
"""First derivatives of more operations are not derived again: the second would have several times as many."""


class SecondDerivatives(NamedTuple):
    """How the derivatives of torques change: results (..., n, n, n).

    Entry [i, j, k] of `a_b` is tau_i differentiated by a_j and then by b_k. Derivatives by q are rates as in
    `InverseDerivatives`; turns of a floating base do not commute, so that there `q_q` is not symmetric in j and k.

    Attributes:
        q_q, qd_q, qd_qd, qdd_q: the last is dM/dq. All others are 0, or these with j and k exchanged.
    """

    q_q: Floats
    qd_q: Floats
    qd_qd: Floats
    qdd_q: Floats


def inverse_dynamics_second_derivatives(
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
) -> SecondDerivatives:
    """Second derivatives of tau = `inverse_dynamics(model, q, qd, qdd)`, all effects of the scene included.

    The program of `inverse_dynamics_derivatives` differentiated again; of sign(qd) the same holds.

    Args:
        model, q, qd, qdd, scene, columns, executor, threads, dtype: as for `inverse_dynamics`.
        out: (..., 4, n, n, n) of `dtype`, written to if given; the results are views of it.

    Raises:
        InputError: as `inverse_dynamics`; or the robot has so many joints that more than 100 000 operations are needed
            (an arm of 7 joints needs some 50 000).

    Accuracy: 1e-13 of the largest entry of each tensor. In float32, 1e-5; on a free base 1e-4, as weights cancel.
    """
    sources, shape = arrays_of(model, {"q": q, "qd": qd, "qdd": qdd}, scene, columns or {}, dtype)
    n, runner = model.n, _runner(plan(model, scene))
    whole = results(runner, sources, shape, (4, n, n, n), out, executor, threads, dtype)
    return SecondDerivatives(*(whole[..., k, :, :, :] for k in range(4)))


@lru_cache(maxsize=8)
def _runner(a_plan: Plan) -> Runner:
    return runner_of(second_derivatives(a_plan), a_plan)


def second_derivatives(a_plan: Plan) -> Program:
    """Return the program of d^2 tau / (dq dq, dqd dq, dqd dqd) and dM / dq, row by row.

    Raises:
        InputError: it is too long.
    """
    refuse_load(a_plan.scene)
    first = inverse_derivatives(a_plan)
    program = _differentiated(a_plan) if first.size <= MOST_BEFORE else None
    if program is None or program.size > MOST_OPERATIONS:
        needed = f"those of its first need {first.size}" if program is None else f"they need {program.size}"
        what = f"second derivatives of {a_plan.model.name} need more than {MOST_OPERATIONS} operations ({needed})"
        raise InputError(what, remedy="fix joints that stay at rest, or take differences of the first derivatives")
    return program


@traced
def _differentiated(plan: Plan, tape: Tape) -> Iterable[Scalar]:
    first, n = again(inverse_derivatives(plan), tape), plan.model.n
    sample, _ = plan.terms(tape)
    by_q = jacobian(first, moves(sample))
    by_qd = jacobian(first[n * n : 2 * n * n], [{rate: 1.0} for rate in sample.qd])
    return [x for row in (*by_q[: 2 * n * n], *by_qd, *by_q[2 * n * n :]) for x in row]
