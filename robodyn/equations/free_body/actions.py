"""The forces and moments on each body of a robot in one state, in floats."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects import motors
from robodyn.dynamics.effects.effect import Effect, Sample
from robodyn.dynamics.effects.motors import spins
from robodyn.dynamics.effects.wrenches import acting
from robodyn.dynamics.plan import at_rest
from robodyn.dynamics.recursions.newton_euler import euler
from robodyn.equations.free_body.types import Action, JointRow
from robodyn.programs.vectors import ZERO, narrowed, product
from robodyn.robot.kinematics import Acceleration, Motion, Pose, Velocity, Wrench, acceleration_of_point
from robodyn.robot.model import Model
from robodyn.scene.parts import GROUND
from robodyn.scene.scene import Scene
from robodyn.solids.inertia.laws import Inertia, about_centre
from robodyn.support.floats import Floats

SPINNING = motors.GYROSCOPIC.name
_LETTERS = {
    "viscous friction": "V",
    "coulomb friction": "C",
    "rotor inertia": "J",
    "coupled motor": "U",
    SPINNING: "K",
    "joint spring": "S",
    "limit spring": "L",
}

_CAUSES = {"external wrench": "surroundings", "loop forces": "loop", "contact forces": "contact"}
_OF_WRENCHES = {
    "external wrench": ("E", "N"),
    "loop forces": ("F", "G"),
    "contact forces": ("P", "Q"),
    "fluid": ("B", ""),
    SPINNING: ("", "H"),
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
    """Return wrenches of the surroundings, of loops, of contacts and of spinning rotors, where they act on links."""
    places = {
        **{name: [(w.link, w.point) for w in acting(scene, cause)] for name, cause in _CAUSES.items()},
        SPINNING: [(spin.link, (0.0, 0.0, 0.0)) for spin in spins(sample.model, scene) if spin.share],
        "fluid": [(immersed.link, immersed.centre) for immersed in scene.immersed],
    }
    out = []
    for effect in effects:
        if effect.name not in places:
            continue
        found = effect.add(at_rest(sample), sample, scene).wrenches
        letters = _OF_WRENCHES[effect.name]
        for k, ((i, loads), (link, point)) in enumerate(zip(found, places[effect.name], strict=True), 1):
            wrench = Wrench(*map(narrowed, loads))
            symbols = (f"{letters[0]}{k}" if letters[0] else "", f"{letters[1]}{k}" if letters[1] else "")
            _, R, p = sample.model.links[link]
            where = p + product(R, np.array(point))
            moment = wrench.n - np.cross(where, wrench.f)
            what = f"{effect.name} on {link}"
            by = "rotor" if effect.name == SPINNING else _CAUSES.get(effect.name, "surroundings")
            out.append(Applied(i, Action(effect.name, what, by, symbols, where, wrench.f, moment)))
    return out


def torques_at_joints(effects: tuple[Effect, ...], sample: Sample, scene: Scene) -> dict[str, Mapping[int, float]]:
    """By effect and body, the torque that the effect asks of the actuator at the body's joint."""
    found = {effect.name: effect.add(at_rest(sample), sample, scene).at_joint for effect in effects}
    return {name: torques for name, torques in found.items() if torques}


def cut(i: int, model: Model, wrench: Wrench, torques: Mapping[str, Mapping[int, float]]) -> JointRow:
    """Return the wrench at the joint of body i, taken apart."""
    joint, parent, (f, n) = model.bodies[i].joint, model.parents[i], wrench
    drive, others = None, {}
    if joint.kind == "floating":
        f, n = np.zeros(3), np.zeros(3)
    elif joint.kind != "fixed":
        others = {name: float(by_body[i]) for name, by_body in torques.items() if by_body.get(i, 0.0)}
        turning = joint.kind == "revolute"
        along = float(product(joint.axis, n if turning else f))
        drive = along + sum(others.values())
        f, n = (f, n - along * joint.axis) if turning else (f - along * joint.axis, n)
    carrier = model.bodies[parent].name if parent >= 0 else GROUND
    return JointRow(i, joint.name, carrier, model.bodies[i].name, joint.kind, joint.axis, wrench, f, n, drive, others)


def at_joint(at: JointRow, by: str, motion: Motion | None = None, sign: float = 1.0) -> Iterator[Action]:
    """Yield what a joint does to the body that it carries, or with `motion` and -1 to that body's parent."""
    R, p = (motion.R, motion.p) if motion is not None else (np.eye(3), np.zeros(3))
    minus = "" if sign > 0 else "-"

    def action(kind: str, what: str, letters: tuple[str, str], f: Floats, n: Floats) -> Action:
        symbols = (f"{minus}{letters[0]}{at.number}", f"{minus}{letters[1]}{at.number}")
        return Action(kind, what, by, symbols, p, sign * product(R, f), sign * product(R, n))

    if at.kind == "floating":
        yield action("drive", f"what moves {at.name}", ("D", "T"), *at.wrench)
        return
    yield action("reaction", f"reaction, {at.name}", ("R", "M"), at.force, at.moment)
    if at.drive is None:
        return
    parts = {"drive": at.drive, **{name: -torque for name, torque in at.others.items()}}
    for kind, value in parts.items():
        vector = value * at.axis
        f, n = (ZERO, vector) if at.kind == "revolute" else (vector, ZERO)
        letter = _LETTERS.get(kind, "D" if at.kind == "prismatic" else "T")
        yield action(kind, f"{kind}, {at.name}", (letter, letter), f, n)
