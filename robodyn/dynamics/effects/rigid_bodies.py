"""Effects of the bodies themselves: gravity, inertia, Coriolis forces, a moving base, payloads, mimic joints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.programs.vectors import Scalar
from robodyn.robot.kinematics import Motion, poses
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.solids.inertia.laws import MASSLESS, combined, inertia_of, symmetric


class Gravity(Effect):
    """The ground accelerates upwards."""

    name, adds = "gravity", "the ground's acceleration -g"

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        some = "gravity is ({:g}, {:g}, {:g}) m/s^2".format(*scene.gravity)
        return Verdict.of(any(scene.gravity), "gravity is zero", some)

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        return replace(terms, gravity=1.0 * np.array(scene.gravity))

    def stored(self, sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
        """Potential energy -sum m g . r [J], zero for a mass at the ground's origin."""
        energy: Scalar = 0.0
        for pose, body in zip(poses(sample.model.parents, motions), terms.inertias, strict=True):
            energy = energy - terms.gravity @ (pose.R @ body.mc + body.m * pose.p)
        return energy


class JointInertia(Effect):
    """The joints accelerate."""

    name, adds = "inertia", "M(q) qdd"

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        joints = range(6 if model.floating else 0, model.n)
        moving = sum(("qdd", i) not in zero_columns for i in joints)
        return Verdict.of(moving, "no joint accelerates", f"{moving} of {len(joints)} coordinates accelerate")

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        first = 6 if sample.model.floating else 0
        return replace(terms, qdd=terms.qdd[:first] + sample.qdd[first:])


class Coriolis(Effect):
    """Coriolis and centrifugal forces: joints and base move."""

    name, adds = "coriolis", "c(q, qd): Coriolis and centrifugal forces, those of a turning base included"

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        moving = sum(("qd", i) not in zero_columns for i in range(model.n))
        return Verdict.of(moving, "nothing moves", f"{moving} of {model.n} velocities are not zero")

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        return replace(terms, qd=sample.qd)


class MovingBase(Effect):
    """The base accelerates. Its angular velocity enters with the other velocities, in `Coriolis`."""

    name, adds = "moving base", "what the base's acceleration asks of the joints"

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        if not model.floating:
            return Verdict(False, "the base is fixed")
        still = all(("qdd", i) in zero_columns for i in range(6))
        some = "the base follows the base columns; its angular velocity is counted under coriolis"
        return Verdict.of(not still, "the base does not accelerate", some)

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        return replace(terms, qdd=sample.qdd[:6] + terms.qdd[6:])


class Payload(Effect):
    """A mass fixed to a link, added to its body by the parallel axis theorem."""

    name, adds = "payload", "mass, centre of mass and inertia to a link, by the parallel axis theorem"

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        loads = [load for load in scene.payloads if load.mass or any(load.inertia)]
        some = ", ".join(f"{load.mass:g} kg on {load.link}" for load in loads)
        return Verdict.of(loads, "the scene has no payload", some)

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        inertias = list(terms.inertias)
        for load in scene.payloads:
            body, R, p = sample.model.links[load.link]
            mass = inertia_of(load.mass, np.array(load.com), symmetric(load.inertia), R, p)
            inertias[body] = combined((inertias[body], mass))
        return replace(terms, inertias=tuple(inertias))

    def background(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        """The whole motion and gravity, on a robot without mass: what a payload needs to be felt."""
        massless = tuple(MASSLESS for _ in terms.inertias)
        return GRAVITY.add(replace(terms, inertias=massless, qd=sample.qd, qdd=sample.qdd), sample, scene)


class Mimic(Effect):
    """Mimic joints follow their leader's coordinate, and their torques are reflected onto it."""

    name, adds = "mimic", "nothing by itself: torques of a follower, times its multiplier, are part of its leader's"

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        names = [body.joint.name for body in model.bodies if body.joint.mimics is not None]
        some = f"{len(names)} joints follow others ({', '.join(names[:4])}{', ...' * (len(names) > 4)})"
        return Verdict.of(names, "no joint mimics another", some)

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        """Nothing: that a joint follows another is part of the model, so every other effect already sees it."""
        return terms


GRAVITY, INERTIA, CORIOLIS = Gravity(), JointInertia(), Coriolis()
MOVING_BASE, PAYLOAD, MIMIC = MovingBase(), Payload(), Mimic()
