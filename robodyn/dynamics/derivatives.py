"""Derivatives of inverse and forward dynamics for arrays of samples: dense, by entries, and second ones."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from robodyn.dynamics.arrays import arrays_of, results
from robodyn.dynamics.effects.effect import Sample
from robodyn.dynamics.forward import acceleration_program
from robodyn.dynamics.inverse import mass_runner
from robodyn.dynamics.plan import Plan, loads, plan, ready, runner_of
from robodyn.errors import InputError
from robodyn.programs.derivative import Direction, Row, again, jacobian
from robodyn.programs.program import Program, trace
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import CONSTANT, Tape
from robodyn.programs.vectors import Scalar, total
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_constraints, refuse_load
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats

MOST_OPERATIONS = 100_000
"""Longer programs are refused: they take a minute to derive and minutes to compile."""
MOST_BEFORE = 30_000
"""First derivatives of more operations are not derived again: the second would have several times as many."""


class InverseDerivatives(NamedTuple):
    """How torques change: matrices (..., n, n), row i for tau_i.

    Attributes:
        dq: d tau / dq [N m/rad, ...]. Columns are rates: of a floating base a small turn about the body's axes and a
            shift along the ground's, while qd and qdd keep their components.
        dqd: d tau / d qd [N m s/rad, ...].
        dqdd: d tau / d qdd, the mass matrix with rotors [kg m^2, ...], exactly symmetric. Friction that grows with load
            multiplies what the links add to a row of it by 1 + load s(qd) sign(tau_l), and it is not symmetric.
    """

    dq: Floats
    dqd: Floats
    dqdd: Floats


class ForwardDerivatives(NamedTuple):
    """How accelerations change: matrices (..., n, n), row i for qdd_i.

    Attributes:
        dq: d qdd / dq [1/s^2, ...]. Columns as in `InverseDerivatives`.
        dqd: d qdd / d qd [1/s, ...].
        dtau: d qdd / d tau, the inverse of the mass matrix [1/(kg m^2), ...], exactly symmetric.
    """

    dq: Floats
    dqd: Floats
    dtau: Floats


def inverse_dynamics_derivatives(
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
) -> InverseDerivatives:
    """d tau / dq, d tau / d qd and M of tau = `inverse_dynamics(model, q, qd, qdd)`, all effects of the scene included.

    The traced recursion differentiated operation by operation. sign(qd) has derivative 0: Coulomb friction adds
    nothing, not even at rest, where it jumps; with the scene's `slip_speed` it is smooth, and its slope is there.

    Args, errors: as for `inverse_dynamics`; out is (..., 3, n, n), and the matrices are views of it.

    Accuracy: 1e-13 of the largest entry of each matrix. In float32, 1e-5; on a free base 1e-4, as weights cancel.
    """
    sources, shape = arrays_of(model, {"q": q, "qd": qd, "qdd": qdd}, scene, columns or {}, dtype)
    runner = ready(inverse_derivatives, plan(model, scene))
    whole = results(runner, sources, shape, (3, model.n, model.n), out, executor, threads, dtype)
    return InverseDerivatives(*(whole[..., k, :, :] for k in range(3)))


def forward_dynamics_derivatives(
    model: Model,
    q: ArrayLike,
    qd: ArrayLike,
    tau: ArrayLike,
    *,
    scene: Scene = DEFAULT,
    columns: Mapping[str, ArrayLike] | None = None,
    out: Floats | None = None,
    executor: str = "auto",
    threads: int | None = None,
    dtype: DTypeLike = np.float64,
) -> ForwardDerivatives:
    """d qdd / dq, d qdd / d qd and M^-1 of qdd = `forward_dynamics(model, q, qd, tau)`, by `d qdd = M^-1 (d tau - d
    ID)`.

    Of friction the same holds as for `inverse_dynamics_derivatives`.

    Args, errors: as for `forward_dynamics`; out is (..., 3, n, n), and the matrices are views of it.

    Accuracy: cond(M) times 1e-13 of the largest entry of each matrix.
    """
    sources, shape = arrays_of(model, {"q": q, "qd": qd, "tau": tau}, scene, columns or {}, dtype)
    runner = ready(forward_derivatives, plan(model, scene))
    whole = results(runner, sources, shape, (3, model.n, model.n), out, executor, threads, dtype)
    return ForwardDerivatives(*(whole[..., k, :, :] for k in range(3)))


@lru_cache(maxsize=16)
def inverse_derivatives(plan: Plan) -> Program:
    """The program of d tau / dq, d tau / d qd and M, row by row; what stands at the same place is computed together."""
    n = plan.model.n

    def outputs(tape: Tape) -> Iterable[Scalar]:
        if plan.scene.loaded:
            sample, terms = plan.terms(tape)
            by_qdd = jacobian(loads(sample, terms).tau, [{each: 1.0} for each in sample.qdd])
            mass = [x for row in by_qdd for x in row]
        else:
            mass = again(mass_runner(plan.model, plan.scene).program, tape)
        return [*_joined(_rates_of_torques(plan, tape), n), *mass]

    return trace(outputs, [(k * n + i) * n + j for i in range(n) for j in range(n) for k in range(3)])


@lru_cache(maxsize=16)
def forward_derivatives(plan: Plan) -> Program:
    """The program of d qdd / dq, d qdd / d qd and M^-1, row by row. Column after column is finished, from the tips of
    the tree, so that few values wait at a time."""
    refuse_load(plan.scene)
    n = plan.model.n

    def outputs(tape: Tape) -> Iterable[Scalar]:
        qdd = again(acceleration_program(plan), tape)
        lower = jacobian(qdd, [{tape.input("tau", i): 1.0} for i in range(n)])
        inverse = [[lower[max(i, j)][min(i, j)] for j in range(n)] for i in range(n)]
        torques = trace(lambda own: [x for row in _rates_of_torques(plan, own) for x in row])
        rates = again(torques, tape, {("qdd", i): each for i, each in enumerate(qdd)})
        rows = [rates[2 * n * i : 2 * n * (i + 1)] for i in range(n)]
        solved = [[-total(inverse[i][k] * rows[k][j] for k in range(n)) for j in range(2 * n)] for i in range(n)]
        return [*_joined(solved, n), *(x for row in inverse for x in row)]

    return trace(outputs, [(k * n + i) * n + j for j in reversed(range(n)) for k in (2, 1, 0) for i in range(n)])


def _joined(rows: list[Row], n: int) -> list[Scalar]:
    """The entries of the left and then of the right square, row by row."""
    return [*(x for row in rows for x in row[:n]), *(x for row in rows for x in row[n:])]


def _rates_of_torques(plan: Plan, tape: Tape) -> list[Row]:
    """Return n rows of d tau / dq and d tau / d qd beside each other."""
    refuse_constraints(plan.scene)
    sample, terms = plan.terms(tape)
    return jacobian(loads(sample, terms).tau, [*moves(sample), *({rate: 1.0} for rate in sample.qd)])


def moves(sample: Sample) -> list[Direction]:
    """Return how q changes along each rate: its own coordinate, or a floating base's turn `q (w, 0) / 2` and shift."""
    out: list[Direction] = []
    for joint in sample.model.independent:
        k = joint.coordinate
        if joint.kind != "floating":
            out.append({sample.q[k]: 1.0})
            continue
        position, (x, y, z, w) = sample.q[k : k + 3], sample.q[k + 3 : k + 7]
        turns = ((w, z, -y, -x), (-z, w, x, -y), (y, -x, w, -z))
        out += [dict(zip((x, y, z, w), (0.5 * part for part in turn), strict=True)) for turn in turns]
        out += [{coordinate: 1.0} for coordinate in position]
    return out


class Entries(NamedTuple):
    """Entries of d tau / dq, d tau / d qd and M; all others are 0 in any state, but for the lower triangle of M.

    Attributes:
        values: (..., k).
        matrix: (k,) 0 for d tau / dq, 1 for d tau / d qd, 2 for M, of which the upper triangle is given.
        row, column: (k,) of the matrix, which is (n, n).
    """

    values: Floats
    matrix: NDArray[np.intp]
    row: NDArray[np.intp]
    column: NDArray[np.intp]
    n: int

    def dense(self) -> InverseDerivatives:
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
    """`inverse_dynamics_derivatives`, to the last bit, without what the tree of joints makes zero: with legs, most of
    it.

    The pattern depends on the model and the scene alone. Args, errors: as for `inverse_dynamics`; out is (..., k).
    """
    sources, shape = arrays_of(model, {"q": q, "qd": qd, "qdd": qdd}, scene, columns or {}, dtype)
    runner, places = _entries_runner(plan(model, scene))
    values = results(runner, sources, shape, (len(places[0]),), out, executor, threads, dtype)
    return Entries(values, places[0], places[1], places[2], model.n)


@lru_cache(maxsize=16)
def _entries_runner(a_plan: Plan) -> tuple[Runner, NDArray[np.intp]]:
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


class SecondDerivatives(NamedTuple):
    """How the derivatives of torques change: results (..., n, n, n). Entry [i, j, k] of `a_b` is tau_i differentiated
    by a_j and then by b_k; `qdd_q` is dM/dq, and all others are 0, or these with j and k exchanged. Turns of a floating
    base do not commute, so that there `q_q` is not symmetric in j and k."""

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

    Args: as for `inverse_dynamics`; out is (..., 4, n, n, n), and the results are views of it.

    Raises:
        InputError: as `inverse_dynamics`; or more than 100 000 operations are needed (an arm of 7 joints needs 50 000).

    Accuracy: 1e-13 of the largest entry of each tensor. In float32, 1e-5; on a free base 1e-4, as weights cancel.
    """
    sources, shape = arrays_of(model, {"q": q, "qd": qd, "qdd": qdd}, scene, columns or {}, dtype)
    n, runner = model.n, ready(_second_derivatives, plan(model, scene))
    whole = results(runner, sources, shape, (4, n, n, n), out, executor, threads, dtype)
    return SecondDerivatives(*(whole[..., k, :, :, :] for k in range(4)))


def _second_derivatives(a_plan: Plan) -> Program:
    """Return the program of d^2 tau / (dq dq, dqd dq, dqd dqd) and dM / dq, row by row, unless it is too long."""
    refuse_load(a_plan.scene)
    first, n = inverse_derivatives(a_plan), a_plan.model.n

    def outputs(tape: Tape) -> Iterable[Scalar]:
        entries, (sample, _) = again(first, tape), a_plan.terms(tape)
        by_q = jacobian(entries, moves(sample))
        by_qd = jacobian(entries[n * n : 2 * n * n], [{rate: 1.0} for rate in sample.qd])
        return [x for row in (*by_q[: 2 * n * n], *by_qd, *by_q[2 * n * n :]) for x in row]

    program = trace(outputs) if first.size <= MOST_BEFORE else None
    if program is None or program.size > MOST_OPERATIONS:
        needed = f"those of its first need {first.size}" if program is None else f"they need {program.size}"
        what = f"second derivatives of {a_plan.model.name} need more than {MOST_OPERATIONS} operations ({needed})"
        raise InputError(what, remedy="fix joints that stay at rest, or take differences of the first derivatives")
    return program
