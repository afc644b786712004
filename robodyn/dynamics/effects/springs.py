"""Springs: those that hold a joint, and those that push it back from beyond its limits."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.programs.vectors import Scalar, sign, total
from robodyn.robot.kinematics import Motion
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import LimitSpring, Scene, Spring


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


JOINT, LIMIT = JointSpring(), LimitSpringEffect()
