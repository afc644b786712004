"""The Model: a description as dynamics sees it, a list of bodies in which parents come first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from robodyn.programs.vectors import length
from robodyn.solids.inertia.laws import Inertia
from robodyn.support.floats import Floats
from robodyn.support.frozen import Frozen
from robodyn.support.wording import Cell, Shown, count, figure, listed, shown, shown_path

if TYPE_CHECKING:
    from robodyn.robot.urdf.parts import Description


@dataclass(frozen=True, eq=False)
class Joint(Frozen):
    """What carries a body: its motion relative to the parent body.

    Attributes:
        name: of the URDF joint ("base" for the joint that carries the base).
        kind: "fixed" (the base only), "revolute", "prismatic" or "floating".
        R, p: (3, 3), (3,) placement in the parent body's frame at q = 0 [m].
        axis: (3,) unit vector in the body's axes.
        coordinate: name of the coordinate that moves it, and where its values start in q and in qd.
        multiplier, offset: q_joint = multiplier q + offset; 1 and 0 but for mimic joints.
        lower, upper, effort, velocity: limits, None where the description has none [rad or m, N m or N, rad/s or m/s].
        damping, friction: of the description [N m s/rad, N m].
        reduction: mechanical reduction of its transmission, 1 without one.
        rotor_inertia: of its transmission [kg m^2], 0 without one.
        link: its parent link, "" where that is none of the description's.
    """

    name: str
    kind: str
    R: Floats
    p: Floats
    axis: Floats
    coordinate: int = -1
    rate: int = -1
    multiplier: float = 1.0
    offset: float = 0.0
    continuous: bool = False
    mimics: str | None = None
    lower: float | None = None
    upper: float | None = None
    effort: float | None = None
    velocity: float | None = None
    damping: float = 0.0
    friction: float = 0.0
    reduction: float = 1.0
    rotor_inertia: float = 0.0
    link: str = ""


@dataclass(frozen=True, eq=False)
class Body(Frozen):
    """Links that move as one. Its frame is that of the link that its joint carries, whose name it bears."""

    name: str
    parent: int
    joint: Joint
    inertia: Inertia


class Frame(NamedTuple):
    """A link's place: the body that it is part of, and its rotation and origin in that body's frame."""

    body: int
    R: Floats
    p: Floats


@dataclass(frozen=True, eq=False, repr=False)
class Model(Shown, Frozen):
    """A tree of bodies; bodies[0] is the base and bodies[i].parent < i.

    Attributes:
        name, file: of the description.
        bodies: one per moving link, with the links fixed to it merged in exactly.
        links: where every link of the description is.
        notes: what was assumed or looks wrong, a line each.
        description: what it was made of.
    """

    name: str
    file: str
    bodies: tuple[Body, ...]
    links: Mapping[str, Frame]
    notes: tuple[str, ...] = ()
    description: Description | None = None

    def _lines(self) -> Sequence[str]:
        heavy = sum(body.inertia.m > 0.0 for body in self.bodies)
        return (
            f"Model {shown(self.name)} of {shown_path(self.file)}, {'moving' if self.floating else 'fixed'} base",
            f"{count(self.n, 'degree')} of freedom, joints: {listed(self.joint_names) or 'none'}",
            f"{figure(self.total_mass, 4)} kg in {heavy} of {count(len(self.bodies), 'body', 'bodies')}",
        )

    def _table(self) -> tuple[Sequence[str], Sequence[Sequence[Cell]]]:
        units = {"revolute": "rad, N m, rad/s", "prismatic": "m, N, m/s"}
        rows: list[list[Cell]] = []
        for body in self.bodies:
            joint, mass = body.joint, float(body.inertia.m)
            limits = joint.lower, joint.upper, joint.effort, joint.velocity
            rows.append([body.name, mass, joint.name, joint.kind, *limits, units.get(joint.kind, "")])
        return ("body", "mass [kg]", "joint", "kind", "lower", "upper", "effort", "velocity", "in"), rows

    def _repr_html_(self) -> str:
        return f"{super()._repr_html_()}<p><code>robodyn.view(model)</code> shows it in 3-D.</p>"

    @cached_property
    def parents(self) -> tuple[int, ...]:
        """parents[i] < i is the body that carries body i; -1 is the ground."""
        return tuple(body.parent for body in self.bodies)

    @cached_property
    def independent(self) -> tuple[Joint, ...]:
        """The joints that have coordinates of their own (all but fixed and mimic joints), in the order of q."""
        joints = [body.joint for body in self.bodies if body.joint.kind != "fixed" and body.joint.mimics is None]
        return tuple(sorted(joints, key=lambda joint: joint.coordinate))

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the entries of q; a floating joint J has J_x J_y J_z J_qx J_qy J_qz J_qw."""
        return _names(self.independent, ("x", "y", "z", "qx", "qy", "qz", "qw"))

    @cached_property
    def rates(self) -> tuple[str, ...]:
        """Names of the entries of qd, qdd and tau; a floating joint J has J_wx J_wy J_wz J_vx J_vy J_vz."""
        return _names(self.independent, ("wx", "wy", "wz", "vx", "vy", "vz"))

    @cached_property
    def quaternions(self) -> tuple[tuple[str, int], ...]:
        """Names of the floating joints, and where in q their qx qy qz qw begin."""
        return tuple((joint.name, joint.coordinate + 3) for joint in self.independent if joint.kind == "floating")

    @cached_property
    def tips_first(self) -> tuple[int, ...]:
        """The entries of tau from the tips of the tree to its base, one branch after another."""
        rates = [body.joint.rate for body in reversed(self.bodies) if body.joint.kind != "fixed"]
        return tuple(dict.fromkeys(rates))

    @property
    def nq(self) -> int:
        """The number of entries of q: one per joint, seven per floating joint."""
        return len(self.coordinates)

    @property
    def n(self) -> int:
        """Degrees of freedom: the number of entries of qd, qdd and tau."""
        return len(self.rates)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints with a coordinate of their own, in the order of q."""
        return tuple(joint.name for joint in self.independent)

    @cached_property
    def total_mass(self) -> float:
        """kg."""
        return float(sum(body.inertia.m for body in self.bodies))

    @property
    def reach(self) -> float:
        """How far from the base's origin a mass centre can be at most, sliders at their farthest limits [m]."""
        lengths: list[float] = []
        for body in self.bodies:
            joint = body.joint
            slide = max(abs(joint.lower or 0.0), abs(joint.upper or 0.0)) if joint.kind == "prismatic" else 0.0
            before = lengths[body.parent] if body.parent >= 0 else 0.0
            lengths.append(before + length(joint.p) + slide)
        centres = (length(body.inertia.centre_of_mass) for body in self.bodies)
        return max(length + centre for length, centre in zip(lengths, centres, strict=True))

    @property
    def floating(self) -> bool:
        """Whether the base moves; its seven coordinates then come first."""
        return self.bodies[0].joint.kind == "floating"


def _names(joints: tuple[Joint, ...], floating: tuple[str, ...]) -> tuple[str, ...]:
    names: list[str] = []
    for joint in joints:
        names += [f"{joint.name}_{part}" for part in floating] if joint.kind == "floating" else [joint.name]
    return tuple(names)
