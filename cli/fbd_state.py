"""The options of `robodyn fbd` that say in which state the robot is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from robodyn.cli.options import PATH, AtType
from robodyn.cli.reading_options import given, reading
from robodyn.robot.configuration import configuration, rates
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.trajectory.at_time import row_at
from robodyn.trajectory.robot_motion import read_motion

Callback = Callable[..., Any]


def STATE(command: Callback) -> Callback:
    """The options --at, --qd, --qdd, --traj and --time."""
    options = (
        click.option("--at", type=AtType(), metavar="Q", help="Joint values in order, or JOINT=Q,...; the rest 0."),
        click.option("--qd", type=AtType(), metavar="QD", help="Velocities, likewise; default at rest."),
        click.option("--qdd", type=AtType(), metavar="QDD", help="Accelerations, likewise; default none."),
        click.option("--traj", type=PATH, metavar="FILE", help="Take the state from a trajectory, at --time."),
        click.option("--time", type=float, metavar="T", help="s; the nearest row of the trajectory counts."),
    )
    for option in reversed(options):
        command = option(command)
    return command


def state_of(
    model: Model, scene: Scene, at: Any, qd: Any, qdd: Any, traj: str | None, time: float | None
) -> tuple[str, dict[str, Any], tuple[str, ...]]:
    """The state in words, and as what `free_bodies` takes; and warnings about its table."""
    ctx = click.get_current_context()
    if traj is None:
        if time is not None or given():
            raise click.UsageError(f"{given() or '--time'} goes with --traj", ctx)
        if scene.columns:
            raise click.UsageError("the scene's wrenches need columns of a trajectory: give --traj and --time", ctx)
        words = ["at rest" if qd is None else "moving"] + ["accelerating"] * (qdd is not None)
        state = {"q": configuration(model, at or ()), "qd": rates(model, qd or ()), "qdd": rates(model, qdd or ())}
        return ("as given" if at is not None else "at zero") + ", " + ", ".join(words), state, ()
    if at is not None or qd is not None or qdd is not None:
        raise click.UsageError("--traj says all of the state: leave out --at, --qd and --qdd", ctx)
    if time is None:
        raise click.UsageError("--traj needs --time", ctx)
    with read_motion(traj, model, scene, **reading()) as reader:
        row = row_at(reader, time)
    since = " after the first" if row.origin else ""
    words_of_row = f"row {row.first_row} of {traj} at {row.time[0]:.6g} s{since}"
    if row.time[0] != time:
        words_of_row += f", the nearest to {time:.6g} s"
    columns = {name: float(values[0]) for name, values in row.extra.items()}
    found: dict[str, Any] = {"q": row.q[0], "qd": row.qd[0], "qdd": row.qdd[0], "columns": columns}
    return words_of_row, found, (*(doubt.said for doubt in row.doubts), *row.notes)
