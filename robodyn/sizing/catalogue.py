"""Which motors and gears of a catalogue suffice for a robot along its motions, joint by joint from the tips to the base.

At the motor of a joint, `T = G J qdd + load / (G e^s)` (`loads.sizing.motor_torque`) for every motor, gear and ratio. Its
mean square is a quadratic form of integrals along the motion; its share of the peak curve is largest in few stretches
of the motion, which bounds of the other stretches tell without a look at their samples.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from robodyn.dynamics.effects.motors import rotor_of
from robodyn.dynamics.inverse import inverse_dynamics, mass_matrix
from robodyn.errors import InputError, SceneError, printable
from robodyn.loads.sizing import LEAST, allowed
from robodyn.robot.limits import binding
from robodyn.robot.model import Joint, Model
from robodyn.scene.fit import check_scene, known, refuse_constraints
from robodyn.scene.scene import DEFAULT, Curve, Motor, Payload, Rotor, Scene
from robodyn.sizing.catalogue_tables import CatalogueGear, CatalogueMotor, check_joints, read_gears, read_motors
from robodyn.support.floats import BEYOND, Floats, first_largest, steady
from robodyn.support.input_file import beyond, limits
from robodyn.support.wording import figure, listed, shown, toml_key, toml_string
from robodyn.trajectory.motion import Trajectory, join
from robodyn.trajectory.plausible import refuse_units
from robodyn.trajectory.read import TrajectoryReader, read_motion

Motion = Trajectory | TrajectoryReader | str | os.PathLike[str]
BY = ("mass", "price", "loss")
LIMITS = ("speed", "input speed", "peak torque", "RMS torque", "gear peak", "gear mean", "inertia ratio")
"""What a motor and a gear are judged by, in the order in which one is named of several that are exceeded alike."""
_FIRST = {"mass": "the lightest", "price": "the cheapest", "loss": "the least loss"}
DIRECT = CatalogueGear("", (1.0,), 1.0, None, None, None)
_SWEEPS, _ROUNDS = 8, 3
_STRETCHES, _CELLS = 256, 1 << 20
"""Stretches of a motion that have bounds; numbers that are worked on at a time."""
_POSES, _POINTS = 2000, 1500
"""Rows of the motions whose inertia is looked at, and that are kept for plots."""


class Choice(NamedTuple):
    """A motor, a gear and its ratio at a joint.

    Attributes:
        gear: "" of a motor without one, or where the scene says the ratio; ratio: turns of the motor per turn of the
            joint [rad/m of a slide].
        margins: by limit 1 - use: what is left of it, negative where it is exceeded; None where it is not judged.
        binding: the limit of which most is used, "" where nothing is judged.
        inertia_ratio: the joint's largest inertia along the motions over that of the rotor, G^2 J.
        mass, price: of motor and gear [kg]; loss: mean of copper and gear along the worst motion [W]. None: not known.
    """

    motor: str
    gear: str
    ratio: float
    margins: Mapping[str, float | None]
    binding: str
    feasible: bool
    inertia_ratio: float | None
    mass: float
    price: float | None
    loss: float | None
    places: tuple[int, int] = (0, 0)  # of motor and gear in their catalogues


@dataclass(frozen=True)
class JointChoices:
    """What a catalogue has for a joint.

    Attributes:
        choices: those that suffice, best first, then the others, the nearest miss first.
        ruled_out: of the others how many fail by which limit, the one that they exceed most.
        peak, rms, max_speed: of the load, without a rotor, along the worst motion [N m or N, rad/s or m/s].
        points: (3, P) speed, torque and acceleration of the joint, for plots.
    """

    name: str
    unit: str
    choices: tuple[Choice, ...]
    ruled_out: Mapping[str, int]
    peak: float
    rms: float
    max_speed: float
    points: Floats = field(repr=False)

    @property
    def feasible(self) -> int:
        return len(self.choices) - sum(self.ruled_out.values())

    @property
    def best(self) -> Choice | None:
        return self.choices[0] if self.feasible else None

    @property
    def nearest(self) -> Choice | None:
        """The one that fails by least."""
        return self.choices[self.feasible] if self.ruled_out else None


@dataclass(frozen=True)
class Catalogue:
    """The choice of motors and gears for a robot.

    Attributes:
        by: what they are ranked by: the least mass, price or loss.
        sweeps: from tips to base, the last of which changed nothing if `converged`.
        scene: the given one with the chosen motors, their rotors, gears and masses, which are `payloads`.
    """

    robot: str
    by: str
    joints: tuple[JointChoices, ...]
    sweeps: int
    converged: bool
    notes: tuple[str, ...]
    scene: Scene = field(repr=False)
    payloads: tuple[Payload, ...] = field(repr=False)
    motors: tuple[CatalogueMotor, ...] = field(repr=False)
    gears: tuple[CatalogueGear, ...] = field(repr=False)

    @property
    def feasible(self) -> bool:
        return all(joint.best for joint in self.joints)

    def total(self, quantity: str) -> float | None:
        """Return the sum of mass, price or loss of the best of all joints; None if one is not known."""
        values = [getattr(joint.best, quantity, None) for joint in self.joints]
        return None if None in values or not values else float(sum(values))

    @property
    def toml(self) -> str:
        """The best of each joint, and their masses, as a scene of their own."""
        blocks = [f"# motors chosen by robodyn size, {_FIRST[self.by]} first\n"]
        for joint in self.joints:
            if (best := joint.best) is not None:
                rotor, motor = self.scene.rotor[joint.name], self.scene.motor[joint.name]
                values = {"gear": rotor.gear, "inertia": rotor.inertia, **vars(motor)}
                named = printable(f"# {best.motor} {best.gear}".rstrip())
                blocks.append(f"{named}\n[motor.{toml_key(joint.name)}]\n{_entries(values)}")
        for load in self.payloads:
            values = {"link": load.link, "mass": load.mass, "com": load.com}
            blocks.append(f"[[payload]]\n{_entries(values)}")
        return "\n".join(blocks)


def _entries(values: Mapping[str, Any]) -> str:
    """Return lines of TOML for names, numbers, and tuples of these."""

    def text(value: Any) -> str:
        if isinstance(value, tuple):
            return f"[{', '.join(map(text, value))}]"
        return toml_string(value) if isinstance(value, str) else repr(float(value))

    return "".join(f"{key} = {text(value)}\n" for key, value in values.items() if value is not None)


class Course:
    """The load of a joint along motions, one after another: of each its samples, speeds, accelerations and weights."""

    def __init__(self, load: Sequence[Floats], qd: Sequence[Floats], qdd: Sequence[Floats], time: Sequence[Floats]):
        self.load, self.qd, self.qdd = (np.concatenate(each) for each in (load, qd, qdd))
        self.driving = np.sign(self.load) * np.sign(self.qd)
        self.speed = np.abs(self.qd)
        weights = [_weights(each) for each in time]
        self.durations = [float(each.sum()) for each in weights]
        ends = np.cumsum([0, *map(len, time)])
        self.integrals, self.mean_speeds, self.cubic_means, self.powers = [], [], [], []
        for k, w in enumerate(weights):
            own = slice(ends[k], ends[k + 1])
            a, L, v, s = self.qdd[own], self.load[own], self.speed[own], self.driving[own]
            parts = [(w * (s == sign)) for sign in (1.0, 0.0, -1.0)]
            cross, square = ([float((part * x * L).sum()) for part in parts] for x in (a, L))
            self.integrals.append((float((w * a * a).sum()), cross, square))
            self.mean_speeds.append(float((w * v).sum()) / self.durations[k])
            travel = float((w * v).sum()) if len(w) > 1 else 0.0
            wear = float((w * v * np.abs(L) ** 3).sum())
            self.cubic_means.append((wear / travel) ** (1 / 3) if travel else 0.0)
            self.powers.append([float((part * np.abs(L) * v).sum()) for part in parts])

    @property
    def rms(self) -> float:
        return max((sum(parts[2]) / t) ** 0.5 for parts, t in zip(self.integrals, self.durations, strict=True))

    def mean_squares(self, G: Floats, J: Floats, e: Floats) -> Floats:
        """Return (motions, R) of `T^2`: `(G J)^2 <a^2> + 2 J <a L / e^s> + <(L / e^s)^2> / G^2` [(N m)^2].

        Accuracy: 1e-12 of the larger of its first and its last part.
        """
        found = []
        for (square, cross, load), t in zip(self.integrals, self.durations, strict=True):
            mixed = cross[0] / e + cross[1] + cross[2] * e
            last = load[0] / (e * e) + load[1] + load[2] * e * e
            found.append(((G * J) ** 2 * square + 2.0 * J * mixed + last / (G * G)) / t)
        return np.maximum(np.array(found), 0.0)

    def losses(self, e: Floats) -> Floats:
        """Return (motions, R) the mean power that gears lose: `L qd (1/e - 1)` driving, `L qd (1 - e)` driven [W]."""
        each = zip(self.powers, self.durations, strict=True)
        return np.array([(power[0] * (1.0 / e - 1.0) + power[2] * (1.0 - e)) / t for power, t in each])

    @cached_property
    def stretches(self) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """Places (B, size) of the samples of stretches, and (B,) their least and largest acceleration and speed."""
        size = max(16, -(-len(self.load) // _STRETCHES))
        starts = np.arange(0, len(self.load), size)
        places = np.minimum(starts[:, None] + np.arange(size), len(self.load) - 1)
        ends = (bound.reduceat(x, starts) for x in (self.qdd, self.speed) for bound in (np.minimum, np.maximum))
        return places, *ends

    @cached_property
    def _loads(self) -> dict[float, tuple[Floats, Floats]]:
        return {}

    def load_bounds(self, e: float) -> tuple[Floats, Floats]:
        """Return (B,) the least and largest `L / e^s` of the stretches."""
        if e not in self._loads:
            load = self.load * np.where(self.driving > 0, 1.0 / e, np.where(self.driving < 0, e, 1.0))
            starts = self.stretches[0][:, 0]
            self._loads[e] = np.minimum.reduceat(load, starts), np.maximum.reduceat(load, starts)
        return self._loads[e]

    def peak_uses(self, peak: float | Curve, G: Floats, J: Floats, e: Floats) -> Floats:
        """Return (R,) the largest `|T| / peak(G |qd|)` along the motions, for ratios G, inertias J and efficiencies e."""
        places, a0, a1, v0, v1 = self.stretches
        step = max(1, _CELLS // len(a0))
        found = np.zeros(len(G))
        least = LEAST * (max(y for _, y in peak) if isinstance(peak, tuple) else peak)
        for begin in range(0, len(G), step):
            g, j, some = G[begin : begin + step, None], J[begin : begin + step, None], e[begin : begin + step]
            low, high = (np.array([self.load_bounds(float(x))[k] for x in some]) for k in (0, 1))
            most = np.maximum(np.abs(g * j * a1 + high / g), np.abs(g * j * a0 + low / g))
            bound = most / np.maximum(_least_allowed(peak, g * v0, g * v1), least)
            best, rows = found[begin : begin + step], np.arange(len(g))
            for turn in range(_ROUNDS + 1):
                top = bound.argmax(axis=1)
                if turn < _ROUNDS:
                    asked = rows[bound[rows, top] > best], top[bound[rows, top] > best]
                else:
                    asked = np.nonzero(bound > best[:, None])
                chunk = max(1, _CELLS // places.shape[1])
                for k in range(0, len(asked[0]), chunk):
                    row, stretch = asked[0][k : k + chunk], asked[1][k : k + chunk]
                    at, own = places[stretch], some[row, None]
                    share = np.where(self.driving[at] > 0, 1.0 / own, np.where(self.driving[at] < 0, own, 1.0))
                    torque = np.abs(g[row] * j[row] * self.qdd[at] + self.load[at] * share / g[row])
                    use = torque / np.maximum(allowed(peak, g[row] * self.speed[at]), least)
                    np.maximum.at(best, row, use.max(axis=1))
                bound[asked] = -1.0
        return found


def _weights(time: Floats) -> Floats:
    """Return trapezoidal weights (N,), 1 of a single sample."""
    if len(time) == 1:
        return np.ones(1)
    steps = 0.5 * np.diff(time)
    return np.append(steps, 0.0) + np.append(0.0, steps)


def _least_allowed(torque: float | Curve, low: Floats, high: Floats) -> Floats:
    """The least that a curve allows between two speeds: at one of them, or at a point of the curve between."""
    found = np.minimum(allowed(torque, low), allowed(torque, high))
    for speed, value in torque if isinstance(torque, tuple) else ():
        found = np.where((low < speed) & (speed < high), np.minimum(found, value), found)
    return found


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def evaluated(
    course: Course,
    inertia: float,
    motor: CatalogueMotor,
    gears: Sequence[tuple[CatalogueGear, float]],
    most_ratio: float | None = None,
) -> dict[str, Floats]:
    """Return what a motor with each of R gears in a ratio uses of each of `LIMITS` (R,), nan where it is not judged, and
    "inertia", the inertia ratio, and "loss" [W].

    Args:
        inertia: largest of the joint [kg m^2]; most_ratio: the largest inertia ratio that may be.
    """
    G = np.array([abs(ratio) for _, ratio in gears])
    e = np.array([gear.efficiency for gear, _ in gears])
    J = motor.inertia + np.array([gear.inertia for gear, _ in gears])
    fastest, none = float(course.speed.max()), np.full(len(G), np.nan)

    def of_gears(value: float, name: str) -> Floats:
        return value / np.array([getattr(gear, name) or np.nan for gear, _ in gears])

    uses = {name: none for name in LIMITS}
    if motor.speed_limit is not None:
        uses["speed"] = G * fastest / motor.speed_limit
    uses["input speed"] = of_gears(fastest, "max_input_speed") * G
    uses["gear peak"] = of_gears(float(np.abs(course.load).max()), "peak")
    uses["gear mean"] = of_gears(max(course.cubic_means), "average")
    ratio = inertia / (G * G * J)
    if most_ratio is not None:
        uses["inertia ratio"] = ratio / most_ratio
    squares = course.mean_squares(G, J, e)
    if motor.continuous is not None:
        top = max(y for _, y in motor.continuous) if isinstance(motor.continuous, tuple) else motor.continuous
        most = np.array([allowed(motor.continuous, G * v) for v in course.mean_speeds])
        uses["RMS torque"] = (np.sqrt(squares) / np.maximum(most, LEAST * top)).max(axis=0)
    if motor.peak is not None:  # at speeds that it has
        able = ~(uses["speed"] > BEYOND)
        uses["peak torque"] = none.copy()
        uses["peak torque"][able] = course.peak_uses(motor.peak, G[able], J[able], e[able])
    loss = none
    if motor.resistance is not None and motor.torque_constant is not None:
        loss = (motor.resistance / motor.torque_constant**2 * squares + course.losses(e)).max(axis=0)
    return uses | {"inertia": np.where(J > 0.0, ratio, np.nan), "loss": loss}


class _Sizing:
    """The robot along its motions, with what is chosen so far."""

    def __init__(self, model: Model, scene: Scene, motions: Sequence[Trajectory], joints: Sequence[Joint]) -> None:
        self.model, self.motions, self.joints = model, motions, joints
        names = {joint.name for joint in joints}
        self.given = scene
        rotors = {name: rotor for name, rotor in scene.rotor.items() if name not in names}
        still = {joint.name: Rotor(0.0, 1.0) for joint in joints}
        self.bare = replace(scene, rotor=rotors | still, motor={})  # with no rotor of these joints
        self.places = {body.joint.name: k for k, body in enumerate(model.bodies)}

    def payload(self, joint: Joint, mass: float) -> Payload:
        """The mass of a joint's motor and gear, at the joint's origin on the body before it."""
        before = self.model.bodies[self.model.bodies[self.places[joint.name]].parent]
        return Payload(before.name, mass, (float(joint.p[0]), float(joint.p[1]), float(joint.p[2])))

    def behind(self, joint: Joint) -> set[str]:
        """The joints whose motors this joint moves, itself or by joints that mimic it."""
        moved = [body.joint.kind != "fixed" and body.joint.rate == joint.rate for body in self.model.bodies]
        for k, body in enumerate(self.model.bodies):
            moved[k] = moved[k] or (body.parent >= 0 and moved[body.parent])
        parents = self.model.parents
        return {each.name for each in self.joints if moved[parents[self.places[each.name]]]}

    def course(self, joint: Joint, payloads: Sequence[Payload]) -> tuple[Course, float]:
        """Return the load of a joint with these masses, and its largest inertia along the motions [kg m^2 or kg]."""
        scene, k, loads = self.bare.changed(payloads=payloads), joint.rate, []
        for block in self.motions:
            columns = {name: block.extra[name] for name in scene.columns}
            tau = inverse_dynamics(self.model, block.q, block.qd, block.qdd, scene=scene, columns=columns)
            loads.append(np.ascontiguousarray(tau[:, k]))
            if not np.isfinite(loads[-1]).all() or np.abs(loads[-1]).max() > 1e60:
                remedy = "are masses, lengths, times and the motion in SI units?"
                raise InputError(f"the torque of {shown(joint.name)} overflows", remedy=remedy)
        poses = np.concatenate([block.q for block in self.motions])
        poses = poses[:: -(-len(poses) // _POSES)]
        inertia = float(mass_matrix(self.model, poses, scene=scene)[:, k, k].max())
        rates = ([each.qd[:, k] for each in self.motions], [each.qdd[:, k] for each in self.motions])
        return Course(loads, *rates, [each.time for each in self.motions]), inertia


def size(
    model: Model,
    motions: Motion | Iterable[Motion],
    motors: str | os.PathLike[str] | Sequence[CatalogueMotor],
    gears: str | os.PathLike[str] | Sequence[CatalogueGear] | None = None,
    scene: Scene = DEFAULT,
    *,
    by: str = "mass",
    joints: Sequence[str] = (),
    masses_included: bool = False,
    inertia_ratio: float | None = None,
) -> Catalogue:
    """Return which motors, gears and ratios of a catalogue suffice for each joint along motions, ranked.

    The mass of a motor and its gear is a point at the origin of its joint, on the link before, and loads the joints
    before: these are chosen from the tips to the base, until nothing changes. Rotors count at their own joints. What the
    scene and the description say of rotors and motors of these joints is replaced, friction stays.

    Args:
        motions: of `robodyn.motion`, files or readers: peaks count over all, RMS and cubic mean of the worst.
        motors, gears: CSV files, or rows. Without gears ratio, efficiency and limits of the scene, or the description.
        by: "mass", "price" or "loss"; the first of the catalogue among equals, those where it is not known last.
        joints: those that are sized; all that move independently without.
        masses_included: the description's links have the masses of motors and gears already.
        inertia_ratio: the largest that may be; None: it is told, and not judged.

    Raises:
        CatalogueError: all faults of a catalogue, with line and column.
        InputError: the scene does not fit the robot or has loops, contacts or passive joints; a motion is wrong; there
            are too many pairs; nothing has what `by` asks for.

    Accuracy: uses of limits within 1e-9 of those of `torques` with the same motors in its scene.
    """
    check_scene(scene, model)
    refuse_constraints(scene)
    if scene.constrained or scene.coupled:
        what = "passive joints" if scene.constrained else "motors that turn with several joints"
        raise SceneError(f"the scene has {what}, and a motor for each joint is chosen here", remedy="leave them out")
    if by not in BY:
        raise InputError(f"by is {shown(by)}", remedy=f"one of: {', '.join(BY)}")
    movable = [joint for joint in model.independent if joint.kind in ("revolute", "prismatic")]
    for name in joints:
        known("joints", "joint", name, [joint.name for joint in movable])
    chosen = [joint for joint in movable if not joints or joint.name in joints]
    if not chosen:
        raise InputError("no joint moves", remedy="describe the robot with joints")
    notes: list[str] = []
    table, of_gears = _catalogues(motors, gears, [joint.name for joint in movable], notes)
    given = [motions] if isinstance(motions, (str, os.PathLike, Trajectory, TrajectoryReader)) else list(motions)
    whole = [_whole(model, scene, each, notes) for each in given]
    if not whole:
        raise InputError("there is no motion", remedy="give one or more")
    if by != "mass":
        _refuse_unknown(by, table, notes)
    sizing = _Sizing(model, scene, whole, chosen)
    found: dict[str, tuple[tuple[Payload, ...], JointChoices]] = {}
    masses: dict[str, float] = {}
    order = sorted(chosen, key=lambda joint: -sizing.places[joint.name])
    beyond_it = {joint.name: sizing.behind(joint) for joint in order}
    sweeps, changed = 0, True
    while changed and sweeps < _SWEEPS:
        sweeps, changed = sweeps + 1, False
        for joint in order:
            loads = {} if masses_included else {each.name: masses.get(each.name, 0.0) for each in order}
            payloads = tuple(
                sizing.payload(each, loads[each.name])
                for each in chosen
                if each.name in beyond_it[joint.name] and loads.get(each.name)
            )
            if joint.name in found and found[joint.name][0] == payloads:
                continue
            changed = True
            options = _options(joint, scene, of_gears)
            choices = _choices(joint, *sizing.course(joint, payloads), table, options, by, inertia_ratio)
            found[joint.name] = payloads, choices
            masses[joint.name] = choices.choices[0].mass if choices.choices else 0.0
    if changed:
        notes.append(f"masses and choices still change after {sweeps} sweeps: joints that mimic others carry motors")
    results = tuple(found[joint.name][1] for joint in chosen)
    notes += _said(results, chosen, masses_included)
    after, added = _scene_of(sizing, results, table, of_gears, masses_included)
    return Catalogue(model.name, by, results, sweeps, not changed, tuple(notes), after, added, table, of_gears or ())


def _catalogues(
    motors: object, gears: object, names: Sequence[str], notes: list[str]
) -> tuple[tuple[CatalogueMotor, ...], tuple[CatalogueGear, ...] | None]:
    """Return the rows of both catalogues."""
    found: list[tuple[object, ...] | None] = []
    for source, read in ((motors, read_motors), (gears, read_gears)):
        rows = source
        if isinstance(source, (str, os.PathLike)):
            rows, said = read(os.fspath(source))
            notes += said
            check_joints(rows, names, os.fspath(source))
        found.append(None if rows is None else tuple(rows))  # type: ignore[arg-type]
    pairs = len(found[0] or ()) * (1 if found[1] is None else sum(len(gear.ratios) for gear in found[1]))  # type: ignore[attr-defined]
    if pairs > limits().catalogue_pairs:
        raise beyond("catalogue_pairs", f"{pairs} motors with gears in a ratio", InputError)
    return found[0], found[1]  # type: ignore[return-value]


def _whole(model: Model, scene: Scene, motion: Motion, notes: list[str]) -> Trajectory:
    opened: AbstractContextManager[Trajectory | TrajectoryReader] = (
        read_motion(motion, model, scene) if isinstance(motion, (str, os.PathLike)) else nullcontext(motion)
    )
    with opened as reader:
        file = getattr(reader, "file", None)
        blocks, values = [], 0
        for block in [reader] if isinstance(reader, Trajectory) else reader.blocks():
            refuse_units(block.caveats, file)
            values += len(block) * (model.nq + 2 * model.n)
            if values > limits().log_values:
                raise beyond("log_values", "too many values of a motion", InputError, file=file)
            blocks += [block] if len(block) else []
    if not blocks:
        raise InputError("the trajectory has no samples", file=file)
    whole = join(blocks)
    place = f"{file}: " if file else ""
    notes += [f"{place}{said}" for said in (*(each.text for each in whole.caveats), *whole.notes)]
    return whole


def _refuse_unknown(by: str, motors: Sequence[CatalogueMotor], notes: list[str]) -> None:
    silent = [motor.name for motor in motors if getattr(motor, "resistance" if by == "loss" else by) is None]
    if len(silent) == len(motors):
        columns = "resistance and torque_constant" if by == "loss" else "price"
        raise InputError(f"no motor has a {by}", remedy=f"fill in the columns {columns}, or rank by mass")
    if silent:
        notes.append(f"the {by} of {listed(silent)} is not known: ranked last")


def _options(
    joint: Joint, scene: Scene, gears: Sequence[CatalogueGear] | None
) -> tuple[list[tuple[int, CatalogueGear, float]], bool]:
    """Return the gears in their ratios that a joint's rotary motor may have, and whether a linear motor may drive it."""
    slide = joint.kind == "prismatic"
    if gears is not None:
        fit = [(k, gear) for k, gear in enumerate(gears) if gear.screw == slide]
        return [
            (k, gear, ratio) for k, gear in fit for ratio in gear.ratios if not gear.joints or joint.name in gear.joints
        ], slide
    ratio, motor = rotor_of(joint, scene)[1], scene.motor.get(joint.name, Motor())
    rotor = scene.rotor.get(joint.name)
    geared = joint.reduction != 1.0 or (rotor is not None and rotor.gear is not None)
    own = replace(DIRECT, efficiency=motor.efficiency, peak=motor.gear_peak, average=motor.gear_average)
    return ([(-1, own, ratio)] if ratio and (geared or not slide) else []), slide and not geared


def _choices(
    joint: Joint,
    course: Course,
    inertia: float,
    motors: Sequence[CatalogueMotor],
    options: tuple[list[tuple[int, CatalogueGear, float]], bool],
    by: str,
    most_ratio: float | None,
) -> JointChoices:
    """Evaluate every motor with every gear that fits, and rank them."""
    geared, linear = options
    found: list[Choice] = []
    worst: list[float] = []
    for m, motor in enumerate(motors):
        if motor.joints and joint.name not in motor.joints:
            continue
        own = ([(-1, DIRECT, 1.0)] if linear else []) if motor.linear else geared
        if not own:
            continue
        uses = evaluated(course, inertia, motor, [(gear, ratio) for _, gear, ratio in own], most_ratio)
        matrix = np.nan_to_num(np.array([uses[name] for name in LIMITS]), nan=-1.0, posinf=1e9)
        bind = steady(matrix).argmax(axis=0)
        for r, (g, gear, ratio) in enumerate(own):
            margins = {name: None if x < 0.0 else 1.0 - float(x) for name, x in zip(LIMITS, matrix[:, r], strict=True)}
            most, ratio_of, loss = float(matrix[bind[r], r]), float(uses["inertia"][r]), float(uses["loss"][r])
            price = (
                None if motor.price is None or (g >= 0 and gear.price is None) else motor.price + (gear.price or 0.0)
            )
            found.append(
                Choice(
                    motor=motor.name,
                    gear=gear.name,
                    ratio=ratio,
                    margins=margins,
                    binding=LIMITS[bind[r]] if most >= 0.0 else "",
                    feasible=most <= BEYOND,
                    inertia_ratio=ratio_of if np.isfinite(ratio_of) else None,
                    mass=motor.mass + gear.mass,
                    price=price,
                    loss=loss if np.isfinite(loss) else None,
                    places=(m, g),
                )
            )
            worst.append(most)
    values = [np.inf if (value := getattr(each, by)) is None else value for each in found]
    keys = np.where([each.feasible for each in found], steady(values), steady(worst)).tolist()
    ranked = sorted(range(len(found)), key=lambda k: (not found[k].feasible, keys[k]))
    at = np.arange(0, len(course.load), -(-len(course.load) // _POINTS))
    at = np.unique([*at, first_largest(np.abs(course.load)), first_largest(course.speed)])
    return JointChoices(
        name=joint.name,
        unit="N" if joint.kind == "prismatic" else "N m",
        choices=tuple(found[k] for k in ranked),
        ruled_out=dict(Counter(each.binding for each in found if not each.feasible).most_common()),
        peak=float(np.abs(course.load).max()),
        rms=course.rms,
        max_speed=float(course.speed.max()),
        points=np.array([course.qd[at], course.load[at], course.qdd[at]]),
    )


def _said(found: Sequence[JointChoices], joints: Sequence[Joint], masses_included: bool) -> list[str]:
    """Return what the choice rests on."""
    lines = []
    for each, joint in zip(found, joints, strict=True):
        limit, fast = binding(joint.effort), binding(joint.velocity)
        if limit is not None and each.peak > BEYOND * limit:
            lines.append(
                f"{each.name}: the load of {figure(each.peak)} {each.unit} is above the effort limit {limit:g}"
            )
        if fast is not None and each.max_speed > BEYOND * fast:
            lines.append(f"{each.name}: the speed of {figure(each.max_speed)} is above the velocity limit {fast:g}")
        if not each.choices:
            lines.append(f"{each.name}: the catalogue has no motor and gear that fit this joint")
        elif not each.best and not masses_included:
            lines.append(f"{each.name}: joints before it are judged with the mass of the nearest miss")
    return lines


def _scene_of(
    sizing: _Sizing,
    found: Sequence[JointChoices],
    motors: Sequence[CatalogueMotor],
    gears: Sequence[CatalogueGear] | None,
    masses_included: bool,
) -> tuple[Scene, tuple[Payload, ...]]:
    """Return the scene with the best of each joint, as `torques` judges it, and the masses that were added; joints
    without one stay as they were."""
    scene, payloads = sizing.given, list[Payload]()
    rotors, drives = dict(scene.rotor), dict(scene.motor)
    for joint, each in zip(sizing.joints, found, strict=True):
        if (best := each.best) is None:
            continue
        motor, (own, _) = motors[best.places[0]], _options(joint, scene, gears)
        gear = next((gear for g, gear, ratio in own if (g, ratio) == (best.places[1], best.ratio)), DIRECT)
        gear = DIRECT if motor.linear else gear
        rotors[joint.name] = Rotor(motor.inertia + gear.inertia, best.ratio)
        fastest = [x for x in (motor.max_speed, gear.max_input_speed) if x is not None]
        drives[joint.name] = Motor(
            efficiency=gear.efficiency,
            continuous=motor.continuous,
            peak=motor.peak,
            max_speed=min([*fastest, *([motor.speed_limit] if motor.speed_limit else [])], default=None),
            gear_average=gear.average,
            gear_peak=gear.peak,
        )
        if best.mass and not masses_included:
            payloads.append(sizing.payload(joint, best.mass))
    return replace(scene.changed(payloads=payloads), rotor=rotors, motor=drives), tuple(payloads)
