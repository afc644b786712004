"""The uncertain parameters of a robot, counted in standard deviations, and draws of all of them together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from robodyn.dynamics.effects.viscous_friction import friction_of
from robodyn.dynamics.regressor import INERTIAL
from robodyn.errors import SceneError
from robodyn.programs.vectors import product
from robodyn.robot.joints import placement
from robodyn.robot.model import Frame, Model
from robodyn.robot.urdf.parts import Inertial, Link
from robodyn.scene.covariance import Covariance
from robodyn.scene.parts import Friction
from robodyn.scene.scene import Scene
from robodyn.scene.uncertainty import LinkUncertainty, Uncertainty
from robodyn.solids.inertia.laws import symmetric
from robodyn.support.floats import Floats
from robodyn.support.wording import alternatives, shown

OF_LINKS = ("mass", "com", "com", "com", "inertia", "inertia", "inertia", "inertia")
"""What varies of a link: mass, centre of mass along x, y and z, a factor of the inertia, and ixx, iyy and izz."""
OF_JOINTS = ("viscous", "forward", "backward", "stribeck", "rotor")


@dataclass(frozen=True)
class Variation:
    """An uncertain parameter, and what one standard deviation of it adds, to first order.

    Attributes:
        name: "forearm.mass", "forearm.com" (of each axis), "forearm.inertia", "elbow.friction", or the regressor's.
        deviation: its standard deviation in SI units; of a factor as a share.
        body, moments: m, mc and I in the order of `INERTIAL` are added to this body; -1 and () if none are.
        joint, friction, rotor: this friction and this reflected inertia [kg m^2] are added at a joint; "" if none are.
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
    """A link whose moments vary.

    Attributes:
        frame: its place in the body that it is part of.
        deviations: (8,) of `OF_LINKS`.
        first: the column of x that belongs to the first of them that is not zero.
    """

    inertial: Inertial
    frame: Frame
    deviations: Floats
    first: int

    @property
    def varied(self) -> list[int]:
        """The places in `OF_LINKS` of what varies."""
        return [int(k) for k in np.flatnonzero(self.deviations)]

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
        squares = np.einsum("ni,ni->n", centre, centre)
        apart = squares[:, None, None] * np.eye(3) - centre[:, :, None] * centre[:, None, :]
        I = np.einsum("ij,njk,lk->nil", R, I_c, R) + m[:, None, None] * apart
        moments = np.column_stack((m, m[:, None] * centre, I[:, (0, 0, 0, 1, 1, 2), (0, 1, 2, 1, 2, 2)]))
        return np.asarray(moments[1:] - moments[0])


@dataclass(frozen=True, eq=False)
class Variations:
    """The uncertain parameters x of a robot, each of variance 1, and how they change theta, in which loads are linear.

    theta has the ten moments (`INERTIAL`) of each body that varies, and an entry of its own for each x at a joint.

    Attributes:
        each: in the order of the columns of x.
        links: those that vary otherwise than linearly.
        factor: L with x = L z for independent z; None where x is independent.
    """

    each: tuple[Variation, ...]
    links: tuple[UncertainLink, ...] = ()
    factor: Floats | None = None

    @cached_property
    def bodies(self) -> tuple[int, ...]:
        """The bodies that vary."""
        return tuple(sorted({variation.body for variation in self.each if variation.moments}))

    @cached_property
    def jacobian(self) -> Floats:
        """(m, k) the derivative of theta by x."""
        found = np.zeros(
            (len(self.bodies) * len(INERTIAL) + sum(not each.moments for each in self.each), len(self.each))
        )
        at = len(self.bodies) * len(INERTIAL)
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

    def variance(self, changes: Floats) -> Floats:
        """Return the variance of what has these derivatives by theta (..., m), to first order."""
        along = self.along(changes)
        if self.factor is not None:
            along = product(along.reshape(-1, len(self.each)), self.factor).reshape(along.shape)
        return np.asarray(np.einsum("...k,...k->...", along, along))

    def theta(self, x: Floats) -> Floats:
        """Return (draws, m) by how much theta changes with x (draws, k), to all orders."""
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

    def draws(self, count: int, seed: int) -> Floats:
        """Return (count, k) normal draws of x, the same for the same seed."""
        z = np.random.default_rng(seed).standard_normal((count, len(self.each)))
        return z if self.factor is None else np.asarray(product(z, self.factor.T))

    @cached_property
    def correlation(self) -> Floats:
        """(k, k) of x."""
        return np.eye(len(self.each)) if self.factor is None else np.asarray(product(self.factor, self.factor.T))


def variations(model: Model, scene: Scene) -> Variations:
    """Return what is uncertain of a robot in a scene that says so.

    Raises:
        SceneError: nothing varies; or a covariance names a parameter that is none.
    """
    given = scene.uncertainty or Uncertainty()
    if given.covariance is not None:
        return _of_covariance(given.covariance, model, scene)
    each: list[Variation] = []
    links = []
    for link in model.description.links if model.description else ():
        found = _uncertain(link, given.of_link(link.name), model, len(each))
        if found is not None:
            links.append(found)
            each += _of_link(link.name, found)
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


def _of_link(name: str, link: UncertainLink) -> Iterator[Variation]:
    """Yield what varies of a link. Moments are polynomials of second degree, whose central differences are exact."""
    one = np.eye(len(link.varied))
    changes = 0.5 * (link.added(one) - link.added(-one))
    for k, change in zip(link.varied, changes.tolist(), strict=True):
        yield Variation(f"{name}.{OF_LINKS[k]}", float(link.deviations[k]), link.frame.body, tuple(change))


def _of_friction(given: Uncertainty, model: Model, scene: Scene) -> Iterator[Variation]:
    for body in model.bodies:
        joint = body.joint
        own = given.of_joint(joint.name) if joint.kind in ("revolute", "prismatic") else None
        if own is None or not own.value:
            continue
        has = friction_of(joint, scene)
        share = own.value
        added = Friction(0.0, share, -share)
        if own.relative:
            stribeck = None if has.stribeck is None else share * has.stribeck
            added = replace(
                has, viscous=share * has.viscous, forward=share * has.forward, backward=share * has.backward
            )
            added = replace(added, stribeck=stribeck)
        if added.viscous or added.dry:
            yield Variation(f"{joint.name}.friction", share, joint=joint.name, friction=added)


def _of_covariance(given: Covariance, model: Model, scene: Scene) -> Variations:
    deviations = np.sqrt(np.diag(given.covariance))
    known = {f"{body.name}.{name}" for body in model.bodies for name in INERTIAL}
    hinges = [body.joint for body in model.bodies if body.joint.kind in ("revolute", "prismatic")]
    known |= {f"{joint.name}.{name}" for joint in hinges for name in OF_JOINTS}
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
    factor = None if np.array_equal(correlation, np.eye(len(each))) else _factor(correlation)
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
    joint = next(body.joint for body in model.bodies if body.joint.name == owner)
    has = friction_of(joint, scene)
    none = replace(has, viscous=0.0, forward=0.0, backward=0.0, stribeck=None if has.stribeck is None else 0.0)
    return Variation(name, deviation, joint=owner, friction=replace(none, **{quantity: deviation}))


def _factor(C: Floats) -> Floats:
    """Return L (k, k) with L L^T = C, positive semi-definite, by Cholesky's method with pivots.

    It ends where nothing is left.
    """
    left, L = C.copy(), np.zeros_like(C)
    for column in range(len(C)):
        k = int(np.diag(left).argmax())
        if left[k, k] <= 1e-12:
            break
        L[:, column] = left[:, k] / np.sqrt(left[k, k])
        left = left - np.outer(L[:, column], L[:, column])
    return L
