"""Which motors and gears of a catalogue suffice along motions of a robot, joint by joint from the tips to the base.

At a motor `T = G J qdd + load / (G e^s)` (`loads.sizing.motor_torque`), for every motor, gear and ratio. Its mean
square is a quadratic form of integrals along the motion. Its share of the peak curve is largest in few stretches of the
motion: bounds of the others tell so without a look at their samples.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from robodyn.dynamics.effects.motors import rotor_of
from robodyn.dynamics.inverse import inverse_dynamics, mass_matrix
from robodyn.errors import InputError, SceneError, printable
from robodyn.loads.sizing import LEAST, allowed, points
from robodyn.robot.limits import binding
from robodyn.robot.model import Joint, Model
from robodyn.scene.fit import check_scene, known, refuse_constraints
from robodyn.scene.scene import DEFAULT, Curve, Motor, Payload, Rotor, Scene
from robodyn.sizing.catalogue_tables import CatalogueError, CatalogueGear, CatalogueMotor, read_gears, read_motors
from robodyn.support.floats import BEYOND, LARGEST, Floats, steady
from robodyn.support.input_file import beyond, limits
from robodyn.support.wording import figure, listed, shown, toml_key, toml_string
from robodyn.trajectory.motion import Trajectory, join
from robodyn.trajectory.plausible import refuse_units
from robodyn.trajectory.read import TrajectoryReader, read_motion

Motion = Trajectory | TrajectoryReader | str | os.PathLike[str]
Options = Sequence[tuple[CatalogueGear, float]]
"""Gears, each in a ratio."""
BY = ("mass", "price", "loss")
LIMITS = ("speed", "input speed", "peak torque", "RMS torque", "gear peak", "gear mean", "inertia ratio")
"""What a motor and a gear are judged by, in the order in which one is named of several that are exceeded alike."""
NO_GEAR = CatalogueGear("", (1.0,), None, 1.0)
_SWEEPS = 8
_STRETCHES, _CELLS = 256, 1 << 20
"""Stretches of a motion that have bounds; numbers that are worked on at a time."""
_POSES, _POINTS = 2000, 1500
"""Rows of the motions whose inertia is looked at, and that are kept for plots."""


class Choice(NamedTuple):
    """A motor, a gear and its ratio at a joint.

    Attributes:
        gear: named "" where there is none, or where the scene or the description says the ratio.
        ratio: turns of the motor per turn of the joint [rad/m of a slide].
        margins: by limit 1 - use: what is left of it, negative where it is exceeded; None where it is not judged.
        binding: the limit of which most is used, "" where nothing is judged.
        inertia_ratio: the joint's largest inertia along the motions over that of the rotor, G^2 J.
        mass, price: of motor and gear [kg]; loss: mean of copper and gear along the worst motion [W]. None: not known.
    """

    motor: CatalogueMotor
    gear: CatalogueGear
    ratio: float
    margins: Mapping[str, float | None]
    binding: str
    feasible: bool
    inertia_ratio: float | None
    mass: float
    price: float | None
    loss: float | None

    @property
    def inertia(self) -> float:
        """Of rotor and gear at the motor's shaft [kg m^2]."""
        return self.motor.inertia + self.gear.inertia


@dataclass(frozen=True)
class JointChoices:
    """What a catalogue has for a joint.

    Attributes:
        choices: those that suffice, best first, then the others, the nearest miss first.
        ruled_out: of the others how many fail by which limit, the one that they exceed most.
        peak, rms, max_speed: of the load, without a rotor, along the worst motion [N m or N, rad/s or m/s].
        points: (3, P) speed, load and acceleration of the joint, for plots.
    """

    name: str
    unit: str
    choices: tuple[Choice, ...] = field(repr=False)
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
        scene: the given one with the best of each joint, and their masses, which are `payloads`.
    """

    robot: str
    by: str
    joints: tuple[JointChoices, ...]
    sweeps: int
    converged: bool
    notes: tuple[str, ...]
    scene: Scene = field(repr=False)
    payloads: tuple[Payload, ...] = field(repr=False)

    @property
    def feasible(self) -> bool:
        return self.converged and all(joint.best for joint in self.joints)

    def total(self, quantity: str) -> float | None:
        """Return the sum of mass, price or loss of the best of all joints; None if one is not known."""
        values: list[Any] = [getattr(joint.best, quantity, None) for joint in self.joints]
        return None if None in values else float(sum(values))

    @property
    def toml(self) -> str:
        """The best of each joint, and their masses, as a scene of their own."""
        blocks = ["# motors chosen by robodyn size\n"]
        for joint in self.joints:
            if (best := joint.best) is not None:
                named = printable(f"# {best.motor.name} {best.gear.name}".rstrip())
                values = {"gear": best.ratio, "inertia": best.inertia, **vars(self.scene.motor[joint.name])}
                blocks.append(f"{named}\n[motor.{toml_key(joint.name)}]\n{_entries(values)}")
        for load in self.payloads:
            blocks.append(f"[[payload]]\n{_entries({'link': load.link, 'mass': load.mass, 'com': load.com})}")
        return "\n".join(blocks)


def _entries(values: Mapping[str, Any]) -> str:
    """Return lines of TOML for names, numbers, and tuples of these."""

    def text(value: Any) -> str:
        if isinstance(value, tuple):
            return f"[{', '.join(map(text, value))}]"
        return toml_string(value) if isinstance(value, str) else repr(float(value))

    return "".join(f"{key} = {text(value)}\n" for key, value in values.items() if value is not None)


class Course:
    """The load of a joint along motions: samples (N,) of all, means over the time of each (motions, ...)."""

    def __init__(self, parts: Sequence[tuple[Floats, Floats, Floats, Floats]]) -> None:
        """Args: of each motion (N,) time, load [N m or N], and speed and acceleration of the joint."""
        _, self.load, self.qd, self.qdd = (np.concatenate(each) for each in zip(*parts, strict=True))
        self.sign, self.speed = np.sign(self.load) * np.sign(self.qd), np.abs(self.qd)
        N = len(self.load)
        self.starts: Any = np.arange(0, N, max(16, int(min(N / _STRETCHES, N**0.5 / 2))))  # of stretches
        self._bounds: dict[str | float, tuple[Floats, Floats]] = {}
        rows: list[tuple[Any, ...]] = []
        for time, load, qd, a in parts:
            steps = 0.5 * np.diff(time)  # trapezoidal weights; one sample is its own mean
            w = np.append(steps, 0.0) + np.append(0.0, steps) if len(time) > 1 else np.ones(1)
            w, v, s = w / w.sum(), np.abs(qd), np.sign(load) * np.sign(qd)
            by_sign = np.array([w * (s > 0), w * (s == 0), w * (s < 0)])
            travel, wear = float(w @ v), float(w @ (v * np.abs(load) ** 3))
            mean = (wear / travel) ** (1 / 3) if travel and len(time) > 1 else 0.0
            by_load = (by_sign @ (a * load), by_sign @ (load * load), by_sign @ np.abs(load * v))
            rows.append((w @ (a * a), *by_load, travel, mean))
        squares, *vectors, speeds, means = zip(*rows, strict=True)
        self.squares, self.mean_speeds, self.cubic_mean = np.array(squares), np.array(speeds), max(means)
        self.cross, self.loads, self.powers = map(np.array, vectors)

    def mean_squares(self, G: Floats, J: Floats, e: Floats) -> Floats:
        """Return (motions, R) of `T^2`: `(G J)^2 <a^2> + 2 J <a L / e^s> + <(L / e^s)^2> / G^2` [(N m)^2].

        Accuracy: 1e-12 of the larger of its first and its last part.
        """
        share = np.array([1.0 / e, np.ones_like(e), e])
        found = np.outer(self.squares, (G * J) ** 2) + self.cross @ share * (2.0 * J) + self.loads @ share**2 / (G * G)
        return np.asarray(np.maximum(found, 0.0))

    def gear_losses(self, e: Floats) -> Floats:
        """Return (motions, R) the mean power that gears lose: `L qd (1/e - 1)` driving, `L qd (1 - e)` driven [W]."""
        found: Floats = self.powers @ np.array([1.0 / e - 1.0, np.zeros_like(e), 1.0 - e])
        return found

    def shared(self, e: Floats | float, at: Any = slice(None)) -> Floats:
        """Return `L / e^s` of samples."""
        sign = self.sign[at]
        found: Floats = self.load[at] * np.where(sign > 0, 1.0 / e, np.where(sign < 0, e, 1.0))
        return found

    def bounds(self, what: str | float) -> tuple[Floats, Floats]:
        """Return the least and the largest of each stretch, of an attribute or of `L / e^s` by e."""
        if what not in self._bounds:
            values = getattr(self, what) if isinstance(what, str) else self.shared(what)
            self._bounds[what] = np.minimum.reduceat(values, self.starts), np.maximum.reduceat(values, self.starts)
        return self._bounds[what]

    def peak_uses(self, peak: float | Curve, G: Floats, J: Floats, e: Floats) -> Floats:
        """Return (R,) the largest `|T| / peak(G |qd|)` along the motions, for ratios, inertias and efficiencies."""
        slow, fast = self.bounds("speed")
        least_a, most_a = self.bounds("qdd")
        size = int(self.starts[1]) if len(self.starts) > 1 else len(self.load)
        step = max(1, _CELLS // max(size, len(self.starts)))
        found, least = np.zeros(len(G)), LEAST * max(y for _, y in points(peak))
        for begin in range(0, len(G), step):
            g, j, some = G[begin : begin + step, None], J[begin : begin + step, None], e[begin : begin + step]
            low, high = np.array([self.bounds(x) for x in some.tolist()]).transpose(1, 0, 2)
            most = np.maximum(np.abs(g * j * most_a + high / g), np.abs(g * j * least_a + low / g))
            bound = most / np.maximum(_least_allowed(peak, g * slow, g * fast), least)
            best, rows = found[begin : begin + step], np.arange(len(g))
            while len(rows):  # those of which a stretch may have more than was found so far
                stretch = bound[rows].argmax(axis=1)
                more = bound[rows, stretch] > best[rows]
                rows, stretch = rows[more], stretch[more]
                at = np.minimum(self.starts[stretch][:, None] + np.arange(size), len(self.load) - 1)
                torque = np.abs(g[rows] * j[rows] * self.qdd[at] + self.shared(some[rows, None], at) / g[rows])
                use = torque / np.maximum(allowed(peak, g[rows] * self.speed[at]), least)
                best[rows] = np.maximum(best[rows], use.max(axis=1))
                bound[rows, stretch] = -1.0
        return found


def _least_allowed(torque: float | Curve, low: Floats, high: Floats) -> Floats:
    """The least that a curve allows between two speeds: at one of them, or at a point of the curve between."""
    found = np.minimum(allowed(torque, low), allowed(torque, high))
    for speed, value in points(torque)[1:]:
        found = np.where((low < speed) & (speed < high), np.minimum(found, value), found)
    return found


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def evaluated(
    course: Course, inertia: float, motor: CatalogueMotor, gears: Options, most_ratio: float | None = None
) -> tuple[Floats, Floats, Floats]:
    """Return what a motor with each of R gears uses of each of `LIMITS` (7, R), nan where it is not judged; the inertia
    ratio and the loss [W] (R,), nan where they are not known.

    Args:
        inertia: largest of the joint [kg m^2]; most_ratio: the largest inertia ratio that may be.
    """
    G, e = np.array([abs(ratio) for _, ratio in gears]), np.array([gear.efficiency for gear, _ in gears])
    J = motor.inertia + np.array([gear.inertia for gear, _ in gears])
    of_gears = {
        name: np.array([getattr(gear, name) or np.nan for gear, _ in gears])
        for name in ("peak_torque", "average_torque", "max_input_speed")
    }
    speed, ratio = G * course.speed.max(), np.where(J > 0.0, inertia / (G * G * J), np.nan)
    squares, peak, rms = course.mean_squares(G, J, e), np.full(len(G), np.nan), np.full(len(G), np.nan)
    fast = speed / (motor.speed_limit or np.nan)
    if motor.continuous_torque is not None:
        most = allowed(motor.continuous_torque, np.outer(course.mean_speeds, G))
        rms = (np.sqrt(squares) / np.maximum(most, LEAST * max(y for _, y in points(motor.continuous_torque)))).max(0)
    if motor.peak_torque is not None:  # at speeds that it has
        able = ~(fast > BEYOND)
        peak[able] = course.peak_uses(motor.peak_torque, G[able], J[able], e[able])
    loss = np.full(len(G), np.nan)
    if motor.resistance is not None and motor.torque_constant is not None:
        loss = (motor.resistance / motor.torque_constant**2 * squares + course.gear_losses(e)).max(axis=0)
    gear_peak = np.abs(course.load).max() / of_gears["peak_torque"]
    gear_mean = course.cubic_mean / of_gears["average_torque"]
    uses = (fast, speed / of_gears["max_input_speed"], peak, rms, gear_peak, gear_mean, ratio / (most_ratio or np.nan))
    return np.array(uses), ratio, loss


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
    before: these are chosen from the tips to the base, until nothing changes. Rotors count at their own joints. What
    the scene and the description say of rotors and motors of these joints is replaced, friction stays.

    Args:
        motions: of `robodyn.motion`, files or readers: peaks count over all, RMS and cubic mean of the worst.
        motors, gears: CSV files, or rows. Without gears ratio, efficiency and limits of the scene, or the description.
        by: "mass", "price" or "loss"; the first of the catalogue among equals, those where it is not known last.
        joints: those that are sized; all that move independently without.
        masses_included: the description's links have the masses of motors and gears already.
        inertia_ratio: the largest that may be; None: it is told, and not judged.

    Raises:
        CatalogueError: all faults of the catalogues, with line and column.
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
    sized = [joint for joint in movable if not joints or joint.name in joints]
    if not sized:
        raise InputError("no joint moves", remedy="describe the robot with joints")
    table, of_gears, notes = _catalogues(motors, gears, [joint.name for joint in movable], by)
    given = [motions] if isinstance(motions, (str, os.PathLike, Trajectory, TrajectoryReader)) else list(motions)
    whole = [_whole(model, scene, each, notes) for each in given]
    if not whole:
        raise InputError("there is no motion", remedy="give one or more")
    still = {joint.name: Rotor(0.0, 1.0) for joint in sized}
    bare = replace(scene, rotor={**scene.rotor, **still}, motor={})  # without the rotors of these joints
    places = {body.joint.name: k for k, body in enumerate(model.bodies)}
    order = sorted(sized, key=lambda joint: -places[joint.name])
    found: dict[str, tuple[tuple[Payload, ...], JointChoices]] = {}
    masses: dict[str, Payload] = {}
    sweeps, changed = 0, True
    while changed and sweeps < _SWEEPS:
        sweeps, changed = sweeps + 1, False
        for joint in order:
            moved = _moved(model, joint)
            loads = (masses[each.name] for each in sized if each.name in masses)
            payloads = tuple(load for load in loads if load.link in moved)
            if joint.name in found and found[joint.name][0] == payloads:
                continue
            changed = True
            course, inertia = _course(model, bare.changed(payloads=payloads), whole, joint)
            choices = _choices(joint, course, inertia, table, _options(joint, scene, of_gears), by, inertia_ratio)
            found[joint.name] = payloads, choices
            if choices.choices and choices.choices[0].mass and not masses_included:
                x, y, z = joint.p.tolist()
                before = model.bodies[model.bodies[places[joint.name]].parent].name
                masses[joint.name] = Payload(before, choices.choices[0].mass, (x, y, z))
            else:
                masses.pop(joint.name, None)
    results = tuple(found[joint.name][1] for joint in sized)
    notes += _said(results, sized)
    if changed:
        notes.append(f"choices still change after {sweeps} sweeps: joints that mimic others carry motors")
    best = {joint.name: joint.best for joint in results if joint.best}
    added = tuple(masses[name] for name in best if name in masses)
    rotors = {name: Rotor(each.inertia, each.ratio) for name, each in best.items()}
    after = replace(
        scene.changed(payloads=added),
        rotor={**scene.rotor, **rotors},
        motor={**scene.motor, **{name: _motor(each) for name, each in best.items()}},
    )
    return Catalogue(model.name, by, results, sweeps, not changed, tuple(notes), after, added)


def _catalogues(
    motors: Any, gears: Any, names: Sequence[str], by: str
) -> tuple[Sequence[CatalogueMotor], Sequence[CatalogueGear] | None, list[str]]:
    """Return the rows of both catalogues, and notes on them; raise CatalogueError with the faults of both."""
    faults: list[InputError] = []
    notes: list[str] = []
    rows: list[Any] = [motors, gears]
    for k, source in enumerate(rows):
        if isinstance(source, (str, os.PathLike)):
            try:
                path = os.fspath(source)
                rows[k], said = read_gears(path) if k else read_motors(path, names)
                notes += said
            except CatalogueError as error:
                faults += error.faults
    if faults:
        raise CatalogueError(faults)
    pairs = len(rows[0]) * (1 if rows[1] is None else sum(len(gear.ratios) for gear in rows[1]))
    if pairs > limits().catalogue_pairs:
        raise beyond("catalogue_pairs", f"{pairs} motors with gears in a ratio", InputError)
    if by == "mass":
        return rows[0], rows[1], notes
    column = "resistance" if by == "loss" else by
    silent = [row.name for some in rows for row in some or () if getattr(row, column, 0.0) is None]
    if len(silent) >= len(rows[0]) + (column == "price") * len(rows[1] or ()):
        columns = "resistance and torque_constant" if by == "loss" else column
        raise InputError(f"nothing in the catalogue has a {by}", remedy=f"fill in {columns}, or rank by mass")
    if silent:
        notes.append(f"the {by} of {listed(silent)} is not known: ranked last")
    return rows[0], rows[1], notes


def _whole(model: Model, scene: Scene, motion: Motion, notes: list[str]) -> Trajectory:
    """Return all of a motion."""
    opened: Any = read_motion(motion, model, scene) if isinstance(motion, (str, os.PathLike)) else nullcontext(motion)
    with opened as reader:
        file, blocks, values = getattr(reader, "file", None), [], 0
        for block in [reader] if isinstance(reader, Trajectory) else reader.blocks():
            refuse_units(block.caveats, file)
            values += len(block) * (model.nq + 2 * model.n)
            if values > limits().log_values:
                raise beyond("log_values", "too many values of a motion", InputError, file=file)
            blocks += [block] if len(block) else []
    if not blocks:
        raise InputError("the trajectory has no samples", file=file)
    whole = join(blocks)
    said = [*(each.text for each in whole.caveats), *whole.notes]
    if whole.derivation is not None:
        derived = listed([each.name for each in whole.derivation.joints])
        said.append(f"accelerations of {derived} are derived; robodyn torques tells how far off that may put torques")
    notes += [f"{file}: {each}" if file else each for each in said]
    return whole


def _moved(model: Model, joint: Joint) -> set[str]:
    """The bodies that a joint moves, itself or by joints that mimic it."""
    moved: set[int] = set()
    for k, body in enumerate(model.bodies):
        if body.parent in moved or (body.joint.kind != "fixed" and body.joint.rate == joint.rate):
            moved.add(k)
    return {model.bodies[k].name for k in moved}


def _course(model: Model, scene: Scene, motions: Sequence[Trajectory], joint: Joint) -> tuple[Course, float]:
    """Return the load of a joint in this scene, and its largest inertia along the motions [kg m^2 or kg]."""
    k, parts = joint.rate, []
    for each in motions:
        columns = {name: each.extra[name] for name in scene.columns}
        tau = inverse_dynamics(model, each.q, each.qd, each.qdd, scene=scene, columns=columns)[:, k]
        if not np.abs(tau).max() <= LARGEST:
            remedy = "are masses, lengths, times and the motion in SI units?"
            raise InputError(f"the torque of {shown(joint.name)} overflows", remedy=remedy)
        parts.append((each.time, np.ascontiguousarray(tau), each.qd[:, k], each.qdd[:, k]))
    poses = np.concatenate([each.q for each in motions])
    inertia = mass_matrix(model, poses[:: -(-len(poses) // _POSES)], scene=scene)[:, k, k].max()
    return Course(parts), float(inertia)


def _options(joint: Joint, scene: Scene, gears: Sequence[CatalogueGear] | None) -> dict[str, Options]:
    """Return the gears in their ratios that a joint's motor may have, by the kind of motor."""
    slide, rotor = joint.kind == "prismatic", scene.rotor.get(joint.name)
    if gears is not None:
        fit = [(gear, ratio) for gear in gears for ratio in gear.ratios if bool(gear.lead) == slide]
        return {"rotary": fit, "linear": [(NO_GEAR, 1.0)] if slide else []}
    ratio, motor = rotor_of(joint, scene)[1], scene.motor.get(joint.name, Motor())
    own = replace(NO_GEAR, efficiency=motor.efficiency, peak_torque=motor.gear_peak, average_torque=motor.gear_average)
    geared = joint.reduction != 1.0 or (rotor is not None and rotor.gear is not None)
    kind = "rotary" if geared or not slide else "linear"
    return {kind: [(own, ratio)] if ratio else []}


def _choices(
    joint: Joint,
    course: Course,
    inertia: float,
    motors: Sequence[CatalogueMotor],
    options: Mapping[str, Options],
    by: str,
    most_ratio: float | None,
) -> JointChoices:
    """Evaluate every motor with every gear that fits, and rank them."""
    found: list[Choice] = []
    for motor in motors:
        own = options.get(motor.kind)
        if not own or (motor.joints and joint.name not in motor.joints):
            continue
        uses, ratios, losses = evaluated(course, inertia, motor, own, most_ratio)
        judged = np.nan_to_num(uses, nan=-1.0, posinf=1e9)
        most, bind = judged.max(axis=0).tolist(), steady(judged).argmax(axis=0).tolist()
        columns = zip(own, judged.T.tolist(), most, bind, _known(ratios), _known(losses), strict=True)
        for (gear, ratio), each, use, at, inertia_ratio, loss in columns:
            price = None if motor.price is None or gear.price is None else motor.price + gear.price
            price = motor.price if not gear.name else price
            margins = {name: None if x < 0.0 else 1.0 - x for name, x in zip(LIMITS, each, strict=True)}
            verdict = LIMITS[at] if use >= 0.0 else "", use <= BEYOND
            found.append(
                Choice(motor, gear, ratio, margins, *verdict, inertia_ratio, motor.mass + gear.mass, price, loss)
            )
    values = [getattr(each, by) if each.feasible else 1.0 - (each.margins[each.binding] or 0.0) for each in found]
    keys = steady([np.inf if value is None else value for value in values]).tolist()
    ranked = sorted(range(len(found)), key=lambda k: (not found[k].feasible, keys[k]))
    at = slice(None, None, -(-len(course.load) // _POINTS))
    return JointChoices(
        name=joint.name,
        unit="N" if joint.kind == "prismatic" else "N m",
        choices=tuple(found[k] for k in ranked),
        ruled_out=dict(Counter(each.binding for each in found if not each.feasible).most_common()),
        peak=float(np.abs(course.load).max()),
        rms=float(np.sqrt(course.loads.sum(axis=1).max())),
        max_speed=float(course.speed.max()),
        points=np.array([course.qd[at], course.load[at], course.qdd[at]]),
    )


def _known(values: Floats) -> list[float | None]:
    return [x if np.isfinite(x) else None for x in values.tolist()]


def _said(found: Sequence[JointChoices], joints: Sequence[Joint]) -> list[str]:
    """Return what the choice rests on."""
    lines = []
    for each, joint in zip(found, joints, strict=True):
        limit, best = binding(joint.effort), each.best
        _, load, acceleration = each.points
        most = max(each.peak, float(np.abs(best.ratio**2 * best.inertia * acceleration + load).max()) if best else 0.0)
        if limit is not None and most > BEYOND * limit:
            lines.append(f"{each.name} takes {figure(most)} {each.unit}, above its effort limit of {limit:g}")
        if not each.choices:
            lines.append(f"{each.name}: the catalogue has no motor and gear that fit this joint")
        elif not best:
            lines.append(f"{each.name}: joints before it are judged with the mass of the nearest miss")
    return lines


def _motor(best: Choice) -> Motor:
    """Return a choice as a motor of a scene."""
    motor, gear = best.motor, best.gear
    fastest = [x for x in (motor.speed_limit, gear.max_input_speed) if x is not None]
    curves, most = (motor.continuous_torque, motor.peak_torque), min(fastest, default=None)
    return Motor(gear.efficiency, *curves, most, gear.average_torque, gear.peak_torque)
