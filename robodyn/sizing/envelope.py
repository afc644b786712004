"""The poses in which weight asks most of joints, bearings and the base, and the most that a link can carry in any.

What is found in a pose is computed there by the traced recursion of `dynamics`; what no pose exceeds is bounded by that
of `recursion.py`, which knows weight, springs and what pulls as weight does. Forces that turn with a link, or stand
across gravity, are bounded apart from it, and the two bounds added.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from math import inf, isfinite, pi

import numpy as np

from robodyn.dynamics.effects.forces import acting
from robodyn.dynamics.plan import plan, ready
from robodyn.errors import InputError, SceneError
from robodyn.loads.sizing import allowed, train_of
from robodyn.programs.vectors import frame, length, product
from robodyn.robot.kinematics import configuration
from robodyn.robot.limits import MOST_EFFORT, coordinate_ranges
from robodyn.robot.model import Joint, Model
from robodyn.scene.fit import check_scene, known, refuse_constraints
from robodyn.scene.scene import DEFAULT, Payload, Scene, Vector
from robodyn.sizing.directions import lattice
from robodyn.sizing.recursion import Key, Pull, Recursion, along_gravity, weight_of
from robodyn.support.floats import BEYOND, Floats, first_largest
from robodyn.support.wording import shown

TARGET = 0.005
"""The gap between bound and pose at which the lattice is fine enough."""
ROWS = (48, 96, 192)
_MOST = 1.5e8
"""Values on all lattices of a recursion, from which on the lattice is not made finer."""
_LARGEST = 3e8
"""Values on the first lattices, beyond which memory may not suffice."""
_PIECES = 32
"""Of the range of a coordinate that several joints follow, each with a bound of its own."""
_FARTHEST = 1e3
_NOISE = 1e-8
"""Of all weight at the farthest reach: what is less is nothing."""
_BLOCK = 20_000
Box = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Load:
    """The largest of a load over all poses.

    Attributes:
        value: found in `pose` [N m or N], a torque with its sign; bound: no pose has more, in magnitude.
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
        mass: with which the limit is reached in a pose [kg]; 0 if it is passed without; None if none ever is.
        certified: with which no pose passes a limit, by the bounds [kg].
        joint, pose, torque, limit: where it is reached.
    """

    link: str
    point: Vector
    mass: float | None
    certified: float | None
    joint: str = ""
    pose: Mapping[str, float] = field(default_factory=dict)
    torque: float = 0.0
    limit: float = 0.0

    @property
    def gap(self) -> float | None:
        """How much `certified` is below `mass`, as a share of it."""
        return None if not self.mass or self.certified is None else 1.0 - self.certified / self.mass


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

    @property
    def gap(self) -> float:
        """The largest gap of a joint's torque."""
        return max((joint.load.gap for joint in self.joints), default=0.0)


def envelope(
    model: Model,
    scene: Scene = DEFAULT,
    *,
    box: Box | None = None,
    payload: tuple[str, Vector] | None = None,
    samples: int = 0,
) -> Envelope:
    """Return the poses within the position limits in which weight loads joints, bearings and the base most.

    A joint without limits turns all the way round. Gravity, payloads, springs, buoyancy and constant wrenches count;
    friction at rest does not. A base that moves is taken as held, its z up.

    Args:
        model: of `robodyn.load`.
        scene: gravity, payloads, springs, motors and so on.
        box: narrower ranges of coordinates, by name [rad or m].
        payload: a link and a point in its frame [m]: finds the largest mass there that all poses bear.
        samples: of random poses that are held against the bounds.

    Raises:
        InputError: no joint moves, a slide has no limits, a box is outside the limits, or a joint or link is unknown.
        SceneError: loops, contacts, joints that do not drive, wrenches by columns, or a fluid that streams.

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
    joints = [joint for joint in model.independent if joint.kind != "floating"]
    if not joints:
        raise InputError("no joint moves", remedy="envelope is about joints that hold weight", file=model.file)
    depth = [0] * len(model.bodies)
    for i, body in enumerate(model.bodies[1:], start=1):
        depth[i] = depth[body.parent] + 1
    if 3 * sum(depth) * lattice(ROWS[0]).sine.size * 2 * ROWS[0] > _LARGEST:
        raise InputError("there are too many joints in a row", remedy="up to 200 are looked at", file=model.file)
    search = _Search(model, replace(scene, limit_spring=None), *ranges(model, scene, box or {}))
    if not np.isfinite(search.pull.force.sum() + search.pull.moment.sum()):
        raise InputError("weights are too large to be added up", remedy="check gravity and masses", file=model.file)
    bearing = {body.joint.name: i for i, body in enumerate(model.bodies)}
    found = search.loads()
    each = []
    for joint in joints:
        own = (Key("torque", joint.rate), Key("tilting", bearing[joint.name]), Key("radial", bearing[joint.name]))
        torque, tilting, radial = (found[key] for key in own)
        each.append(JointEnvelope(joint.name, torque, _effort(joint), _motor(joint, scene), tilting, radial))
    limits = {joint.rate: one.limit for joint, one in zip(joints, each, strict=True) if one.limit is not None}
    notes = (
        ["Friction holds nothing here: at rest it may help or not."]
        if scene.friction or any(joint.friction for joint in joints)
        else []
    )
    if model.floating:
        notes.append("The base is taken as held, with its z up: what it stands on carries it.")
    if search.others:
        notes.append(
            "Forces that turn with links or stand across gravity are bounded apart from weight: gaps are wide."
        )
    return Envelope(
        model,
        scene,
        tuple(each),
        found[Key("tipping", 0)],
        float(search.pull.force.sum()),
        {joint.name: (float(search.low[k]), float(search.high[k])) for joint in joints for k in [joint.coordinate]},
        None if payload is None else search.payload(*payload, limits, found),
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


def _effort(joint: Joint) -> float | None:
    return joint.effort if joint.effort is not None and 0.0 < joint.effort < MOST_EFFORT else None


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
        self.pull = weight_of(model, scene)
        self.springs = {name: (each.stiffness, each.rest) for name, each in scene.spring.items() if each.stiffness}
        self.rest = np.clip(configuration(model), low, high)
        counts: dict[int, int] = {}
        for body in model.bodies[1:]:
            counts[body.joint.coordinate] = counts.get(body.joint.coordinate, 0) + bool(body.joint.multiplier)
        self.shared = [k for k, count in counts.items() if count > 1]
        self.others = [each for each in acting(scene, "surroundings") if not along_gravity(each, self.pull.direction)]
        self.axes = [
            frame(np.asarray(body.joint.axis, float)) if i else np.eye(3) for i, body in enumerate(model.bodies)
        ]

    @cached_property
    def keys(self) -> list[Key]:
        torques = [Key("torque", joint.rate) for joint in self.model.independent if joint.kind != "floating"]
        bearings = [Key(what, i) for i in range(1, len(self.model.bodies)) for what in ("tilting", "radial")]
        return [*torques, *bearings, Key("tipping", 0)]

    def outputs(self, q: Floats, scene: Scene | None = None, executor: str = "numpy") -> Floats:
        """(N, n + 6 bodies) torques and wrenches of poses at rest."""
        still = frozenset((source, k) for source in ("qd", "qdd") for k in range(self.model.n))
        runner = ready(_wrenches, plan(self.model, scene or self.scene, still))
        zero = np.zeros((len(q), self.model.n))
        return runner({"q": q, "qd": zero, "qdd": zero, "columns": np.empty((len(q), 0))}, len(q), executor=executor)

    def values(self, rows: Sequence[tuple[Key, int]], outputs: Floats) -> Floats:
        """(N,) what each row asks for where outputs has one pose a row."""
        return np.array([self.value(key, outputs[k : k + 1])[0] * side for k, (key, side) in enumerate(rows)])

    def value(self, key: Key, outputs: Floats) -> Floats:
        """(N,) what a key asks for in all poses of outputs: a torque with its sign, else a magnitude."""
        if key.what == "torque":
            return outputs[:, key.place]
        first = self.model.n + 6 * key.place + (0 if key.what == "radial" else 3)
        x, y, _ = product(self.axes[key.place], outputs[:, first : first + 3].T)
        return np.asarray(np.hypot(x, y))

    def recursion(self, rows: int, pull: Pull | None = None, **how: object) -> Recursion:
        low, high = how.pop("low", self.low), how.pop("high", self.high)
        springs = self.springs if pull is None or pull is self.pull else {}
        return Recursion(self.model, pull or self.pull, low, high, lattice(rows), springs=springs, **how)  # type: ignore[arg-type]

    def bounds(self, recursion: Recursion) -> dict[tuple[Key, int], float]:
        """Return bounds of each key and side, with what other forces add."""
        found = {}
        for (key, side), most in recursion.most.items():
            plain = Key(key.what, key.place)
            if key.what == "torque" or side == 1:
                found[plain, side] = most + self.more.get((plain, side), self.more.get((plain, 1), 0.0))
        return found

    @cached_property
    def more(self) -> dict[tuple[Key, int], float]:
        """What forces that do not pull along gravity add to each key at most."""
        found: dict[tuple[Key, int], float] = {}
        for wrench in self.others:
            body, R, p = self.model.links[wrench.link]
            f, n = (np.array(each, dtype=float) for each in (wrench.force, wrench.moment))
            size, force = length(f), np.zeros(len(self.model.bodies))
            force[body] = size
            moment = force[:, None] * (product(np.asarray(R, float), np.array(wrench.point, dtype=float)) + p)
            steady = wrench.frame != "link" and size > 0.0
            one = self.recursion(ROWS[0], Pull(f / size if steady else self.pull.direction, force, moment))
            far = [one.scale, *(each.max() * (1.0 + one.lattice.bulge) ** 2 for each in one.support[1:])]
            for (key, side), most in one.most.items():
                plain, joints = Key(key.what, key.place), [(1.0, key.place, key.what == "radial")]
                if key.what == "torque":
                    own = [(i, body.joint) for i, body in enumerate(self.model.bodies) if i]
                    own = [(i, joint) for i, joint in own if joint.rate == key.place]
                    joints = [(abs(joint.multiplier), i, joint.kind == "prismatic") for i, joint in own]
                anyway = sum(ratio * float(one.carried[i] if straight else far[i]) for ratio, i, straight in joints)
                added = (most if steady else anyway) + length(n) * sum(x for x, _, straight in joints if not straight)
                found[plain, side] = found.get((plain, side), 0.0) + added
        return found

    def poses(self, recursion: Recursion, rows: Sequence[tuple[Key, int]]) -> Floats:
        """Return (rows, nq) the worst poses that are found for keys and sides."""
        own = [(Key(key.what, key.place), side) for key, side in rows]
        q, _ = recursion.poses(own, self.rest)
        moved = set(self.shared)
        for joint in self.model.independent:
            if joint.kind != "floating" and (self.others or joint.name in self.springs):
                moved.add(joint.coordinate)
        for _ in range(2 if moved else 0):  # what has no closed form
            for k in sorted(moved):
                self._improve(rows, q, k)
        return q

    def _improve(self, rows: Sequence[tuple[Key, int]], q: Floats, k: int) -> None:
        """Give one coordinate its best value among some, then among some near that, in all rows."""
        wide = self.high[k] - self.low[k]
        for step in (wide / 16, wide / 128, wide / 1024, wide / 8192):
            tried = np.clip(q[:, k, None] + step * np.arange(-16, 17), self.low[k], self.high[k])
            tried[:, 0] = q[:, k]
            many = np.repeat(q, tried.shape[1], axis=0)
            many[:, k] = tried.ravel()
            values = self.values([row for row in rows for _ in range(tried.shape[1])], self.outputs(many))
            values = values.reshape(tried.shape)
            best = values.argmax(axis=1)
            better = values.max(axis=1) > values[:, 0] * (1.0 + 1e-12)
            q[better, k] = tried[np.arange(len(q)), best][better]

    def loads(self) -> dict[Key, Load]:
        """Return the largest load of each key, and its bound."""
        rows = [(key, side) for key in self.keys for side in ((1, -1) if key.what == "torque" else (1,))]
        first = self.recursion(ROWS[0])
        q, bounds = self.poses(first, rows), self.bounds(first)
        values = self.values(rows, self.outputs(q))
        best = {key: [k for k, row in enumerate(rows) if row[0] == key] for key in self.keys}
        at = {key: each[first_largest(values[each], _NOISE * first.scale)] for key, each in best.items()}

        def still_open() -> set[Key]:
            most = {key: max(bounds[key, side] for k in best[key] for side in [rows[k][1]]) for key in self.keys}
            return {key for key in self.keys if most[key] > max(values[at[key]] * (1 + TARGET), _NOISE * first.scale)}

        for finer in ROWS[1:]:
            wanted, before = still_open(), dict(bounds)
            if not wanted or first.size * (finer / ROWS[0]) ** 2 > _MOST:
                break
            self._lower(bounds, self.bounds(self.recursion(finer, wanted=frozenset(wanted))))
            if all(bounds[row] > (1.0 - 0.2 * TARGET) * before[row] for row in rows if row[0] in wanted):
                break
        torques = frozenset(key for key in still_open() if key.what == "torque" and not self.others)
        for k in self.shared if torques else ():
            self._split(bounds, k, torques)
        found = {}
        for key in self.keys:
            k, most = at[key], max(bounds[key, rows[j][1]] for j in best[key])
            value = float(values[k] * rows[k][1])
            nothing = max(abs(value), most) <= _NOISE * first.scale
            unit = "N" if key.what == "radial" or (key.what == "torque" and self._slides(key.place)) else "N m"
            pose = self.named(self.rest if nothing else q[k])
            found[key] = Load(0.0 if nothing else value, 0.0 if nothing else max(most, abs(value)), unit, pose)
        return found

    @staticmethod
    def _lower(bounds: dict[tuple[Key, int], float], others: Mapping[tuple[Key, int], float]) -> None:
        for row, value in others.items():
            bounds[row] = min(bounds[row], value)

    def _split(self, bounds: dict[tuple[Key, int], float], k: int, wanted: frozenset[Key]) -> None:
        """Lower bounds where joints move together, by a bound for each piece of their range."""
        ends, most = np.linspace(self.low[k], self.high[k], _PIECES + 1), dict[tuple[Key, int], float]()
        for piece in pairwise(ends):
            low, high = self.low.copy(), self.high.copy()
            low[k], high[k] = piece
            one = self.bounds(self.recursion(ROWS[1], wanted=wanted, low=low, high=high))
            most = {row: max(value, most.get(row, -inf)) for row, value in one.items()}
        self._lower(bounds, most)

    def _slides(self, rate: int) -> bool:
        return next(joint.kind for joint in self.model.independent if joint.rate == rate) == "prismatic"

    def named(self, q: Floats) -> dict[str, float]:
        names = [joint for joint in self.model.independent if joint.kind != "floating"]
        return {joint.name: float(q[joint.coordinate]) + 0.0 for joint in names}

    def payload(self, link: str, point: Vector, limits: Mapping[int, float], found: Mapping[Key, Load]) -> PayloadLimit:
        """Return the largest mass at a point of a link that every pose bears within limits, by entry of tau.

        A torque is `a + m b` in each pose, so that the most of it over all poses is convex in m. From a mass that is
        too large the least that a pose allows is taken, again and again; the bound at that mass and the one without
        have one between them that holds for all masses between."""
        known("--payload", "link", link, self.model.links)
        names = {joint.rate: joint.name for joint in self.model.independent}
        for rate, limit in limits.items():
            one = found[Key("torque", rate)]
            if abs(one.value) > BEYOND * limit:
                return PayloadLimit(link, point, 0.0, 0.0, names[rate], one.pose, one.value, limit)
        loaded = replace(self.scene, payloads=(*self.scene.payloads, Payload(link, 1.0, point)))
        wanted = frozenset(Key("torque", rate) for rate in limits)
        rows = [(key, side) for key in sorted(wanted) for side in (1, -1)]
        most = np.array([limits[key.place] for key, _ in rows])

        def parts(q: Floats) -> tuple[Floats, Floats]:
            without = self.values(rows, self.outputs(q))
            return without, self.values(rows, self.outputs(q, loaded)) - without

        def pulled(mass: float, finer: int = ROWS[0]) -> Recursion:
            more = weight_of(self.model, self.scene, [Payload(link, mass, point)])
            force, moment = self.pull.force + more.force, self.pull.moment + more.moment
            springs = {"springs": self.springs}
            pull = Pull(self.pull.direction, force, moment)
            return Recursion(
                self.model, pull, self.low, self.high, lattice(finer), bearings=False, wanted=wanted, **springs
            )

        alone = self.recursion(
            ROWS[0], weight_of(self.model, self.scene, [Payload(link, 1.0, point)]), bearings=False, wanted=wanted
        )
        _, slope = parts(self.poses(alone, rows))
        bare = np.array([found[key].bound for key, _ in rows])
        with np.errstate(divide="ignore"):
            mass = float(np.min(np.where(slope > _NOISE * alone.scale, (most + bare) / slope, inf), initial=inf))
        if not isfinite(mass):
            return PayloadLimit(link, point, None, None)
        mass *= 1.001  # so that some pose allows less
        for _ in range(30):
            recursion = pulled(mass)
            q = self.poses(recursion, rows)
            without, slope = parts(q)
            with np.errstate(divide="ignore", invalid="ignore"):
                allowed_here = np.where(slope > 0.0, np.maximum(most - without, 0.0) / slope, inf)
            k, last = first_largest(-allowed_here), mass
            if allowed_here[k] < mass:
                mass, worst = float(allowed_here[k]), (rows[k], q[k], float(without[k] + allowed_here[k] * slope[k]))
            if not mass < last * (1.0 - 1e-9):
                break
        certified = 0.0
        for finer in ROWS:
            bounds = self.bounds(pulled(mass, finer))
            heavy = np.array([bounds[row] for row in rows])
            with np.errstate(divide="ignore", invalid="ignore"):
                shares = np.where(heavy > most, np.maximum(most - bare, 0.0) / (heavy - bare), 1.0)
            certified = max(certified, mass * float(min(shares.min(), 1.0)))
            if certified >= mass * (1.0 - TARGET):
                break
        (key, side), pose, torque = worst
        limit = limits[key.place]
        return PayloadLimit(link, point, mass, certified, names[key.place], self.named(pose), side * torque, limit)

    def sampled(self, found: Mapping[Key, Load], count: int) -> Sampled:
        """Hold random poses against the bounds."""
        random, share, of = np.random.default_rng(0), 0.0, ""
        names = {**{joint.rate: joint.name for joint in self.model.independent}}
        for start in range(0, count, _BLOCK):
            size = min(_BLOCK, count - start)
            q = self.low + random.random((size, self.model.nq)) * (self.high - self.low)
            outputs = self.outputs(q, executor="auto" if count < _BLOCK else "compiled")
            for key, load in found.items():
                most = float(np.abs(self.value(key, outputs)).max())
                if load.bound and most / load.bound > share:
                    share = most / load.bound
                    joint = names[key.place] if key.what == "torque" else self.model.bodies[key.place].joint.name
                    of = {"torque": joint, "tipping": "tipping of the base"}.get(
                        key.what, f"{key.what} load of {joint}"
                    )
        return Sampled(count, share, of)


def _wrenches(a_plan: object) -> object:
    return a_plan.wrenches(True)  # type: ignore[attr-defined]
