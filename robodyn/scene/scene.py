"""What a scene adds to a robot: gravity, friction, rotors, springs, payloads, external wrenches, a moving base."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from robodyn.support.frozen import FrozenValue

if TYPE_CHECKING:
    from robodyn.scene.motor import Motor

Vector = tuple[float, float, float]
Entry = float | str
"""A number, or the name of the trajectory column that holds one for every sample."""
GROUND = "ground"
"""What a loop calls the ground, where no link of the robot has that name."""


@dataclass(frozen=True)
class Friction(FrozenValue):
    """Friction of a joint: viscous qd, plus `forward` at qd > 0 or `backward` at qd < 0, plus Stribeck's excess.

    Attributes:
        viscous: N m s/rad (N s/m for a prismatic joint).
        forward, backward: Coulomb torque at qd > 0 and at qd < 0, with its sign [N m].
        stribeck: torque of breakaway [N m], which decays to Coulomb's like exp(-(qd / stribeck_velocity)^2).
        stribeck_velocity: rad/s.
    """

    viscous: float = 0.0
    forward: float = 0.0
    backward: float = 0.0
    stribeck: float | None = None
    stribeck_velocity: float = 0.01

    @property
    def dry(self) -> float:
        """The largest torque that does not fall to zero with the speed [N m]."""
        return max(abs(self.forward), abs(self.backward), abs(self.stribeck or 0.0))


@dataclass(frozen=True)
class Rotor(FrozenValue):
    """A motor's rotor and the gear behind it.

    Attributes:
        inertia: about its own axis [kg m^2]; None: that of the transmission, else 0.
        gear: turns of the motor per turn of the joint (rad/m if prismatic); None: that of the transmission, else 1.
    """

    inertia: float | None
    gear: float | None = None


@dataclass(frozen=True)
class Spring(FrozenValue):
    """A joint spring that pulls towards `rest` [rad] with `stiffness` [N m/rad]."""

    stiffness: float
    rest: float = 0.0


@dataclass(frozen=True)
class Payload(FrozenValue):
    """A mass fixed to a link.

    Attributes:
        mass: kg.
        com: centre of mass in the link's frame [m].
        inertia: ixx, ixy, ixz, iyy, iyz, izz about the centre of mass, in the link's axes [kg m^2].
    """

    link: str
    mass: float
    com: Vector = (0.0, 0.0, 0.0)
    inertia: tuple[float, float, float, float, float, float] = (0.0,) * 6


@dataclass(frozen=True)
class ExternalWrench(FrozenValue):
    """A force [N] and a moment [N m] that act ON a link at a point of its frame [m].

    Attributes:
        frame: the axes of force and moment: "link", "base" (those of the base link) or "world" (gravity's).
        force, moment: numbers or names of trajectory columns.
        cause: what exerts it: the surroundings, or a constraint whose force was found: "loop" or "contact".
        axes: another link whose axes they are in, in place of `frame`.
    """

    link: str
    force: tuple[Entry, Entry, Entry] = (0.0, 0.0, 0.0)
    moment: tuple[Entry, Entry, Entry] = (0.0, 0.0, 0.0)
    point: Vector = (0.0, 0.0, 0.0)
    frame: str = "link"
    cause: str = "surroundings"
    axes: str = ""

    @property
    def columns(self) -> tuple[str, ...]:
        """The trajectory columns that it needs."""
        return tuple(entry for entry in (*self.force, *self.moment) if isinstance(entry, str))


@dataclass(frozen=True)
class Immersed(FrozenValue):
    """A link in the scene's fluid.

    Attributes:
        volume: displaced [m^3], at `centre` in the link's frame [m].
        drag_area: drag coefficient times area along each axis of the link [m^2].
    """

    link: str
    volume: float = 0.0
    centre: Vector = (0.0, 0.0, 0.0)
    drag_area: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Drive(FrozenValue):
    """The torque at a joint in a simulation: `torque + kp (reference - q) + kd (speed - qd)`.

    Attributes:
        torque: N m (N for a prismatic joint), or the name of a column.
        kp, kd: N m/rad and N m s/rad.
        reference: rad, or the name of a column.
        speed: rad/s, or the name of a column; None: the slope of the reference, 0 where that is a number.
    """

    torque: Entry = 0.0
    kp: float = 0.0
    kd: float = 0.0
    reference: Entry = 0.0
    speed: Entry | None = None

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns of the simulation's table that it needs."""
        return tuple(entry for entry in (self.torque, self.reference, self.speed) if isinstance(entry, str))


@dataclass(frozen=True)
class LimitSpring(FrozenValue):
    """What pushes a joint back that is beyond a limit by x > 0: `max(stiffness x + damping xd, 0)`.

    Attributes:
        stiffness, damping: N m/rad and N m s/rad (N/m and N s/m for a prismatic joint).
    """

    stiffness: float
    damping: float = 0.0


@dataclass(frozen=True)
class Loop(FrozenValue):
    """A closure, by which the tree of links that a description is becomes a closed chain.

    Attributes:
        name: as reports call it.
        link, point: a point of this link, in its frame [m], is held at
        to, to_point: a point of that link, in its frame [m]; `to` may be GROUND.
        kind: "point", a ball joint of 3 equations; "hinge", of 5; or "weld", of 6.
        axis, to_axis: of a hinge, in the axes of `link` and of `to`.
        rpy: of a weld, how `link` is turned in the axes of `to` [rad].
        directions: of a point, the directions in the axes of `to` along which it is held; all if empty.
    """

    name: str
    link: str
    point: Vector = (0.0, 0.0, 0.0)
    to: str = GROUND
    to_point: Vector = (0.0, 0.0, 0.0)
    kind: str = "point"
    axis: Vector = (0.0, 0.0, 0.0)
    to_axis: Vector = (0.0, 0.0, 0.0)
    rpy: Vector = (0.0, 0.0, 0.0)
    directions: tuple[Vector, ...] = ()


ALWAYS, AUTO = "always", "auto"
"""Of a contact, `on`: in every sample, or where its points are low and slow."""


@dataclass(frozen=True)
class Contact(FrozenValue):
    """Where a link stands on something, which presses on it and rubs, and does not pull.

    Attributes:
        name: as reports call it.
        link, points: the points of the link that may touch, in its frame [m]: one, or the corners of a polygon.
        normal: in the axes of the ground, out of what it stands on; None: against gravity.
        friction: coefficient of Coulomb's cone.
        on: ALWAYS; AUTO; the name of a column that is not 0 where it touches; or intervals of time (from, to) [s].
        level, height, speed: with AUTO each of its points touches where it is at most `height` [m] above the plane
            `normal . p = level` [m] and slower than `speed` [m/s].
    """

    name: str
    link: str
    points: tuple[Vector, ...] = ((0.0, 0.0, 0.0),)
    normal: Vector | None = None
    friction: float = 0.7
    on: str | tuple[tuple[float, float], ...] = ALWAYS
    level: float = 0.0
    height: float = 0.01
    speed: float = 0.1

    @property
    def columns(self) -> tuple[str, ...]:
        """The trajectory columns that it needs."""
        return (self.on,) if isinstance(self.on, str) and self.on not in (ALWAYS, AUTO) else ()


@dataclass(frozen=True)
class ContactCost(FrozenValue):
    """What contact forces make least, of all that balance: `forces |f|^2 / W^2 + torques sum (tau / limit)^2`.

    Attributes:
        forces, torques: weights of the forces, relative to the robot's weight W, and of torques relative to limits.
        within_limits: whether torques may not exceed the effort limits.
    """

    forces: float = 1.0
    torques: float = 0.0
    within_limits: bool = False


EFFORT = "effort"
"""As a weight: 1 / (effort limit)^2."""


@dataclass(frozen=True)
class Scene(FrozenValue):
    """What surrounds the robot. The default scene is gravity alone, and the friction that the description declares.

    Nothing in a scene can be edited; `dataclasses.replace(scene, friction={**scene.friction, "elbow": Friction(0.3)})`
    is another. Scenes are compared by content.

    Attributes:
        gravity: m/s^2, in the axes of the ground (of a fixed base).
        friction: by joint; replaces what the description says of that joint.
        rotor, spring, motor: by joint.
        immersed: links in a fluid of `fluid_density` [kg/m^3] that streams at `fluid_velocity` [m/s, ground's axes].
        moving_base: the base follows the trajectory's base_* columns; in a simulation it is free.
        held: something carries the base, whatever that takes: a bolted stand, or a vehicle under a base that moves.
        slip_speed: Coulomb friction is f qd / sqrt(qd^2 + slip_speed^2) [rad/s]; 0: f sign(qd).
        initial_q, initial_qd: by coordinate and by rate, where a simulation begins, a number or the name of a column,
            of which the first row counts; 0 where nothing is said.
        drive: by joint, what drives it in a simulation; the others are free.
        between_rows: torques and wrenches of a simulation's table are "linear" between its rows, or "hold" the last.
        joint_limits: "stop" ends a simulation where a joint reaches a limit; "ignore" does not look; "spring" is
            `limit_spring` at every limit.
        loops: closures.
        baumgarte: 0: positions and speeds are projected onto the loops after each step; else the rate [1/s] at which
            Baumgarte's terms let errors of the loops decay.
        actuated: joints that drive; None: all but those of `passive`, or of closed chains those of `drive`.
        passive: joints that nothing drives.
        share: how redundant actuators share: "least" of the sum of their squares, or "weighted" by `weights`.
        weights: by joint, of tau^2 in that sum, a number or EFFORT; `weight` of the others.
        contacts: where links may stand on something.
        contact_cost: which of the contact forces that balance are taken.
    """

    gravity: Vector = (0.0, 0.0, -9.81)
    friction: Mapping[str, Friction] = field(default_factory=dict)
    rotor: Mapping[str, Rotor] = field(default_factory=dict)
    spring: Mapping[str, Spring] = field(default_factory=dict)
    payloads: tuple[Payload, ...] = ()
    wrenches: tuple[ExternalWrench, ...] = ()
    immersed: tuple[Immersed, ...] = ()
    fluid_density: float = 0.0
    fluid_velocity: Vector = (0.0, 0.0, 0.0)
    moving_base: bool = False
    held: bool = False
    slip_speed: float = 0.0
    initial_q: Mapping[str, Entry] = field(default_factory=dict)
    initial_qd: Mapping[str, Entry] = field(default_factory=dict)
    drive: Mapping[str, Drive] = field(default_factory=dict)
    between_rows: str = "linear"
    joint_limits: str = "stop"
    limit_spring: LimitSpring | None = None
    loops: tuple[Loop, ...] = ()
    baumgarte: float = 0.0
    actuated: tuple[str, ...] | None = None
    passive: tuple[str, ...] = ()
    share: str = "least"
    weights: Mapping[str, Entry] = field(default_factory=dict)
    weight: Entry = 1.0
    contacts: tuple[Contact, ...] = ()
    contact_cost: ContactCost = ContactCost()
    motor: Mapping[str, Motor] = field(default_factory=dict)

    def __hash__(self) -> int:
        return self._hash

    def changed(self, gravity: Vector | None = None, payloads: Sequence[Payload] = (), *, held: bool = False) -> Scene:
        """Return the scene with another gravity [m/s^2], if one is given, more payloads, and a base that is held."""
        gravity = self.gravity if gravity is None else gravity
        return replace(self, gravity=gravity, payloads=(*self.payloads, *payloads), held=held or self.held)

    @property
    def constrained(self) -> bool:
        """Whether joint torques are not those of the open tree alone: loops, contacts, or joints that do not drive."""
        return bool(self.loops or self.contacts or self.passive) or self.actuated is not None

    @property
    def constraint_names(self) -> tuple[str, ...]:
        """The names of loops, then of contacts."""
        return (*(loop.name for loop in self.loops), *(contact.name for contact in self.contacts))

    @property
    def columns(self) -> tuple[str, ...]:
        """The trajectory columns that its wrenches need, each once."""
        return tuple(dict.fromkeys(name for wrench in self.wrenches for name in wrench.columns))

    @property
    def motion_columns(self) -> tuple[str, ...]:
        """The columns that a trajectory must have: those of wrenches and contacts."""
        return tuple(dict.fromkeys([*self.columns, *(name for each in self.contacts for name in each.columns)]))

    @property
    def table_columns(self) -> tuple[str, ...]:
        """The columns that a simulation's table must have: those of wrenches, drives and the initial state."""
        driven = [name for drive in self.drive.values() for name in drive.columns]
        initial = [entry for part in (self.initial_q, self.initial_qd) for entry in part.values()]
        return tuple(dict.fromkeys([*self.columns, *driven, *(x for x in initial if isinstance(x, str))]))


DEFAULT = Scene()
