"""What an effect is, and what effects add up to."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from robodyn.programs.vectors import ZERO, Array, Scalar
from robodyn.robot.kinematics import Motion, Wrench, motions
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import Scene
from robodyn.solids.inertia.laws import Inertia

ZeroColumns = frozenset[tuple[str, int]]
"""The (source, column) pairs of q, qd and qdd that are zero in every sample."""


@dataclass(frozen=True)
class Sample:
    """One sample of a motion, in any scalar; `columns` are those that the scene names."""

    model: Model
    q: tuple[Scalar, ...]
    qd: tuple[Scalar, ...]
    qdd: tuple[Scalar, ...]
    columns: Mapping[str, Scalar] = field(default_factory=dict)

    def motions(self) -> list[Motion]:
        return motions(self.model, self.q, self.qd, self.qdd)

    def position(self, joint: Joint) -> Scalar:
        """Return the joint's own position, which for a mimic joint is `multiplier q + offset` [rad or m]."""
        return joint.multiplier * self.q[joint.coordinate] + joint.offset

    def speed(self, joint: Joint) -> Scalar:
        return joint.multiplier * self.qd[joint.rate]

    def acceleration(self, joint: Joint) -> Scalar:
        return joint.multiplier * self.qdd[joint.rate]


@dataclass(frozen=True)
class Terms:
    """What the recursion is given for one sample; each effect returns it with something added.

    Attributes:
        gravity: in the ground's axes. wrenches: (i, wrench) acting ON body i, about its origin and in its axes.
        at_joint: added to the torque at each body's joint; through_gear: the part of it that passes the gear, of
            springs.
        load: by body, the share of the torque through the gear that friction adds, negative where qd is.
        spins: (i, rate, moment) a unit of a rate's acceleration asks for this moment on body i, in its axes, besides
            `inertias`; that of body i asks as much along the rate.
    """

    qd: tuple[Scalar, ...]
    qdd: tuple[Scalar, ...]
    inertias: tuple[Inertia, ...]
    gravity: Array = field(default_factory=lambda: ZERO)
    wrenches: tuple[tuple[int, Wrench], ...] = ()
    at_joint: Mapping[int, Scalar] = field(default_factory=dict)
    through_gear: Mapping[int, Scalar] = field(default_factory=dict)
    load: Mapping[int, Scalar] = field(default_factory=dict)
    spins: tuple[tuple[int, int, Array], ...] = ()

    def with_torques(self, torques: Iterable[tuple[int, Scalar]], through_gear: bool = False) -> Terms:
        """These terms with more torque at the joints of some bodies, given as (body, torque)."""
        at_joint, passing = dict(self.at_joint), dict(self.through_gear)
        for body, torque in torques:
            at_joint[body] = at_joint.get(body, 0.0) + torque
            if through_gear:
                passing[body] = passing.get(body, 0.0) + torque
        return replace(self, at_joint=at_joint, through_gear=passing)


class Verdict(NamedTuple):
    active: bool
    reason: str

    @classmethod
    def of(cls, acting: object, none: str, some: str) -> Verdict:
        """On, as something acts, or off as nothing does."""
        return cls(bool(acting), some if acting else none)

    @classmethod
    def of_joints(
        cls, joints: list[Joint], moving: tuple[str, ZeroColumns], none: str, still: str, some: str
    ) -> Verdict:
        """On where there are joints of a kind, and columns of `moving` that are not zero for one of them."""
        source, zero_columns = moving
        at_rest = all((source, joint.rate) in zero_columns for joint in joints)
        return cls.of(joints and not at_rest, still if joints else none, f"{len(joints)} {some}")


class Effect:
    """One physical effect: a subclass, whose one instance is named among `plan.EFFECTS`.

    name: as reports print it; adds: what it adds to tau, in a few words; by_load: whether it depends on the torques
    that the others make, so that it is what is missing without it.
    """

    name: str
    adds: str
    by_load = False

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        raise NotImplementedError

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        raise NotImplementedError

    def background(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        """What must be on for the effect to show itself when it stands alone; for most, nothing."""
        return terms

    def stored(self, sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
        """The energy that it stores [J]."""
        return 0.0

    def lost(self, sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
        """The power that it takes from the joints [W]."""
        return 0.0
