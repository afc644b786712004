"""Which parameters of a robot its scene calls uncertain, and how far."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from robodyn.dynamics.effects.friction import friction_of
from robodyn.dynamics.plan import plan
from robodyn.dynamics.regressor import INERTIAL, parameters
from robodyn.dynamics.variations import OF_LINKS, UncertainLink, Variation, Variations, pivoted
from robodyn.errors import SceneError
from robodyn.robot.model import Model
from robodyn.robot.urdf.parts import Link
from robodyn.scene.parts import Friction
from robodyn.scene.scene import Scene
from robodyn.scene.uncertainty import Covariance, LinkUncertainty, Uncertainty
from robodyn.support.wording import alternatives, shown

OF_JOINTS = ("viscous", "forward", "backward", "stribeck", "load", "rotor")
"""Parameters of each hinge and slide, and of each coupled motor."""


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
