"""Torques at joints that do not come from the robot: those of drives, closed by their gains."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robodyn.robot.model import Model
from robodyn.scene.parts import Entry
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats


class Drives(NamedTuple):
    """tau = torque + kp (reference - q) + kd (speed - qd), by rate: (n,) each, zero where nothing drives."""

    torque: Floats
    kp: Floats
    kd: Floats
    reference: Floats
    speed: Floats

    def at(self, positions: Floats, qd: Floats) -> Floats:
        """Return the torques [N m or N] at these positions (n,) of joints by rate."""
        return self.torque + self.kp * (self.reference - positions) + self.kd * (self.speed - qd)


def drives_of(model: Model, scene: Scene, q: Floats) -> Drives:
    """Return the drives of a scene. There is no table: a reference that follows one is where the joint stands at q, a
    torque or a speed that does is zero."""
    found = Drives(*(np.zeros(model.n) for _ in Drives._fields))
    for joint in model.independent:
        drive = scene.drive.get(joint.name)
        if drive is not None:
            k, here = joint.rate, float(q[joint.coordinate])
            found.torque[k] = _number(drive.torque, 0.0)
            found.kp[k], found.kd[k] = drive.kp, drive.kd
            found.reference[k] = _number(drive.reference, here)
            found.speed[k] = _number(drive.speed, 0.0)
    return found


def following(scene: Scene) -> list[str]:
    """Return the joints whose drives follow a table."""
    return [name for name, drive in scene.drive.items() if drive.columns]


def _number(entry: Entry | None, otherwise: float) -> float:
    return otherwise if entry is None or isinstance(entry, str) else float(entry)


def positions(model: Model, q: Floats) -> Floats:
    """Return (n,) the positions of hinges and slides by rate, zero for a floating base."""
    out = np.zeros(model.n)
    for joint in model.independent:
        if joint.kind != "floating":
            out[joint.rate] = q[joint.coordinate]
    return out
