"""Which motors and gears of a catalogue suffice along motions of a robot, joint by joint from the tips to the base.

At a motor `T = G J qdd + load / (G e^s)` (`loads.sizing.motor_torque`), for every motor, gear and ratio.
"""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from robodyn.dynamics.effects.motors import rotor_of
from robodyn.dynamics.inverse import inverse_dynamics, mass_matrix
from robodyn.errors import InputError, SceneError, printable
from robodyn.loads.sizing import LEAST, PIECE, allowed, points
from robodyn.robot.model import Joint, Model
from robodyn.scene.fit import check_scene, known, refuse_constraints
from robodyn.scene.scene import DEFAULT, Curve, Motor, Payload, Rotor, Scene
from robodyn.sizing.catalogue_tables import CatalogueGear, CatalogueMotor, read_rows
from robodyn.support.floats import BEYOND, LARGEST, Floats, steady
from robodyn.support.input_file import beyond, limits
from robodyn.support.wording import listed, shown, toml_key, toml_string
from robodyn.trajectory.motion import Trajectory, join
from robodyn.trajectory.plausible import refuse_units
from robodyn.trajectory.read import TrajectoryReader, read_motion

Motion = Trajectory | TrajectoryReader | str | os.PathLike[str]
BY = ("mass", "price", "loss")
LIMITS = ("speed", "input speed", "peak torque", "RMS torque", "gear peak", "gear mean", "inertia ratio")
"""What a motor and a gear are judged by, in the order in which one is named of several that are exceeded alike."""
_SWEEPS = 8


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
        course: the joint's load, without a rotor, along the motions.
    """

    name: str
    unit: str
    choices: tuple[Choice, ...] = field(repr=False)
    ruled_out: Mapping[str, int]
    course: Course = field(repr=False)

    @property
    def feasible(self) -> int:
        return len(self.choices) - sum(self.ruled_out.values())

    @property
    def best(self) -> Choice | None:
        return self.choices[0] if self.feasible else None


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
            if best := joint.best:
                values = {"gear": best.ratio, "inertia": best.inertia, **vars(self.scene.motor[joint.name])}
                lines = [f"{key} = {json.dumps(value)}\n" for key, value in values.items() if value is not None]
                named = printable(f"# {best.motor.name} {best.gear.name}".rstrip())
                blocks.append(f"{named}\n[motor.{toml_key(joint.name)}]\n{''.join(lines)}")
        for load in self.payloads:
            place = f"mass = {load.mass!r}\ncom = {[*load.com]}\n"
            blocks.append(f"[[payload]]\nlink = {toml_string(load.link)}\n{place}")
        return "\n".join(blocks)


class Course:
    """The load of a joint along motions: samples (N,) of all, means over the time of each (motions,).

    Attributes:
        peak, rms, cubic_mean: of the load, of the worst motion [N m or N]; max_speed: of the joint [rad/s or m/s].
    """

    def __init__(self, parts: Sequence[tuple[Floats, Floats, Floats, Floats]]) -> None:
        """Args: of each motion (N,) time, load [N m or N], and speed and acceleration of the joint."""
        times, *columns = zip(*parts, strict=True)
        self.load, self.qd, self.qdd = map(np.concatenate, columns)
        self.speed, self.sign = np.abs(self.qd), np.sign(self.load) * np.sign(self.qd)
        steps = [np.diff(time, prepend=time[0], append=time[-1]) for time in times]
        spans = [each[:-1] + each[1:] for each in steps]  # trapezoidal; one sample is its own mean
        self._weights = np.concatenate([w / w.sum() if len(w) > 1 else np.ones(1) for w in spans])
        self._starts = np.cumsum([0, *map(len, spans[:-1])])
        size, self.mean_speeds = np.abs(self.load), self.means(self.speed)
        wear = self.means(self.speed * size**3)
        self.peak, self.max_speed = float(size.max()), float(self.speed.max())
        self.rms = float(np.sqrt(self.means(size * size).max()))
        self.cubic_mean = float(np.cbrt(wear / np.where(wear > 0.0, self.mean_speeds, 1.0)).max())
        self._geared: dict[float, tuple[Floats, Floats]] = {}

    def means(self, values: Floats) -> Floats:
        """Return (motions,) the mean over the time of each."""
        return np.asarray(np.add.reduceat(self._weights * values, self._starts))

    def geared(self, e: float) -> tuple[Floats, Floats]:
        """Return `L / e^s` (N,), and the mean power that a gear loses, (motions,) [W]."""
        if e not in self._geared:
            share = np.where(self.sign > 0.0, 1.0 / e, np.where(self.sign < 0.0, e, 1.0))
            self._geared[e] = self.load * share, self.means(np.abs(self.load * self.qd * (share - 1.0)))
        return self._geared[e]


def judged(
    course: Course,
    inertia: float,
    motor: CatalogueMotor,
    gear: CatalogueGear,
    ratio: float,
    most_ratio: float | None = None,
) -> Choice:
    """Judge a motor with a gear by what it uses of each of `LIMITS`.

    Args:
        inertia: largest of the joint [kg m^2]; most_ratio: the largest inertia ratio that may be.
    """
    G, J = abs(ratio), motor.inertia + gear.inertia
    load, lost = course.geared(gear.efficiency)
    torque = np.abs(G * J * course.qdd + load / G)
    squares, speed = course.means(torque * torque), G * course.max_speed
    inertia_ratio = inertia / (G * G * J) if J else None
    fast = motor.speed_limit is not None and speed > BEYOND * motor.speed_limit  # than any of the peak curve
    uses = (
        _use(speed, motor.speed_limit),
        _use(speed, gear.max_input_speed),
        None if fast else _use(torque, motor.peak_torque, G * course.speed),
        _use(np.sqrt(squares), motor.continuous_torque, G * course.mean_speeds),
        _use(course.peak, gear.peak_torque),
        _use(course.cubic_mean, gear.average_torque),
        None if inertia_ratio is None else _use(inertia_ratio, most_ratio),
    )
    most = [-1.0 if use is None else use for use in uses]
    at = int(steady(most).argmax())
    loss = None
    if motor.resistance and motor.torque_constant:
        loss = float((motor.resistance / motor.torque_constant**2 * squares + lost).max())
    return Choice(
        motor,
        gear,
        ratio,
        {name: None if use is None else 1.0 - use for name, use in zip(LIMITS, uses, strict=True)},
        LIMITS[at] if most[at] >= 0.0 else "",
        max(most) <= BEYOND,
        inertia_ratio,
        motor.mass + gear.mass,
        None if motor.price is None or gear.price is None else motor.price + gear.price,
        loss,
    )


def _use(value: Floats | float, limit: float | Curve | None, speed: Floats | float = 0.0) -> float | None:
    """Return the largest share of a limit, at these speeds; None without one."""
    if limit is None:
        return None
    least = LEAST * max(y for _, y in points(limit))
    return float(np.max(value / np.maximum(allowed(limit, speed), least)))


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
            are too many pairs.

    Accuracy: uses of limits within 1e-9 of those of `torques` with the same motors in its scene.
    """
    check_scene(scene, model)
    refuse_constraints(scene)
    if scene.constrained or scene.coupled:
        what = "passive joints" if scene.constrained else "motors that turn with several joints"
        raise SceneError(f"the scene has {what}, and a motor for each joint is chosen here", remedy="leave them out")
    if by not in BY:
        raise InputError(f"by is {shown(by)}", remedy=f"one of: {', '.join(BY)}")
    movable = {joint.name: joint for joint in model.independent if joint.kind in ("revolute", "prismatic")}
    for name in joints:
        known("joints", "joint", name, movable)
    sized = [joint for name, joint in movable.items() if not joints or name in joints]
    if not sized:
        raise InputError("no joint moves", remedy="describe the robot with joints")
    notes: list[str] = []
    if isinstance(motors, (str, os.PathLike)):
        motors, said = read_rows(os.fspath(motors), CatalogueMotor)
        notes += said
    if isinstance(gears, (str, os.PathLike)):
        gears, said = read_rows(os.fspath(gears), CatalogueGear)
        notes += said
    _refuse_many(motors, gears or ())
    given = [motions] if isinstance(motions, (str, os.PathLike, Trajectory, TrajectoryReader)) else list(motions)
    whole = [_whole(model, scene, each, notes) for each in given]
    if not whole:
        raise InputError("there is no motion", remedy="give one or more")
    still = {joint.name: Rotor(0.0, 1.0) for joint in sized}
    bare = replace(scene, rotor={**scene.rotor, **still}, motor={})  # without the rotors of these joints
    order = [k for k, body in reversed([*enumerate(model.bodies)]) if body.joint in sized]
    found: dict[str, JointChoices] = {}
    masses: dict[str, Payload] = {}
    sweeps, changed = 0, True
    while changed and sweeps < _SWEEPS:
        before, sweeps = dict(masses), sweeps + 1
        for k in order:
            joint = model.bodies[k].joint
            course, inertia = _course(model, bare.changed(payloads=tuple(masses.values())), whole, joint)
            fit = _gears(joint, scene, gears)
            choices = [judged(course, inertia, motor, *pair, inertia_ratio) for motor in motors for pair in fit]
            found[joint.name] = _ranked(joint, course, choices, by)
            masses.pop(joint.name, None)
            for first in found[joint.name].choices[:1]:
                if first.mass and not masses_included:
                    link = model.bodies[model.bodies[k].parent].name
                    masses[joint.name] = Payload(link, first.mass, tuple(joint.p.tolist()))
        changed = masses != before
    results = tuple(found[joint.name] for joint in sized)
    notes += [note for each in results for note in _said(each, by)]
    if changed:
        notes.append(f"choices still change after {sweeps} sweeps: joints that mimic others carry motors")
    best = {joint.name: joint.best for joint in results if joint.best}
    added = tuple(masses[name] for name in best if name in masses)
    after = replace(
        scene.changed(payloads=added),
        rotor={**scene.rotor, **{name: Rotor(each.inertia, each.ratio) for name, each in best.items()}},
        motor={**scene.motor, **{name: _motor(each) for name, each in best.items()}},
    )
    return Catalogue(model.name, by, results, sweeps, not changed, tuple(notes), after, added)


def _refuse_many(motors: Sequence[CatalogueMotor], gears: Sequence[CatalogueGear]) -> None:
    pairs = len(motors) * sum(len(gear.ratios) for gear in gears)
    if pairs > limits().catalogue_pairs:
        raise beyond("catalogue_pairs", f"{pairs} motors with gears in a ratio", InputError)


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


def _course(model: Model, scene: Scene, motions: Sequence[Trajectory], joint: Joint) -> tuple[Course, float]:
    """Return the load of a joint in this scene, and its largest inertia along the motions [kg m^2 or kg]."""
    k, parts = joint.rate, []
    for each in motions:
        columns = {name: each.extra[name] for name in scene.columns}
        tau = inverse_dynamics(model, each.q, each.qd, each.qdd, scene=scene, columns=columns)[:, k]
        if not np.abs(tau).max() <= LARGEST:
            remedy = "are masses, lengths, times and the motion in SI units?"
            raise InputError(f"the torque of {shown(joint.name)} overflows", remedy=remedy)
        parts.append((each.time, tau, each.qd[:, k], each.qdd[:, k]))
    pieces = (each.q[at : at + PIECE] for each in motions for at in range(0, len(each), PIECE))
    return Course(parts), max(float(mass_matrix(model, q, scene=scene)[:, k, k].max()) for q in pieces)


def _gears(joint: Joint, scene: Scene, gears: Sequence[CatalogueGear] | None) -> list[tuple[CatalogueGear, float]]:
    """Return the gears in a ratio that go between a motor and a joint: without any, what the robot has."""
    slide = joint.kind == "prismatic"
    if gears is not None:
        return [(gear, ratio) for gear in gears for ratio in gear.ratios if bool(gear.lead) == slide]
    drive, rotor = scene.motor.get(joint.name, Motor()), scene.rotor.get(joint.name, Rotor(None))
    ratio, geared = rotor_of(joint, scene)[1], joint.reduction != 1.0 or rotor.ratio is not None
    own = CatalogueGear("", (ratio,), None, drive.efficiency, drive.gear_peak, drive.gear_average, price=0.0)
    return [(own, ratio)] if ratio and (geared or not slide) else []


def _ranked(joint: Joint, course: Course, choices: Sequence[Choice], by: str) -> JointChoices:
    values = [getattr(each, by) if each.feasible else -(each.margins[each.binding] or 0.0) for each in choices]
    keys = steady([np.inf if value is None else value for value in values]).tolist()
    order = sorted(range(len(choices)), key=lambda k: (not choices[k].feasible, keys[k]))
    failed = Counter(each.binding for each in choices if not each.feasible)
    unit = "N" if joint.kind == "prismatic" else "N m"
    return JointChoices(joint.name, unit, tuple(choices[k] for k in order), dict(failed.most_common()), course)


def _said(found: JointChoices, by: str) -> Iterator[str]:
    """Yield what the choice rests on."""
    if not found.choices:
        yield f"{found.name}: the catalogue has no motor and gear that fit this joint"
    elif not found.feasible:
        yield f"{found.name}: joints before it are judged with the mass of the nearest miss"
    elif silent := sum(getattr(each, by) is None for each in found.choices[: found.feasible]):
        yield f"{found.name}: the {by} of {silent} that suffice is not known: ranked last"


def _motor(best: Choice) -> Motor:
    """Return a choice as a motor of a scene."""
    motor, gear = best.motor, best.gear
    fastest = [x for x in (motor.speed_limit, gear.max_input_speed) if x is not None]
    curves, most = (motor.continuous_torque, motor.peak_torque), min(fastest, default=None)
    return Motor(gear.efficiency, *curves, most, gear.average_torque, gear.peak_torque)
