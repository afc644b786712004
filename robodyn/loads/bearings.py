"""What bearings and guides transmit along a motion, gathered block by block."""

from __future__ import annotations

import numpy as np

from robodyn.loads.sizing_result import BearingLoad, Component, Vector
from robodyn.loads.statistics import Greatest, Integrals, resultant
from robodyn.programs.vectors import length, product
from robodyn.robot.model import Joint, Model
from robodyn.support.floats import Floats

NAMES = {"revolute": ("fu", "fv", "fa", "mu", "mv"), "prismatic": ("fu", "fv", "mu", "mv", "ma")}
_RESULTANTS = ("radial", "tilting")
_WIDTH = 7


class BearingPass:
    """Peaks and mean squares of the five components that each joint cannot give way to."""

    def __init__(self, model: Model) -> None:
        numbered = enumerate(body.joint for body in model.bodies[1:])
        self.joints = [(k, joint) for k, joint in numbered if joint.kind in NAMES]
        self.frames = [frame(joint.axis) for _, joint in self.joints]
        self.peaks = Greatest(_WIDTH * len(self.joints))
        self.integrals = Integrals()

    def update(self, time: Floats, first_row: int, wrenches: Floats) -> None:
        """Take in a block.

        Args:
            time: (N,) s; first_row: of the data, from 1.
            wrenches: (N, 6 (bodies - 1)) f and m on every body but the base, in its axes.
        """
        rows = [
            _components(joint, turn, wrenches[:, 6 * k : 6 * k + 6])
            for (k, joint), turn in zip(self.joints, self.frames, strict=True)
        ]
        values = np.concatenate(rows) if rows else np.empty((0, len(time)))
        self.peaks.update(time, first_row, np.abs(values), value=values)
        self.integrals.update(time, {"square": values * values})

    def report(self) -> tuple[BearingLoad, ...]:
        """Return the loads so far; those of a motion without duration are their own RMS."""
        peaks = self.peaks
        rms = np.sqrt(self.integrals.mean("square", peaks.score**2))

        def component(at: int, name: str) -> Component:
            unit = "N m" if name.startswith(("m", "t")) else "N"
            value, when = float(peaks.kept["value"][at]), float(peaks.time[at])
            return Component(name, unit, value, when, int(peaks.row[at]), float(rms[at]))

        loads = []
        for i, ((_, joint), turn) in enumerate(zip(self.joints, self.frames, strict=True)):
            parts = [component(_WIDTH * i + k, name) for k, name in enumerate((*NAMES[joint.kind], *_RESULTANTS))]
            u, v, axis = (_vector(row) for row in turn)
            loads.append(BearingLoad(joint.name, joint.kind, (u, v, axis), tuple(parts[:5]), parts[5], parts[6]))
        return tuple(loads)


def frame(axis: Floats) -> Floats:
    """Return (3, 3) rows u, v and the axis, right-handed.

    u and v are the coordinate axes that follow the axis in x, y, z, x if it is along one of them (-v if it is against
    it); otherwise u is at right angles to the axis and to the coordinate axis that it is furthest from.
    """
    along = np.abs(axis)
    if along.max() == 1.0:
        k = int(along.argmax())
        u = np.roll(np.eye(3)[k], 1)
    else:
        u = np.cross(axis, np.eye(3)[int(along.argmin())])
        u /= length(u)
    return np.array([u, np.cross(axis, u), axis])


def _components(joint: Joint, turn: Floats, wrench: Floats) -> Floats:
    """(7, N) the five components, then radial force and tilting moment."""
    f, m = product(turn, wrench[:, :3].T), product(turn, wrench[:, 3:].T)
    kept = (f, m[:2]) if joint.kind == "revolute" else (f[:2], m)
    return np.vstack((*kept, resultant(f[0], f[1]), resultant(m[0], m[1])))


def _vector(row: Floats) -> Vector:
    x, y, z = (float(value) + 0.0 for value in row)
    return x, y, z
