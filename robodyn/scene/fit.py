"""Whether a scene fits a robot, what it may not have where something cannot be computed with it; and the loops that a
description closes by itself, its <constraint> elements."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import fields, replace
from math import isfinite
from typing import Any

import numpy as np

from robodyn.errors import InputError, SceneError
from robodyn.programs.vectors import product, rotation_from_rpy, rpy_from_rotation
from robodyn.robot.model import Model
from robodyn.robot.urdf.description import Strict
from robodyn.robot.urdf.document import Element, read_document
from robodyn.robot.urdf.parts import ZERO, Description, Vector
from robodyn.robot.urdf.view import numbers
from robodyn.scene.scene import DEFAULT, GROUND, Contact, Loop, Scene
from robodyn.support.wording import alternatives, shown


def check_scene(scene: Scene, model: Model, file: str | None = None) -> None:
    """Raise if the scene, of this file, names a joint or a link that the robot does not have, or contradicts the robot
    or itself: SceneError, of an unknown name with the closest valid one; InputError as `refuse_others`."""
    refuse_others(model, scene)
    joints = [body.joint.name for body in model.bodies if body.joint.kind in ("revolute", "prismatic")]
    independent = [joint.name for joint in model.independent if joint.kind != "floating"]
    leaders = {body.joint.name: body.joint.mimics for body in model.bodies if body.joint.mimics is not None}
    for table, driven in (
        ("[drive]", scene.drive),
        ("[motor]", scene.motor),
        ("[gear]", scene.gear_life),
        ('"actuated"', scene.actuated or ()),
        ('"passive"', scene.passive),
        ("[weights]", scene.weights),
    ):
        for name in driven:
            if name in leaders:
                remedy = f"its torque is part of that of {shown(leaders[name])}: write it there"
                raise SceneError(f"{table}: the joint {shown(name)} mimics another", remedy=remedy, file=file)
            known(table, "joint", name, independent, file)
    uncertain_joints = scene.uncertainty.joint if scene.uncertainty else ()
    for where, kind, names, valid in (
        ("[friction]", "joint", scene.friction, joints),
        ("[rotor]", "joint", scene.rotor, joints),
        *(("[[coupled]]", "joint", motor.joints, joints) for motor in scene.coupled),
        ("[spring]", "joint", scene.spring, joints),
        ("[initial] q", "coordinate", scene.initial_q, model.coordinates),
        ("[initial] qd", "coordinate", scene.initial_qd, model.rates),
        ("[uncertainty.joint]", "joint", uncertain_joints, [*joints, *(motor.name for motor in scene.coupled)]),
        ("[uncertainty.link]", "link", scene.uncertainty.link if scene.uncertainty else (), model.links),
        ("[[payload]]", "link", [load.link for load in scene.payloads], model.links),
        ("[[wrench]]", "link", [wrench.link for wrench in scene.wrenches], model.links),
        ("[[fluid.link]]", "link", [immersed.link for immersed in scene.immersed], model.links),
        ("[[contact]]", "link", [contact.link for contact in scene.contacts], model.links),
    ):
        for name in names:
            known(where, kind, name, valid, file)
    _check_load(scene, {*leaders, *leaders.values()}, file)
    _check_rotors(scene, model, file)
    taken = {body.joint.name for body in model.bodies}
    for motor in scene.coupled:
        if motor.name in taken:
            what = f"[[coupled]] {shown(motor.name)}: a joint or another coupled motor has this name"
            raise SceneError(what, remedy="give each motor a name of its own", file=file)
        taken.add(motor.name)
    for loop in scene.loops:
        where = f"[[loop]] {shown(loop.name)}"
        known(where, "link", loop.link, model.links, file)
        known(where, "link", loop.to, (*model.links, GROUND), file)
        bodies = {model.links[name].body if name in model.links else -1 for name in (loop.link, loop.to)}
        if len(bodies) == 1 or (bodies == {-1, 0} and not model.floating):
            what = f"{where}: no joint moves {shown(loop.link)} against {shown(loop.to)}"
            raise SceneError(what, remedy="a loop connects links that move against each other", file=file)
    for contact in scene.contacts:
        _check_contact(contact, file)
    if scene.contact_cost.forces <= 0.0:
        what = f"[contact_cost] forces is {scene.contact_cost.forces:g}"
        raise SceneError(what, remedy="it is positive: torques alone leave forces open", file=file)
    if scene.moving_base and not model.floating:
        what = "the base moves in the scene and is fixed in the model"
        raise SceneError(what, remedy="load it with moving_base=True", file=file)


def known(where: str, kind: str, name: str, names: Collection[str], file: str | None = None) -> None:
    """Raise if the robot has no joint, link or coordinate of this name; `where` is what names it."""
    if name not in names:
        what = f"{where}: the robot has no {kind} {shown(name)}" + (" that moves" if kind == "joint" else "")
        raise SceneError(what, remedy=alternatives(name, names, f"{kind}s"), file=file)


def _check_load(scene: Scene, mimicking: Collection[str | None], file: str | None) -> None:
    """Raise where friction that grows with load is no share, or stands with what it cannot be computed with."""
    turned = {name for motor in scene.coupled for name in motor.joints}
    for name in scene.loaded:
        load, wrong, remedy = scene.friction[name].load, "", "leave load out"
        if not 0.0 <= load < 1.0:
            wrong, remedy = f"is {load:g}", "it is a share of what the joint passes on: 0 or more, less than 1"
        elif name in turned:
            wrong = "is not known for a joint that a coupled motor turns"
        elif name in mimicking:
            wrong = "is not known for a joint that follows another, or is followed"
        elif name in scene.rotor and scene.rotor[name].spins:
            wrong = "is not known for a joint whose rotor has an axis"
        elif scene.constrained:
            wrong = "is not known with loops, contacts or joints that do not drive"
        if wrong:
            raise SceneError(f'[friction] {shown(name)}: "load" {wrong}', remedy=remedy, file=file)


def _check_rotors(scene: Scene, model: Model, file: str | None) -> None:
    """Raise unless it is clear which link carries each spinning rotor, and about which axis it spins; and where a screw
    or a pinion drives a joint that turns."""
    for i, body in enumerate(model.bodies):
        joint, rotor = body.joint, scene.rotor.get(body.joint.name)
        if rotor is not None and rotor.lead and joint.kind != "prismatic":
            what = f"[rotor] {joint.name}: a lead or pitch_radius is for joints that slide, and this one turns"
            raise SceneError(what, remedy="give gear, turns of the motor per turn of the joint", file=file)
        if rotor is None or not rotor.spins:
            continue
        where, on = f"[rotor] {joint.name}", rotor.on or joint.link
        if not on:
            raise SceneError(f'{where}: "on" is missing', remedy="name the link that carries the rotor", file=file)
        known(where, "link", on, model.links, file)
        if rotor.axis is None and model.links[on].body not in (i, body.parent):
            what = f'{where}: "axis" is missing, and the joint is not on {shown(on)}'
            raise SceneError(what, remedy="give it in the axes of that link", file=file)
        if rotor.axis is not None and not (any(rotor.axis) and all(isfinite(x) for x in rotor.axis)):
            what = f'{where}: "axis" is {list(rotor.axis)}'
            raise SceneError(what, remedy="give a vector that is not zero", file=file)


def _check_contact(contact: Contact, file: str | None) -> None:
    numbers = [*(x for point in contact.points for x in point), *(contact.normal or ())]
    wrong = ""
    if not contact.points:
        wrong = "has no points"
    elif not all(isfinite(x) for x in numbers):
        wrong = "has numbers that are not finite"
    elif not contact.friction >= 0.0:
        wrong = f"has a friction of {contact.friction:g}"
    elif contact.normal is not None and not any(contact.normal):
        wrong = "has a normal without a direction"
    if wrong:
        what = f"[[contact]] {shown(contact.name)} {wrong}"
        raise SceneError(what, remedy="give points, a normal that is not zero, friction of 0 or more", file=file)


def refuse_others(model: object, scene: object = DEFAULT) -> None:
    """Raise unless these are a robot and what surrounds it."""
    for name, thing, kind, remedy in (
        ("model", model, Model, "pass what robodyn.load returns"),
        ("scene", scene, Scene, "pass what robodyn.load_scene returns, or a robodyn.Scene"),
    ):
        if not isinstance(thing, kind):
            noun = "robot" if kind is Model else "scene"
            given = "None" if thing is None else f"of type {type(thing).__name__}"
            raise InputError(f"{name} is no {noun} but {given}", remedy=remedy)


def refuse_load(scene: Scene) -> None:
    """Raise if friction grows with load, so that torques are not M qdd + b."""
    if scene.loaded:
        what = f"friction of {shown(scene.loaded[0])} grows with load, and this knows only torques M qdd + b"
        remedy = "torques, simulate, inverse and forward dynamics know it; leave load out"
        raise SceneError(what, remedy=remedy)


def refuse_constraints(scene: Scene, file: str | None = None, *, loops: bool = False, contacts: bool = False) -> None:
    """Raise if a scene closes loops or stands on contacts, unless these are known here."""
    if scene.loops and not loops:
        what = "the scene closes loops, and this knows only the open tree"
        remedy = "robodyn torques, fbd, simulate and linearize follow closed chains; without loops it is the tree"
        raise SceneError(what, remedy=remedy, file=file)
    if scene.contacts and not contacts:
        what = "the scene has contacts, and only torques and fbd find their forces"
        raise SceneError(what, remedy="give the forces as [[wrench]], or leave [[contact]] out", file=file)


def check_moves(model: Model) -> None:
    """Raise if the robot has no coordinates."""
    if model.n == 0:
        what = "nothing can move: the robot has no joint that moves, and its base is fixed"
        remedy = 'free its base: [base] motion = "moving" in a scene'
        raise InputError(what, remedy=remedy, file=model.file)


TAG = "constraint"
KINDS = {"fixed": "weld", "revolute": "hinge", "continuous": "hinge", "spherical": "point", "ball": "point"}
"""Loops by the type of a constraint."""


def scene_of(model: Model, scene: Scene = DEFAULT, given: Collection[str] = ()) -> Scene:
    """Return the scene with what the robot's description says of it: the loops that the <constraint> elements of a URDF
    close; of MJCF and SDF gravity, springs, loops, fluid and more (`Description.scene`).

    Commands do so by themselves. What the scene says counts: a loop takes the place of that of its name, a spring of
    that of its joint, gravity of gravity. A value that is the default counts as not said, unless it is a key `given`.

    Source: the proposal to urdfdom_headers, pull request 108: elements of <robot> beside its joints.

    Raises:
        DescriptionError: a constraint is wrong, or of a type that is no loop here, and the scene does not replace it.
    """
    own, strict = {loop.name for loop in scene.loops}, Strict(model.file)
    lines: dict[str, int] = {}
    loops = []
    for element in [] if model.description is None else constraints(model.description):
        name = strict.text(element, "name", f"<{TAG}>")
        if name in own:
            continue
        if name in lines:
            what = f"a second {TAG} {shown(name)}, the first is in line {lines[name]}"
            raise strict.error(element.line, what, "rename one of them")
        lines[name] = element.line
        loops.append(_loop(element, name, model.links, strict))
    described = {} if model.description is None else model.description.scene
    if described:
        from robodyn.scene.read import scene_from

        scene = _with(scene, scene_from(described, [(b"", model.file)]), given)
    return replace(scene, loops=(*loops, *scene.loops)) if loops else scene


def _with(scene: Scene, described: Scene, given: Collection[str]) -> Scene:
    """Return the scene with what a description says of what the scene does not."""
    changes: dict[str, Any] = {}
    for name in (field.name for field in fields(Scene)):
        own, said, usual = (getattr(each, name) for each in (scene, described, DEFAULT))
        key = "fluid" if name == "immersed" or name.startswith("fluid") else name
        if said == usual or key in given:
            continue
        if isinstance(said, Mapping):
            changes[name] = {**said, **own}
        elif name == "loops":
            changes[name] = (*(loop for loop in said if loop.name not in {each.name for each in own}), *own)
        elif name == "wrenches":
            changes[name] = (*said, *own)
        elif own == usual:
            changes[name] = said
    return replace(scene, **changes)


def _loop(element: Element, name: str, links: Collection[str], strict: Strict) -> Loop:
    owner = f"{TAG} {shown(name)}"
    ends = []
    for role in ("parent", "child"):
        link = strict.text(strict.needed_child(element, role, owner), "link", owner)
        if link not in links:
            what = f"the {role} of {owner} is link {shown(link)}, which does not exist"
            raise strict.error(element.line, what, alternatives(link, links, "links"))
        ends.append(link)
    parent, child = ends
    if parent == child:
        raise strict.error(element.line, f"{owner} ties link {shown(child)} to itself", "name two links")
    kind = KINDS.get(written := strict.text(element, "type", owner).lower())
    if kind is None:
        what = f"{owner} has the type {shown(written)}, which is no loop here"
        remedy = f"types: {', '.join(KINDS)}; or give the scene a [[loop]] of this name"
        raise strict.error(element.line, what, remedy)
    points, turns, axes = [], [], []
    for role in ("parent", "child"):
        points.append(_vector(element, f"{role}_origin", "xyz", owner, strict, ZERO))
        turns.append(rotation_from_rpy(*_vector(element, f"{role}_origin", "rpy", owner, strict, ZERO)))
        axis = _vector(element, f"{role}_axis", "xyz", owner, strict, (1.0, 0.0, 0.0))
        if kind == "hinge" and not any(axis):
            what = f"<{role}_axis> of {owner} has the length 0, which gives no direction"
            raise strict.error(element.line, what, 'write xyz="0 0 1"')
        x, y, z = product(turns[-1], np.array(axis)).tolist()
        axes.append((x, y, z))
    more: dict[str, Any] = {"axis": axes[1], "to_axis": axes[0]} if kind == "hinge" else {}
    if kind == "weld":
        more = {"rpy": rpy_from_rotation(product(turns[0], turns[1].T))}
    return Loop(name, child, points[1], parent, points[0], kind, **more)


def constraints(description: Description) -> list[Element]:
    """Return the <constraint> elements, whatever they say."""
    if description.format != "urdf" or b"<" + TAG.encode() not in description.data:
        return []
    return read_document(description.data, description.file).root.findall(TAG)


def _vector(element: Element, tag: str, name: str, owner: str, strict: Strict, default: Vector) -> Vector:
    part = strict.child(element, tag, owner)
    return default if part is None else strict.vector(numbers(part, name, 3), owner, *default)
