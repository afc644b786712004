"""A scene: what surrounds a robot. Each field of these dataclasses is a key of scene.toml; its type says what may stand
there (see `toml_table`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import pi
from typing import TYPE_CHECKING, Annotated, Any

from robodyn.support.frozen import FrozenValue
from robodyn.support.wording import call_of

if TYPE_CHECKING:
    from robodyn.scene.uncertainty import Uncertainty

Curve = tuple[tuple[float, float], ...]
"""(speed, torque) points with increasing speeds, straight lines between them; nothing beyond the last speed."""
GROUND = "ground"
"""What a loop calls the ground, where no link of the robot has that name."""
ALWAYS, AUTO = "always", "auto"
"""Of a contact, `on`: in every sample, or where its points are low and slow."""


@dataclass(frozen=True)
class Rule:
    """What a value must be beside of its type, and what to write where it is not; part of the type of a field."""

    holds: Callable[[Any], bool]
    remedy: str


def one_of(*words: str) -> Rule:
    return Rule(lambda word: word in words, f"one of: {', '.join(words)}")


Vector = tuple[float, float, float]
Entry = float | str
"""A number, or the name of the trajectory column that holds one for every sample."""
Positive = Annotated[float, Rule(lambda x: x > 0.0, "it is positive")]
NonNegative = Annotated[float, Rule(lambda x: x >= 0.0, "it is positive or zero")]
Direction = Annotated[Vector, Rule(any, "give a vector that has a direction")]
DryTorque = Annotated[float, Rule(lambda x: x >= 0.0, "positive or zero: else it drives the joint")]
_Load = Annotated[float, Rule(lambda x: 0.0 <= x < 1.0, "it is a share, 0 or more and less than 1")]
_Efficiency = Annotated[float, Rule(lambda x: 0.0 < x <= 1.0, "a share above 0 and up to 1, such as 0.85 of 85 %")]
_Areas = Annotated[Vector, Rule(lambda areas: min(areas) >= 0.0, "positive or zero: drag opposes motion by itself")]
_ForcesWeight = Annotated[float, Rule(lambda x: x > 0.0, "it is positive: torques alone leave forces open")]
IfKnown = Annotated[float, Rule(lambda x: x > 0.0, "it is positive; leave it out if it is not known")]
_Physical = Annotated[float, Rule(lambda x: 1e-12 <= x <= 1e12, "positive, in SI units: 1e-12 to 1e12")]
_Celsius = Annotated[float, Rule(lambda x: -100.0 <= x <= 100.0, "degrees Celsius, such as 25: from -100 to 100")]
_Limit = Annotated[float, Rule(lambda x: 0.0 < x <= 1000.0, "degrees Celsius, such as 155: above 0")]
_Copper = Annotated[float, Rule(lambda x: 0.0 <= x <= 0.0045, "1/K, such as 0.00393 of copper, or 0")]
_Magnet = Annotated[float, Rule(lambda x: -0.004 <= x <= 0.0, "1/K, such as -0.001: hot magnets are weaker; or 0")]


@dataclass(frozen=True)
class Friction(FrozenValue):
    """Friction of a joint: viscous qd [N m s/rad], plus Coulomb's `forward` at qd > 0 or `backward` at qd < 0 [N m].

    Attributes:
        stribeck: torque of breakaway [N m], which decays to Coulomb's like exp(-(qd / stribeck_velocity)^2) [rad/s].
        load: share of the torque that the joint passes on to the links, from 0 to less than 1.
    """

    viscous: DryTorque = 0.0
    forward: float = 0.0
    backward: float = 0.0
    stribeck: DryTorque | None = None
    stribeck_velocity: Positive = 0.01
    load: _Load = 0.0

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
        lead: of the screw or the pinion that drives a prismatic joint [m per turn]; `gear` then is turns of the motor
            per turn of it, 1 if None.
        axis: about which it spins at ratio qd, in the axes of the link `on`; None: the joint's.
        on: the link that carries it; "": the joint's parent.
    """

    inertia: NonNegative | None
    gear: float | None = None
    axis: Vector | None = None
    on: str = ""
    lead: Positive | None = None

    @property
    def ratio(self) -> float | None:
        """Turns of the motor per turn of the joint, rad/m of a slide; None if only the transmission says it."""
        if self.lead is None:
            return self.gear
        return (1.0 if self.gear is None else self.gear) * 2.0 * pi / self.lead

    @property
    def spins(self) -> bool:
        """Whether its gyroscopic moments count, as its axis or its carrier is said."""
        return self.axis is not None or bool(self.on)


@dataclass(frozen=True)
class CoupledMotor(FrozenValue):
    """A motor that turns with a sum of joints: its joint-side speed is `s = sum coefficient qd`; `inertia` is of its
    rotor, about its own axis [kg m^2], which turns `gear` times per unit of s."""

    name: str
    joints: Mapping[str, float]
    inertia: NonNegative = 0.0
    gear: float = 1.0
    friction: Friction = field(default_factory=Friction)

    def __hash__(self) -> int:
        return self._hash

    @property
    def reflected(self) -> float:
        """G^2 J [kg m^2]."""
        return self.gear * self.gear * self.inertia

    @property
    def acts(self) -> bool:
        return any(self.joints.values()) and bool(self.reflected or self.friction.viscous or self.friction.dry)


@dataclass(frozen=True)
class Spring(FrozenValue):
    """A joint spring that pulls towards `rest` [rad] with `stiffness` [N m/rad]."""

    stiffness: float
    rest: float = 0.0


@dataclass(frozen=True)
class Payload(FrozenValue):
    """A mass [kg] fixed to a link: its centre in the link's frame [m], and ixx, ixy, ixz, iyy, iyz, izz about that, in
    the link's axes [kg m^2]."""

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
    frame: Annotated[str, one_of("link", "base", "world")] = "link"
    cause: str = "surroundings"
    axes: str = ""

    @property
    def columns(self) -> tuple[str, ...]:
        return tuple(entry for entry in (*self.force, *self.moment) if isinstance(entry, str))


@dataclass(frozen=True)
class Immersed(FrozenValue):
    """A link in the scene's fluid: displaced volume [m^3] at `centre` in the link's frame [m], and drag coefficient
    times area along each axis of the link [m^2]."""

    link: str
    volume: NonNegative = 0.0
    centre: Vector = (0.0, 0.0, 0.0)
    drag_area: _Areas = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Drive(FrozenValue):
    """The torque at a joint in a simulation: `torque + kp (reference - q) + kd (speed - qd)`, in N m and rad; torque,
    reference and speed may be names of columns, and a speed of None is the slope of the reference."""

    torque: Entry = 0.0
    kp: float = 0.0
    kd: float = 0.0
    reference: Entry = 0.0
    speed: Entry | None = None

    @property
    def columns(self) -> tuple[str, ...]:
        return tuple(entry for entry in (self.torque, self.reference, self.speed) if isinstance(entry, str))


@dataclass(frozen=True)
class LimitSpring(FrozenValue):
    """What pushes a joint back beyond a limit by x > 0: `max(stiffness x + damping xd, 0)` [N m/rad, N m s/rad]."""

    stiffness: Positive
    damping: NonNegative = 0.0


@dataclass(frozen=True)
class Thermal(FrozenValue):
    """A motor's winding and housing as two heat capacities, and what heats them: the winding's loss R (T / k)^2, with
    `R = resistance (1 + resistance_coefficient (t - reference))` and k from `torque_constant` in the same way.

    Attributes:
        resistance, torque_constant: [ohm, N m/A] at the temperature `reference`, of one and the same current.
        resistance_coefficient, torque_coefficient: of the winding's metal and of the magnets [1/K].
        winding_housing, housing_ambient: thermal resistances [K/W].
        winding_capacity, housing_capacity: [J/K]. Without those of the housing it stays at `ambient`.
        start: of winding and housing; None: at `ambient`. All temperatures in degrees Celsius.
        winding_limit, housing_limit: what they bear for ever.
        drive_efficiency: of the servo drive between motor and DC bus.
    """

    resistance: _Physical
    torque_constant: _Physical
    winding_housing: _Physical
    winding_capacity: _Physical
    winding_limit: _Limit
    housing_ambient: _Physical | None = None
    housing_capacity: _Physical | None = None
    housing_limit: _Limit | None = None
    reference: _Celsius = 25.0
    resistance_coefficient: _Copper = 0.00393
    torque_coefficient: _Magnet = 0.0
    ambient: _Celsius = 25.0
    start: _Celsius | None = None
    drive_efficiency: _Efficiency = 1.0


@dataclass(frozen=True)
class GearLife(FrozenValue):
    """Life of a gear, `rated_life (rated_speed / speed) (rated_torque / torque)^3`: hours at a torque of its
    output [N m or N] and a speed of its input [rad/s]."""

    rated_life: _Physical
    rated_torque: _Physical
    rated_speed: _Physical


@dataclass(frozen=True)
class Motor(FrozenValue):
    """What drives a joint. Rotor inertia and gear ratio stand in the scene's `Rotor` of the joint.

    Speeds and torques are magnitudes at the motor's shaft [rad/s, N m] (of a linear motor m/s, N); the same curves hold
    for braking.

    Attributes:
        efficiency: of the gear, 0 < efficiency <= 1.
        continuous, peak: the torque that it may give for ever and for moments: one for all speeds, or a curve.
        max_speed: None: where the curve `peak` ends.
        gear_average, gear_peak: what the gear bears at the joint as cubic mean and at the most [N m or N].
        thermal: how it heats up; with it the winding's temperature is judged in place of the RMS torque.
    """

    efficiency: _Efficiency = 1.0
    continuous: float | Curve | None = None
    peak: float | Curve | None = None
    max_speed: IfKnown | None = None
    gear_average: IfKnown | None = None
    gear_peak: IfKnown | None = None
    thermal: Thermal | None = None


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
    kind: Annotated[str, one_of("point", "hinge", "weld")] = "point"
    axis: Vector = (0.0, 0.0, 0.0)
    to_axis: Vector = (0.0, 0.0, 0.0)
    rpy: Vector = (0.0, 0.0, 0.0)
    directions: tuple[Vector, ...] = ()


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
    normal: Direction | None = None
    friction: NonNegative = 0.7
    on: str | tuple[tuple[float, float], ...] = ALWAYS
    level: float = 0.0
    height: NonNegative = 0.01
    speed: NonNegative = 0.1

    @property
    def columns(self) -> tuple[str, ...]:
        return (self.on,) if isinstance(self.on, str) and self.on not in (ALWAYS, AUTO) else ()


@dataclass(frozen=True)
class ContactCost(FrozenValue):
    """What contact forces make least, of all that balance: `forces |f|^2 / W^2 + torques sum (tau / limit)^2`, W being
    the robot's weight; `within_limits`: whether torques may not exceed the effort limits."""

    forces: _ForcesWeight = 1.0
    torques: NonNegative = 0.0
    within_limits: bool = False


LEAST_FORCES = ContactCost()
EFFORT = "effort"
"""As a weight: 1 / (effort limit)^2."""


Names = Annotated[
    tuple[str, ...], Rule(lambda names: len(set(names)) == len(names), 'names of joints, each once: ["a", "b"]')
]


@dataclass(frozen=True, repr=False)
class Scene(FrozenValue):
    """What surrounds the robot. The default scene is gravity alone, and the friction that the description declares.

    Nothing in a scene can be edited; `dataclasses.replace(scene, friction={**scene.friction, "elbow": Friction(0.3)})`
    is another. Scenes are compared by content.

    Attributes:
        gravity: m/s^2, in the axes of the ground (of a fixed base).
        friction: by joint; replaces what the description says of that joint.
        rotor, spring, motor, gear_life: by joint.
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
        baumgarte: 0: positions and speeds are projected onto the loops after each step; else the rate [1/s] at which
            Baumgarte's terms let errors of the loops decay.
        actuated: joints that drive; None: all but those of `passive`, or of closed chains those of `drive`.
        share: how redundant actuators share: "least" of the sum of their squares, or "weighted" by `weights`.
        weights: by joint, of tau^2 in that sum, a number or EFFORT; `weight` of the others.
        contact_cost: which of the contact forces that balance are taken.
        uncertainty: how well the robot's parameters are known; None: no question is asked.
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
    slip_speed: Annotated[float, Rule(lambda x: x >= 0.0, "it is positive, or 0 for sign(qd)")] = 0.0
    initial_q: Mapping[str, Entry] = field(default_factory=dict)
    initial_qd: Mapping[str, Entry] = field(default_factory=dict)
    drive: Mapping[str, Drive] = field(default_factory=dict)
    between_rows: Annotated[str, one_of("linear", "hold")] = "linear"
    joint_limits: Annotated[str, one_of("stop", "ignore", "spring")] = "stop"
    limit_spring: LimitSpring | None = None
    loops: tuple[Loop, ...] = ()
    baumgarte: Annotated[float, Rule(lambda x: x >= 0.0, "it is positive, or 0 for projection after each step")] = 0.0
    actuated: Names | None = None
    passive: Names = ()
    share: Annotated[str, one_of("least", "weighted")] = "least"
    weights: Mapping[str, Entry] = field(default_factory=dict)
    weight: Entry = 1.0
    contacts: tuple[Contact, ...] = ()
    contact_cost: ContactCost = LEAST_FORCES
    motor: Mapping[str, Motor] = field(default_factory=dict)
    uncertainty: Uncertainty | None = None
    coupled: tuple[CoupledMotor, ...] = ()
    gear_life: Mapping[str, GearLife] = field(default_factory=dict)

    def __hash__(self) -> int:
        return self._hash

    def __repr__(self) -> str:
        return call_of(self)

    def changed(self, gravity: Vector | None = None, payloads: Sequence[Payload] = (), *, held: bool = False) -> Scene:
        """Return the scene with another gravity [m/s^2], if one is given, more payloads, and a base that is held."""
        gravity = self.gravity if gravity is None else gravity
        return replace(self, gravity=gravity, payloads=(*self.payloads, *payloads), held=held or self.held)

    @property
    def loaded(self) -> tuple[str, ...]:
        """The joints whose friction grows with load."""
        return tuple(name for name, friction in self.friction.items() if friction.load)

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
