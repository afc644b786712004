"""The regressor: torques as a matrix times the parameters in which they are linear."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robodyn.dynamics.arrays import arrays_of, results
from robodyn.dynamics.effects.friction import COULOMB, VISCOUS, coulomb_torque, joints_with_friction
from robodyn.dynamics.effects.motors import (
    COUPLED,
    GYROSCOPIC,
    ROTOR,
    armatures,
    at_joints,
    coupled_motors,
    moving,
    spins,
    with_spins,
)
from robodyn.dynamics.effects.rigid_bodies import CORIOLIS, GRAVITY, INERTIA, MOVING_BASE, PAYLOAD
from robodyn.dynamics.plan import Plan, applied, at_rest, loads, plan, ready
from robodyn.programs.derivative import jacobian
from robodyn.programs.program import traced
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar, vector
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_constraints
from robodyn.scene.scene import DEFAULT, Friction, Scene
from robodyn.solids.inertia.laws import MASSLESS, Inertia, symmetric
from robodyn.support.floats import Floats

INERTIAL = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")
"""Of each body: mass [kg], first moments [kg m], and moments about its frame's origin [kg m^2], in its axes."""


class Regressor(NamedTuple):
    """tau = Y theta + rest.

    Attributes:
        Y: (..., n, p); theta: (p,) the parameters of the model and the scene.
        names: of the parameters, "forearm.Ixx" of a body and "elbow.viscous" of a joint or a coupled motor.
        rest: (..., n) what springs, wrenches and fluids add; and friction that grows with load, not being linear.
    """

    Y: Floats
    theta: Floats
    names: tuple[str, ...]
    rest: Floats


def regressor(
    model: Model,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    *,
    scene: Scene = DEFAULT,
    columns: Mapping[str, ArrayLike] | None = None,
    executor: str = "auto",
    threads: int | None = None,
) -> Regressor:
    """Y, theta and the rest with `inverse_dynamics(model, q, qd, qdd) = Y theta + rest`.

    theta has ten parameters of each body (`INERTIAL`, with its payloads), of each hinge and slide `viscous`, `forward`
    and `backward` (Coulomb's torque at qd > 0 and, with its sign, at qd < 0) and, where the scene names it, `stribeck`;
    and `rotor`, the inertia of its rotor times the square of the gear [kg m^2], with its gyroscopic moments where the
    scene says its axis; and the same of each coupled motor.

    Args, errors: as for `inverse_dynamics`.

    Accuracy: `Y theta + rest` within 1e-13 of the largest product of an entry of Y and its parameter.
    """
    sources, shape = arrays_of(model, {"q": q, "qd": qd, "qdd": qdd}, scene, columns or {})
    a_plan = plan(model, scene)
    names, theta = zip(*parameters(a_plan), strict=True)
    runner = ready(regressor_program, a_plan)
    rows = results(runner, sources, shape, (model.n * (len(names) + 1),), None, executor, threads)
    Y, rest = rows[..., : -model.n], rows[..., -model.n :]
    return Regressor(Y.reshape(*shape, model.n, len(names)), np.array(theta), names, rest)


@lru_cache(maxsize=16)
@traced
def regressor_program(plan: Plan, tape: Tape) -> Iterable[Scalar]:
    """The program of Y, row by row, and then of the rest."""
    refuse_constraints(plan.scene)
    theta = [tape.input("theta", k) for k, _ in enumerate(parameters(plan))]
    sample, model, scene, values = plan.sample(tape), plan.model, plan.scene, iter(theta)
    of = dict(zip((name for name, _ in parameters(plan)), theta, strict=True))
    inertias = []
    for _ in model.bodies:
        m, x, y, z, *moments = islice(values, len(INERTIAL))
        inertias.append(Inertia(m, vector(x, y, z), symmetric(moments)))
    at_joint = []
    for i, joint, friction in joints_with_friction(model, scene):
        torque = _motor_torque(values, friction, sample.speed(joint), sample.acceleration(joint), scene.slip_speed)
        at_joint.append((i, torque))
    for motor, turned in coupled_motors(model, scene):
        torque = _motor_torque(values, motor.friction, *moving(sample, turned), scene.slip_speed)
        at_joint += at_joints(turned, torque)
    terms = replace(applied(_MOTION, sample, scene), inertias=tuple(inertias)).with_torques(at_joint)
    spinning = ((spin, of[f"{spin.joint.name}.rotor"] * (1.0 / spin.gear)) for spin in spins(model, scene))
    linear = jacobian(loads(sample, with_spins(terms, sample, spinning)).tau, [{each: 1.0} for each in theta])
    others = [effect for effect in plan.effects if effect not in _LINEAR and not effect.by_load]
    massless = replace(at_rest(sample), inertias=tuple(MASSLESS for _ in plan.model.bodies))
    for effect in others:
        massless = effect.add(massless, sample, plan.scene)
    rest = loads(sample, massless).tau
    for effect in plan.effects:
        if effect.by_load:
            rest = [a + b for a, b in zip(rest, plan.missing_without(tape, effect), strict=True)]
    return [*(x for row in linear for x in row), *rest]


_MOTION = (GRAVITY, INERTIA, CORIOLIS, MOVING_BASE)
_LINEAR = (*_MOTION, PAYLOAD, VISCOUS, COULOMB, ROTOR, COUPLED, GYROSCOPIC)
"""The effects that the parameters stand for."""


@lru_cache(maxsize=16)
def parameters(plan: Plan) -> tuple[tuple[str, float], ...]:
    """Return name and value of every parameter, in the order of the columns of Y."""
    model, scene, found = plan.model, plan.scene, []
    sample = plan.sample(Tape())
    for body, (m, mc, I) in zip(model.bodies, applied([PAYLOAD], sample, scene).inertias, strict=True):
        moments = (I[0, 0], I[0, 1], I[0, 2], I[1, 1], I[1, 2], I[2, 2])
        found += [(f"{body.name}.{name}", float(x)) for name, x in zip(INERTIAL, (m, *mc, *moments), strict=True)]
    rotors = {i: inertia for i, _, inertia in armatures(model, scene)}
    motors = [(joint.name, friction, rotors.get(i, 0.0)) for i, joint, friction in joints_with_friction(model, scene)]
    motors += [(motor.name, motor.friction, motor.reflected) for motor in scene.coupled]
    for name, friction, rotor in motors:
        found += [(f"{name}.{each}", getattr(friction, each)) for each in ("viscous", "forward", "backward")]
        found += [] if friction.stribeck is None else [(f"{name}.stribeck", friction.stribeck)]
        found.append((f"{name}.rotor", rotor))
    return tuple(found)


def _motor_torque(
    theta: Iterator[Scalar], friction: Friction, speed: Scalar, acceleration: Scalar, slip_speed: float
) -> Scalar:
    viscous, forward, backward = islice(theta, 3)
    stribeck = None if friction.stribeck is None else next(theta)
    coefficients = replace(friction, forward=forward, backward=backward, stribeck=stribeck)
    dry = coulomb_torque(coefficients, speed, slip_speed)
    return viscous * speed + dry + next(theta) * acceleration
