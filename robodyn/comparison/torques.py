"""What differences do: the largest of each torque over poses and motions within the limits, and who is guilty of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robodyn.comparison.alignment import Pair
from robodyn.comparison.differences import Difference
from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.robot.limits import MOST_EFFORT, binding, coordinate_ranges
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats

RELATIVE = 1e-4
"""Of a joint's largest torque: less is rounding of texts, where no tolerance is given."""
PARTS = ("gravity", "inertia", "velocity")
"""What a torque is split into: of the pose at rest, of accelerations, and of speeds (Coriolis and friction)."""
_SAMPLES, _ROUNDS, _AROUND = 2048, 4, 32
_SEED = 20_26
_MOST_SPEED = 100.0
"""rad/s or m/s: a limit of speed that stands for none."""


@dataclass(frozen=True, eq=False)
class TorqueDifference:
    """The largest difference of a joint's torque that was found.

    Attributes:
        joint: of A. unit: N m or N.
        worst: in all, of a motion; parts: by `PARTS`, each the largest of its own.
        largest: torque of the joint in A over the same motions.
        limit: of effort, None where there is none.
        pose, speed, acceleration: by coordinate of A, where it is worst.
        a, b: the torques there, b's in the sense of A's joint.
        difference: which single difference explains most of it, None if none does; `explains` which share.
    """

    joint: str
    unit: str
    worst: float
    parts: Mapping[str, float]
    largest: float
    limit: float | None
    pose: Mapping[str, float]
    speed: Mapping[str, float]
    acceleration: Mapping[str, float]
    a: float
    b: float
    difference: Difference | None = None
    explains: float = 0.0

    @property
    def share(self) -> float:
        """Of the limit of effort or, without one, of the largest torque."""
        scale = self.limit or self.largest
        return self.worst / scale if scale else (1.0 if self.worst else 0.0)

    def exceeds(self, tolerance: float | None) -> bool:
        return self.worst > (RELATIVE * self.largest if tolerance is None else tolerance) + 1e-12


@dataclass(frozen=True, eq=False)
class _Robot:
    """One of both with its base on the ground and its loops open, as torques are compared."""

    model: Model
    scene: Scene

    def torques(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        return inverse_dynamics(self.model, q, qd, qdd, scene=self.scene)


def torque_differences(
    a: Model, b: Model, scenes: tuple[Scene, Scene], pairs: Sequence[Pair], found: Sequence[Difference]
) -> tuple[tuple[TorqueDifference, ...], tuple[str, ...]]:
    """Return the largest difference of each joint that both have, and notes on what was not compared.

    2048 random motions within the limits of both (a joint without a range: one turn, 1 m; without a limit of speed:
    2 rad/s or m/s; accelerations: that speed within 0.25 s), then a search around the worst of each joint: it is what
    was found, no bound. Joints that one robot lacks stand still; a moving base stands on the ground.
    """
    mine, theirs = _Robot(*_grounded(a, scenes[0])), _Robot(*_grounded(b, scenes[1]))
    notes = []
    if scenes[0].loops or scenes[1].loops:
        notes.append("torques are those of the open chains: loops share them otherwise")
    if any(joint.kind == "floating" for each in (mine, theirs) for joint in each.model.independent):
        return (), (*notes, "torques are not compared: a body inside the robot moves freely")
    to_b = _Map(mine.model, theirs.model, pairs)
    if not to_b.rows:
        return (), (*notes, "torques are not compared: no joint of both moves")
    rng = np.random.default_rng(_SEED)
    low, high = to_b.ranges()
    states = low + rng.random((_SAMPLES, low.size)) * (high - low)
    states[0] = np.clip(0.0, low, high)
    tau_a, tau_b = to_b.parts(mine, theirs, states)
    for step in range(_ROUNDS):
        best = sorted({int(k) for k in np.argmax(np.abs(tau_b - tau_a), axis=1).ravel()})
        more = np.repeat(states[best], _AROUND, axis=0)
        more += rng.uniform(-1.0, 1.0, more.shape) * 0.25 ** (step + 1) * (high - low)
        states = np.concatenate([states, np.clip(more, low, high)])
        new = to_b.parts(mine, theirs, states[-len(more) :])
        tau_a, tau_b = (np.concatenate(both, axis=1) for both in zip((tau_a, tau_b), new, strict=True))
    apart = np.abs(tau_b - tau_a)
    out = []
    for k, (joint, _, _) in enumerate(to_b.rows):
        at = int(np.argmax(apart[0, :, k]))
        state, limit = to_b.full(states[at]), binding(joint.effort)
        pose, speed, acceleration = (
            dict(zip(mine.model.joint_names, part.tolist(), strict=True)) for part in np.split(state, 3)
        )
        one = TorqueDifference(
            joint=joint.name,
            unit="N" if joint.kind == "prismatic" else "N m",
            worst=float(apart[0, at, k]),
            parts={name: float(apart[1 + part, :, k].max()) for part, name in enumerate(PARTS)},
            largest=float(np.abs(tau_a[0, :, k]).max()),
            limit=limit if limit is not None and limit < MOST_EFFORT else None,
            pose=pose,
            speed=speed,
            acceleration=acceleration,
            a=float(tau_a[0, at, k]),
            b=float(tau_b[0, at, k]),
        )
        out.append(_with_guilt(one, mine, joint.rate, state, found))
    return tuple(out), tuple(notes)


def _with_guilt(
    one: TorqueDifference, mine: _Robot, rate: int, state: Floats, found: Sequence[Difference]
) -> TorqueDifference:
    """Say which difference alone, exchanged in A, brings its torque nearest to B's at this state."""
    if not one.exceeds(None):
        return one
    q, qd, qdd = np.split(state, 3)
    best, explains = None, 0.0
    for difference in found:
        if difference.exchange is None:
            continue
        model, scene = difference.exchange(mine.model, mine.scene)
        tau = inverse_dynamics(model, q, qd, qdd, scene=scene, executor="numpy")[rate]
        share = 1.0 - abs(one.b - float(tau)) / one.worst
        if share > explains + 1e-9:
            best, explains = difference, share
    return replace(one, difference=best, explains=explains)


class _Map:
    """From states of A to states of B, q_b = q_a S + o, and back from torques of B to those of A by the transpose.

    A joint that follows another in A and moves by itself in B follows there, too, so that its torque is a part of the
    other's.
    """

    def __init__(self, a: Model, b: Model, pairs: Sequence[Pair]) -> None:
        self.a, self.b = a, b
        self.rows: list[tuple[Joint, Joint, Pair]] = []
        both = [(a.bodies[pair.a].joint, b.bodies[pair.b].joint, pair) for pair in pairs]
        both = [row for row in both if row[0].kind == row[1].kind in ("revolute", "prismatic") and not row[1].mimics]
        self.rows = [row for row in both if row[0].mimics is None]
        at = {one.rate: k for k, (one, _, _) in enumerate(self.rows)}
        self.S, self.o = np.zeros((len(self.rows), b.n)), np.zeros(b.n)
        for one, other, pair in both:
            if one.rate in at:
                self.S[at[one.rate], other.rate] = pair.sign * one.multiplier
                self.o[other.rate] = pair.sign * one.offset + pair.offset

    def ranges(self) -> tuple[Floats, Floats]:
        """Least and largest positions, speeds and accelerations of the common joints, in A's sense."""
        mine, theirs = coordinate_ranges(self.a), coordinate_ranges(self.b)
        ends, speeds = [], []
        for one, other, pair in self.rows:
            most = 1.0 if one.kind == "prismatic" else np.pi
            there = [pair.sign * (end[other.coordinate] - pair.offset) for end in theirs]
            low = max(mine[0][one.coordinate], min(there), -2.0 * most)
            high = min(mine[1][one.coordinate], max(there), 2.0 * most)
            ends.append((low, high) if low < high and high - low < 4.0 * most else (-most, most))
            limits = [binding(joint.velocity) for joint in (one, other)]
            speeds.append(min((limit for limit in limits if limit is not None and limit < _MOST_SPEED), default=2.0))
        low, high = np.array(ends, dtype=float).T
        speed = np.array(speeds)
        return np.concatenate([low, -speed, -4.0 * speed]), np.concatenate([high, speed, 4.0 * speed])

    def full(self, states: Floats) -> Floats:
        """States of all of A's coordinates; those that B lacks are zero."""
        out = np.zeros((*states.shape[:-1], 3, self.a.n))
        out[..., [one.rate for one, _, _ in self.rows]] = states.reshape(*states.shape[:-1], 3, -1)
        return out.reshape(*states.shape[:-1], -1)

    def other(self, states: Floats) -> Floats:
        out = states.reshape(*states.shape[:-1], 3, -1) @ self.S
        out[..., 0, :] += self.o
        return out.reshape(*states.shape[:-1], -1)

    def parts(self, mine: _Robot, theirs: _Robot, states: Floats) -> tuple[Floats, Floats]:
        """Return torques (4, samples, joints) of A and of B in A's sense: in all, of the pose, of accelerations, of
        speeds."""
        both = []
        for robot, full in ((mine, self.full(states)), (theirs, self.other(states))):
            q, qd, qdd = np.split(full, 3, axis=-1)
            still = np.zeros_like(q)
            whole, rest = robot.torques(q, qd, qdd), robot.torques(q, still, still)
            both.append([whole, rest, robot.torques(q, still, qdd) - rest, robot.torques(q, qd, still) - rest])
        return np.stack(both[0]).take([one.rate for one, _, _ in self.rows], axis=-1), np.stack(both[1]) @ self.S.T


def _grounded(model: Model, scene: Scene) -> tuple[Model, Scene]:
    """Return the model with its base on the ground, and the scene without what a base or loops need."""
    plain = replace(scene, loops=(), contacts=(), moving_base=False, held=False, wrenches=(), drive={})
    plain = replace(plain, initial_q={}, initial_qd={}, actuated=None, passive=(), weights={})
    if not model.floating:
        return model, plain
    bodies = []
    for i, body in enumerate(model.bodies):
        joint = body.joint
        if i == 0:
            joint = replace(joint, kind="fixed", coordinate=-1, rate=-1, R=np.eye(3), p=np.zeros(3))
        else:
            joint = replace(joint, coordinate=joint.coordinate - 7, rate=joint.rate - 6)
        bodies.append(replace(body, joint=joint))
    return Model(model.name, model.file, tuple(bodies), model.links, model.notes, None), plain
