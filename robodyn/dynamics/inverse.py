"""Inverse dynamics, bias, mass and Coriolis matrix for arrays of samples: the Python interface to the recursions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from robodyn.dynamics.arrays import arrays_of, check_out, results, zero_sources
from robodyn.dynamics.effects import motors, rigid_bodies
from robodyn.dynamics.effects.motors import mass_entries
from robodyn.dynamics.plan import Plan, applied, loads, plan, ready, runner_of, torque_runner
from robodyn.dynamics.recursions.articulated_body import aligned, composite_body, floating_turns, turned
from robodyn.programs.derivative import again, jacobian
from robodyn.programs.program import trace, traced
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar, skew, vector
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_constraints, refuse_load, refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats


def inverse_dynamics(
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
) -> Floats:
    """tau = M(q) qdd + c(q, qd) + g(q) + friction + armature qdd + springs - J^T w.

    The recursive Newton-Euler algorithm (RNEA), traced once per model and scene, then run over all samples. In a scene
    with loops, contacts or passive joints these are the torques of the drives, as `constraint_forces` finds them.

    Args:
        model: of `robodyn.load`.
        q: (..., nq) rad or m; a floating base comes first, as x y z qx qy qz qw.
        qd, qdd: (..., n) per s and per s^2; of a floating base wx wy wz (body axes) and vx vy vz (ground's axes).
            Broadcast against q; `0` is a robot at rest.
        scene: gravity, friction and so on; by default gravity (0, 0, -9.81) and the friction of the description.
        columns: (...) values of the columns that the scene's wrenches name.
        out: (..., n) of `dtype`, written to and returned if given.
        executor: "numpy" starts at once; "compiled" turns the recursion into machine code, tens of times faster per
            sample, and needs llvmlite; "auto" weighs the work. Their results differ by rounding.
        threads: of the compiled executor; None is all cores. Results do not depend on it.
        dtype: float64 or float32, of arrays and arithmetic.

    Returns:
        (..., n) N m or N, in the order of `model.rates`. The columns of a matrix are contiguous, which is fastest.

    Raises:
        InputError: a shape, or a joint or link that the scene names, does not fit the model; no such executor; loops of
            the scene are open.

    Accuracy: 1e-14 of the largest torque for chains of up to 100 bodies, 1e-6 in float32. The executors agree within 4
        ulp of it for real robots on a fixed base, 8 on a free one. Bit-identical wherever a fixed base stands and with
        every effect whose coefficient is zero.
    """
    sources, shape = arrays_of(model, {"q": q, "qd": qd, "qdd": qdd}, scene, columns or {}, dtype)
    if not scene.constrained:
        runner = torque_runner(model, scene, zero_sources(sources))
        return results(runner, sources, shape, (model.n,), out, executor, threads, dtype)
    from robodyn.dynamics.constraints.solve import constraint_forces

    found = constraint_forces(model, q, qd, qdd, scene=scene, columns=columns, executor=executor, threads=threads).tau
    if out is None:
        return found.astype(dtype, copy=False)
    check_out(out, found.shape, dtype)
    out[...] = found
    return out


def bias_forces(
    model: Model,
    q: ArrayLike,
    qd: ArrayLike,
    *,
    scene: Scene = DEFAULT,
    columns: Mapping[str, ArrayLike] | None = None,
    executor: str = "auto",
    threads: int | None = None,
) -> Floats:
    """b(q, qd) = c(q, qd) + g(q) + friction + springs - J^T w, the torque of a motion without acceleration.

    Args, returns and accuracy: as for `inverse_dynamics` with qdd = 0.

    Raises:
        InputError: as `inverse_dynamics`; or the scene has loops or contacts, whose forces follow from qdd, or friction
            that grows with load, which the torques of qdd change.
    """
    refuse_others(model, scene)
    refuse_constraints(scene)
    refuse_load(scene)
    return inverse_dynamics(model, q, qd, 0.0, scene=scene, columns=columns, executor=executor, threads=threads)


def mass_matrix(
    model: Model, q: ArrayLike, *, scene: Scene = DEFAULT, executor: str = "auto", threads: int | None = None
) -> Floats:
    """M(q) (..., n, n) [kg m^2, kg m or kg], exactly symmetric, with payloads and rotor inertias of the scene.

    Args, errors: as for `inverse_dynamics`.

    Accuracy: 1e-14 of the largest entry.
    """
    refuse_others(model, scene)
    sources, shape = arrays_of(model, {"q": q})
    return results(mass_runner(model, scene), sources, shape, (model.n, model.n), None, executor, threads)


@lru_cache(maxsize=16)
def mass_runner(model: Model, scene: Scene) -> Runner:
    a_plan = plan(model, scene)

    def outputs(tape: Tape) -> Iterable[Scalar]:
        sample = Plan(aligned(model), scene).sample(tape)
        joints, inertias = sample.motions(), applied([rigid_bodies.PAYLOAD], sample, scene).inertias
        M = np.zeros((model.n, model.n), dtype=object)
        for (i, j), value in composite_body(sample.model, joints, inertias, mass_entries(sample, scene)).items():
            M[i, j] = M[j, i] = value
        turns = floating_turns(sample.model, joints)
        rows = [turned(column, turns) for column in zip(*(turned(row, turns) for row in M.tolist()), strict=True)]
        return [rows[max(i, j)][min(i, j)] for i in range(model.n) for j in range(model.n)]

    return runner_of(trace(outputs), a_plan)


def coriolis_matrix(
    model: Model,
    q: ArrayLike,
    qd: ArrayLike,
    *,
    scene: Scene = DEFAULT,
    executor: str = "auto",
    threads: int | None = None,
) -> Floats:
    """C(q, qd) with `C qd = c`, the Coriolis and centrifugal torques, and `M' - 2 C` skew-symmetric (Christoffel's).

    Half the derivative of c, which is quadratic in the rates; to the columns of a floating base's w, which are rates of
    no coordinates, `M [w]/2` is added, what its axes' own turn makes of the connection (Levi-Civita's, for the
    left-invariant frame). It is (..., n, n) [kg m^2/s and the like], with the scene's payloads and rotors that have an
    axis; others, as they turn in place, add to M alone. Args, errors: as for `inverse_dynamics`.

    Accuracy: 1e-14 of the largest entry of C for chains of up to 100 bodies.
    """
    refuse_others(model, scene)
    sources, shape = arrays_of(model, {"q": q, "qd": qd})
    runner = ready(coriolis_program, plan(model, scene))
    return results(runner, sources, shape, (model.n, model.n), None, executor, threads)


@traced
def coriolis_program(plan: Plan, tape: Tape) -> Iterable[Scalar]:
    model, sample = plan.model, plan.sample(tape)
    sample = replace(sample, qdd=(0.0,) * model.n)
    terms = applied([rigid_bodies.CORIOLIS, rigid_bodies.PAYLOAD, motors.GYROSCOPIC], sample, plan.scene)
    rows = jacobian(loads(sample, terms).tau, [{rate: 1.0} for rate in sample.qd])
    rows = [[0.5 * x for x in row] for row in rows]
    mass = again(mass_runner(model, plan.scene).program, tape)
    for joint in model.independent:
        if joint.kind == "floating":
            k = joint.rate
            turn = 0.5 * skew(vector(*sample.qd[k : k + 3]))
            for i, row in enumerate(rows):
                row[k : k + 3] = vector(*row[k : k + 3]) + vector(*mass[i * model.n + k : i * model.n + k + 3]) @ turn
    return [x for row in rows for x in row]
