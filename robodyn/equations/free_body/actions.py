"""The forces and moments on each body of a robot in one state, in floats."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.effect import Effect, Sample
from robodyn.dynamics.plan import at_rest
from robodyn.dynamics.recursions.euler import acceleration_of_point, euler
from robodyn.equations.free_body.types import Action
from robodyn.programs.vectors import ZERO, narrowed, product
from robodyn.robot.model import Joint, Model
from robodyn.robot.motion_types import Motion, Wrench
from robodyn.robot.poses import Acceleration, Pose, Velocity
from robodyn.scene.scene import Scene
from robodyn.solids.inertia.laws import Inertia, about_centre
from robodyn.support.floats import Floats

_LETTERS = {
    "viscous friction": "V",
    "coulomb friction": "C",
    "rotor inertia": "J",
    "joint spring": "S",
    "limit spring": "L",
}


def weight(body: Inertia, pose: Pose, gravity: Floats) -> Action:
    """m g at the mass centre."""
    force = body.m * product(pose.R.T, gravity)
    return Action("weight", "weight", "gravity", ("W", ""), body.centre_of_mass, force, np.zeros(3))


def inertial(body: Inertia, moving: Velocity, speeding: Acceleration) -> Action:
    """-m a_c at the mass centre and -dH_c/dt: what balances the rest, as d'Alembert has it."""
    c = body.centre_of_mass
    a_c = acceleration_of_point(speeding.a, c, moving.w, speeding.wd)
    moment = -euler(about_centre(body.I, body.m, c), moving.w, speeding.wd)
    return Action("inertial", "inertia", "its motion", ("-ma", "-dH"), c, -(body.m * a_c), moment)


class Applied(NamedTuple):
    """What effects do to a body: `kind`, what acts, where [m], force [N], moment [N m]."""

    body: int
    action: Action


def applied_wrenches(effects: tuple[Effect, ...], sample: Sample, scene: Scene) -> list[Applied]:
    """Return the wrenches of the surroundings, each at the point of its link where it acts."""
    places = {
        "external wrench": [(w.link, w.point) for w in scene.wrenches if any(w.force) or any(w.moment)],
        "fluid": [(immersed.link, immersed.centre) for immersed in scene.immersed],
    }
    out = []
    for effect in effects:
        if effect.name not in places:
            continue
        found = effect.add(at_rest(sample), sample, scene).wrenches
        letters = ("E", "N") if effect.name == "external wrench" else ("B", "")
        for k, ((i, loads), (link, point)) in enumerate(zip(found, places[effect.name], strict=True), 1):
            wrench = Wrench(*map(narrowed, loads))
            symbols = (f"{letters[0]}{k}", f"{letters[1]}{k}" if letters[1] else "")
            _, R, p = sample.model.links[link]
            where = p + product(R, np.array(point))
            moment = wrench.n - np.cross(where, wrench.f)
            what = f"{effect.name} on {link}"
            out.append(Applied(i, Action(effect.name, what, "surroundings", symbols, where, wrench.f, moment)))
    return out


def torques_at_joints(effects: tuple[Effect, ...], sample: Sample, scene: Scene) -> dict[str, Mapping[int, float]]:
    """By effect and body, the torque that the effect asks of the actuator at the body's joint."""
    found = {effect.name: effect.add(at_rest(sample), sample, scene).at_joint for effect in effects}
    return {name: torques for name, torques in found.items() if torques}


class Cut(NamedTuple):
    """What the parent of a body does to it at its joint, in the body's axes at its origin.

    Attributes:
        wrench: all of it; force, moment: the part that the joint's surfaces transmit.
        along: the part along the axis, N m or N; drive: what the actuator supplies of it, and `others` take up.
    """

    joint: Joint
    wrench: Wrench
    force: Floats
    moment: Floats
    along: float | None
    drive: float
    others: dict[str, float]


def cut(i: int, model: Model, wrench: Wrench, torques: Mapping[str, Mapping[int, float]]) -> Cut:
    """Return the wrench at the joint of body i, taken apart."""
    joint, (f, n) = model.bodies[i].joint, wrench
    if joint.kind == "fixed":
        return Cut(joint, wrench, f, n, None, 0.0, {})
    if joint.kind == "floating":
        return Cut(joint, wrench, np.zeros(3), np.zeros(3), None, 0.0, {})
    others = {name: float(by_body[i]) for name, by_body in torques.items() if by_body.get(i, 0.0)}
    turning = joint.kind == "revolute"
    along = float(product(joint.axis, n if turning else f))
    drive = along + sum(others.values())
    force, moment = (f, n - along * joint.axis) if turning else (f - along * joint.axis, n)
    return Cut(joint, wrench, force, moment, along, drive, others)


def at_joint(number: int, at: Cut, by: str, motion: Motion | None = None, sign: float = 1.0) -> Iterator[Action]:
    """Yield what a joint does to the body that it carries, or with `motion` and -1 to that body's parent."""
    R, p = (motion.R, motion.p) if motion is not None else (np.eye(3), np.zeros(3))
    minus = "" if sign > 0 else "-"

    def action(kind: str, what: str, letters: tuple[str, str], f: Floats, n: Floats) -> Action:
        symbols = (f"{minus}{letters[0]}{number}", f"{minus}{letters[1]}{number}")
        return Action(kind, what, by, symbols, p, sign * product(R, f), sign * product(R, n))

    joint = at.joint
    if joint.kind == "floating":
        yield action("drive", f"what moves {joint.name}", ("D", "T"), *at.wrench)
        return
    yield action("reaction", f"reaction, {joint.name}", ("R", "M"), at.force, at.moment)
    if at.along is None:
        return
    parts = {"drive": at.drive, **{name: -torque for name, torque in at.others.items()}}
    for kind, value in parts.items():
        vector = value * joint.axis
        f, n = (ZERO, vector) if joint.kind == "revolute" else (vector, ZERO)
        letter = _LETTERS.get(kind, "D" if joint.kind == "prismatic" else "T")
        yield action(kind, f"{kind}, {joint.name}", (letter, letter), f, n)
