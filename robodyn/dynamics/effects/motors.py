"""Motors: rotors that their joints turn, motors that turn with several joints, and gyroscopic moments of rotors.

Rotors turn G times as fast as their joints and add G^2 J qdd. Their gyroscopic moments on the links are added where a
scene says a rotor's axis; without, they are no part of the model, as in MuJoCo's armature and the Robotics Toolbox.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.dynamics.effects.friction import coulomb_torque
from robodyn.programs.vectors import IDENTITY, ZERO, Array, Scalar, cross, length, product, total
from robodyn.robot.kinematics import Motion, Wrench, accelerations, poses, velocities
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import CoupledMotor, Scene

Turned = tuple[int, Joint, float]
"""A body, its joint, and how much a motor turns per turn of it, its gear aside."""


def rotor_of(joint: Joint, scene: Scene) -> tuple[float, float]:
    """The rotor inertia [kg m^2] and the gear ratio of a joint: the scene's word, else its transmission's."""
    rotor = scene.rotor.get(joint.name)
    inertia, gear = (None, None) if rotor is None else (rotor.inertia, rotor.ratio)
    return joint.rotor_inertia if inertia is None else inertia, joint.reduction if gear is None else gear


def armatures(model: Model, scene: Scene) -> Iterator[tuple[int, Joint, float]]:
    """Yield the body, joint and reflected inertia G^2 J [kg m^2] of every joint that has a rotor."""
    for i, body in enumerate(model.bodies):
        joint = body.joint
        inertia, gear = rotor_of(joint, scene)
        if inertia and gear:
            yield i, joint, gear * gear * inertia


class RotorInertia(Effect):
    """G^2 J qdd of rotors on joints of their own."""

    name, adds = "rotor inertia", "G^2 J qdd"

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        joints = [joint for _, joint, _ in armatures(model, scene)]
        none, some = "neither the scene nor a transmission has a rotor inertia", "joints with rotors"
        return Verdict.of_joints(joints, ("qdd", zero_columns), none, "no joint with a rotor accelerates", some)

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        return terms.with_torques(
            (i, armature * sample.acceleration(joint)) for i, joint, armature in armatures(sample.model, scene)
        )

    def stored(self, sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
        """sum G^2 J qd^2 / 2 [J]."""
        turning = ((armature, sample.speed(joint)) for _, joint, armature in armatures(sample.model, scene))
        return total((0.5 * armature) * (speed * speed) for armature, speed in turning)


def coupled_motors(model: Model, scene: Scene) -> Iterator[tuple[CoupledMotor, list[Turned]]]:
    joints = [(i, body.joint) for i, body in enumerate(model.bodies)]
    for motor in scene.coupled:
        yield motor, [(i, joint, motor.joints[joint.name]) for i, joint in joints if joint.name in motor.joints]


def reflected(model: Model, scene: Scene) -> dict[tuple[int, int], float]:
    """By coordinates i <= j, what rotors add to M: multiplier^2 G^2 J of single joints, c c^T G^2 J of coupled."""
    entries: dict[tuple[int, int], float] = {}
    for _, joint, inertia in armatures(model, scene):
        own = joint.rate, joint.rate
        entries[own] = entries.get(own, 0.0) + joint.multiplier**2 * inertia
    for motor, turned in coupled_motors(model, scene):
        shares = along(turned)
        for i, first in shares.items():
            for j, second in shares.items():
                if i <= j and motor.reflected:
                    entries[i, j] = entries.get((i, j), 0.0) + first * second * motor.reflected
    return entries


def along(turned: list[Turned]) -> dict[int, float]:
    """Return by coordinate how much a motor turns per rate of it, its gear aside."""
    shares: dict[int, float] = {}
    for _, joint, share in turned:
        shares[joint.rate] = shares.get(joint.rate, 0.0) + joint.multiplier * share
    return shares


def moving(sample: Sample, turned: list[Turned]) -> tuple[Scalar, Scalar]:
    """s = sum c_k qd_k and sdd = sum c_k qdd_k of a motor [rad/s, rad/s^2]."""
    speed = total(share * sample.speed(joint) for _, joint, share in turned)
    return speed, total(share * sample.acceleration(joint) for _, joint, share in turned)


def motor_torque(motor: CoupledMotor, speed: Scalar, acceleration: Scalar, slip_speed: float) -> Scalar:
    """`G^2 J sdd + d s + friction(s)` [N m]."""
    friction = motor.friction.viscous * speed + coulomb_torque(motor.friction, speed, slip_speed)
    return friction + motor.reflected * acceleration


def at_joints(turned: list[Turned], torque: Scalar) -> Iterator[tuple[int, Scalar]]:
    """Yield (body, c_j torque), what a motor's torque is at the joint of each body."""
    return ((i, share * torque) for i, _, share in turned)


class CoupledMotors(Effect):
    """A motor that turns with a sum of joints, with its own rotor and friction, as in many wrists: its joint-side speed
    is `s = sum c_k qd_k`, it needs `T = G^2 J sdd + d s + friction(s)`, and joint j has its part `c_j T`."""

    name = "coupled motor"
    adds = "c_j (G^2 J sdd + d s + f sign(s)) with s = sum c_k qd_k over the joints that a motor turns with"

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        acting = [each for each in coupled_motors(model, scene) if each[0].acts]
        joints = [joint for _, turned in acting for _, joint, _ in turned]
        still = all((source, joint.rate) in zero_columns for joint in joints for source in ("qd", "qdd"))
        names = ", ".join(motor.name for motor, _ in acting)
        none = "no joint of a coupled motor moves" if acting else "the scene has no coupled motor"
        return Verdict.of(acting and not still, none, f"motors of several joints: {names}")

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        for motor, turned in coupled_motors(sample.model, scene):
            torque = motor_torque(motor, *moving(sample, turned), scene.slip_speed)
            terms = terms.with_torques(at_joints(turned, torque))
        return terms

    def stored(self, sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
        """sum G^2 J s^2 / 2 [J]."""
        each = ((motor, moving(sample, turned)[0]) for motor, turned in coupled_motors(sample.model, scene))
        return total((0.5 * motor.reflected) * (speed * speed) for motor, speed in each)

    def lost(self, sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
        """sum of friction times s [W]."""
        each = ((motor, moving(sample, turned)[0]) for motor, turned in coupled_motors(sample.model, scene))
        return total(motor_torque(motor, speed, 0.0, scene.slip_speed) * speed for motor, speed in each)


class Spin(NamedTuple):
    """A rotor whose axis is said: of the joint that it drives, and the body that this moves.

    carrier, link: the body that carries it, and the link that it is fixed to; axis: (3,) unit vector in the carrier's
    axes; gear: its speed per speed of the joint; share: J G, its angular momentum per that [kg m^2].
    """

    body: int
    joint: Joint
    carrier: int
    link: str
    axis: Array
    gear: float
    share: float


def spins(model: Model, scene: Scene) -> Iterator[Spin]:
    """Yield every rotor whose axis or carrier the scene says, in the order of bodies."""
    for i, body in enumerate(model.bodies):
        joint = body.joint
        rotor = scene.rotor.get(joint.name)
        inertia, gear = rotor_of(joint, scene)
        if rotor is None or not rotor.spins or not gear:
            continue
        link = rotor.on or joint.link
        carrier, R, _ = model.links[link]
        if rotor.axis is not None:
            along = np.array(rotor.axis)
            axis = product(R, along / length(along))
        else:
            axis = joint.axis if carrier == i else product(joint.R, joint.axis)
        yield Spin(i, joint, carrier, link, axis, gear, inertia * gear)


def mass_entries(sample: Sample, scene: Scene) -> Mapping[tuple[int, int], Scalar]:
    """By coordinates i <= j, what rotors add to M: the reflected inertias, and J G (a . dw_c/dqd) of spinning ones."""
    model = sample.model
    entries: dict[tuple[int, int], Scalar] = {**reflected(model, scene)}
    joints: list[Motion] | None = None
    for spin in spins(model, scene):
        joints = joints or sample.motions()
        rate, moment, k = spin.joint.rate, spin.axis * (spin.share * spin.joint.multiplier), spin.carrier
        while k >= 0:
            joint = model.bodies[k].joint
            turning: list[Scalar] = [*moment] if joint.kind == "floating" else []
            if joint.kind == "revolute":
                turning = [joint.multiplier * (joint.axis @ moment)]
            for other, along in enumerate(turning, joint.rate):
                pair = min(rate, other), max(rate, other)
                entries[pair] = entries.get(pair, 0.0) + (2.0 * along if other == rate else along)
            moment, k = joints[k].R @ moment, model.parents[k]
    return entries


def with_spins(terms: Terms, sample: Sample, each: Iterable[tuple[Spin, Scalar]]) -> Terms:
    """Return the terms with rotors that spin. A rotor takes the moment `dh/dt = J G (qdd a + w x qd a)` of its carrier,
    and `J G (a . wd)` of its motor; `each` is a rotor and its J G [kg m^2]."""
    if not (pairs := list(each)):
        return terms
    joints = sample.motions()
    speeds, rates = velocities(sample.model.parents, joints), accelerations(sample.model.parents, joints)
    wrenches, torques, columns = list(terms.wrenches), [], list(terms.spins)
    for spin, share in pairs:
        (w, _), (wd, _), a = speeds[spin.carrier], rates[spin.carrier], spin.axis
        h, rate = a * (share * sample.speed(spin.joint)), a * (share * sample.acceleration(spin.joint))
        wrenches.append((spin.carrier, Wrench(ZERO, -(rate + cross(w, h)))))
        torques.append((spin.body, share * (a @ wd)))
        columns.append((spin.carrier, spin.joint.rate, a * (share * spin.joint.multiplier)))
    return replace(terms, wrenches=tuple(wrenches), spins=tuple(columns)).with_torques(torques)


def angular_momentum(sample: Sample, scene: Scene, motions: list[Motion]) -> Array:
    """Sum of J G qd a, in the base's axes [kg m^2/s]."""
    found = list(spins(sample.model, scene))
    if not found:
        return ZERO
    base, *others = motions
    where = poses(sample.model.parents, [base._replace(R=IDENTITY, p=ZERO), *others])
    return sum((where[s.carrier].R @ (s.axis * (s.share * sample.speed(s.joint))) for s in found), ZERO)


class GyroscopicMoment(Effect):
    """The moment of a rotor that turns at G qd about an axis a that is fixed in the link that carries it. Its angular
    momentum relative to that link is `h = J G qd a`, and its kinetic energy adds `J G qd (a . w)` to that of its spin
    alone; what it has as part of the link belongs to the link's inertia."""

    name = "gyroscopic moment"
    adds = "J G (qdd a + w x qd a) to the link that carries a rotor, and J G (a . wd) to its joint, where a is said"

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        acting = [spin.joint.name for spin in spins(model, scene) if spin.share]
        still = all((source, rate) in zero_columns for rate in range(model.n) for source in ("qd", "qdd"))
        none = "nothing moves" if acting else "the scene says no rotor's axis"
        return Verdict.of(acting and not still, none, f"rotors with an axis: {', '.join(acting)}")

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        return with_spins(terms, sample, ((s, s.share) for s in spins(sample.model, scene) if s.share))

    def stored(self, sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
        """sum J G qd (a . w) [J]."""
        speeds, each = velocities(sample.model.parents, motions), spins(sample.model, scene)
        return total((s.share * sample.speed(s.joint)) * (s.axis @ speeds[s.carrier].w) for s in each)

    def lost(self, sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
        """Nothing: less the power of its moments on carriers, which counts as given by wrenches and is stored [W]."""
        speeds = velocities(sample.model.parents, motions)
        moments = self.add(replace(terms, wrenches=()), sample, scene).wrenches
        return total(wrench.n @ speeds[i].w for i, wrench in moments)


ROTOR, COUPLED, GYROSCOPIC = RotorInertia(), CoupledMotors(), GyroscopicMoment()
