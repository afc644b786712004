"""Whether a base that is taken as held is one that in truth stands on legs or wheels, or flies."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from math import hypot
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.doubts import Doubt
from robodyn.model import Model
from robodyn.result import ComponentLoad, JointLoad
from robodyn.scene import Scene
from robodyn.spatial import length, product
from robodyn.wording import figure, shown

Floats = NDArray[np.float64]

GROUNDS = frozenset({"world", "ground", "earth", "floor", "wall", "ceiling", "table"})
"""Names of a root link by which a description says that what is fixed to it does not move."""
FEET = frozenset({"foot", "feet", "toe", "sole", "ankle", "hoof", "paw"})
LEGS = FEET | frozenset({"leg", "lowerleg", "upperleg", "knee", "calf", "shank", "shin", "tibia", "thigh"})
WHEELS = frozenset({"wheel", "wheels", "caster", "casters"})
ROTORS = frozenset({"rotor", "propeller", "prop", "thruster"})
FLIERS = frozenset({"quadrotor", "quadcopter", "hexarotor", "multirotor", "drone", "uav", "flying"})
VANISHING = 0.01
"""Of the weight, or of the largest force that balances: a base wrench below it is rounding or noise."""
_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
_NAMES = 4


def carried(
    model: Model,
    scene: Scene,
    base: Sequence[ComponentLoad],
    joints: Sequence[JointLoad],
    largest_force: float,
    largest_moment: float,
) -> tuple[Doubt, ...]:
    """Return what is in doubt about what carries the base, and what carries the robot at floating joints.

    Nothing where the scene says that the base is held, where no wrench is left, and where a base that does not move may
    well be bolted down.

    Args:
        base, joints: their loads.
        largest_force, largest_moment: that balance along the motion [N, N m].
    """
    weight = model.total_mass * hypot(*scene.gravity)
    least = VANISHING * max(weight, largest_force), VANISHING * max(weight * model.reach, largest_moment)
    parts = {part.name: part.rms for part in base}
    wrench = [hypot(*(parts[f"{kind}{axis}"] for axis in "xyz")) for kind in "fm"]
    found = [_base_doubt(model, scene, *wrench)] if _left(wrench, least) else []
    loads = {joint.name: joint.rms for joint in joints}
    for name in (body.joint.name for body in model.bodies[1:] if body.joint.kind == "floating"):
        wrench = [hypot(*(loads[f"{name}_{kind}{axis}"] for axis in "xyz")) for kind in "vw"]
        if _left(wrench, least):
            what = f"nothing drives the floating joint {shown(name)}, whose motion takes {_wrench(*wrench)}"
            found.append(Doubt("as long as what floats is carried (assumed)", f"{what}; give it as [[wrench]]"))
    return tuple(doubt for doubt in found if doubt is not None)


def _left(wrench: Sequence[float], least: Sequence[float]) -> bool:
    return any(size > most for size, most in zip(wrench, least, strict=True))


def _wrench(force: float, moment: float) -> str:
    return f"{figure(force)} N and {figure(moment)} N m (RMS)"


def _base_doubt(model: Model, scene: Scene, force: float, moment: float) -> Doubt | None:
    alone = "the wrenches of the scene do not carry it" if scene.wrenches else "there is no contact that carries it"
    why = alone if model.floating else untouched(model)
    if scene.held or not why:
        return None
    loads = "which a robot that floats cannot have" if model.floating else "loads of a robot that hangs by its base"
    free = "" if model.floating else 'let the base move ([base] motion = "moving", base_ columns) and '
    said = (
        f"the ground holds the base with {_wrench(force, moment)}, {loads}: {why}; "
        f"if something carries the base, such as bolts or a vehicle, say so (--base-held, or [base] held = true), "
        f"otherwise {free}give the contact forces as [[wrench]]"
    )
    return Doubt("as long as the base is held (assumed)", said)


def untouched(model: Model) -> str:
    """Return what makes one think that a base is not bolted down, and does not touch anything; empty if nothing does.

    Legs are two or more branches of two or more joints that end below all of the base (z up), or that have links called
    foot, shank and the like. The names of wheels, casters, rotors and flying machines count; names such as base_link or
    trunk do not. A root called world or ground is bolted down.
    """
    root = _words(model.bodies[0].name)
    if root & GROUNDS and root <= GROUNDS | {"link", "frame"}:
        return ""
    if not model.n:
        return "no joint moves"
    legs = _legs(model)
    if len(legs) > 1:
        return f"there is no contact at its feet ({_some(legs)})"
    wheels = [name for name in model.links if _words(name) & WHEELS]
    if len(wheels) > 1:
        return f"there is no contact at its wheels ({_some(wheels)})"
    near = [name for name, frame in model.links.items() if model.bodies[frame.body].parent < 1]
    rotors = [name for name in near if _words(name) & ROTORS]
    if len(rotors) > 2:
        return f"there is no thrust at its rotors ({_some(rotors)})"
    flies = [name for name in (model.name, *model.links) if _words(name) & FLIERS]
    return f"there is no thrust, and by its names it flies ({_some(flies)})" if flies else ""


def _words(name: str) -> frozenset[str]:
    """Return the words of a name such as LF_FOOT, left_foot_2 or leftLowerLeg, in small letters."""
    return frozenset(word.lower() for word in _WORDS.findall(name))


def _some(names: Sequence[str]) -> str:
    more = f" and {len(names) - _NAMES} more" if len(names) > _NAMES else ""
    return ", ".join(shown(name) for name in names[:_NAMES]) + more


class _Branch(NamedTuple):
    """What a joint of the base carries: links, and how far below that joint the lowest of them is, of what length."""

    links: Sequence[str]
    foot: str
    height: float
    drop: float
    length: float


def _legs(model: Model) -> list[str]:
    """Return the links at which legs end, by where they are or else by their names."""
    branches = list(_branches(model))
    bottom = _bottom(model)
    below = [each for each in branches if each.drop > 0.5 * each.length and bottom - each.height > 0.25 * each.length]
    lowest = min((each.height for each in below), default=0.0)
    level = [each.foot for each in below if each.height < lowest + 0.2 * each.length]
    if len(level) > 1 and model.bodies[0].inertia.m > 0.0:
        return level
    named = ([name for name in each.links if _leg(name)] for each in branches)
    return [names[-1] for names in named if names]


def _leg(name: str) -> bool:
    return bool(_words(name) & LEGS)


def _branches(model: Model) -> Iterator[_Branch]:
    """Yield the branches of two or more joints in a row that the base carries."""
    first, depth, reach = [0], [0], [0.0]
    for i, body in enumerate(model.bodies[1:], 1):
        first.append(first[body.parent] or i)
        depth.append(depth[body.parent] + (body.joint.mimics is None))
        reach.append(reach[body.parent] + (length(body.joint.p) if body.parent else 0.0))
    places = _origins(model)
    for hip in dict.fromkeys(first[1:]):
        links = [name for name, frame in model.links.items() if first[frame.body] == hip]
        if ends := [name for name in links if depth[model.links[name].body] > 1]:
            foot = min(ends, key=lambda name: places[name][2])
            end, height = model.links[foot], float(places[foot][2])
            drop = float(model.bodies[hip].joint.p[2]) - height
            yield _Branch(links, foot, height, drop, reach[end.body] + length(end.p))


def _bottom(model: Model) -> float:
    """Return the height of the lowest of the base's frames and mass centre, but for a footprint on the floor [m]."""
    base = model.bodies[0].inertia
    own = (frame.p[2] for name, frame in model.links.items() if frame.body == 0 and "footprint" not in _words(name))
    return float(min(own, default=0.0)) if not base.m > 0.0 else float(min(base.mc[2] / base.m, *own, 0.0))


def _origins(model: Model) -> Mapping[str, Floats]:
    """Return where the links are in the base's frame, all joints at 0 [m]."""
    R, p = [np.eye(3)], [np.zeros(3)]
    for body in model.bodies[1:]:
        R.append(product(R[body.parent], body.joint.R))
        p.append(p[body.parent] + product(R[body.parent], body.joint.p))
    return {name: p[frame.body] + product(R[frame.body], frame.p) for name, frame in model.links.items()}
