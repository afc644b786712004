"""Forward dynamics for arrays of samples: the accelerations that torques make."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from math import ceil, log

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from robodyn.dynamics.arrays import arrays_of, results, zero_sources
from robodyn.dynamics.effects.effect import Sample, Terms, ZeroColumns
from robodyn.dynamics.effects.motors import reflected
from robodyn.dynamics.inverse import mass_matrix
from robodyn.dynamics.plan import Plan, applied, plan, ready
from robodyn.dynamics.recursions.articulated_body import RESIST, aligned, articulated_body, floating_turns, turned
from robodyn.dynamics.recursions.newton_euler import inertial_wrenches
from robodyn.errors import InputError
from robodyn.programs.program import traced
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar, sign
from robodyn.robot.kinematics import Wrench, motions
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_constraints
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats, first_largest
from robodyn.support.wording import shown

STEEPEST = 0.5
"""The largest load at a joint with a rotor: 44 repetitions."""
CLOSE = 1e-13
"""What is left of |y|'s error."""
Rotors = Mapping[tuple[int, int], Scalar]
Solve = Callable[[Sequence[Scalar], Rotors], list[Scalar]]


def repetitions(scene: Scene, names: Sequence[str]) -> int:
    """How often accelerations are found again for joints with rotors; InputError where a load is too large."""
    largest = max((scene.friction[name].load for name in names), default=0.0)
    if largest > STEEPEST:
        name = max(names, key=lambda each: scene.friction[each].load)
        what = f"[friction] {shown(name)}: load {largest:g} at a joint with a rotor is too large for forward dynamics"
        raise InputError(what, remedy=f"give {STEEPEST:g} or less, or no rotor")
    return ceil(log(CLOSE) / log(largest)) if largest else 0


def loaded_accelerations(
    solve: Solve, forces: Sequence[Scalar], rotors: Rotors, joints: Sequence[tuple[int, Scalar, Scalar]], passes: int
) -> list[Scalar]:
    """Return qdd with friction by load at joints, each its rate, its load with the sign of qd, and the torque that
    passes its gear to springs; rotors do not couple them. `solve` finds qdd of an open tree from forces and rotors."""

    def solved(torques: Sequence[Scalar], scales: Sequence[Scalar]) -> list[Scalar]:
        """Return qdd with these torques through the gears, and rotors times a scale."""
        through, scaled = list(forces), dict(rotors)
        for (rate, _, springs), torque, scale in zip(joints, torques, scales, strict=True):
            through[rate] = torque - springs
            if (rate, rate) in rotors:
                scaled[rate, rate] = rotors[rate, rate] * scale
        return solve(through, scaled)

    before = [forces[rate] + springs for rate, _, springs in joints]
    own = [rotors.get((rate, rate), 0.0) for rate, _, _ in joints]
    left = list(before)
    for _ in range(passes):
        scales = [1.0 / (1.0 - m * m) for _, m, _ in joints]
        parts = zip(joints, before, left, scales, strict=True)
        qdd = solved([(c - m * (y * sign(y))) * scale for (_, m, _), c, y, scale in parts], scales)
        left = [c - A * qdd[rate] for (rate, _, _), c, A in zip(joints, before, own, strict=True)]
    scales = [1.0 / (1.0 + m * sign(y)) for (_, m, _), y in zip(joints, left, strict=True)]
    return solved([c * scale for c, scale in zip(before, scales, strict=True)], scales)


@traced
def acceleration_program(plan: Plan, tape: Tape) -> Iterable[Scalar]:
    """The program of qdd from q, qd and tau, which is another input; `plan.zero_columns` may name its entries too."""
    refuse_constraints(plan.scene)
    model, scene, zero_columns = aligned(plan.model), plan.scene, plan.zero_columns
    sample = replace(Plan(model, scene, zero_columns).sample(tape), qdd=(0.0,) * model.n)
    tau = [0.0 if ("tau", i) in zero_columns else tape.input("tau", i) for i in range(model.n)]
    return accelerations(sample, applied(plan.effects, sample, scene), tau, scene)


def accelerations(sample: Sample, terms: Terms, tau: Sequence[Scalar], scene: Scene) -> list[Scalar]:
    """qdd of one sample of a model of `aligned`, in whatever scalar it is made of; the terms have no acceleration."""
    model, rotors = sample.model, reflected(sample.model, scene)
    joints = motions(model, sample.q, terms.qd, terms.qdd)
    biases = inertial_wrenches(model.parents, joints, terms.inertias, terms.gravity)
    for i, wrench in terms.wrenches:
        biases[i] = Wrench(biases[i].f - wrench.f, biases[i].n - wrench.n)
    forces = list(tau)
    for i, torque in terms.at_joint.items():
        joint = model.bodies[i].joint
        forces[joint.rate] = forces[joint.rate] - joint.multiplier * torque
    free = floating_turns(model, joints)

    def solve(forces: Sequence[Scalar], rotors: Rotors) -> list[Scalar]:
        own = turned(forces, free, back=True)
        qdd = articulated_body(model, joints, terms.inertias, biases, own, rotors, terms.spins)
        return turned(qdd, free)

    if not terms.load:
        return solve(forces, rotors)
    at = {i: model.bodies[i].joint for i in terms.load}
    loaded = [(at[i].rate, load, terms.through_gear.get(i, 0.0)) for i, load in terms.load.items()]
    heavy = [joint.name for joint in at.values() if rotors.get((joint.rate, joint.rate))]
    return loaded_accelerations(solve, forces, rotors, loaded, repetitions(scene, heavy))


def forward_dynamics(
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
) -> Floats:
    """qdd = M(q)^-1 (tau - c(q, qd) - g(q) - friction - springs + J^T w), M with payloads and rotors.

    The articulated-body algorithm (ABA). Coulomb friction is that of the motion, none at rest, so it holds nothing
    still.

    Args:
        tau: (..., n) N m or N, those of `inverse_dynamics`; `0` leaves the robot to itself.
        model, q, qd, scene, columns, out, executor, threads, dtype: as for `inverse_dynamics`.

    Returns:
        (..., n) per s^2, in the order of `model.rates`.

    Raises:
        InputError: as `inverse_dynamics`; or nothing resists a joint.

    Accuracy: the torques of these accelerations differ from tau by 1e-14 of the largest entry of |M| |qdd| + |bias| +
        |tau|, for chains of up to 100 bodies and mass ratios from 1e-12 to 1e12; qdd itself by cond(M) times that. In
        float32, 1e-5 of the largest entry.
    """
    sources, shape = arrays_of(model, {"q": q, "qd": qd, "tau": tau}, scene, columns or {}, dtype)
    runner = acceleration_runner(model, scene, zero_sources(sources))
    qdd = results(runner, sources, shape, (model.n,), out, executor, threads, dtype)
    if np.count_nonzero(np.isfinite(qdd)) != qdd.size:  # name the joint that M resists least
        finite = [np.isfinite(values).all(axis=1) for values in sources.values() if values.size]
        bad = np.all(finite, axis=0) & ~np.isfinite(qdd.reshape(-1, model.n)).all(axis=1)
        for k in np.flatnonzero(bad)[:1]:
            moments, ways = np.linalg.eigh(mass_matrix(model, sources["q"][k], scene=scene))
            worst = first_largest(-np.abs(moments))
            weakest = f'"{model.rates[first_largest(np.abs(ways[:, worst]))]}"'
            why = f"hardly anything resists {weakest} (smallest eigenvalue of M {moments[worst]:.1g})"
            raise InputError(f"sample {k} has no finite accelerations: {why}", remedy=RESIST)
    return qdd


@lru_cache(maxsize=16)
def acceleration_runner(model: Model, scene: Scene, zero_columns: ZeroColumns = frozenset()) -> Runner:
    return ready(acceleration_program, plan(model, scene, zero_columns))
