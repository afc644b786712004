"""`robodyn retime`: a path in the shortest time that all limits allow."""

from __future__ import annotations

from functools import partial
from typing import Any

import click

from robodyn.cli import options
from robodyn.cli.files import ROBOT, TABLE, check_names, expect, robot_in_scene
from robodyn.cli.options import Call, Parsed, finite_numbers, option, takes
from robodyn.cli.screen import answer, write_table
from robodyn.report.sizing.retime import retime_json, retime_page, retime_sections
from robodyn.sizing.retime import GRID, PROFILES, RATE, retime
from robodyn.trajectory.write import format_of


def _share(text: str) -> float:
    numbers = finite_numbers(text.removesuffix("%"))
    if len(numbers) != 1:
        raise ValueError(f"{text!r} is no share, such as 80% or 0.8")
    return numbers[0] / 100.0 if text.endswith("%") else numbers[0]


@click.command("retime", short_help="Time a path: the fastest motion within all limits, or point to point.")
@click.argument("urdf", type=options.PATH)
@click.argument("path", type=options.PATH)
@takes(
    option("--out FILE", "Write the motion: .csv, .parquet or .npz.", options.TABLE_OUT),
    option("--profile", "optimal: the shortest time; others: from stop to stop.", PROFILES, default=PROFILES[0]),
    option("--speed SHARE", "Of the velocity limits, such as 80%.", Parsed("share", _share), default=1.0),
    option("--acceleration A", "rad/s^2 (m/s^2), of all joints; or JOINT=A,...", options.VALUES),
    option("--jerk J", "rad/s^3 (m/s^3), likewise.", options.VALUES),
    option("--blend R", "rad, m: straight lines, corners rounded from R on; 0 stops.", click.FloatRange(min=0.0)),
    option("--rate HZ", f"Rows per second; default {RATE:g}.", options.POSITIVE, default=RATE),
    option("--grid N", f"Intervals of the path; default {GRID}.", int, default=GRID),
    option("--hold rest|POSITION|...*", "Joints without columns: at rest, a position, JOINT=POSITION,..."),
    options.TABLE,
    option("--angle-unit", "Of joints whose columns do not tell; default rad.", ("rad", "deg")),
    option("--ignore-extra", "Leave out columns that the robot does not know."),
    options.SCENE,
    options.REPORT,
    options.FORMAT,
)
def command(call: Call, urdf: str, path: str, profile: str, **how: Any) -> int:
    """Lead a curve through the way-points of a table, and time it: as fast as the limits of speed, acceleration, torque
    and motors allow (reachability analysis), or as drives go, from point to point. Says which limit binds. The columns
    are those of a trajectory; time is not needed, and `dwell` [s] is how long the robot waits in a row. Exit status 1
    if no motion keeps all limits; nothing is written then. A file named - is standard input.

    \b
    Examples:
      robodyn retime robots/puma.urdf waypoints.csv --acceleration 20 --out motion.csv
      robodyn retime robots/puma560.urdf waypoints.csv --scene robots/puma560_sizing.toml --report fastest.html
      robodyn retime robots/puma.urdf waypoints.csv --profile scurve --speed 80% --out motion.csv
    """
    check_names()
    expect(ROBOT, urdf)
    expect(TABLE, path)
    if call.out is not None:
        format_of(call.out)
    model, scene = robot_in_scene(call, urdf)
    found = retime(model, path, scene, profile=profile, **how, **call.reading)
    written = write_table(call.out if found.feasible else None, found.names, found.time, found.columns)
    answer(call, retime_sections(found), partial(retime_page, found), written, json=lambda: retime_json(found))
    return int(not found.feasible)
