"""A robot in a scene and a state as a system of single bodies, its joints and loops as connections."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robodyn.dynamics.effects.effect import Sample, Terms
from robodyn.dynamics.effects.motors import armatures, coupled_motors, spins
from robodyn.dynamics.plan import applied
from robodyn.equations.dae.connections import PLAIN, Anchors, Connection, directions, hinge, point, slide, weld
from robodyn.equations.dae.equations import Along, Equation, Sum, Turn
from robodyn.equations.dae.state import State, state_of
from robodyn.equations.dae.system import Matrices, System, matrices
from robodyn.equations.ode import bias_plan
from robodyn.errors import SceneError
from robodyn.programs.vectors import IDENTITY, ZERO, Array, Scalar, length, product, rotation_from_rpy
from robodyn.robot.model import Joint, Model
from robodyn.scene.parts import Loop
from robodyn.scene.scene import Scene


def joint_connections(model: Model, centres: Sequence[Array], q: Sequence[Scalar]) -> tuple[Connection, ...]:
    """Return one for each body's joint, in the order of the bodies; where a joint is floating, one without equations.

    Args:
        centres: (3,) mass centre of each body, in its frame [m].
        q: nq scalars near which the angles of hinges are (they count turns).
    """
    found = []
    for i, body in enumerate(model.bodies):
        joint, j = body.joint, body.parent
        from_parent = joint.p - (centres[j] if j >= 0 else ZERO)
        near = joint.multiplier * q[joint.coordinate] + joint.offset if joint.coordinate >= 0 else 0.0
        found.append(_joint(joint, Anchors(i, j, -centres[i], from_parent, joint.R), near))
    return tuple(found)


def _joint(joint: Joint, anchors: Anchors, near: Scalar) -> Connection:
    body, other, own, to, R = anchors
    if joint.kind == "fixed":
        return weld(joint.name, anchors, "fixed")
    if joint.kind == "floating":
        turns = [Turn(body, other, e, R) for e in PLAIN.vectors]
        moves = [Along(body, other, own, to, product(R, e)) for e in PLAIN.vectors]
        return Connection(joint.name, "floating", body, other, (), (*turns, *moves))
    if joint.kind == "revolute":
        return hinge(joint.name, anchors, joint.axis, "revolute", [Turn(body, other, joint.axis, R, near)])
    return slide(joint.name, anchors, joint.axis, "prismatic", [Along(body, other, own, to, product(R, joint.axis))])


def mimic_connections(model: Model, joints: Sequence[Connection]) -> Iterator[Connection]:
    """For each joint that follows another, one equation: q_follower - multiplier q_leader - offset = 0."""
    number = {body.joint.name: i for i, body in enumerate(model.bodies)}
    for i, body in enumerate(model.bodies):
        joint = body.joint
        if joint.mimics is None:
            continue
        leader: Equation = joints[number[joint.mimics]].free[0]
        rule = Sum(((1.0, joints[i].free[0]), (-joint.multiplier, leader)), -joint.offset)
        name = f"{joint.name} follows {joint.mimics}"
        yield Connection(name, "mimic", i, body.parent, (("F" if joint.kind == "prismatic" else "M", rule),))


def loop_connections(model: Model, centres: Sequence[Array], loops: Sequence[Loop]) -> Iterator[Connection]:
    """Yield the closures of a scene."""
    for loop in loops:
        body, R, place = _frame(model, centres, loop.link, loop.point)
        other, R_o, to = _frame(model, centres, loop.to, loop.to_point)
        if loop.kind == "hinge":
            axis, to_axis = _unit(product(R, np.array(loop.axis))), _unit(product(R_o, np.array(loop.to_axis)))
            yield hinge(loop.name, Anchors(body, other, place, to, _turn_between(axis, to_axis)), axis)
        elif loop.kind == "weld":
            turn = product(R_o, rotation_from_rpy(*loop.rpy), R.T)
            yield weld(loop.name, Anchors(body, other, place, to, turn))
        elif loop.directions:
            along = [product(R_o, np.array(n)) for n in loop.directions]
            yield directions(loop.name, Anchors(body, other, place, to, IDENTITY), along)
        else:
            yield point(loop.name, Anchors(body, other, place, to, product(R_o, R.T)))


def _frame(model: Model, centres: Sequence[Array], link: str, at: Sequence[float]) -> tuple[int, Array, Array]:
    """The body of a link, or the ground; the link's axes in the body's, and a point of it from the mass centre."""
    if link not in model.links:
        return -1, IDENTITY, np.array(at, dtype=float)
    body, R, p = model.links[link]
    return body, R, p + product(R, np.array(at, dtype=float)) - centres[body]


def _unit(axis: Array) -> Array:
    unit: Array = axis / np.sqrt(product(axis, axis))
    return unit


def _turn_between(a: Array, b: Array) -> Array:
    """Return a rotation that takes the unit vector a to b: half a turn about a + b, after half a turn about a.

    Where they are opposite, half a turn about a vector across them.
    """
    middle = a + b
    if np.abs(middle).max() < 1e-6:
        middle = np.cross(a, np.eye(3)[int(np.argmin(np.abs(a)))])
        return _half_turn(_unit(middle))
    turn: Array = product(_half_turn(_unit(middle)), _half_turn(a))
    return turn


def _half_turn(axis: Array) -> Array:
    return 2.0 * np.outer(axis, axis) - np.eye(3)


@dataclass(frozen=True, eq=False)
class Posed:
    """A robot taken apart.

    Attributes:
        sample, terms: the motion without acceleration, and what the scene's effects make of it.
        system: its bodies, joints, mimic rules and loops.
        at: where the bodies are.
        matrices: of the equations of motion there, with the torques tau.
        length: of the robot: the largest distance between a mass centre and a joint [m], 1 where all are zero.
    """

    model: Model
    scene: Scene
    sample: Sample
    terms: Terms
    tau: Sequence[Scalar]
    system: System
    at: State
    matrices: Matrices
    length: float


def posed(model: Model, scene: Scene, q: Sequence[Scalar], qd: Sequence[Scalar], tau: Sequence[Scalar]) -> Posed:
    """Return the robot in a state; `q`, `qd` and `tau` may be any scalar.

    Raises:
        InputError: the scene does not fit the model, or says the axes of rotors.
    """
    for spin in spins(model, scene):
        what = f"[rotor] {spin.joint.name} has an axis, and bodies on their own know only rotors that turn in place"
        raise SceneError(what, remedy="leave axis and on out, or ask for another form of the equations")
    sample = Sample(model, tuple(q), tuple(qd), (0.0,) * model.n)
    terms = applied(bias_plan(model, scene).effects, sample, scene)
    centres = [inertia.centre_of_mass for inertia in terms.inertias]
    joints = joint_connections(model, centres, sample.q)
    mimics, loops = tuple(mimic_connections(model, joints)), tuple(loop_connections(model, centres, scene.loops))
    rotors = _rotors(model, scene)
    system = System(terms.inertias, joints, mimics, loops, rotors)
    at = state_of(model, centres, sample.q, sample.qd)
    found = matrices(system, at, terms.gravity, terms.wrenches, along_joints(model, system, terms, tau))
    arms = [*centres, *(body.joint.p - centres[body.parent] for body in model.bodies if body.parent >= 0)]
    size = max(length(np.asarray(arm, dtype=float)) for arm in arms) or 1.0
    return Posed(model, scene, sample, terms, tau, system, at, found, size)


def _rotors(model: Model, scene: Scene) -> dict[tuple[int, int], float]:
    """By pairs of bodies, what rotors add between their joints: G^2 J, and c_i c_k G^2 J of coupled motors."""
    rotors = {(i, i): inertia for i, _, inertia in armatures(model, scene)}
    for motor, turned in coupled_motors(model, scene):
        for i, _, first in turned if motor.reflected else ():
            for k, _, second in turned:
                rotors[i, k] = rotors.get((i, k), 0.0) + first * second * motor.reflected
    return rotors


def along_joints(model: Model, system: System, terms: Terms, tau: Sequence[Scalar]) -> list[Scalar]:
    """What acts along each joint's own coordinates: tau at the joint it belongs to, less friction and springs."""
    out: list[Scalar] = []
    for i, (body, connection) in enumerate(zip(model.bodies, system.joints, strict=True)):
        joint, taken = body.joint, terms.at_joint.get(i, 0.0)
        for k in range(len(connection.free)):
            out.append((0.0 if joint.mimics is not None else tau[joint.rate + k]) - taken)
    return out


def own_rates(model: Model, system: System, along: Sequence[Scalar]) -> list[Scalar]:
    """Return the n entries, in the order of `model.rates`, out of those of all joints in the order of the bodies."""
    out: list[Scalar] = [0.0] * model.n
    start = 0
    for body, connection in zip(model.bodies, system.joints, strict=True):
        width = len(connection.free)
        if body.joint.mimics is None:
            out[body.joint.rate : body.joint.rate + width] = along[start : start + width]
        start += width
    return out
