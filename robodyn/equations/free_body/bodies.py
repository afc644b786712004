"""A robot in one state as free bodies: weight, inertia, reactions, drives and what the surroundings do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robodyn.dynamics.arrays import arrays_of, zero_columns
from robodyn.dynamics.constraints.solve import as_tree
from robodyn.dynamics.effects import motors
from robodyn.dynamics.effects.effect import Effect, Sample, Terms
from robodyn.dynamics.effects.forces import acting
from robodyn.dynamics.effects.motors import spins
from robodyn.dynamics.plan import applied, at_rest, plan
from robodyn.dynamics.recursions.newton_euler import euler, joint_torques, newton_euler
from robodyn.errors import InputError
from robodyn.programs.vectors import ZERO, cross, narrowed, narrowed_all, product
from robodyn.robot.kinematics import (
    Motion,
    Pose,
    Wrench,
    acceleration_of_point,
    accelerations,
    motions,
    poses,
    velocities,
)
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_load, refuse_others
from robodyn.scene.scene import DEFAULT, GROUND, Scene
from robodyn.solids.inertia.laws import about_centre
from robodyn.support.floats import Floats
from robodyn.support.wording import figure, shown


@dataclass(frozen=True, eq=False)
class Action:
    """A force and a moment on a body, in the body's axes.

    Attributes:
        kind: "weight", "inertial", "reaction", "drive", "viscous friction", "coulomb friction", "rotor inertia",
            "coupled motor", "gyroscopic moment", "joint spring", "external wrench" or "fluid".
        what: in words; by: the body, joint or thing that exerts it.
        symbols: of the force and of the moment; a joint's have its number, and a minus sign on the parent.
        point: (3,) where the force acts, from the body's origin [m].
        force: (3,) N.
        moment: (3,) N m, besides that of the force.
    """

    kind: str
    what: str
    by: str
    symbols: tuple[str, str]
    point: Floats
    force: Floats
    moment: Floats

    @property
    def at_origin(self) -> Floats:
        return self.moment + cross(self.point, self.force)


@dataclass(frozen=True, eq=False)
class FreeBody:
    """One body with all that acts on it.

    Attributes:
        number: its place in the model, which is also its joint's number.
        links: of the description that move as this body.
        com: (3,) mass centre in the body's frame [m].
        pose: rotation and origin of the body's frame in the ground's.
        actions: their forces and moments add up to zero.
        ends: (number, point) of the joints of the bodies that it carries, in its frame [m].
    """

    number: int
    name: str
    links: tuple[str, ...]
    mass: float
    com: Floats
    pose: Pose
    actions: tuple[Action, ...]
    ends: tuple[tuple[int, Floats], ...]

    @property
    def force(self) -> Floats:
        return np.asarray(np.array([action.force for action in self.actions]).sum(axis=0))

    @property
    def moment(self) -> Floats:
        """The sum of the moments about the body's origin [N m]."""
        return np.asarray(np.array([action.at_origin for action in self.actions]).sum(axis=0))


@dataclass(frozen=True, eq=False)
class JointRow:
    """A joint as an engineer counts it: f degrees of freedom and 6 - f reactions.

    Attributes:
        number: of the body that it carries; parent, child: names of bodies ("ground" below the base).
        kind: "fixed" (the base only), "revolute", "prismatic" or "floating".
        axis: (3,) in the child's axes, zeros without one.
        wrench: on the child, all of it, in its axes at its origin; force, moment: (3,) what the joint's surfaces
            transmit of it [N, N m]; nothing along the axis of a hinge (moment) or slide (force).
        drive: along the axis, what the actuator supplies there [N m or N]; None without an axis.
        others: by effect, what takes up part of the drive.
    """

    number: int
    name: str
    parent: str
    child: str
    kind: str
    axis: Floats
    wrench: Wrench
    force: Floats
    moment: Floats
    drive: float | None
    others: Mapping[str, float]

    @property
    def freedom(self) -> int:
        return {"fixed": 0, "floating": 6}.get(self.kind, 1)

    @property
    def reactions(self) -> int:
        return 6 - self.freedom


@dataclass(frozen=True, eq=False)
class FreeBodies:
    """A robot in one state, taken apart.

    Attributes:
        q, qd, qdd: the state, in the model's order; gravity: m/s^2, in the ground's axes.
        tau: (n,) along the coordinates, the drives of followers reflected onto their leaders [N m or N].
        residual_force, residual_moment: the largest sum on any body, of the largest single force and moment on any.
    """

    robot: str
    file: str
    q: dict[str, float]
    qd: dict[str, float]
    qdd: dict[str, float]
    gravity: tuple[float, float, float]
    bodies: tuple[FreeBody, ...]
    joints: tuple[JointRow, ...]
    tau: dict[str, float]
    residual_force: float
    residual_moment: float
    warnings: tuple[str, ...]


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


def applied_wrenches(effects: tuple[Effect, ...], sample: Sample, scene: Scene) -> list[tuple[int, Action]]:
    """(body, action) of wrenches of the surroundings, loops, contacts and spinning rotors, where they act on links."""
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
            out.append((i, Action(effect.name, what, by, symbols, where, wrench.f, moment)))
    return out


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


def free_bodies(
    model: Model,
    q: ArrayLike,
    qd: ArrayLike = 0.0,
    qdd: ArrayLike = 0.0,
    *,
    scene: Scene = DEFAULT,
    columns: Mapping[str, float] | None = None,
) -> FreeBodies:
    """Return every body of a robot cut free, with all forces and moments on it: they add up to zero.

    The reactions come from the force recursion; weights and inertial forces from each body's own acceleration and
    Euler's laws about its mass centre. Their balance therefore checks one against the other.

    Args:
        q: (nq,) rad or m; qd, qdd: (n,) per s and per s^2, as for `inverse_dynamics`; `0` is at rest.
        scene: what surrounds the robot; its payloads are part of their bodies.
        columns: numbers for the columns that the scene's wrenches name.

    Raises:
        InputError: a shape does not fit the model, or there is more than one sample.

    Accuracy: forces, and moments about each body's origin, add up to zero within 1e-14 of the largest on any body, for
    chains of up to 100 bodies.
    """
    refuse_others(model, scene)
    refuse_load(scene)
    given: Mapping[str, ArrayLike] = columns or {}
    missing: Floats = np.zeros(model.n)
    if scene.constrained:
        scene, given, missing = as_tree(model, (q, qd, qdd), scene, given)
    sources, shape = arrays_of(model, {"q": q, "qd": qd, "qdd": qdd}, scene, given)
    if shape:
        raise InputError(f"{shape} samples", remedy="a free-body diagram is of one state")
    a_plan = plan(model, scene, zero_columns(sources))
    state = {name: tuple(values[0].tolist()) for name, values in sources.items() if values.size or name != "columns"}
    extra = dict(zip(scene.columns, state.pop("columns", ()), strict=True))
    sample = Sample(model, state["q"], state["qd"], state["qdd"], extra)
    terms = applied(a_plan.effects, sample, scene)
    joints = motions(model, sample.q, terms.qd, terms.qdd)
    wrenches = narrowed_all(newton_euler(model.parents, joints, terms.inertias, terms.gravity, terms.wrenches))
    torques = {effect.name: effect.add(at_rest(sample), sample, scene).at_joint for effect in a_plan.effects}
    cuts = [cut(i, model, wrench, torques) for i, wrench in enumerate(wrenches)]
    tau = joint_torques(model, joints, wrenches, terms.at_joint)
    around = applied_wrenches(a_plan.effects, sample, scene)
    bodies = tuple(_cut_free(model, terms, joints, cuts, around))
    warnings = []
    slides = {joint.name for joint in model.independent if joint.kind == "prismatic"}
    for name, value in zip(model.rates, missing.tolist(), strict=True):
        if value:
            unit = "N" if name in slides or name[-3:] in ("_vx", "_vy", "_vz") else "N m"
            taken = f"the motion takes {figure(value)} {unit} there, shown as its drive"
            warnings.append(f"nothing drives {shown(name)}, and {taken}")
    actions = [action for body in bodies for action in body.actions]
    force = max([np.finfo(float).tiny, *(float(np.abs(action.force).max()) for action in actions)])
    moment = max([np.finfo(float).tiny, *(float(np.abs(action.at_origin).max()) for action in actions)])
    return FreeBodies(
        robot=model.name,
        file=model.file,
        q=dict(zip(model.coordinates, sample.q, strict=True)),
        qd=dict(zip(model.rates, sample.qd, strict=True)),
        qdd=dict(zip(model.rates, sample.qdd, strict=True)),
        gravity=scene.gravity,
        bodies=bodies,
        joints=tuple(cuts),
        tau=dict(zip(model.rates, map(float, tau), strict=True)),
        residual_force=max(float(np.abs(body.force).max()) for body in bodies) / force,
        residual_moment=max(float(np.abs(body.moment).max()) for body in bodies) / moment,
        warnings=(*warnings, *model.notes),
    )


def _cut_free(
    model: Model, terms: Terms, joints: list[Motion], cuts: list[JointRow], around: list[tuple[int, Action]]
) -> Iterator[FreeBody]:
    parents = model.parents
    moving, speeding = narrowed_all(velocities(parents, joints)), narrowed_all(accelerations(parents, joints))
    where, joints = narrowed_all(poses(parents, joints)), narrowed_all(joints)
    for i, body in enumerate(model.bodies):
        own, c = terms.inertias[i], terms.inertias[i].centre_of_mass
        acting: list[Action] = []
        if own.m or np.any(own.I):
            pull = own.m * product(where[i].R.T, terms.gravity)
            # -m a_c at the mass centre and -dH_c/dt: what balances the rest, as d'Alembert has it
            force = -(own.m * acceleration_of_point(speeding[i].a, c, moving[i].w, speeding[i].wd))
            moment = -euler(about_centre(own.I, own.m, c), moving[i].w, speeding[i].wd)
            acting.append(Action("weight", "weight", "gravity", ("W", ""), c, pull, np.zeros(3)))
            acting.append(Action("inertial", "inertia", "its motion", ("-ma", "-dH"), c, force, moment))
        acting += [*(action for k, action in around if k == i), *at_joint(cuts[i], cuts[i].parent)]
        children = [k for k, parent in enumerate(parents) if parent == i]
        for k in children:
            acting += at_joint(cuts[k], model.bodies[k].name, joints[k], -1.0)
        ends = tuple((k, joints[k].p) for k in children)
        links = tuple(name for name, frame in model.links.items() if frame.body == i)
        yield FreeBody(i, body.name, links, float(own.m), c, where[i], tuple(acting), ends)
