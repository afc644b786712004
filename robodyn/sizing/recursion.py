"""The most that weight can ask of joints, bearings and the base in any pose, bounded from above, from tips to base.

Of each body the most that `w . h` can be for a direction w in its axes is known, h the first moment of all that it
carries: its support function. From that follows what weight asks of its joint, of a direction of gravity in its axes.
All these functions pass to the body before: a joint is the maximum over its turns or its stroke, a branch the sum. At
the base gravity is known. Each is exact, whatever the number of joints, but for the lattice that it is kept on
(`directions.py`). Joints that mimic count as free within their limits, which only adds.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from math import copysign
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from robodyn.programs.vectors import frame, length, product
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import DEFAULT, ExternalWrench, Scene
from robodyn.sizing.directions import Lattice
from robodyn.support.floats import Floats

ROUNDING = 1e-10
"""Of the weight at the farthest reach: more than the rounding of all sums of a bound."""


class Pull(NamedTuple):
    """What pulls one way throughout, as gravity does: a direction in the base's axes, on each body how strongly [N],
    and that times the place where, in the body's frame [N m]."""

    direction: Floats
    force: Floats
    moment: Floats


def weight_of(model: Model, scene: Scene = DEFAULT) -> Pull:
    """Return what pulls along gravity: bodies, payloads, buoyancy, forces along it."""
    size, direction = length(np.array(scene.gravity, dtype=float)), down(scene)
    force = np.array([body.inertia.m * size for body in model.bodies], dtype=float)
    moment = np.array([np.asarray(body.inertia.mc, float) * size for body in model.bodies])
    points = [(each.link, each.com, each.mass * size) for each in scene.payloads]
    points += [(each.link, each.centre, -scene.fluid_density * each.volume * size) for each in scene.immersed]
    points += [(each.link, each.point, float(np.dot(each.force, direction))) for each in scene.wrenches]
    for link, point, pull in points:
        body, R, p = model.links[link]
        force[body] += pull
        moment[body] += pull * (product(np.asarray(R, float), np.array(point, dtype=float)) + np.asarray(p, float))
    return Pull(direction, force, moment)


def down(scene: Scene) -> Floats:
    """The direction of gravity in the base's axes; -z where there is none."""
    g = np.array(scene.gravity, dtype=float)
    return g / length(g) if g.any() else np.array([0.0, 0.0, -1.0])


def along_gravity(wrench: ExternalWrench, scene: Scene) -> bool:
    """Whether a wrench is a force along gravity, whatever the pose."""
    force = np.array(wrench.force, dtype=float)
    aside = length(np.cross(force, down(scene)))
    return wrench.frame != "link" and not any(wrench.moment) and aside <= 1e-15 * length(force)


class Key(NamedTuple):
    """What is asked for: "torque" (place: the entry of tau), or of a joint's bearing, or the base as body 0, what is
    across its axis: "tilting" moment or "radial" force (place: the body)."""

    what: str
    place: int


SUPPORT = Key("support", 0)


def bounds(
    model: Model,
    pull: Pull,
    low: Floats,
    high: Floats,
    lattice: Lattice,
    wanted: Collection[Key],
    springs: Mapping[str, tuple[float, float]] = MappingProxyType({}),
) -> dict[Key, float]:
    """Return a bound of the most that weight, and springs, ask for in magnitude, of each key [N m, N].

    Args:
        low, high: (nq,) of each coordinate [rad or m].
        springs: stiffness and rest of joints, by name.
    """
    bodies, carried = model.bodies, pull.force.copy()
    for i in reversed(range(1, len(bodies))):
        carried[bodies[i].parent] += carried[i]
    axes = [frame(np.asarray(body.joint.axis, float)) if i else np.eye(3) for i, body in enumerate(bodies)]
    ways = [product(turn.T, lattice.directions) for turn in axes]
    found = [{SUPPORT: product(moment, way)} for moment, way in zip(pull.moment, ways, strict=True)]
    for i in reversed(range(1, len(bodies))):
        joint, parent, here = bodies[i].joint, bodies[i].parent, found[i]
        for key, own in _own(joint, i, here[SUPPORT], float(carried[i]), lattice, wanted).items():
            here[key] = here.get(key, 0.0) + own
        passed, ends = np.stack([*here.values()]), _ends(joint, low, high)
        if joint.kind == "revolute":
            passed = lattice.turned(passed, *ends)
        passed = lattice.at(passed, lattice.mix(product(axes[i], joint.R.T, ways[parent])))
        passed[0] += carried[i] * product(joint.p, ways[parent])
        if joint.kind == "prismatic":
            along = carried[i] * product(product(joint.R, joint.axis), ways[parent])
            passed[0] += np.maximum(ends[0] * along, ends[1] * along)
        for key, value in zip(here, passed, strict=True):
            found[parent][key] = found[parent].get(key, 0.0) + value
        found[i] = {}
    if (base := Key("tilting", 0)) in wanted:
        found[0][base] = lattice.tilting(found[0][SUPPORT])
    gravity = lattice.mix(np.stack([-pull.direction, pull.direction], axis=1))
    rounding = ROUNDING * scale(model, pull, low, high)
    sides, most = np.array([1.0, -1.0]), {}
    for key in wanted:
        sprung = np.zeros(2)
        for joint in (body.joint for body in bodies if key == ("torque", body.joint.rate)):
            stiffness, rest = springs.get(joint.name, (0.0, 0.0))
            forces = [joint.multiplier * stiffness * (end - rest) for end in _ends(joint, low, high)]
            sprung += np.max([sides * force for force in forces], axis=0)
        total = lattice.at(found[0][key], gravity) + sprung
        most[key] = float(total.max() + rounding + ROUNDING * np.abs(sprung).max())
    return most


def _ends(joint: Joint, low: Floats, high: Floats) -> list[float]:
    """Between which positions a joint is."""
    return sorted(float(joint.multiplier * end[joint.coordinate] + joint.offset) for end in (low, high))


def _own(
    joint: Joint, i: int, support: Floats, carried: float, lattice: Lattice, wanted: Collection[Key]
) -> dict[Key, Floats]:
    """Return what weight asks for at the joint of body i, of the direction of gravity in the body's axes."""
    found: dict[Key, Floats] = {}
    x, y, z = lattice.directions
    if (key := Key("torque", joint.rate)) in wanted:
        if joint.kind == "prismatic":
            found[key] = joint.multiplier * carried * z
        else:
            found[key] = abs(joint.multiplier) * lattice.about(support, copysign(1.0, joint.multiplier))
    if (key := Key("tilting", i)) in wanted:
        found[key] = lattice.tilting(support)
    if (key := Key("radial", i)) in wanted:
        found[key] = abs(carried) * np.hypot(x, y)
    return found


def scale(model: Model, pull: Pull, low: Floats, high: Floats) -> float:
    """More than all weight at its farthest reach asks for [N m, N]."""
    slides = (_ends(body.joint, low, high) for body in model.bodies if body.joint.kind == "prismatic")
    reach = 1.0 + model.reach + sum(max(map(abs, ends)) for ends in slides)
    return float(np.abs(pull.force).sum() * reach + np.abs(pull.moment).sum()) or 1.0
