"""What identification found, and the same in the words of descriptions and scenes: the description,
in which nothing but inertials and friction is edited, and its scene."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.friction import friction_of, joints_with_friction
from robodyn.dynamics.effects.motors import rotor_of
from robodyn.dynamics.regressor import INERTIAL, regressor
from robodyn.errors import InputError
from robodyn.identification.model_selection import Structure
from robodyn.identification.parameters.base import Base
from robodyn.identification.parameters.consistent import parameters_of, pseudo_inertia
from robodyn.programs.vectors import product
from robodyn.robot.masses.declared import declared
from robodyn.robot.model import Model
from robodyn.robot.urdf.document import read_document
from robodyn.robot.urdf.edits import Edit, edited, with_attributes, with_comment, with_first_child
from robodyn.robot.urdf.parts import INERTIA, Description
from robodyn.robot.urdf.sources import EXPANDED, Search
from robodyn.robot.urdf.view import LinkView, View
from robodyn.scene.scene import DEFAULT, CoupledMotor, Friction, Rotor, Scene
from robodyn.scene.uncertainty import Covariance
from robodyn.solids.inertia.laws import Inertia, symmetric
from robodyn.solids.inertia.properties import MassProperties, from_inertia, from_moments, inertial_element
from robodyn.support.courses import Courses
from robodyn.support.floats import Floats
from robodyn.support.wording import count, figure, listed, shown, shown_path, toml_key, toml_string

_LEFT = 1e-3  # the part of a body, in its every direction, that is left to its main link at least


@dataclass(frozen=True)
class Errors:
    """||computed - measured|| / ||measured|| in N m, both sides filtered; of all joints together, and by joint."""

    relative_error: float
    joints: Mapping[str, float]


@dataclass(frozen=True)
class MotorFit:
    """What was found of a motor, joint side.

    Attributes:
        joints: how it turns with joints; of a joint's own motor {"wrist": 1.0}.
        viscous: N m s/rad; coulomb, offset: half the difference and half the sum of friction forwards and backwards
            [N m]; rotor: reflected inertia [kg m^2]; load: friction as a part of the torque that passes the gear.
        stribeck: torque of breakaway [N m], which decays with `stribeck_velocity` [rad/s].
    """

    joints: Mapping[str, float]
    viscous: float
    coulomb: float
    offset: float
    rotor: float
    stribeck: float | None = None
    stribeck_velocity: float | None = None
    load: float | None = None

    def friction(self, speed: Floats, transmitted: float = 0.0) -> Floats:
        """Return the friction at speeds of the motor [rad/s, m/s], while so much torque passes the gear [N m, N]."""
        sign, decay = np.sign(speed), np.zeros(len(speed))
        if self.stribeck is not None and self.stribeck_velocity:
            decay = np.exp(-((speed / self.stribeck_velocity) ** 2))
        coulomb = self.coulomb + (self.load or 0.0) * abs(transmitted) + ((self.stribeck or 0.0) - self.coulomb) * decay
        return np.asarray(self.viscous * speed + coulomb * sign + self.offset * (1.0 - decay) * sign * sign)


@dataclass(frozen=True, eq=False)
class BaseFit:
    """Base parameters (r,) by least squares without bounds, with their covariance; by the consistent parameters; and by
    the description."""

    base: Base
    values: Floats
    covariance: Floats
    consistent: Floats
    described: Floats

    @property
    def standard_errors(self) -> Floats:
        return np.sqrt(np.diagonal(self.covariance))


@dataclass(frozen=True, eq=False)
class Identified:
    """A description that explains logs.

    Attributes:
        names, described, theta: of `robodyn.regressor` of `model` in `scene`: before and after.
        scene: the given one with what was found of friction and rotors.
        coupled: names of motors of two joints, and what part of the squares of both joints' residuals they leave.
        train, held_out: of the consistent parameters; `bound_*` of least squares without bounds; `original_*` of the
            description. None where nothing is held out.
        discrepancy: by joint, standard error of torques of another motion beside that of the parameters, for what the
            model has not [N m]; delays: by joint, how late its torque is logged, which was taken out [s].
        alone: relative error of held-out torques (all, where none are held out) by the calibrated description without
            its scene: without rotors, coupled motors, and what friction is beside viscous and Coulomb's.
        strength: of the prior, chosen by cross-validation.
        cutoff: of the filter on both sides [Hz]; slip_speed: below which friction is smoothed [rad/s].
        consistent: whether every body that is shown can exist; unseen: bodies of which no torque shows anything.
        rows: that were compared, of all joints; samples: rows of the logs.
        faults: torques that are exchanged or have the wrong sign, and units that are doubtful, a line each, which are
            among the warnings.
        curves: goes through the logs once more, for `curves_of` them.
    """

    model: Model
    scene: Scene
    names: tuple[str, ...]
    described: Floats
    theta: Floats
    base: BaseFit
    motors: Mapping[str, MotorFit]
    coupled: Mapping[str, float]
    train: Errors
    held_out: Errors | None
    bound_train: Errors
    bound_held_out: Errors | None
    original_train: Errors
    original_held_out: Errors | None
    discrepancy: Mapping[str, float]
    delays: Mapping[str, float]
    alone: float
    strength: float
    cutoff: float
    slip_speed: float
    consistent: bool
    unseen: tuple[str, ...]
    rows: int
    samples: int
    duration: float
    hashes: Mapping[str, str]
    faults: tuple[str, ...]
    warnings: tuple[str, ...]
    curves: Callable[[], Courses] = field(repr=False)

    @property
    def judged(self) -> tuple[Errors, Errors]:
        """Of what was found, and of the description: held out, or of all where nothing is."""
        return self.held_out or self.train, self.original_held_out or self.original_train

    @property
    def explains(self) -> bool:
        """Whether less than half of the torques that are judged is left."""
        return self.judged[0].relative_error < 0.5

    @property
    def better(self) -> bool:
        """Whether torques that are judged are explained better than by the description and by zero."""
        new, old = self.judged
        return new.relative_error < min(old.relative_error, 1.0)


def motor_fits(structure: Structure, theta: Floats) -> dict[str, MotorFit]:
    found, fits = dict(zip(structure.names, theta.tolist(), strict=True)), {}
    for k, shape in structure.shapes.items():
        motor = structure.regressor.motors[k]
        turned = np.flatnonzero(motor.direction)
        joints = {structure.regressor.model.rates[j]: float(motor.direction[j]) for j in turned}
        values = {name.rpartition(".")[2]: found[name] for name in shape.names(motor)}
        fits[motor.name] = MotorFit(joints, stribeck_velocity=shape.stribeck, **values)
    return fits


def outcome(
    model: Model, scene: Scene, structure: Structure, theta: Floats, slip_speed: float
) -> tuple[tuple[str, ...], Floats, Floats, Scene]:
    """Return names and values before and after of what was found, as `robodyn.regressor` has them, and the scene."""
    joints = {body.joint.name: body.joint for body in model.bodies}
    motors = motor_fits(structure, theta)
    friction, coupled = dict(scene.friction), {motor.name: motor for motor in scene.coupled}
    for name, fit in motors.items():  # friction grows with load, and has Stribeck's excess or none, as was fitted
        before = coupled.get(name, CoupledMotor(name, fit.joints))
        old = friction_of(joints[name], scene) if name in joints else before.friction
        new = replace(old, load=fit.load or 0.0, stribeck=None)
        if fit.stribeck is not None:
            speed = fit.stribeck_velocity or 0.0
            new = replace(new, stribeck=old.stribeck or old.dry, stribeck_velocity=speed)
        if name in joints:
            friction[name] = new
        else:
            coupled[name] = replace(before, friction=new)
    bare = replace(scene, payloads=(), friction=friction, coupled=tuple(coupled.values()))
    zero = np.zeros(model.n)
    found = regressor(model, zero, zero, zero, scene=bare)
    values = dict(zip(found.names, found.theta.tolist(), strict=True))
    pairs = zip(structure.names, theta.tolist(), strict=True)
    values |= {name: value for name, value in pairs if name.rpartition(".")[2] in INERTIAL}
    for name, fit in motors.items():
        values |= {f"{name}.viscous": fit.viscous, f"{name}.rotor": fit.rotor}
        forward, backward = max(fit.offset + fit.coulomb, 0.0), min(fit.offset - fit.coulomb, 0.0)
        values |= {f"{name}.forward": forward, f"{name}.backward": backward}
        if fit.stribeck is not None:
            values[f"{name}.stribeck"] = fit.stribeck
    after = np.array([values[name] for name in found.names])
    whole = calibrated(model, found.names, after, bare)
    return found.names, found.theta, after, replace(whole, slip_speed=slip_speed, payloads=scene.payloads)


def covariance(found: Identified) -> Covariance:
    """Return the calibrated parameters with the covariance of the base parameters, carried by those that name groups:
    the others are taken for known, which changes no torque of a motion that shows no more than the log. What the model
    has not is a constant torque of each joint, unknown by its discrepancy: friction, also of breakaway."""
    loads = {f"{name}.load": found.scene.friction[name].load for name in found.scene.loaded}
    names, theta = (*found.names, *loads), np.append(found.theta, list(loads.values()))
    carried = carriers(found.base.base, names)
    C = carried @ found.base.covariance @ carried.T
    for name, deviation in found.discrepancy.items():
        constant = np.array([each in (f"{name}.forward", f"{name}.backward") for each in names], dtype=float)
        C += deviation**2 * np.outer(constant, constant)
        C += np.diag([deviation**2 * (each == f"{name}.stribeck") for each in names])
    own = np.flatnonzero(np.diagonal(C) > 0.0)
    C = C[np.ix_(own, own)]
    return Covariance(tuple(names[k] for k in own), theta[own], (C + C.T) / 2.0)


def carriers(base: Base, names: Sequence[str]) -> Floats:
    """Return (p, r) how much of each of `names` of `robodyn.regressor` stands for each base parameter."""
    places = {name: k for k, name in enumerate(names)}
    carried = np.zeros((len(names), base.rank))
    for column, k in enumerate(base.independent):
        motor, _, kind = base.names[k].rpartition(".")
        parts = {base.names[k]: 1.0}
        if kind in ("coulomb", "offset"):
            parts = {f"{motor}.forward": 1.0, f"{motor}.backward": 1.0 if kind == "offset" else -1.0}
        for name in parts.keys() & places.keys():
            carried[places[name], column] = parts[name]
    return carried


class Calibrated(NamedTuple):
    """The text, and notes on what is not as one might expect, a line each."""

    data: bytes
    notes: tuple[str, ...]


def calibrated_urdf(
    model: Model,
    names: Sequence[str],
    described: Floats,
    theta: Floats,
    *,
    comment: Sequence[str] = (),
    friction: bool = False,
) -> Calibrated:
    """Return the description's text with the inertials of bodies that theta changes, every other byte as it was.

    See `link_inertias` for links fixed to each other. Inertias stand in the axes of their links. Numbers are the
    shortest that read back as the same floats. Of a xacro file it is the expanded text.

    Args:
        names, described, theta: of `robodyn.regressor`, before and after identification.
        comment: lines of a comment at the top.
        friction: edit `<dynamics>`, too: `damping` is viscous and `friction` is (forward - backward) / 2.

    Raises:
        InputError: the file is UTF-16, or as `link_inertias`.

    Accuracy: bodies of the text have theta within 1e-12 of the largest parameter of a kind, joints exactly.
    """
    description = model.description
    assert description is not None, "models are made of descriptions"
    document = read_document(description.data, description.file)
    if document.data != description.data:
        raise InputError("the file is UTF-16 and cannot be edited", remedy="save it as UTF-8", file=description.file)
    view, (bodies, notes) = View(document.root), link_inertias(model, described, theta)
    edits = [with_comment(document.data, comment)] if comment else []
    for name, body in bodies.items():
        edits += _inertial(view.link[name], body)
    if friction:
        changes, lopsided = _dynamics(model, view, dict(zip(names, theta.tolist(), strict=True)))
        edits += changes
        if lopsided:
            why = "which differs forwards and backwards: a scene can say it"
            notes.append(f"<dynamics friction> is the mean of the friction of {listed(lopsided)}, {why}")
    if description.file.endswith(EXPANDED):
        notes.append("the description is xacro; this is its expansion, to which macros and arguments are lost")
    return Calibrated(edited(document.data, edits, document.encoding), tuple(notes))


def lost_meshes(description: Description, path: str) -> str | None:
    """Return a line on meshes that a description loses when it is written to another folder; None if none is lost."""
    names = list(dict.fromkeys(g.filename for link in description.links for g in link.geometries if g.filename))
    there = Search(path, description.search.package_paths)

    def is_lost(name: str) -> bool:
        old, new = description.search.find(name), there.find(name)
        return old is not None and (new is None or not os.path.samefile(old, new))

    lost = [name for name in names if is_lost(name)]
    if not lost:
        return None
    folder = os.path.dirname(description.file.removesuffix(EXPANDED)) or os.curdir
    what = f"{count(len(lost), 'mesh', 'meshes')} of {len(names)} will not be found beside {shown_path(path)}"
    return f"{what}, by the names that the description has: write it into {shown_path(folder)}"


def _inertial(link: LinkView, body: MassProperties) -> Iterator[Edit]:
    lines = inertial_element(body).splitlines()
    if link.inertial is None:
        yield with_first_child(link.element, lines)
        return
    element, I, missing = link.inertial.element, body.inertia, list[str]()
    products = (I[0, 0], I[0, 1], I[0, 2], I[1, 1], I[1, 2], I[2, 2])
    origin = {"xyz": _numbers(*body.com)}
    if any(link.inertial.origin.rpy.or_default(0.0) or ()):
        origin["rpy"] = "0 0 0"
    inertia = {name: _numbers(value) for name, value in zip(INERTIA, products, strict=True)}
    children = {"origin": origin, "mass": {"value": _numbers(body.mass)}, "inertia": inertia}
    for line, (tag, values) in zip(lines[1:-1], children.items(), strict=True):
        child = element.find(tag)
        if child is None:
            missing.append(line.strip())
        else:
            yield from with_attributes(child, values)
    if missing:
        yield with_first_child(element, missing)


def _dynamics(model: Model, view: View, theta: dict[str, float]) -> tuple[list[Edit], list[str]]:
    edits, lopsided = list[Edit](), list[str]()
    for body in model.bodies:
        joint = body.joint
        if f"{joint.name}.viscous" not in theta or joint.name not in view.joint:
            continue
        viscous, forward, backward = (theta[f"{joint.name}.{part}"] for part in ("viscous", "forward", "backward"))
        dry = (forward - backward) / 2.0
        if (viscous, dry) != (joint.damping, joint.friction):
            element, values = view.joint[joint.name].element, {"damping": _numbers(viscous), "friction": _numbers(dry)}
            child = element.find("dynamics")
            if child is None:
                said = " ".join(f'{name}="{value}"' for name, value in values.items())
                edits.append(with_first_child(element, [f"<dynamics {said}/>"]))
            else:
                edits += with_attributes(child, values)
        if forward != -backward:
            lopsided.append(joint.name)
    return edits, lopsided


def _numbers(*values: float) -> str:
    return " ".join(repr(float(value)) for value in values)


def link_inertias(model: Model, described: Floats, theta: Floats) -> tuple[dict[str, MassProperties], list[str]]:
    """Return by link, in its frame, the inertials that give bodies theta, and a line each of what could not stay.

    Of links fixed to each other the change goes to the one that the joint carries, or, if that has no mass, to the
    heaviest. The others stay, unless they are more than the body: they are then scaled, so that about half of the body
    in its narrowest direction is left to the first. Payloads of the scene belong to no link; raise InputError if what
    the log shows of a body is less than its own.
    """
    bodies, notes = dict[str, MassProperties](), list[str]()
    for k, body in enumerate(model.bodies):
        own = slice(10 * k, 10 * k + 10)
        if (theta[own] == described[own]).all():
            continue
        m, mc, I = body.inertia
        P = pseudo_inertia(theta[own] - (described[own] - (m, *mc, *I[np.triu_indices(3)])))
        if np.linalg.eigvalsh(P / np.sqrt(np.outer(*(np.abs(np.diagonal(P)),) * 2))).min() <= 0.0:
            what = f"what the log shows of body {shown(body.name)} leaves nothing that can exist beside its payload"
            raise InputError(what, remedy="leave the payload out, or correct its mass and place")
        changed, why = _shared(model, k, P)
        bodies |= changed
        notes += why
    return bodies, notes


def _shared(model: Model, k: int, P: Floats) -> tuple[dict[str, MassProperties], list[str]]:
    assert model.description is not None, "models are made of descriptions"
    links = [link for link in model.description.links if link.name in model.links and model.links[link.name].body == k]
    masses = [0.0 if link.inertial is None else link.inertial.mass for link in links]
    own = next(i for i, link in enumerate(links) if link.name == model.bodies[k].name)
    main = links[own if masses[own] > 0.0 or max(masses) <= 0.0 else int(np.argmax(masses))]
    others = {each.name: each.body for link in links if link is not main and (each := declared(link)) is not None}
    others = {name: body for name, body in others.items() if body.mass or body.S_c.any()}
    total = np.zeros((4, 4))
    for name, body in others.items():
        m, mc, I = body.placed(model.links[name].R, model.links[name].p).moments
        total += pseudo_inertia((m, *mc, *I[np.triu_indices(3)]))
    share, notes, changed = 1.0, list[str](), dict[str, MassProperties]()
    if others:
        L = np.linalg.cholesky(P)
        largest = float(np.linalg.eigvalsh(np.linalg.solve(L, np.linalg.solve(L, total).T)).max())
        share = 1.0 if largest <= 1.0 - _LEFT else float(f"{0.5 / largest:.3g}")
    if share < 1.0:
        changed = {name: from_inertia(share * b.mass, b.com, share * b.inertia) for name, b in others.items()}
        what = f"the links {listed(list(others))} are more than body {shown(model.bodies[k].name)} is found to be"
        notes.append(f"{what}: their masses and inertias are scaled by {figure(share)}")
    m, mx, my, mz, *moments = parameters_of(P - share * total).tolist()
    frame = model.links[main.name]
    body = from_moments(Inertia(m, np.array((mx, my, mz)), symmetric(moments)))
    return {main.name: body.placed(frame.R.T, -product(frame.R.T, frame.p)), **changed}, notes


def calibrated(model: Model, names: Sequence[str], theta: Floats, scene: Scene = DEFAULT) -> Scene:
    """Return the scene with the friction and the rotors of theta, which replace what the description says of them; what
    theta does not hold stays. Accuracy: `robodyn.regressor` of it has theta, rotors within 2 eps."""
    found = dict(zip(names, theta.tolist(), strict=True))
    friction, rotors = dict(scene.friction), dict(scene.rotor)
    for _, joint, old in joints_with_friction(model, scene):
        new = _friction_found(joint.name, old, found)
        if new != Friction() or old != Friction():
            friction[joint.name] = new
        inertia, gear = rotor_of(joint, scene)
        reflected = found.get(f"{joint.name}.rotor", 0.0)
        if gear and (inertia or reflected):
            before = rotors.get(joint.name, Rotor(None))
            rotors[joint.name] = replace(before, inertia=reflected / gear / gear, gear=gear, lead=None)
    coupled = []
    for motor in scene.coupled:
        inertia = found.get(f"{motor.name}.rotor", motor.reflected) / motor.gear / motor.gear
        of_motor = _friction_found(motor.name, motor.friction, found)
        coupled.append(replace(motor, inertia=inertia, friction=of_motor))
    return replace(scene, friction=friction, rotor=rotors, coupled=tuple(coupled))


def _friction_found(motor: str, old: Friction, found: dict[str, float]) -> Friction:
    parts = ("viscous", "forward", "backward", "stribeck")
    return replace(old, **{part: found[name] for part in parts if (name := f"{motor}.{part}") in found})


def friction_toml(model: Model, scene: Scene, comment: Sequence[str] = ()) -> str:
    """Return as TOML what a scene says of friction and rotors, which `robodyn.load_scene` reads back the same."""
    blocks = ["".join(f"# {line}".rstrip() + "\n" for line in comment)] if comment else []

    def add(header: str, entries: Iterable[tuple[str, str]]) -> None:
        blocks.append(f"{header}\n" + "".join(f"{key} = {value}\n" for key, value in entries))

    if scene.slip_speed:
        blocks.append(f"slip_speed = {scene.slip_speed!r}\n")
    for _, joint, _ in joints_with_friction(model, scene):
        key = toml_key(joint.name)
        if joint.name in scene.friction:
            add(f"[friction.{key}]", _entries(friction_of(joint, scene)))
        if joint.name in scene.rotor:
            inertia, gear = rotor_of(joint, scene)
            values, rotor = [("inertia", repr(inertia)), ("gear", repr(gear))], scene.rotor[joint.name]
            if rotor.axis is not None:
                values.append(("axis", repr([float(x) for x in rotor.axis])))
            if rotor.on:
                values.append(("on", toml_string(rotor.on)))
            add(f"[rotor.{key}]", values)
    for motor in scene.coupled:
        turned = ", ".join(f"{toml_key(name)} = {part!r}" for name, part in motor.joints.items())
        own = ("inertia", repr(motor.inertia)), ("gear", repr(motor.gear))
        named = ("name", toml_string(motor.name)), ("joints", f"{{ {turned} }}")
        add("[[coupled]]", (*named, *own, *_entries(motor.friction)))
    return "\n".join(blocks)


def _entries(friction: Friction) -> Iterator[tuple[str, str]]:
    yield "viscous", repr(friction.viscous)
    forward, backward = friction.forward, friction.backward
    yield "coulomb", repr(forward) if forward == -backward else f"[{forward!r}, {backward!r}]"
    for each in fields(Friction)[3:]:
        value = getattr(friction, each.name)
        if value != each.default:
            yield each.name, repr(value)
