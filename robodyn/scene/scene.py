"""What a scene adds to a robot: gravity, friction, rotors, springs, payloads, external wrenches, a moving base."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated

from robodyn.scene import parts
from robodyn.scene.parts import Entry, Payload, Rule, Vector, one_of
from robodyn.support.frozen import FrozenValue
from robodyn.support.wording import call_of

if TYPE_CHECKING:
    from robodyn.scene.uncertainty import Uncertainty

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
        coupled: motors that turn with several joints.
        uncertainty: how well the robot's parameters are known; None: no question is asked.
    """

    gravity: Vector = (0.0, 0.0, -9.81)
    friction: Mapping[str, parts.Friction] = field(default_factory=dict)
    rotor: Mapping[str, parts.Rotor] = field(default_factory=dict)
    spring: Mapping[str, parts.Spring] = field(default_factory=dict)
    payloads: tuple[Payload, ...] = ()
    wrenches: tuple[parts.ExternalWrench, ...] = ()
    immersed: tuple[parts.Immersed, ...] = ()
    fluid_density: float = 0.0
    fluid_velocity: Vector = (0.0, 0.0, 0.0)
    moving_base: bool = False
    held: bool = False
    slip_speed: Annotated[float, Rule(lambda x: x >= 0.0, "it is positive, or 0 for sign(qd)")] = 0.0
    initial_q: Mapping[str, Entry] = field(default_factory=dict)
    initial_qd: Mapping[str, Entry] = field(default_factory=dict)
    drive: Mapping[str, parts.Drive] = field(default_factory=dict)
    between_rows: Annotated[str, one_of("linear", "hold")] = "linear"
    joint_limits: Annotated[str, one_of("stop", "ignore", "spring")] = "stop"
    limit_spring: parts.LimitSpring | None = None
    loops: tuple[parts.Loop, ...] = ()
    baumgarte: Annotated[float, Rule(lambda x: x >= 0.0, "it is positive, or 0 for projection after each step")] = 0.0
    actuated: Names | None = None
    passive: Names = ()
    share: Annotated[str, one_of("least", "weighted")] = "least"
    weights: Mapping[str, Entry] = field(default_factory=dict)
    weight: Entry = 1.0
    contacts: tuple[parts.Contact, ...] = ()
    contact_cost: parts.ContactCost = parts.LEAST_FORCES
    motor: Mapping[str, parts.Motor] = field(default_factory=dict)
    uncertainty: Uncertainty | None = None
    coupled: tuple[parts.CoupledMotor, ...] = ()

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
