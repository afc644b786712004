"""The parameters of a robot: the regressor, torques as a matrix times those in which they are linear; and those that a
scene calls uncertain, counted in standard deviations, with the derivatives of loads by them, to first order."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robodyn.dynamics.arrays import arrays_of, results
from robodyn.dynamics.effects.friction import (
    COULOMB,
    VISCOUS,
    coulomb_torque,
    direction,
    friction_of,
    joints_with_friction,
)
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
from robodyn.dynamics.plan import Plan, applied, at_rest, loads, plan, ready, runner_of
from robodyn.errors import SceneError
from robodyn.programs.derivative import jacobian
from robodyn.programs.program import trace, traced
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import IDENTITY, Scalar, length, product, total, vector
from robodyn.robot.load import placement
from robodyn.robot.model import Frame, Model
from robodyn.robot.urdf.parts import Inertial
from robodyn.scene.fit import refuse_constraints
from robodyn.scene.scene import DEFAULT, Friction, Scene
from robodyn.scene.uncertainty import Covariance, LinkUncertainty, Uncertainty
from robodyn.solids.inertia.laws import MASSLESS, Inertia, combined, inertia_of, symmetric
from robodyn.support.floats import Floats, einsum
from robodyn.support.wording import alternatives, shown

INERTIAL = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")
"""Of each body: mass [kg], first moments [kg m], and moments about its frame's origin [kg m^2], in its axes."""
_MOTION = (GRAVITY, INERTIA, CORIOLIS, MOVING_BASE)
_LINEAR = (*_MOTION, PAYLOAD, VISCOUS, COULOMB, ROTOR, COUPLED, GYROSCOPIC)
"""The effects that the parameters stand for."""
OF_JOINTS = ("viscous", "forward", "backward", "stribeck", "load", "rotor")
"""Parameters of each hinge and slide, and of each coupled motor."""
_MISFIT = 5.0
"""Standard errors from a parameter's value in a covariance file, beyond which that is another robot's."""
Row = Sequence[tuple[int, float]]
"""A sum of loads, each by its number and its weight; loads are numbered as `Plan.wrenches` has them, with joints."""


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

    theta has ten parameters of each body (`INERTIAL`, with its payloads), of each hinge, slide and coupled motor
    `viscous`, `forward` and `backward` (Coulomb's torque at qd > 0 and, with its sign, at qd < 0) and, where the scene
    names it, `stribeck`; and `rotor`, the inertia of its rotor times the square of the gear [kg m^2], with its
    gyroscopic moments where the scene says its axis. Args, errors: as for `inverse_dynamics`.

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


@dataclass(frozen=True)
class Variation:
    """An uncertain parameter, and what one standard deviation of it adds, to first order.

    name: "forearm.mass", "forearm.com" (of each axis), "forearm.inertia", "elbow.friction", or the regressor's;
    deviation: in SI units, of a factor as a share; moments: m, mc and I, as `INERTIAL`, added to a body, -1 and () if
    none are; friction, rotor [kg m^2]: added at a joint or to a coupled motor, "" if none are.
    """

    name: str
    deviation: float
    body: int = -1
    moments: tuple[float, ...] = ()
    joint: str = ""
    friction: Friction = field(default_factory=Friction)
    rotor: float = 0.0


@dataclass(frozen=True, eq=False)
class Variations:
    """The uncertain parameters x, each of variance 1; `factor` is L with x = L z for independent z, None where x is."""

    each: tuple[Variation, ...]
    factor: Floats | None = None

    def independent(self, changes: Floats) -> Floats:
        """Return derivatives by independent parameters of variance 1 of what has these by x (..., k)."""
        return changes if self.factor is None else changes @ self.factor

    def variance(self, changes: Floats) -> Floats:
        """Return the variance of what has these derivatives by x (..., k)."""
        along = self.independent(changes)
        return np.asarray(einsum("...k,...k->...", along, along))

    def even_draws(self, count: int, seed: int) -> Floats:
        """Return (count, k) draws of x, each independent parameter in even steps of probability (Latin hypercube)."""
        from statistics import NormalDist

        steps = np.array([NormalDist().inv_cdf((k + 0.5) / count) for k in range(count)])
        rng = np.random.default_rng(seed)
        z = np.column_stack([rng.permutation(steps) for _ in self.each])
        return z if self.factor is None else np.asarray(product(z, self.factor.T))


def pivoted(C: Floats) -> Floats:
    """L (k, k) with L L^T = C, a correlation, by Cholesky's method with pivots, which ends where rounding is left:
    parameters that an identification hardly tells apart have correlations near 1, and what these leave is all that a
    torque shows."""
    left, L = C.copy(), np.zeros_like(C)
    rounding = len(C) * np.finfo(float).eps
    for column in range(len(C)):
        k = int(np.diag(left).argmax())
        if left[k, k] <= rounding:
            break
        L[:, column] = left[:, k] / np.sqrt(left[k, k])
        left = left - np.outer(L[:, column], L[:, column])
    return L


def variations(model: Model, scene: Scene) -> Variations:
    """Return what is uncertain of a robot; SceneError if nothing varies, or a covariance names no parameter of it."""
    given = scene.uncertainty or Uncertainty()
    if given.covariance is not None:
        return _of_covariance(given.covariance, model, scene)
    each: list[Variation] = []
    for link in model.description.links if model.description else ():
        if link.inertial is not None and link.name in model.links:
            each += _of_link(link.name, link.inertial, given.of_link(link.name), model.links[link.name])
    hinges = (body.joint for body in model.bodies if body.joint.kind in ("revolute", "prismatic"))
    frictions = [(joint.name, friction_of(joint, scene)) for joint in hinges]
    for name, has in (*frictions, *((motor.name, motor.friction) for motor in scene.coupled)):
        own = given.joint.get(name, given.friction)
        if own is None or not own.value:
            continue
        share = own.value
        added = Friction(0.0, share, -share)
        if own.relative:
            stribeck = None if has.stribeck is None else share * has.stribeck
            parts = {part: share * getattr(has, part) for part in ("viscous", "forward", "backward", "load")}
            added = replace(has, stribeck=stribeck, **parts)
        if added.viscous or added.dry or added.load:
            each.append(Variation(f"{name}.friction", share, joint=name, friction=added))
    if not each:
        what = "[uncertainty] leaves nothing uncertain"
        raise SceneError(what, remedy='give mass = "5 %" to links with mass, or friction = "20 %" to joints with it')
    return Variations(tuple(each))


def _of_link(name: str, inertial: Inertial, given: LinkUncertainty, frame: Frame) -> Iterator[Variation]:
    """Yield the derivatives of a link's moments by its mass (radii of gyration kept), its mass centre and inertia."""
    (turn, c), mass, (body, R, p) = placement(inertial.origin), inertial.mass, frame
    I_c = product(turn, symmetric(inertial.inertia), turn.T)

    def varied(quantity: str, deviation: float, changed: Inertia) -> Variation:
        I = changed.I[np.triu_indices(3)]
        return Variation(f"{name}.{quantity}", deviation, body, tuple(map(float, (changed.m, *changed.mc, *I))))

    if given.mass is not None and (deviation := given.mass.of(mass)):
        growth = deviation / mass if mass else 0.0
        yield varied("mass", deviation, inertia_of(deviation, c, growth * I_c, R, p))
    if given.com is not None and mass and (deviation := given.com.of(length(c))):
        for axis in IDENTITY:
            there, back = (
                inertia_of(0.5 * sign * mass, c + sign * deviation * axis, np.zeros((3, 3)), R, p) for sign in (1, -1)
            )
            yield varied("com", deviation, combined((there, back)))  # of second degree: central differences are exact
    if given.inertia is not None and (deviation := given.inertia.value):
        for more in [I_c] if given.inertia.relative else [np.outer(axis, axis) for axis in IDENTITY]:
            yield varied("inertia", deviation, inertia_of(0.0, c, deviation * more, R, p))


def misfits(model: Model, scene: Scene) -> tuple[str, ...]:
    """Return a warning if the covariance was found for a robot with other parameters, further off than its errors."""
    known = scene.uncertainty.covariance if scene.uncertainty else None
    if known is None:
        return ()
    here = dict(parameters(plan(model, scene)))
    errors = np.sqrt(np.diag(known.covariance))
    rows = zip(known.parameters, known.values.tolist(), errors.tolist(), strict=True)
    off = {name: abs(here[name] - value) / error for name, value, error in rows if name in here and error > 0.0}
    worst = max(off, key=lambda name: off[name], default="")
    if not worst or off[worst] <= _MISFIT:
        return ()
    there = known.values[known.parameters.index(worst)]
    what = f"the covariance of [uncertainty] was found for other parameters: {shown(worst)} {there:.4g}, here"
    return (f"{what} {here[worst]:.4g}, {off[worst]:.3g} standard errors apart",)


def _of_covariance(given: Covariance, model: Model, scene: Scene) -> Variations:
    deviations = np.sqrt(np.diag(given.covariance))
    known = {f"{body.name}.{name}" for body in model.bodies for name in INERTIAL}
    hinges = [body.joint.name for body in model.bodies if body.joint.kind in ("revolute", "prismatic")]
    motors = [motor.name for motor in scene.coupled]
    known |= {f"{owner}.{name}" for owner in (*hinges, *motors) for name in OF_JOINTS}
    for name in given.parameters:
        if name not in known:
            remedy = alternatives(name, sorted(known), "parameters")
            raise SceneError(f"[uncertainty] covariance: the robot has no parameter {shown(name)}", remedy=remedy)
    kept, each = np.flatnonzero(deviations), []
    frictions = {body.joint.name: friction_of(body.joint, scene) for body in model.bodies}
    frictions |= {motor.name: motor.friction for motor in scene.coupled}
    for name, deviation in ((given.parameters[k], float(deviations[k])) for k in kept):
        owner, _, quantity = name.rpartition(".")
        if quantity in INERTIAL:
            body = next(k for k, body in enumerate(model.bodies) if body.name == owner)
            moments = tuple(deviation if part == quantity else 0.0 for part in INERTIAL)
            each.append(Variation(name, deviation, body, moments))
        elif quantity == "rotor":
            each.append(Variation(name, deviation, joint=owner, rotor=deviation))
        else:
            has = frictions[owner]
            stribeck = None if has.stribeck is None else 0.0
            none = replace(has, viscous=0.0, forward=0.0, backward=0.0, stribeck=stribeck, load=0.0)
            each.append(Variation(name, deviation, joint=owner, friction=replace(none, **{quantity: deviation})))
    if not each:
        raise SceneError("[uncertainty] covariance leaves nothing uncertain: all variances are 0")
    sizes = deviations[kept]
    correlation = given.covariance[np.ix_(kept, kept)] / (sizes[:, None] * sizes)
    factor = None if np.array_equal(correlation, np.eye(len(each))) else pivoted(correlation)
    return Variations(tuple(each), factor)


def summed(rows: Iterable[Row], loads: Sequence[Any]) -> list[Any]:
    return [total(loads[k] if weight == 1.0 else weight * loads[k] for k, weight in row) for row in rows]


def derivative_runner(a_plan: Plan, found: Variations, rows: Sequence[Row]) -> Runner:
    """Return the derivatives of sums of loads at a given `x`, for each sum in turn those by all of x."""
    refuse_constraints(a_plan.scene)

    def outputs(tape: Tape) -> Iterable[Scalar]:
        x = [tape.input("x", k) for k in range(len(found.each))]
        sums = summed(rows, _loads(a_plan, tape, x, found))
        return [entry for row in jacobian(sums, [{each: 1.0} for each in x]) for entry in row]

    return runner_of(trace(outputs), a_plan, {"x": len(found.each)})


def _loads(a_plan: Plan, tape: Tape, x: Sequence[Scalar], found: Variations) -> list[Scalar]:
    """Loads with more mass, more friction, which is linear in its coefficients, and more inertia of rotors."""
    sample, terms = a_plan.terms(tape)
    model, scene = sample.model, a_plan.scene
    inertias, load = list(terms.inertias), dict(terms.load)
    added: dict[int, list[Scalar]] = {}
    of = {body.joint.name: [(i, body.joint, 1.0)] for i, body in enumerate(model.bodies)}
    of |= {motor.name: turned for motor, turned in coupled_motors(model, scene)}
    rotors = {spin.joint.name: spin for spin in spins(model, scene)}
    torques: list[tuple[int, Scalar]] = []
    spinning = []
    for scalar, variation in zip(x, found.each, strict=True):
        if variation.moments:
            before = added.get(variation.body, [0.0] * len(INERTIAL))
            pairs = zip(before, variation.moments, strict=True)
            added[variation.body] = [old + change * scalar if change else old for old, change in pairs]
            continue
        turned, friction = of[variation.joint], variation.friction
        speed, acceleration = moving(sample, turned)
        dry = coulomb_torque(friction, speed, scene.slip_speed) if friction.dry else 0.0
        torque = friction.viscous * speed + dry + variation.rotor * acceleration
        torques += at_joints(turned, scalar * torque)
        if friction.load:
            i, way = turned[0][0], direction(speed, scene.slip_speed)
            load[i] = load.get(i, 0.0) + scalar * (friction.load * way)
        if variation.rotor and variation.joint in rotors:
            spin = rotors[variation.joint]
            spinning.append((spin, scalar * (variation.rotor / spin.gear)))
    for body, (m, *mc, xx, xy, xz, yy, yz, zz) in added.items():
        more = Inertia(m, vector(*mc), symmetric((xx, xy, xz, yy, yz, zz)))
        inertias[body] = combined((inertias[body], more))
    terms = replace(terms, inertias=tuple(inertias), load=load).with_torques(torques)
    result = loads(sample, with_spins(terms, sample, spinning))
    return [*result.tau, *(scalar for wrench in result.reactions for part in wrench for scalar in part)]
