"""The poses in which weight asks most of joints, bearings and the base, and the most that a link can carry in any.

What is found in a pose is computed there by the traced recursion of `dynamics`; what no pose exceeds is bounded by that
of `recursion.py`, which knows weight, springs and what pulls as weight does.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf, isfinite, pi

import numpy as np

from robodyn.dynamics.effects.forces import acting
from robodyn.errors import InputError, SceneError
from robodyn.loads.sizing import allowed, train_of
from robodyn.robot.kinematics import configuration
from robodyn.robot.limits import MOST_EFFORT, binding, coordinate_ranges
from robodyn.robot.model import Joint, Model
from robodyn.scene.fit import check_scene, known, refuse_constraints
from robodyn.scene.scene import DEFAULT, Payload, Scene, Vector
from robodyn.sizing.directions import lattice
from robodyn.sizing.poses import Poses
from robodyn.sizing.recursion import Key, along_gravity, bounds, scale, weight_of
from robodyn.support.floats import BEYOND, Floats, first_largest
from robodyn.support.wording import shown

TARGET = 0.005
"""The gap between bound and pose at which the lattice is fine enough."""
ROWS = (48, 96, 192)
_MOST = 1.5e8
"""Values on all lattices of a recursion, from which on it is not made finer."""
_LARGEST = 3e8
"""Values on the first lattices, beyond which memory may not suffice."""
_HALVED = 5
"""How often the range of a coordinate that several joints follow is halved; twice as often that of a spring."""
_FARTHEST = 1e3  # m
_NOISE = 1e-8
"""Of all weight at the farthest reach: what is less is nothing."""
_BLOCK = 4096
_HEAVY = 1e9
"""A payload [kg] with which every joint that bears a part of it passes its limit."""
Box = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Load:
    """The largest of a load over all poses.

    Attributes:
        value: found in `pose` [N m or N], a torque with its sign; bound: no pose has more, in magnitude. Both are 0
            where that is less than 1e-8 of all weight at its farthest reach.
        pose: rad or m, by coordinate.
    """

    value: float
    bound: float
    unit: str
    pose: Mapping[str, float]

    @property
    def gap(self) -> float:
        """How much the bound is above what was found, as a share of it; 0 where both are nothing."""
        size = abs(self.value)
        return self.bound / size - 1.0 if size > 0.0 else 0.0 if self.bound == 0.0 else inf


@dataclass(frozen=True)
class JointEnvelope:
    """What holding still asks of a joint at most, and of its bearing or guide, parent on child at the joint's origin.

    Attributes:
        load: of the motor, for all joints that follow it.
        effort_limit: of the description; motor_limit: what motor and gear of the scene hold without end at standstill,
            at the joint; None where nothing is said [N m, N].
        tilting: moment across the axis; radial: force across it.
    """

    name: str
    load: Load
    effort_limit: float | None
    motor_limit: float | None
    tilting: Load
    radial: Load

    JSON_ALSO = ("use",)

    @property
    def limit(self) -> float | None:
        """The least of the limits."""
        return min((x for x in (self.effort_limit, self.motor_limit) if x is not None), default=None)

    @property
    def use(self) -> float | None:
        """The torque as a share of the limit."""
        return None if self.limit is None else abs(self.load.value) / self.limit if self.limit else inf


@dataclass(frozen=True)
class PayloadLimit:
    """The largest mass at a point of a link that every pose bears.

    Attributes:
        mass: with which the limit of a joint is reached in a pose [kg]; 0 if passed without; None if none ever is.
        certified: with which no pose passes a limit, by the bounds [kg].
    """

    link: str
    point: Vector
    mass: float | None
    certified: float | None
    joint: str = ""
    pose: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Sampled:
    """Random poses: the largest share of any bound that they reach, and of which."""

    count: int
    share: float
    of: str


@dataclass(frozen=True, eq=False)
class Envelope:
    """What holding still asks of a robot at most, over all poses.

    Attributes:
        joints: in the order of the coordinates.
        tipping: moment about the base's x and y, at its origin; weight: all that the base bears upwards [N].
        box: the range of each coordinate [rad or m].
        unlimited: joints without a limit of effort or motor.
        notes: what was assumed.
    """

    model: Model
    scene: Scene
    joints: tuple[JointEnvelope, ...]
    tipping: Load
    weight: float
    box: Mapping[str, tuple[float, float]]
    payload: PayloadLimit | None
    samples: Sampled | None
    unlimited: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def robot(self) -> str:
        return self.model.name

    @property
    def worst(self) -> JointEnvelope | None:
        """The joint with the largest use of its limit."""
        limited = [joint for joint in self.joints if joint.use is not None]
        return limited[first_largest([joint.use or 0.0 for joint in limited])] if limited else None

    @property
    def exceeded(self) -> tuple[JointEnvelope, ...]:
        """The joints beyond a limit in their worst pose."""
        return tuple(x for x in self.joints if x.limit is not None and abs(x.load.value) > BEYOND * x.limit)


def envelope(
    model: Model,
    scene: Scene = DEFAULT,
    *,
    box: Box | None = None,
    payload: tuple[str, Vector] | None = None,
    samples: int = 0,
) -> Envelope:
    """Return the poses within the position limits in which weight loads joints, bearings and the base most.

    A joint without limits turns all the way round. Gravity, payloads, springs, buoyancy and forces along gravity count;
    friction at rest does not. A base that moves is taken as held, its z up.

    Args:
        model: of `robodyn.load`.
        scene: gravity, payloads, springs, motors and so on.
        box: narrower ranges of coordinates, by name [rad or m].
        payload: a link and a point in its frame [m]: finds the largest mass there that all poses bear.
        samples: of random poses that are held against the bounds.

    Raises:
        InputError: no joint moves, a slide has no limits, a box is outside the limits, or a joint or link is unknown.
        SceneError: loops, contacts, joints that do not drive, a fluid that streams, or wrenches by columns, that turn
            with a link or stand across gravity.

    Accuracy: `value` is that of `inverse_dynamics` at rest in `pose`. No pose exceeds `bound`; its gap is below 1 % for
        arms of up to 7 joints.
    """
    check_scene(scene, model)
    refuse_constraints(scene)
    if scene.constrained:
        raise SceneError("some joints do not drive, and this knows only joints that do", remedy="leave actuated out")
    if scene.columns:
        what = f"a wrench follows the column {shown(scene.columns[0])}, and poses have no table"
        raise SceneError(what, remedy="give the wrench numbers")
    if any(scene.fluid_velocity) and any(any(each.drag_area) for each in scene.immersed):
        raise SceneError("the fluid streams, and bounds of its drag are not known", remedy="leave velocity out")
    for wrench in acting(scene, "surroundings"):
        if not along_gravity(wrench, scene):
            what = (
                f"the wrench on {shown(wrench.link)} turns with the link or stands across gravity: it has no bound here"
            )
            raise SceneError(what, remedy="leave it out; forces along gravity count, with frame base or world")
    joints = [joint for joint in model.independent if joint.kind != "floating"]
    if not joints:
        raise InputError("no joint moves", remedy="envelope is about joints that hold weight", file=model.file)
    search = _Search(model, replace(scene, limit_spring=None), *ranges(model, scene, box or {}))
    if search.functions * lattice(ROWS[0]).size > _LARGEST:
        raise InputError("there are too many joints in a row", remedy="up to 200 are looked at", file=model.file)
    if not np.isfinite(search.pull.force.sum() + search.pull.moment.sum()):
        raise InputError("weights are too large to be added up", remedy="check gravity and masses", file=model.file)
    bearing = {body.joint.name: i for i, body in enumerate(model.bodies)}
    found = search.loads()
    each = []
    for joint in joints:
        own = (Key("torque", joint.rate), Key("tilting", bearing[joint.name]), Key("radial", bearing[joint.name]))
        torque, tilting, radial = (found[key] for key in own)
        limits = binding(joint.effort, MOST_EFFORT), _motor(joint, scene)
        each.append(JointEnvelope(joint.name, torque, *limits, tilting, radial))
    limited = {joint.rate: one.limit for joint, one in zip(joints, each, strict=True) if one.limit is not None}
    notes = []
    if scene.friction or any(joint.friction for joint in joints):
        notes.append("Friction holds nothing here: at rest it may help or not.")
    if model.floating:
        notes.append("The base is taken as held, with its z up: what it stands on carries it.")
    return Envelope(
        model,
        scene,
        tuple(each),
        found[Key("tilting", 0)],
        float(search.pull.force.sum()),
        {joint.name: (float(search.low[k]), float(search.high[k])) for joint in joints for k in [joint.coordinate]},
        None if payload is None else search.payload(*payload, limited, found),
        search.sampled(found, samples) if samples else None,
        tuple(one.name for one in each if one.limit is None),
        tuple(notes),
    )


def ranges(model: Model, scene: Scene, box: Box) -> tuple[Floats, Floats]:
    """Return (nq,) the least and largest of each coordinate [rad or m], within limits and box; of a joint that can turn
    round one turn. InputError where there is none, or no end."""
    low, high = coordinate_ranges(model)
    names = {joint.name: joint for joint in model.independent if joint.kind != "floating"}
    for joint in names.values():
        if joint.continuous:
            low[joint.coordinate], high[joint.coordinate] = -inf, inf
    for name, (least, largest) in box.items():
        known("--box", "joint", name, names)
        k, said = names[name].coordinate, f"--box {name}: {least:g}..{largest:g} is"
        if not (isfinite(least) and isfinite(largest) and least <= largest):
            raise InputError(f"{said} no range", remedy="write least..largest")
        if largest < low[k] or least > high[k]:
            raise InputError(f"{said} outside the limits {low[k]:g}..{high[k]:g}", remedy="widen it, or the limits")
        low[k], high[k] = max(low[k], least), min(high[k], largest)
    for joint in names.values():
        k = joint.coordinate
        if low[k] > high[k]:
            what = f"the limits of {shown(joint.name)}, with those of joints that follow, leave no position"
            raise InputError(what, remedy="lower is below upper", file=model.file)
        if joint.kind == "prismatic" and max(-low[k], high[k]) > _FARTHEST:
            what = f"the slide {shown(joint.name)} has no limits, so that nothing bounds its levers"
            raise InputError(what, remedy=f"--box {joint.name}=0..1, in m", file=model.file)
        alone = sum(body.joint.coordinate == k for body in model.bodies[1:]) == 1 and joint.name not in scene.spring
        if joint.kind == "revolute" and not high[k] - low[k] < (2.0 if alone else 100.0) * pi:
            middle = 0.0 if low[k] <= -pi and high[k] >= pi else low[k] + pi if isfinite(low[k]) else high[k] - pi
            low[k], high[k] = middle - pi, middle + pi
    for _, k in model.quaternions:
        low[k - 3 : k + 4] = high[k - 3 : k + 4] = (*(0.0,) * 6, 1.0)
    return low, high


def _motor(joint: Joint, scene: Scene) -> float | None:
    """Return what a joint's motor and gear hold at standstill, where the gear loses nothing [N m, N]."""
    train = train_of(joint, scene)
    if train is None:
        return None
    curve = train.motor.peak if train.motor.continuous is None else train.motor.continuous
    held = [] if curve is None else [float(allowed(curve, 0.0)) * abs(train.gear)]
    return min([*held, *([train.motor.gear_peak] if train.motor.gear_peak else [])], default=None)


class _Search:
    """The poses of one robot in one scene, and what they ask for."""

    def __init__(self, model: Model, scene: Scene, low: Floats, high: Floats) -> None:
        self.model, self.scene, self.low, self.high = model, scene, low, high
        self.pull, self.rest = weight_of(model, scene), np.clip(configuration(model), low, high)
        springs = {name: (each.stiffness, each.rest) for name, each in scene.spring.items() if each.stiffness}
        self.bounds = partial(bounds, model, springs=springs)
        self.joints = {joint.rate: joint for joint in model.independent if joint.kind != "floating"}
        bearings = [Key(what, i) for i in range(1, len(model.bodies)) for what in ("tilting", "radial")]
        self.keys = [*(Key("torque", rate) for rate in self.joints), *bearings, Key("tilting", 0)]
        self.poses, self.nothing = Poses(model, self.keys, scene), _NOISE * scale(model, self.pull, low, high)
        self.worst: dict[Key, tuple[float, Floats]] = {}
        owners = [body.joint.coordinate for body in model.bodies[1:] if body.joint.multiplier]
        self.shared = {k for k in owners if owners.count(k) > 1}
        self.sprung = {body.joint.coordinate for body in model.bodies[1:] if body.joint.name in springs} - self.shared
        depth = [0]
        for parent in model.parents[1:]:
            depth.append(depth[parent] + 1)
        self.functions = 3 * sum(depth)
        """How many are kept on lattices at most."""

    def look(self, keys: Collection[Key], low: Floats, high: Floats) -> None:
        """Keep of each key the worst pose that is found between low and high, and its value."""
        which = np.array([self.keys.index(key) for key in keys])
        q, values = self.poses.worst(which, low, high, np.clip(self.rest, low, high))
        for key, pose, value in zip(keys, q, values.tolist(), strict=True):
            before = abs(self.worst[key][0]) if key in self.worst else -inf
            if abs(value) > before + max(1e-9 * abs(value), self.nothing):
                self.worst[key] = value, pose

    def enough(self, key: Key) -> float:
        """A bound that is near enough to the worst pose."""
        return max(abs(self.worst[key][0]) * (1.0 + TARGET), self.nothing)

    def loads(self) -> dict[Key, Load]:
        """Return the largest load of each key, and its bound."""
        most = self.bounds(self.pull, self.low, self.high, lattice(ROWS[0]), self.keys)
        self.look(self.keys, self.low, self.high)
        for finer in ROWS[1:]:
            wanted, before = [key for key in self.keys if most[key] > self.enough(key)], dict(most)
            if not wanted or self.functions * lattice(finer).size > _MOST:
                break
            new = self.bounds(self.pull, self.low, self.high, lattice(finer), wanted)
            most.update({key: min(most[key], new[key]) for key in wanted})
            if all(most[key] > (1.0 - 0.2 * TARGET) * before[key] for key in wanted):
                break
        for k in sorted(self.shared | self.sprung):
            wanted = [key for key in self.keys if most[key] > self.enough(key)]
            if k in self.sprung:  # a spring loads its own joint
                wanted = [x for x in wanted if x.what == "torque" and self.joints[x.place].coordinate == k]
            new = self._split(k, wanted, _HALVED * (2 if k in self.sprung else 1))
            most.update({key: min(most[key], new[key]) for key in wanted})
        found = {}
        for key in self.keys:
            value, pose = self.worst[key]
            slides = key.what == "torque" and self.joints[key.place].kind == "prismatic"
            unit = "N" if slides or key.what == "radial" else "N m"
            if max(abs(value), most[key]) <= self.nothing:
                found[key] = Load(0.0, 0.0, unit, self.named(self.rest))
            else:
                found[key] = Load(value, most[key], unit, self.named(pose))
        return found

    def _split(self, k: int, wanted: Sequence[Key], most_halved: int) -> dict[Key, float]:
        """Return bounds of keys as the largest of those for pieces of the range of a coordinate, which are halved
        until they are near enough to the worst pose, or short."""
        found = dict.fromkeys(wanted, -inf)
        pieces = [(self.low[k], self.high[k], 0, wanted)] if wanted else []
        while pieces:
            start, end, halved, keys = pieces.pop()
            low, high = self.low.copy(), self.high.copy()
            low[k], high[k] = start, end
            most, more = self.bounds(self.pull, low, high, lattice(ROWS[1]), keys), []
            if open_keys := [key for key in keys if most[key] > max(self.enough(key), found[key])]:
                self.look(open_keys, low, high)
                more = [key for key in open_keys if most[key] > self.enough(key)] if halved < most_halved else []
            found.update({key: max(found[key], most[key]) for key in keys if key not in more})
            if more:
                middle = 0.5 * (start + end)
                pieces += [(start, middle, halved + 1, more), (middle, end, halved + 1, more)]
        return found

    def named(self, q: Floats) -> dict[str, float]:
        return {joint.name: float(q[joint.coordinate]) + 0.0 for joint in self.joints.values()}

    def payload(self, link: str, point: Vector, limits: Mapping[int, float], found: Mapping[Key, Load]) -> PayloadLimit:
        """Return the largest mass at a point of a link that every pose bears within limits, by entry of tau.

        A torque is `a + m b` in each pose, so that the most of it over all poses is convex in m. From a mass that is
        too large the least that a worst pose allows is taken, again and again; the bound at that mass and the one
        without have one between them that holds for all masses between."""
        known("--payload", "link", link, self.model.links)
        if max(map(abs, point)) > _FARTHEST:
            raise InputError(f"--payload {link}: {max(map(abs, point)):g} m is too far out", remedy="the point is in m")
        keys = [Key("torque", rate) for rate in limits]
        for key, limit in zip(keys, limits.values(), strict=True):
            if abs(found[key].value) > BEYOND * limit:
                return PayloadLimit(link, point, 0.0, 0.0, self.joints[key.place].name, found[key].pose)
        poses = Poses(self.model, keys, self.scene, Payload(link, 1.0, point))
        which, most, mass, worst = np.arange(len(keys)), np.array([*limits.values()]), _HEAVY, None
        for _ in range(30 if keys else 0):
            q, values = poses.worst(which, self.low, self.high, self.rest, mass)
            over = np.abs(values) > BEYOND * most
            if not over.any():
                break
            without, loaded = (poses.parts(which, q[:, None], times)[:, 0, 0] * np.sign(values) for times in (0.0, 1.0))
            allowed = np.full(len(keys), inf)
            allowed[over] = np.maximum(most - without, 0.0)[over] / (loaded - without)[over]
            k = first_largest(-allowed)
            mass, worst = float(allowed[k]), (self.joints[keys[k].place].name, self.named(q[k]))
        if worst is None:
            return PayloadLimit(link, point, None, None)
        pull = weight_of(self.model, replace(self.scene, payloads=(*self.scene.payloads, Payload(link, mass, point))))
        bare, certified = np.array([found[key].bound for key in keys]), 0.0
        for finer in ROWS:
            heavy = np.array([*self.bounds(pull, self.low, self.high, lattice(finer), keys).values()])
            with np.errstate(divide="ignore", invalid="ignore"):
                shares = np.where(heavy > most, np.maximum(most - bare, 0.0) / (heavy - bare), 1.0)
            certified = max(certified, mass * float(min(shares.min(), 1.0)))
            if certified >= mass * (1.0 - TARGET):
                break
        return PayloadLimit(link, point, mass, certified, *worst)

    def sampled(self, found: Mapping[Key, Load], count: int) -> Sampled:
        """Hold random poses against the bounds."""
        random, which, shares = np.random.default_rng(0), np.arange(len(self.keys)), np.zeros(len(self.keys))
        most = np.array([found[key].bound or inf for key in self.keys])
        for start in range(0, count, _BLOCK):
            q = self.low + random.random((min(_BLOCK, count - start), self.model.nq)) * (self.high - self.low)
            sizes = np.sqrt((self.poses.parts(which, q[None]) ** 2).sum(axis=2))
            shares = np.maximum(shares, sizes.max(axis=1) / most)
        worst = first_largest(shares)
        what, place = self.keys[worst]
        name = self.joints[place].name if what == "torque" else self.model.bodies[place].joint.name
        of = name if what == "torque" else f"{what} load of {name}" if place else "tipping of the base"
        return Sampled(count, float(shares[worst]), of)
