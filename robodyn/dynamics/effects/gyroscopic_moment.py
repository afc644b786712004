"""Gyroscopic moments: a rotor that turns at G qd about an axis a that is fixed in the link that carries it.

Its angular momentum relative to that link, whose angular velocity is w, is `h = J G qd a`, and its kinetic energy adds
`J G qd (a . w)` to that of its spin alone; what it has as part of the link belongs to the link's inertia.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.coupled_motor import reflected
from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.dynamics.effects.rotor_inertia import rotor_of
from robodyn.programs.vectors import IDENTITY, ZERO, Array, Scalar, cross, length, product, total
from robodyn.robot.kinematics import Motion, Wrench, accelerations, poses, velocities
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import Scene


class Spin(NamedTuple):
    """A rotor whose axis is said.

    Attributes:
        body, joint: that it drives.
        gear, inertia: of the rotor [kg m^2].
        carrier: the body that carries it.
        link: that it is fixed to.
        axis: (3,) unit vector in the carrier's axes.
    """

    body: int
    joint: Joint
    gear: float
    inertia: float
    carrier: int
    link: str
    axis: Array

    @property
    def share(self) -> float:
        """J G: its angular momentum per speed of the joint [kg m^2]."""
        return self.inertia * self.gear


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
        yield Spin(i, joint, gear, inertia, carrier, link, axis)


def mass_entries(sample: Sample, scene: Scene) -> Mapping[tuple[int, int], Scalar]:
    """By coordinates i <= j, what rotors add to M: the reflected inertias, and J G (a . dw_c/dqd) of spinning ones."""
    model = sample.model
    entries: dict[tuple[int, int], Scalar] = {**reflected(model, scene)}
    joints: list[Motion] | None = None
    for spin in spins(model, scene):
        joints = joints or sample.motions()
        rate, moment, k = spin.joint.rate, spin.axis * (spin.share * spin.joint.multiplier), spin.carrier
        while k >= 0:
            for other, along in _turning(model.bodies[k].joint, moment):
                pair = min(rate, other), max(rate, other)
                entries[pair] = entries.get(pair, 0.0) + (2.0 * along if other == rate else along)
            moment, k = joints[k].R @ moment, model.parents[k]
    return entries


def _turning(joint: Joint, moment: Array) -> Iterator[tuple[int, Scalar]]:
    """Yield the rates by which a joint turns its body, and what a moment on the body does along them."""
    if joint.kind == "revolute":
        yield joint.rate, joint.multiplier * (joint.axis @ moment)
    elif joint.kind == "floating":
        yield from enumerate(moment, joint.rate)


def why(model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
    acting = [spin.joint.name for spin in spins(model, scene) if spin.inertia]
    still = all((source, rate) in zero_columns for rate in range(model.n) for source in ("qd", "qdd"))
    none = "nothing moves" if acting else "the scene says no rotor's axis"
    return Verdict.of(acting and not still, none, f"rotors with an axis: {', '.join(acting)}")


def with_spins(terms: Terms, sample: Sample, each: Iterable[tuple[Spin, Scalar]]) -> Terms:
    """Return the terms with rotors that spin.

    A rotor takes the moment `dh/dt = J G (qdd a + w x qd a)` of its carrier, and `J G (a . wd)` of its motor.

    Args:
        each: rotors, and J G of each [kg m^2].
    """
    pairs = list(each)
    if not pairs:
        return terms
    joints = sample.motions()
    moving, speeding = velocities(sample.model.parents, joints), accelerations(sample.model.parents, joints)
    wrenches, torques, columns = list(terms.wrenches), [], list(terms.spins)
    for spin, share in pairs:
        (w, _), (wd, _), a = moving[spin.carrier], speeding[spin.carrier], spin.axis
        h, rate = a * (share * sample.speed(spin.joint)), a * (share * sample.acceleration(spin.joint))
        wrenches.append((spin.carrier, Wrench(ZERO, -(rate + cross(w, h)))))
        torques.append((spin.body, share * (a @ wd)))
        columns.append((spin.carrier, spin.joint.rate, a * (share * spin.joint.multiplier)))
    return replace(terms, wrenches=tuple(wrenches), spins=tuple(columns)).with_torques(torques)


def add(terms: Terms, sample: Sample, scene: Scene) -> Terms:
    return with_spins(terms, sample, ((spin, spin.share) for spin in spins(sample.model, scene) if spin.inertia))


def angular_momentum(sample: Sample, scene: Scene, motions: list[Motion]) -> Array:
    """Sum of J G qd a, in the base's axes [kg m^2/s]."""
    found = list(spins(sample.model, scene))
    if not found:
        return ZERO
    base, *others = motions
    where = poses(sample.model.parents, [base._replace(R=IDENTITY, p=ZERO), *others])
    return sum((where[s.carrier].R @ (s.axis * (s.share * sample.speed(s.joint))) for s in found), ZERO)


def stored(sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
    """sum J G qd (a . w) [J]."""
    moving = velocities(sample.model.parents, motions)
    each = spins(sample.model, scene)
    return total((s.share * sample.speed(s.joint)) * (s.axis @ moving[s.carrier].w) for s in each)


def lost(sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
    """Nothing: less the power of its moments on carriers, which counts as given by wrenches and is stored [W]."""
    moving = velocities(sample.model.parents, motions)
    moments = add(replace(terms, wrenches=()), sample, scene).wrenches
    return total(wrench.n @ moving[i].w for i, wrench in moments)


EFFECT = Effect(
    "gyroscopic moment",
    "J G (qdd a + w x qd a) to the link that carries a rotor, and J G (a . wd) to its joint, where a is said",
    why,
    add,
    stored=stored,
    lost=lost,
)
