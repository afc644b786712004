"""Springs at joints and their limits; wrenches ON links: of surroundings, of fluids, of loops and contacts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.programs.vectors import Array, Scalar, cross, sign, total
from robodyn.robot.kinematics import Motion, Wrench, poses, velocities
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import Entry, ExternalWrench, LimitSpring, Scene, Spring


class JointSpring(Effect):
    """A torque k (q - q0) that the actuator must hold."""

    name, adds = "joint spring", "k (q - q0)"

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        names = [joint.name for _, joint, _ in _sprung(model, scene)]
        return Verdict.of(names, "the scene has no spring", f"springs at {', '.join(names)}")

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        each = _sprung(sample.model, scene)
        torques = ((i, spring.stiffness * (sample.position(joint) - spring.rest)) for i, joint, spring in each)
        return terms.with_torques(torques, through_gear=True)

    def stored(self, sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
        """sum k (q - q0)^2 / 2 [J]."""
        stretched = ((k, sample.position(joint) - k.rest) for _, joint, k in _sprung(sample.model, scene))
        return total((0.5 * spring.stiffness) * (stretch * stretch) for spring, stretch in stretched)


def _sprung(model: Model, scene: Scene) -> Iterator[tuple[int, Joint, Spring]]:
    for i, body in enumerate(model.bodies):
        spring = scene.spring.get(body.joint.name)
        if spring is not None and spring.stiffness:
            yield i, body.joint, spring


class Stop(NamedTuple):
    """A limit with its spring; `side` is -1 or 1, `value` the joint's position there."""

    body: int
    joint: Joint
    side: float
    value: float
    spring: LimitSpring

    def beyond(self, sample: Sample) -> tuple[Scalar, Scalar]:
        """Return how far the joint is beyond the limit, negative within, and the rate of that."""
        return self.side * (sample.position(self.joint) - self.value), self.side * sample.speed(self.joint)

    def torque(self, x: Scalar, xd: Scalar) -> Scalar:
        """`max(stiffness x + damping xd, 0)` for x > 0, else 0 [N m], without a branch."""
        push = self.spring.stiffness * x + self.spring.damping * xd
        return _positive(push) * (0.5 * (sign(x) * sign(x) + sign(x)))


def _positive(x: Scalar) -> Scalar:
    """max(x, 0)."""
    return 0.5 * (x + x * sign(x))


def _stops(model: Model, scene: Scene) -> Iterator[Stop]:
    for i, body in enumerate(model.bodies):
        for side, value in ((-1.0, body.joint.lower), (1.0, body.joint.upper)):
            if scene.limit_spring is not None and value is not None:
                yield Stop(i, body.joint, side, value, scene.limit_spring)


class LimitSpringEffect(Effect):
    """A torque that pushes a joint back which is beyond a limit, and never pulls it there."""

    name, adds = "limit spring", "max(k x + d xd, 0) where a joint is beyond a limit by x"

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        if scene.limit_spring is None:
            return Verdict(False, "the scene has no springs at joint limits")
        count = len(list(_stops(model, scene)))
        return Verdict.of(count, "no joint has a limit", f"springs at {count} joint limits")

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        torques = ((stop.body, stop.side * stop.torque(*stop.beyond(sample))) for stop in _stops(sample.model, scene))
        return terms.with_torques(torques, through_gear=True)

    def stored(self, sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
        """sum k x^2 / 2 over the limits that are passed by x > 0 [J]."""
        stretched = ((stop.spring, _positive(stop.beyond(sample)[0])) for stop in _stops(sample.model, scene))
        return total((0.5 * spring.stiffness) * (stretch * stretch) for spring, stretch in stretched)

    def lost(self, sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
        """sum of xd times what damping adds to the push of the springs [W]."""
        power: Scalar = 0.0
        for stop in _stops(sample.model, scene):
            x, xd = stop.beyond(sample)
            power = power + (stop.torque(x, xd) - stop.spring.stiffness * _positive(x)) * xd
        return power


SPRING, LIMIT_SPRING = JointSpring(), LimitSpringEffect()


def acting(scene: Scene, cause: str) -> list[ExternalWrench]:
    """The wrenches of one cause that are not nothing."""
    return [each for each in scene.wrenches if each.cause == cause and (any(each.force) or any(each.moment))]


class WrenchEffect(Effect):
    """The scene's wrenches of one cause."""

    def __init__(self, name: str, cause: str, none: str, adds: str) -> None:
        """Args: none: why it is off where there is none."""
        self.name, self.cause, self.none, self.adds = name, cause, none, adds

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        links = dict.fromkeys(wrench.link for wrench in acting(scene, self.cause))
        return Verdict.of(links, self.none, f"acts on {', '.join(links)}")

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        where = poses(sample.model.parents, sample.motions())
        more = []
        for wrench in acting(scene, self.cause):
            body, R, p = sample.model.links[wrench.link]
            if wrench.axes:
                other, turn, _ = sample.model.links[wrench.axes]
                axes = where[body].R.T @ (where[other].R @ turn)
            else:
                axes = {"link": R, "base": where[body].R.T @ where[0].R, "world": where[body].R.T}[wrench.frame]
            f = axes @ _entries(wrench.force, sample)
            n = axes @ _entries(wrench.moment, sample) + cross(p + R @ np.array(wrench.point), f)
            more.append((body, Wrench(f, n)))
        return replace(terms, wrenches=(*terms.wrenches, *more))


def _entries(entries: tuple[Entry, Entry, Entry], sample: Sample) -> Array:
    return np.array([sample.columns[entry] if isinstance(entry, str) else float(entry) for entry in entries])


class Fluid(Effect):
    """Buoyancy and quadratic drag on links in still or streaming water or air."""

    name, adds = "fluid", "buoyancy -rho V g and drag rho/2 C_d A v^2 against the motion, link by link"

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        links = [immersed.link for immersed in scene.immersed if immersed.volume or any(immersed.drag_area)]
        some = f"{scene.fluid_density:g} kg/m^3 around {', '.join(links)}"
        return Verdict.of(scene.fluid_density and links, "the scene has no fluid", some)

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        """Buoyancy and drag -rho/2 C_d A_k |u_k| u_k along each axis k of a link, both at its centre of volume. u is
        the centre's velocity relative to the fluid, in the link's axes."""
        joints = sample.motions()
        where, moving = poses(sample.model.parents, joints), velocities(sample.model.parents, joints)
        acting = []
        for immersed in scene.immersed:
            body, R, p = sample.model.links[immersed.link]
            to_body, (w, v) = where[body].R.T, moving[body]
            centre = p + R @ np.array(immersed.centre)
            u = R.T @ (v + cross(w, centre) - to_body @ np.array(scene.fluid_velocity, dtype=float))
            area = 0.5 * scene.fluid_density * np.array(immersed.drag_area)
            drag = np.array([-(c * (sign(x) * (x * x))) for c, x in zip(area, u, strict=True)])
            weight = scene.fluid_density * immersed.volume * np.array(scene.gravity)
            f = R @ drag + to_body @ -weight
            acting.append((body, Wrench(f, cross(centre, f))))
        return replace(terms, wrenches=(*terms.wrenches, *acting))


_ADDS = "-J^T w for a force and a moment that act on a link"
EXTERNAL = WrenchEffect("external wrench", "surroundings", "the scene has no external wrench", _ADDS)
LOOPS = WrenchEffect("loop forces", "loop", "no loop is closed", "-J^T lambda of the forces that close loops")
CONTACTS = WrenchEffect("contact forces", "contact", "no link stands on anything", "-J^T f of what links stand on")
FLUID = Fluid()
