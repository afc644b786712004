"""Derivatives of inverse and forward dynamics for arrays of samples."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from robodyn.dynamics.arrays import arrays_of, results
from robodyn.dynamics.effects.effect import Sample
from robodyn.dynamics.forward import acceleration_program
from robodyn.dynamics.mass import mass_runner
from robodyn.dynamics.plan import Plan, loads, plan
from robodyn.dynamics.runners import runner_of
from robodyn.programs.derivative import Direction, Row, again, jacobian
from robodyn.programs.program import Program, trace, traced
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar, total
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_constraints, refuse_load
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats


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

    The traced recursion differentiated operation by operation, so these are derivatives of the very torques that
    `inverse_dynamics` returns. sign(qd) has derivative 0: Coulomb friction adds nothing, not even at rest, where it
    jumps; with the scene's `slip_speed` it is smooth, and its slope is there.

    Args:
        model, q, qd, qdd, scene, columns, executor, threads, dtype: as for `inverse_dynamics`.
        out: (..., 3, n, n) of `dtype`, written to if given; the matrices are views of it.

    Raises:
        InputError: as `inverse_dynamics`.

    Accuracy: 1e-13 of the largest entry of each matrix. In float32, 1e-5; on a free base 1e-4, as weights cancel.
    """
    sources, shape = arrays_of(model, {"q": q, "qd": qd, "qdd": qdd}, scene, columns or {}, dtype)
    runner = inverse_runner(plan(model, scene))
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
    """d qdd / dq, d qdd / d qd and M^-1 of qdd = `forward_dynamics(model, q, qd, tau)`.

    By `d qdd = M^-1 (d tau - d ID)` at the accelerations of the articulated-body algorithm, of which M^-1 is the
    derivative by tau. Of friction the same holds as for `inverse_dynamics_derivatives`.

    Args:
        model, q, qd, tau, scene, columns, executor, threads, dtype: as for `forward_dynamics`.
        out: (..., 3, n, n) of `dtype`, written to if given; the matrices are views of it.

    Raises:
        InputError: as `forward_dynamics`.

    Accuracy: cond(M) times 1e-13 of the largest entry of each matrix.
    """
    sources, shape = arrays_of(model, {"q": q, "qd": qd, "tau": tau}, scene, columns or {}, dtype)
    runner = forward_runner(plan(model, scene))
    whole = results(runner, sources, shape, (3, model.n, model.n), out, executor, threads, dtype)
    return ForwardDerivatives(*(whole[..., k, :, :] for k in range(3)))


@lru_cache(maxsize=16)
def inverse_runner(a_plan: Plan) -> Runner:
    """Return d tau / dq, d tau / d qd and M row by row, ready to run."""
    return runner_of(inverse_derivatives(a_plan), a_plan)


@lru_cache(maxsize=16)
def forward_runner(a_plan: Plan) -> Runner:
    """Return d qdd / dq, d qdd / d qd and M^-1 row by row, ready to run."""
    return runner_of(forward_derivatives(a_plan), a_plan)


@lru_cache(maxsize=16)
def inverse_derivatives(plan: Plan) -> Program:
    """Return the program of d tau / dq, d tau / d qd and M, row by row.

    What stands at the same place of the three is computed together, for it shares most: fewer values wait at a time
    than where one matrix follows the other.
    """
    n = plan.model.n

    def outputs(tape: Tape) -> Iterable[Scalar]:
        mass = _by_accelerations(plan, tape)
        return [*_joined(_rates_of_torques(plan, tape), n), *mass]

    return trace(outputs, [(k * n + i) * n + j for i in range(n) for j in range(n) for k in range(3)])


def _by_accelerations(plan: Plan, tape: Tape) -> Iterable[Scalar]:
    """Return d tau / d qdd, row by row."""
    if not plan.scene.loaded:
        return again(mass_runner(plan.model, plan.scene).program, tape)
    sample, terms = plan.terms(tape)
    return [x for row in jacobian(loads(sample, terms).tau, [{each: 1.0} for each in sample.qdd]) for x in row]


@lru_cache(maxsize=16)
def forward_derivatives(plan: Plan) -> Program:
    """Return the program of d qdd / dq, d qdd / d qd and M^-1, row by row.

    Column after column is finished, from the tips of the tree, so that few values wait at a time.
    """
    refuse_load(plan.scene)
    n = plan.model.n

    def outputs(tape: Tape) -> Iterable[Scalar]:
        qdd = again(acceleration_program(plan), tape)
        lower = jacobian(qdd, [{tape.input("tau", i): 1.0} for i in range(n)])
        inverse = [[lower[max(i, j)][min(i, j)] for j in range(n)] for i in range(n)]
        rows = _at(_program_of_rates(plan), tape, qdd, n)
        solved = [[-total(inverse[i][k] * rows[k][j] for k in range(n)) for j in range(2 * n)] for i in range(n)]
        return [*_joined(solved, n), *(x for row in inverse for x in row)]

    return trace(outputs, [(k * n + i) * n + j for j in reversed(range(n)) for k in (2, 1, 0) for i in range(n)])


@traced
def _program_of_rates(plan: Plan, tape: Tape) -> Iterable[Scalar]:
    """The program of (d tau / dq, d tau / d qd), n rows of 2 n."""
    return [x for row in _rates_of_torques(plan, tape) for x in row]


def _at(program: Program, tape: Tape, qdd: list[Scalar], n: int) -> list[Row]:
    given = {("qdd", i): each for i, each in enumerate(qdd)}
    entries = again(program, tape, given)
    return [entries[2 * n * i : 2 * n * (i + 1)] for i in range(n)]


def _joined(rows: list[Row], n: int) -> list[Scalar]:
    """Return the entries of the left and then of the right square, row by row."""
    return [*(x for row in rows for x in row[:n]), *(x for row in rows for x in row[n:])]


def _rates_of_torques(plan: Plan, tape: Tape) -> list[Row]:
    """Return n rows of d tau / dq and d tau / d qd beside each other."""
    refuse_constraints(plan.scene)
    sample, terms = plan.terms(tape)
    return jacobian(loads(sample, terms).tau, [*moves(sample), *({rate: 1.0} for rate in sample.qd)])


def moves(sample: Sample) -> list[Direction]:
    """Return how q changes along each rate: its own coordinate, or a floating base's turn and shift.

    A turn w about the body's axes changes the quaternion by `q (w, 0) / 2`, whatever its length.
    """
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
