"""`robodyn fbd`: a robot in one state, taken apart into free bodies."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Any

import click

from robodyn.cli.files import check_names, refuse_foreign, robot_in_scene
from robodyn.cli.options import AT, FOLDER, FORMAT, PATH, QD, READING, SCENE, VALUES, Call, option, refuse, takes
from robodyn.cli.screen import answer
from robodyn.dynamics.plan import plan
from robodyn.equations.free_body.bodies import free_bodies
from robodyn.errors import InputError
from robodyn.loads.constraints import Follower
from robodyn.report.equations.equations import free_bodies_json, free_body_sections
from robodyn.robot.kinematics import configuration, rates
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.files import write_whole
from robodyn.trajectory.plausible import refuse_units
from robodyn.trajectory.read import read_motion, row_at


def state_of(
    call: Call, model: Model, scene: Scene, qdd: Any, traj: str | None, time: float | None
) -> tuple[str, dict[str, Any], tuple[str, ...]]:
    """Return the state in words, and as what `free_bodies` takes; and warnings about its table."""
    at, qd = call.at, call.qd
    if traj is None:
        if time is not None or call.reading_given:
            refuse(f"{call.reading_given or '--time'} goes with --traj")
        if scene.motion_columns:
            refuse("the scene needs columns of a trajectory: give --traj and --time")
        words = ["at rest" if qd is None else "moving"] + ["accelerating"] * (qdd is not None)
        state = {"q": configuration(model, at or ()), "qd": rates(model, qd or ()), "qdd": rates(model, qdd or ())}
        return ("as given" if at is not None else "at zero") + ", " + ", ".join(words), state, ()
    if at is not None or qd is not None or qdd is not None:
        refuse("--traj says all of the state: leave out --at, --qd and --qdd")
    if time is None:
        refuse("--traj needs --time")
    with read_motion(traj, model, scene, **call.reading) as reader:
        take = [Follower(plan(model, scene), reader.followed, reader.file).take] if scene.loops else []
        row = row_at(reader, time, *take)
    refuse_units(row.caveats, traj)
    since = " after the first" if row.origin else ""
    words_of_row = f"row {row.first_row} of {traj} at {row.time[0]:.6g} s{since}"
    if row.time[0] != time:
        words_of_row += f", the nearest to {time:.6g} s"
    columns = {name: float(values[0]) for name, values in row.extra.items()}
    found: dict[str, Any] = {"q": row.q[0], "qd": row.qd[0], "qdd": row.qdd[0], "columns": columns}
    return words_of_row, found, (*(caveat.text for caveat in row.caveats), *row.notes)


@click.command("fbd", short_help="Draw free bodies: all forces and moments on each body.")
@click.argument("urdf", type=PATH)
@takes(
    AT,
    QD,
    option("--qdd QDD", "Accelerations, likewise; default none.", VALUES),
    option("--traj FILE", "Take the state from a trajectory, at --time.", PATH),
    option("--time T", "s; the nearest row of the trajectory counts.", float),
    READING,
    SCENE,
    option("--svg FOLDER", "Write a drawing of each body there.", FOLDER),
    FORMAT,
)
def command(call: Call, urdf: str, qdd: Any, traj: str | None, time: float | None, svg: str | None) -> None:
    """List and draw free bodies: all forces and moments on each body, and what each joint transmits.
    The state is given by --at, --qd and --qdd, or is a row of a trajectory.

    \b
    Examples:
      robodyn fbd robots/scara.urdf --at 0.3,-0.5,0.05 --qdd elbow=2
      robodyn fbd robots/puma.urdf --traj robots/puma_reach.csv --time 0.5 --svg drawings
    """
    check_names()
    model, scene = robot_in_scene(call, urdf, loops=True, contacts=True)
    words, state, warnings = state_of(call, model, scene, qdd, traj, time)
    found = free_bodies(model, scene=scene, **state)
    found = replace(found, warnings=(*warnings, *found.warnings))
    written = ""
    if svg is not None:
        from robodyn.report.equations.free_body import drawings

        files, remedy = list(drawings(found, words)), "name another folder"
        try:
            os.makedirs(svg, exist_ok=True)
        except (OSError, ValueError) as error:
            why = (error.strerror or str(error)).lower() if isinstance(error, OSError) else str(error)
            raise InputError(f"cannot be written: {why}", remedy=remedy, file=svg) from None
        for name, _ in files:
            refuse_foreign(os.path.join(svg, name), "a drawing", remedy)
        for name, content in files:
            write_whole(os.path.join(svg, name), content.encode(), remedy)
        written = f"\nwritten: {len(files)} drawings in {svg}\n"
    sections = free_body_sections(found, words)
    answer(call, sections, written=written, json=lambda: free_bodies_json(found, words))
