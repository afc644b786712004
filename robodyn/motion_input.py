"""Motions of a robot, from files and arrays."""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robodyn.model import Joint, Model
from robodyn.scene import DEFAULT, Scene
from robodyn.trajectory.columns import Kind, Signal, Signals
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.read import from_arrays, open_trajectory
from robodyn.trajectory.reader import Derivatives, TrajectoryReader

Floats = NDArray[np.float64]


def signals(model: Model) -> Signals:
    """What the model wants to read from a trajectory."""
    dependent = tuple(body.joint.name for body in model.bodies if body.joint.mimics is not None)
    return Signals(tuple(Signal(joint.name, _kind(joint)) for joint in model.independent), dependent)


def _kind(joint: Joint) -> Kind:
    if joint.kind == "floating":
        return "floating"
    if joint.kind == "prismatic":
        return "length"
    return "continuous" if joint.continuous else "angle"


def read_motion(
    path: str | os.PathLike[str],
    model: Model,
    scene: Scene = DEFAULT,
    *,
    derivatives: Derivatives = "auto",
    ignore_extra: bool = False,
) -> TrajectoryReader:
    """A reader of the motion of this robot in this scene, for `torques`.

    Args:
        path: `.csv`, `.parquet` or `.npz`; `-` is standard input.
        derivatives: how missing velocities and accelerations are derived; see `robodyn.trajectory.read`.
        ignore_extra: leave unknown columns out instead of refusing them.

    Raises:
        TrajectoryError: the file cannot be read or its columns do not fit the robot.
    """
    return open_trajectory(
        path, signals(model), extra=scene.columns, derivatives=derivatives, ignore_extra=ignore_extra
    )


def motion(
    model: Model,
    time: ArrayLike,
    q: ArrayLike,
    qd: ArrayLike | None = None,
    qdd: ArrayLike | None = None,
    *,
    columns: Mapping[str, ArrayLike] | None = None,
    derivatives: Derivatives = "auto",
) -> Trajectory:
    """A motion of this robot from arrays, for `torques`; velocities and accelerations that are left out are derived.

    Args:
        time: (N,) s, increasing.
        q: (N, nq) rad or m; qd, qdd: (N, n) per s and per s^2; in the order of `model.coordinates` and `model.rates`.
        columns: (N,) values of the columns that the scene's wrenches name.
        derivatives: see `robodyn.trajectory.read`.

    Raises:
        TrajectoryError: an array has the wrong shape or is not finite, or time does not increase.
    """
    return from_arrays(signals(model), time, q, qd, qdd, columns, derivatives)


def sources_of(block: Trajectory, scene: Scene) -> dict[str, Floats]:
    """The arrays of a block as programs read them."""
    extra = [block.extra[name] for name in scene.columns]
    columns = np.stack(extra, axis=1) if extra else np.empty((len(block), 0))
    return {"q": block.q, "qd": block.qd, "qdd": block.qdd, "columns": columns}
