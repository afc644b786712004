"""Which joints drive, and how they share."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.constraints.structure import Mask
from robodyn.errors import SceneError
from robodyn.robot.limits import binding
from robodyn.robot.model import Joint, Model
from robodyn.scene.parts import EFFORT, GROUND
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats
from robodyn.support.wording import shown


class Actuation(NamedTuple):
    """Of a robot's rates.

    Attributes:
        passive: (n,) which nothing drives: those of passive joints and of floating ones, and the base's where contacts
            or loops to the ground hold it.
        driven: (n,) joints that drive; a base that is neither passive nor driven is held.
        weights: (driven,) of the squares of their torques.
        limits: (driven,) effort limits [N m or N], infinite where there is none.
    """

    passive: Mask
    driven: Mask
    weights: Floats
    limits: Floats

    @property
    def counted(self) -> Mask:
        """(n,) rates that constraints act on: all but those of a base that is held."""
        return np.asarray(self.passive | self.driven)


@lru_cache(maxsize=16)
def actuation(model: Model, scene: Scene) -> Actuation:
    """Return what drives in a scene: joints of `actuated`, or all but those of `passive`; where neither is said, those
    of `drive` in a closed chain that has some, else all.

    Raises:
        SceneError: a weight or a cost asks for the effort limit of a joint that has none.
    """
    passive, driven = np.zeros(model.n, dtype=bool), np.zeros(model.n, dtype=bool)
    weights, limits = [], []
    actuated = scene.actuated
    if actuated is None and not scene.passive and scene.loops and scene.drive:
        actuated = tuple(scene.drive)
    base = 6 if model.floating else 0
    for joint in model.independent:
        if joint.kind == "floating":
            passive[joint.rate : joint.rate + 6] = joint.rate >= base or _grounded(model, scene)
            continue
        drives = joint.name in actuated if actuated is not None else joint.name not in scene.passive
        passive[joint.rate], driven[joint.rate] = not drives, drives
        if not drives and joint.name in scene.weights:
            what = f"[weights]: nothing drives {shown(joint.name)}"
            raise SceneError(what, remedy="give weights of joints that drive")
        if drives:
            weights.append(_weight(joint, scene))
            limits.append(binding(joint.effort) or np.inf)
    cost = scene.contact_cost
    if scene.contacts and (cost.torques or cost.within_limits) and not np.isfinite(limits).any():
        what = "[contact_cost] counts torques by their effort limits, and no joint that drives has one"
        raise SceneError(what, remedy="give limits in the description, or leave torques and within_limits out")
    return Actuation(passive, driven, np.array(weights), np.array(limits))


def _grounded(model: Model, scene: Scene) -> bool:
    """Return whether contacts, or loops to the ground, hold a base that moves, and nothing else does."""
    to_ground = GROUND not in model.links and any(loop.to == GROUND for loop in scene.loops)
    return (bool(scene.contacts) or to_ground) and not scene.held


def _weight(joint: Joint, scene: Scene) -> float:
    weight = scene.weights.get(joint.name, scene.weight) if scene.share == "weighted" else 1.0
    if weight != EFFORT:
        return float(weight)
    limit = binding(joint.effort)
    if not limit:
        what = f'[weights]: {shown(joint.name)} has no effort limit, by which "{EFFORT}" weighs'
        raise SceneError(what, remedy="give its weight as a number, or the limit in the description")
    return 1.0 / limit**2
