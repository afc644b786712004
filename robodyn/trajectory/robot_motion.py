"""Motions of a robot, from files and arrays."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from robodyn.robot.model import Joint, Model
from robodyn.scene.fit import refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.trajectory.columns import Kind, Signal, Signals
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.read import from_arrays, open_trajectory
from robodyn.trajectory.reader import TrajectoryReader
from robodyn.trajectory.reading import Derivatives, HoldGiven, Reading, hold_of
from robodyn.trajectory.units import AngleUnit, TimeUnit


def signals(model: Model, scene: Scene = DEFAULT) -> Signals:
    """Return what the model wants to read from a trajectory."""
    dependent = tuple(body.joint.name for body in model.bodies if body.joint.mimics is not None)
    constraints = (*(loop.name for loop in scene.loops), *(contact.name for contact in scene.contacts))
    joints = tuple(_signal(model, joint) for joint in model.independent)
    return Signals(joints, dependent, _looped(model, scene), constraints)


def _looped(model: Model, scene: Scene) -> tuple[str, ...]:
    """Return the joints that move a loop: those between the two links and what carries both."""
    found: set[int] = set()
    for loop in scene.loops:
        there = (model.links[loop.to].body if loop.to in model.links else -1, model.links[loop.link].body)
        ways = [{*_outward(model, body)} for body in there]
        found |= {model.bodies[i].joint.coordinate for i in ways[0] ^ ways[1]}
    return tuple(joint.name for joint in model.independent if joint.coordinate in found)


def _outward(model: Model, i: int) -> Iterator[int]:
    while i >= 0:
        yield i
        i = model.parents[i]


def _signal(model: Model, joint: Joint) -> Signal:
    """Return a joint as a signal; its limits are those of joints that mimic it, too, where all can be kept."""
    lower, upper = -inf, inf
    for each in (body.joint for body in model.bodies if body.joint.coordinate == joint.coordinate):
        ends = [-inf if each.lower is None else each.lower, inf if each.upper is None else each.upper]
        if each.multiplier and ends[0] < ends[1] and joint.kind != "floating":
            low, high = sorted((end - each.offset) / each.multiplier for end in ends)
            if max(low, lower) <= min(high, upper):
                lower, upper = max(low, lower), min(high, upper)
    return Signal(joint.name, _kind(joint), lower, upper, joint.velocity or inf)


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
    hold: HoldGiven | None = None,
    columns: Mapping[str, str] | None = None,
    time_unit: TimeUnit | None = None,
    angle_unit: AngleUnit | None = None,
    topic: str | None = None,
    measured: bool = False,
    encoder_error: float = 0.0,
) -> TrajectoryReader:
    """Return a reader of the motion of this robot in this scene, for `torques`.

    Joints of loops may be without columns: they follow, see `loads.follow`.

    Args:
        path: `.csv`, `.parquet` or `.npz`; a bag of ROS (`.db3`, `.mcap`, `.bag`, or a folder) or messages of ROS
            (`.yaml`, `.json`); `-` is standard input.
        derivatives: how missing velocities and accelerations are derived: "auto", "anew" (also those that are given),
            "given" (not at all), "spline", "savgol" or "central".
        ignore_extra: leave unknown columns out instead of refusing them.
        hold: where joints without columns are held: "rest" (nearest to zero within the limits), a position for all, or
            positions by joint; None refuses them. Those of loops are held only by name.
        columns: our name -> the table's, such as {"q_elbow": "Elbow angle"}.
        time_unit, angle_unit: of columns whose names do not tell; None assumes s and rad, and doubts them where the
            motion could hardly be so.
        topic: of a bag; None: the only one with messages about joints.
        measured: read the torques that a log gives too: `extra["tau_<joint>"]` of its blocks [N m].
        encoder_error: the largest error of encoders that repeats with the angle [rad; m of slides], for error bars:
            positions alone do not tell it from motion.

    Raises:
        TrajectoryError: the file cannot be read or its columns do not fit the robot.
    """
    refuse_others(model, scene)
    reading = Reading(
        derivatives, ignore_extra, hold_of(hold), columns or {}, time_unit, angle_unit, topic, measured, encoder_error
    )
    return open_trajectory(path, signals(model, scene), extra=scene.motion_columns, reading=reading)


def motion(
    model: Model,
    time: ArrayLike,
    q: ArrayLike | Mapping[str, ArrayLike],
    qd: ArrayLike | Mapping[str, ArrayLike] | None = None,
    qdd: ArrayLike | Mapping[str, ArrayLike] | None = None,
    *,
    scene: Scene = DEFAULT,
    columns: Mapping[str, ArrayLike] | None = None,
    derivatives: Derivatives = "auto",
    time_unit: TimeUnit | None = None,
    angle_unit: AngleUnit | None = None,
    encoder_error: float = 0.0,
) -> Trajectory:
    """A motion of this robot from arrays, for `torques`; velocities and accelerations that are left out are derived.

    Args:
        time: (N,) s, increasing.
        q: (N, nq) rad or m; qd, qdd: (N, n) per s and per s^2; in the order of `model.coordinates` and `model.rates`.
            Or (N,) by coordinate or rate: what is left out follows from the loops of the scene.
        scene: with the loops that tell what is left out.
        columns: (N,) values of the columns that the scene's wrenches and contacts name.
        derivatives, time_unit, angle_unit, encoder_error: as for `read_motion`.

    Raises:
        TrajectoryError: an array has the wrong shape or is not finite, or time does not increase.
    """
    refuse_others(model, scene)
    reading = Reading(derivatives, time_unit=time_unit, angle_unit=angle_unit, encoder_error=encoder_error)
    return from_arrays(signals(model, scene), time, q, qd, qdd, columns, reading)


def sources_of(block: Trajectory, scene: Scene) -> dict[str, Floats]:
    """The arrays of a block as programs read them."""
    extra = [block.extra[name] for name in scene.columns]
    columns = np.stack(extra, axis=1) if extra else np.empty((len(block), 0))
    return {"q": block.q, "qd": block.qd, "qdd": block.qdd, "columns": columns}
