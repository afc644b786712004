"""Methods that conserve energy or momentum, and whether they apply to a robot in its scene."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.effect import Effect, Sample
from robodyn.dynamics.effects.motors import angular_momentum
from robodyn.dynamics.effects.rigid_bodies import PAYLOAD
from robodyn.dynamics.plan import applied
from robodyn.dynamics.recursions.momentum import momenta
from robodyn.errors import InputError
from robodyn.programs.program import trace
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Array, Scalar, cross
from robodyn.robot.model import Model
from robodyn.scene.parts import GROUND
from robodyn.scene.scene import Scene
from robodyn.simulation.equations import STATE, Equations


def check_leapfrog(equations: Equations) -> None:
    """Raise if the accelerations of a robot in a scene depend on its speeds.

    Raises:
        InputError: they do; it names the effects that make them.
    """
    scene, effects = equations.scene, equations.plan.effects
    if not _needs_speed(equations, effects):
        return
    undriven = Equations(replace(equations.plan, scene=replace(scene, drive={})))
    causes = [effect.name for effect in effects if _needs_speed(undriven, [effect])]
    causes = ["loops"] if scene.loops else causes
    causes += ["drives with kd"] * any(drive.kd for drive in scene.drive.values())
    what = f"verlet does not apply: accelerations depend on speeds ({', '.join(causes)})"
    raise InputError(what, remedy="--method gauss2 keeps energy too, whatever forces there are")


def _needs_speed(equations: Equations, effects: Sequence[Effect]) -> bool:
    nq, n = equations.model.nq, equations.model.n

    def outputs(tape: Tape) -> Iterable[Scalar]:
        state = equations.state(tape)
        return equations.accelerations(state.q, state.qd, equations.given(tape), effects)[0]

    return bool({(STATE, nq + i) for i in range(n)} & trace(outputs).inputs)


def is_free(model: Model, scene: Scene) -> bool:
    """Return whether nothing but gravity acts on the robot from outside, so that its momenta are known."""
    bodies = model.bodies
    roots = [body for body in bodies if body.parent < 0]
    if roots[0].joint.kind == "fixed" and not roots[0].inertia.m:
        roots = [body for body in bodies if body.parent == 0]
    alone = len(roots) == 1 and roots[0].joint.kind == "floating"
    tied = any(loop.to == GROUND for loop in scene.loops)
    return alone and not scene.wrenches and not scene.fluid_density and not tied


def check_free(model: Model, scene: Scene, name: str) -> None:
    """Raise if a method of this name, which keeps momenta, does not apply.

    Raises:
        InputError: the robot is not free.
    """
    if not is_free(model, scene):
        what = f"{name} does not apply: the momenta of a robot that is held or pushed from outside change"
        raise InputError(what, remedy='--method rk4, or [base] motion = "moving" in the scene')


class Momentum(NamedTuple):
    """Linear momentum, and angular momentum about the centre of mass, in the ground's axes; and the mass."""

    P: Array
    H: Array
    m: Scalar


def momentum(equations: Equations, q: Sequence[Scalar], qd: Sequence[Scalar]) -> Momentum:
    """`P = R P_base`, `H_c = R (H_base - c x P_base)`."""
    model, scene = equations.model, equations.scene
    sample = Sample(model, tuple(q), tuple(qd), (0.0,) * model.n)
    joints = sample.motions()
    whole, R = momenta(model.parents, joints, applied([PAYLOAD], sample, scene).inertias), joints[0].R
    spinning = angular_momentum(sample, scene, joints)
    return Momentum(R @ whole.P, R @ (whole.H + spinning - cross(whole.mc, whole.P) / whole.m), whole.m)


def kept(
    equations: Equations,
    before: tuple[Sequence[Scalar], Sequence[Scalar]],
    q: Sequence[Scalar],
    qd: list[Scalar],
    step: Scalar,
) -> list[Scalar]:
    """qd with other rates of the floating base, so that the momenta at q are those of before and the weight's impulse.

    Momenta are linear in rates: `A dw + m R_0 dv = dP` and `B dw = dH`, where column k of A and B are the momenta of a
    unit of the base's angular velocity k alone, and R_0 the axes in which v is given.

    Args:
        before: q and qd at the beginning of the step.
    """
    base = next(body for body in equations.model.bodies if body.joint.kind == "floating")
    first, n = base.joint.rate, equations.model.n
    was, now = momentum(equations, *before), momentum(equations, q, qd)
    units = [momentum(equations, q, [float(i == first + k) for i in range(n)]) for k in range(3)]
    dP = was.P + np.array(equations.scene.gravity) * (now.m * step) - now.P
    dw = _solved([unit.H for unit in units], was.H - now.H)
    dP = dP - sum(unit.P * part for unit, part in zip(units, dw, strict=True))
    R = base.joint.R if base.parent < 0 else equations.model.bodies[0].joint.R @ base.joint.R
    change = [*dw, *(R.T @ dP * (1.0 / now.m))]
    return [x + change[i - first] if first <= i < first + 6 else x for i, x in enumerate(qd)]


def _solved(columns: Sequence[Array], right: Array) -> list[Scalar]:
    """x of the three equations `sum_k columns_k x_k = right`."""
    a, b, c = columns
    normals = cross(b, c), cross(c, a), cross(a, b)
    determinant = a @ normals[0]
    return [(normal @ right) / determinant for normal in normals]
