"""The mass matrix and the Coriolis matrix for arrays of samples."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from robodyn.dynamics.arrays import arrays_of, results
from robodyn.dynamics.effects import motors, rigid_bodies
from robodyn.dynamics.effects.motors import mass_entries
from robodyn.dynamics.plan import Plan, applied, loads, plan, ready, runner_of
from robodyn.dynamics.recursions.composite_body import composite_body
from robodyn.dynamics.recursions.elimination import aligned, floating_turns, turned
from robodyn.programs.derivative import again, jacobian
from robodyn.programs.program import trace, traced
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar, skew, vector
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats


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

    c is quadratic in the rates, so half its derivative by them is Christoffel's matrix where the rates are those of
    coordinates. A floating base turns at rates w that are those of none; there `M [w]/2` is added to the columns of w,
    what its axes' own turn makes of the connection (Levi-Civita's, for the left-invariant frame).

    It is (..., n, n) [kg m^2/s and the like], with the scene's payloads and rotors that have an axis; others, as they
    turn in place, add to M alone.

    Args, errors: as for `inverse_dynamics`.

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
