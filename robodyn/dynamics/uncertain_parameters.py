"""Which parameters of a robot its scene calls uncertain and how far, and the loads of a robot with others.

The parameters x are counted in standard deviations, and change theta, in which loads are linear: the moments of bodies,
friction and rotors.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from statistics import NormalDist
from typing import Any

import numpy as np

from robodyn.dynamics.effects.effect import Sample, Terms
from robodyn.dynamics.effects.friction import coulomb_torque, direction, friction_of
from robodyn.dynamics.effects.motors import at_joints, coupled_motors, moving, spins, with_spins
from robodyn.dynamics.plan import Plan, loads, plan, runner_of
from robodyn.dynamics.regressor import INERTIAL, parameters
from robodyn.errors import SceneError
from robodyn.programs.derivative import jacobian
from robodyn.programs.program import trace
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar, product, total, vector
from robodyn.robot.load import placement
from robodyn.robot.model import Frame, Model
from robodyn.robot.urdf.parts import Inertial, Link
from robodyn.scene.fit import refuse_constraints
from robodyn.scene.parts import Friction
from robodyn.scene.scene import Scene
from robodyn.scene.uncertainty import Covariance, LinkUncertainty, Uncertainty
from robodyn.solids.inertia.laws import Inertia, combined, symmetric
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum
from robodyn.support.wording import alternatives, shown

OF_LINKS = ("mass", "com", "com", "com", "inertia", "inertia", "inertia", "inertia")
"""What varies of a link: mass, centre of mass along x, y and z, a factor of the inertia, and ixx, iyy and izz."""
_DRAWS, _SEED = 1000, 1900


@dataclass(frozen=True)
class Variation:
    """An uncertain parameter, and what one standard deviation of it adds, to first order.

    Attributes:
        name: "forearm.mass", "forearm.com" (of each axis), "forearm.inertia", "elbow.friction", or the regressor's.
        deviation: its standard deviation in SI units; of a factor as a share.
        body, moments: m, mc and I in the order of `INERTIAL` are added to this body; -1 and () if none are.
        joint, friction, rotor: this friction and this reflected inertia [kg m^2] are added at a joint, or to a coupled
            motor; "" if none are.
    """

    name: str
    deviation: float
    body: int = -1
    moments: tuple[float, ...] = ()
    joint: str = ""
    friction: Friction = field(default_factory=Friction)
    rotor: float = 0.0


@dataclass(frozen=True, eq=False)
class UncertainLink:
    """A link whose moments vary, its place in its body, deviations (8,) of `OF_LINKS`, and the first column of x."""

    inertial: Inertial
    frame: Frame
    deviations: Floats
    first: int

    @property
    def varied(self) -> list[int]:
        return np.flatnonzero(self.deviations).tolist()

    def added(self, x: Floats) -> Floats:
        """Return (draws, 10) what is added to the body's moments where what varies is off by x (draws, varied)."""
        off = np.zeros((1 + len(x), len(OF_LINKS)))
        off[1:, self.varied] = x * self.deviations[self.varied]
        (turn, c), mass = placement(self.inertial.origin), self.inertial.mass
        m = mass + off[:, 0]
        growth = (m / mass if mass else np.ones(len(m))) * (1.0 + off[:, 4])
        I_c = product(turn, symmetric(self.inertial.inertia), turn.T) * growth[:, None, None]
        I_c += off[:, 5:, None] * np.eye(3)
        _, R, p = self.frame
        centre = product(c + off[:, 1:4], R.T) + p
        squares = einsum("ni,ni->n", centre, centre)
        apart = squares[:, None, None] * np.eye(3) - centre[:, :, None] * centre[:, None, :]
        I = einsum("ij,njk,lk->nil", R, I_c, R) + m[:, None, None] * apart
        moments = np.column_stack((m, m[:, None] * centre, I[:, (0, 0, 0, 1, 1, 2), (0, 1, 2, 1, 2, 2)]))
        return np.asarray(moments[1:] - moments[0])


@dataclass(frozen=True, eq=False)
class Variations:
    """The uncertain parameters x of a robot, each of variance 1, and how they change theta, in which loads are linear.

    theta has the ten moments (`INERTIAL`) of each body that varies, and an entry of its own for each x at a joint.
    `links` vary otherwise than linearly; `factor` is L with x = L z for independent z, None where x is.
    """

    each: tuple[Variation, ...]
    links: tuple[UncertainLink, ...] = ()
    factor: Floats | None = None

    @cached_property
    def bodies(self) -> tuple[int, ...]:
        return tuple(sorted({variation.body for variation in self.each if variation.moments}))

    @cached_property
    def jacobian(self) -> Floats:
        """(m, k) the derivative of theta by x."""
        at = len(self.bodies) * len(INERTIAL)
        found = np.zeros((at + sum(not each.moments for each in self.each), len(self.each)))
        for k, variation in enumerate(self.each):
            if variation.moments:
                found[self._place(variation.body), k] = variation.moments
            else:
                found[at, k], at = 1.0, at + 1
        return found

    def along(self, changes: Floats) -> Floats:
        """Return derivatives by x (..., k) of what has these by theta (..., m)."""
        flat = changes.reshape(-1, len(self.jacobian))
        found = np.empty((len(flat), len(self.each)))
        for body in (*self.bodies, -1):
            columns = [k for k, variation in enumerate(self.each) if variation.body == body]
            rows = self._place(body)
            found[:, columns] = product(flat[:, rows], self.jacobian[rows][:, columns])
        return found.reshape(*changes.shape[:-1], len(self.each))

    def independent(self, changes: Floats) -> Floats:
        """Return derivatives by independent parameters of variance 1 (..., k) of what has these by theta (..., m)."""
        along = self.along(changes)
        if self.factor is None:
            return along
        return np.asarray(product(along.reshape(-1, len(self.each)), self.factor).reshape(along.shape))

    def spread(self, changes: Floats) -> Floats:
        """Return derivatives (..., p) by uncorrelated numbers that move theta as x does, to all orders.

        Their squares add up to the mean square of how what has the derivatives `changes` by theta (..., m) is off.
        """
        if not self.links:
            return self.independent(changes)
        return np.concatenate([product(changes[..., rows], root) for rows, root in self._roots], -1)

    @cached_property
    def _roots(self) -> list[tuple[slice, Floats]]:
        """The entries of theta of every body, and of joints, each with a root of their mean products."""
        drawn, found = self.theta(self.even_draws(_DRAWS, _SEED)), []
        for rows in map(self._place, (*self.bodies, -1)):
            C = product(drawn[:, rows].T, drawn[:, rows]) / _DRAWS
            sizes = np.sqrt(np.diagonal(C))
            sizes = np.where(sizes > 0.0, sizes, 1.0)
            root = sizes[:, None] * pivoted(C / sizes / sizes[:, None])
            found.append((rows, root[:, root.any(0)]))
        return found

    def variance(self, changes: Floats) -> Floats:
        """Return the variance of what has these derivatives by theta (..., m), to first order."""
        along = self.independent(changes)
        return np.asarray(einsum("...k,...k->...", along, along))

    def theta(self, x: Floats) -> Floats:
        """(draws, m) by how much theta changes with x (draws, k), to all orders."""
        found = product(x, self.jacobian.T)
        for link in self.links:
            columns = slice(link.first, link.first + len(link.varied))
            place = self._place(link.frame.body)
            linear = product(x[:, columns], self.jacobian[place, columns].T)
            found[:, place] += link.added(x[:, columns]) - linear
        return np.asarray(found)

    def _place(self, body: int) -> slice:
        """Return where the moments of a body are in theta; of -1 what is at joints."""
        if body < 0:
            return slice(len(self.bodies) * len(INERTIAL), None)
        at = self.bodies.index(body) * len(INERTIAL)
        return slice(at, at + len(INERTIAL))

    def even_draws(self, count: int, seed: int) -> Floats:
        """Return (count, k) draws of x, each independent parameter in even steps of probability (Latin hypercube)."""
        steps = np.array([NormalDist().inv_cdf((k + 0.5) / count) for k in range(count)])
        rng = np.random.default_rng(seed)
        z = np.column_stack([rng.permutation(steps) for _ in self.each])
        return z if self.factor is None else np.asarray(product(z, self.factor.T))


def pivoted(C: Floats) -> Floats:
    """Return L (k, k) with L L^T = C, a correlation, by Cholesky's method with pivots; it ends where rounding is left.

    What an identification hardly tells apart has correlations near 1, and all that a torque shows of it is what these
    leave: 1e-13 of each variance is not nothing.
    """
    left, L = C.copy(), np.zeros_like(C)
    rounding = len(C) * np.finfo(float).eps
    for column in range(len(C)):
        k = int(np.diag(left).argmax())
        if left[k, k] <= rounding:
            break
        L[:, column] = left[:, k] / np.sqrt(left[k, k])
        left = left - np.outer(L[:, column], L[:, column])
    return L


OF_JOINTS = ("viscous", "forward", "backward", "stribeck", "load", "rotor")
"""Parameters of each hinge and slide, and of each coupled motor."""


def variations(model: Model, scene: Scene) -> Variations:
    """Return what is uncertain of a robot; SceneError if nothing varies, or a covariance names no parameter of it."""
    given = scene.uncertainty or Uncertainty()
    if given.covariance is not None:
        return _of_covariance(given.covariance, model, scene)
    each: list[Variation] = []
    links = []
    for link in model.description.links if model.description else ():
        found = _uncertain(link, given.of_link(link.name), model, len(each))
        if found is not None:
            links.append(found)
            one = np.eye(len(found.varied))  # moments are polynomials of second degree: central differences are exact
            changes = 0.5 * (found.added(one) - found.added(-one))
            for k, change in zip(found.varied, changes.tolist(), strict=True):
                name, deviation = f"{link.name}.{OF_LINKS[k]}", float(found.deviations[k])
                each.append(Variation(name, deviation, found.frame.body, tuple(change)))
    each += _of_friction(given, model, scene)
    if not each:
        what = "[uncertainty] leaves nothing uncertain"
        raise SceneError(what, remedy='give mass = "5 %" to links with mass, or friction = "20 %" to joints with it')
    return Variations(tuple(each), tuple(links))


def _uncertain(link: Link, given: LinkUncertainty, model: Model, first: int) -> UncertainLink | None:
    inertial = link.inertial
    if inertial is None or link.name not in model.links:
        return None
    deviations = np.zeros(len(OF_LINKS))
    if given.mass is not None:
        deviations[0] = given.mass.of(inertial.mass)
    if given.com is not None and inertial.mass:
        deviations[1:4] = given.com.of(float(np.sqrt(np.square(inertial.origin.xyz).sum())))
    if given.inertia is not None:
        deviations[4 if given.inertia.relative else slice(5, 8)] = given.inertia.value
    return UncertainLink(inertial, model.links[link.name], deviations, first) if deviations.any() else None


def _of_friction(given: Uncertainty, model: Model, scene: Scene) -> Iterator[Variation]:
    hinges = (body.joint for body in model.bodies if body.joint.kind in ("revolute", "prismatic"))
    frictions = [(joint.name, friction_of(joint, scene)) for joint in hinges]
    for name, has in (*frictions, *((motor.name, motor.friction) for motor in scene.coupled)):
        own = given.of_joint(name)
        if own is None or not own.value:
            continue
        share = own.value
        added = Friction(0.0, share, -share)
        if own.relative:
            stribeck = None if has.stribeck is None else share * has.stribeck
            parts = {part: share * getattr(has, part) for part in ("viscous", "forward", "backward", "load")}
            added = replace(has, stribeck=stribeck, **parts)
        if added.viscous or added.dry or added.load:
            yield Variation(f"{name}.friction", share, joint=name, friction=added)


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


_MISFIT = 5.0
"""Standard errors from a parameter's value in a covariance file, beyond which that is another robot's."""


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
    kept = np.flatnonzero(deviations)
    each = tuple(_named(given.parameters[k], float(deviations[k]), model, scene) for k in kept)
    if not each:
        raise SceneError("[uncertainty] covariance leaves nothing uncertain: all variances are 0")
    sizes = deviations[kept]
    correlation = given.covariance[np.ix_(kept, kept)] / (sizes[:, None] * sizes)
    factor = None if np.array_equal(correlation, np.eye(len(each))) else pivoted(correlation)
    return Variations(each, (), factor)


def _named(name: str, deviation: float, model: Model, scene: Scene) -> Variation:
    """Return what a parameter of the regressor adds."""
    owner, _, quantity = name.rpartition(".")
    if quantity in INERTIAL:
        body = next(k for k, body in enumerate(model.bodies) if body.name == owner)
        moments = tuple(deviation if each == quantity else 0.0 for each in INERTIAL)
        return Variation(name, deviation, body, moments)
    if quantity == "rotor":
        return Variation(name, deviation, joint=owner, rotor=deviation)
    frictions = {body.joint.name: friction_of(body.joint, scene) for body in model.bodies}
    has = (frictions | {motor.name: motor.friction for motor in scene.coupled})[owner]
    stribeck = None if has.stribeck is None else 0.0
    none = replace(has, viscous=0.0, forward=0.0, backward=0.0, stribeck=stribeck, load=0.0)
    return Variation(name, deviation, joint=owner, friction=replace(none, **{quantity: deviation}))


Row = Sequence[tuple[int, float]]
"""A sum of loads, each by its number and its weight; loads are numbered as `Plan.wrenches` has them, with joints."""


def summed(rows: Iterable[Row], loads: Sequence[Any]) -> list[Any]:
    return [total(loads[k] if weight == 1.0 else weight * loads[k] for k, weight in row) for row in rows]


def derivative_runner(a_plan: Plan, found: Variations, rows: Sequence[Row]) -> Runner:
    """Return the derivatives of sums of loads at a given `theta`, for each sum in turn those by all of theta."""
    refuse_constraints(a_plan.scene)

    def outputs(tape: Tape) -> Iterable[Scalar]:
        theta = [tape.input("theta", k) for k, _ in enumerate(found.jacobian)]
        sums = summed(rows, _loads(a_plan, tape, theta, found))
        return [entry for row in jacobian(sums, [{each: 1.0} for each in theta]) for entry in row]

    return runner_of(trace(outputs), a_plan, {"theta": len(found.jacobian)})


def _loads(a_plan: Plan, tape: Tape, theta: Sequence[Scalar], found: Variations) -> list[Scalar]:
    sample, terms = a_plan.terms(tape)
    inertias, width = list(terms.inertias), len(INERTIAL)
    for k, body in enumerate(found.bodies):
        m, x, y, z, *moments = theta[width * k : width * (k + 1)]
        inertias[body] = combined((inertias[body], Inertia(m, vector(x, y, z), symmetric(moments))))
    of_joints = [each for each in found.each if not each.moments]
    terms = replace(terms, inertias=tuple(inertias))
    result = loads(sample, _with_joints(terms, sample, a_plan, theta[width * len(found.bodies) :], of_joints))
    return [*result.tau, *(scalar for wrench in result.reactions for part in wrench for scalar in part)]


def _with_joints(terms: Terms, sample: Sample, a_plan: Plan, x: Sequence[Scalar], each: Sequence[Variation]) -> Terms:
    """The terms with more friction, which is linear in its coefficients, and more inertia of rotors."""
    of = {body.joint.name: [(i, body.joint, 1.0)] for i, body in enumerate(sample.model.bodies)}
    of |= {motor.name: turned for motor, turned in coupled_motors(sample.model, a_plan.scene)}
    torques: list[tuple[int, Scalar]] = []
    spinning, load = [], dict(terms.load)
    rotors = {spin.joint.name: spin for spin in spins(sample.model, a_plan.scene)}
    for scalar, variation in zip(x, each, strict=True):
        turned, friction = of[variation.joint], variation.friction
        speed, acceleration = moving(sample, turned)
        dry = coulomb_torque(friction, speed, a_plan.scene.slip_speed) if friction.dry else 0.0
        torque = friction.viscous * speed + dry + variation.rotor * acceleration
        torques += at_joints(turned, scalar * torque)
        if friction.load:
            i, way = turned[0][0], direction(speed, a_plan.scene.slip_speed)
            load[i] = load.get(i, 0.0) + scalar * (friction.load * way)
        if variation.rotor and variation.joint in rotors:
            spin = rotors[variation.joint]
            spinning.append((spin, scalar * (variation.rotor / spin.gear)))
    return with_spins(replace(terms, load=load).with_torques(torques), sample, spinning)
