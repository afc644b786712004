"""`robodyn excite`: a motion from which parameters can be identified."""

from __future__ import annotations

from functools import partial
from typing import Any

import click

from robodyn.cli.files import check_names, robot_in_scene
from robodyn.cli.options import FORMAT, NAMES, PATH, POSITIVE, REPORT, SCENE, TABLE_OUT, VALUES, Call, option, takes
from robodyn.cli.screen import answer, write_table
from robodyn.identification.excitation.excite import HARMONICS, PERIOD, RATE, excite
from robodyn.report.identification import excitation_json, excitation_page, excitation_sections
from robodyn.trajectory.write import format_of


@click.command("excite", short_help="Find a motion that shows a robot's parameters.")
@click.argument("urdf", type=PATH)
@takes(
    option("--out FILE", "Write the motion: .csv, .parquet or .npz.", TABLE_OUT),
    option("--period S", f"s, of the motion; default {PERIOD:g}.", POSITIVE, default=PERIOD),
    option("--harmonics N", f"Of its series; default {HARMONICS}.", int, default=HARMONICS),
    option("--rate HZ", f"Rows per second; default {RATE:g}.", POSITIVE, default=RATE),
    option("--joints A,B", "That move; default all.", NAMES, default=()),
    option("--max-acceleration A", "rad/s^2; default speed limit / 0.25 s.", POSITIVE),
    option("--noise N", "N m, of torques; or JOINT=N,...; default 1% of effort limits.", VALUES),
    option("--seed N", "Of where the search begins.", click.IntRange(min=0), default=0),
    SCENE,
    REPORT,
    FORMAT,
)
def command(
    call: Call,
    urdf: str,
    period: float,
    harmonics: int,
    rate: float,
    joints: tuple[str, ...],
    max_acceleration: float | None,
    noise: Any,
    seed: int,
) -> None:
    """Find a motion within all limits whose torques tell masses, inertias and friction as well as possible: a Fourier
    series, at rest at both ends, with the largest determinant of the base parameters' information that is found. Says
    how well each base parameter will be known. A file named - is standard input.

    \b
    Examples:
      robodyn excite robots/puma.urdf --out motion.csv
      robodyn excite robots/puma560.urdf --joints waist,shoulder,elbow --period 20 --harmonics 8 --out motion.csv
    """
    check_names()
    if call.out is not None:
        format_of(call.out)
    model, scene = robot_in_scene(call, urdf)
    limits: dict[str, Any] = {"max_acceleration": max_acceleration, "noise": noise, "seed": seed}
    found = excite(model, scene, period=period, harmonics=harmonics, rate=rate, joints=joints, **limits)
    written = write_table(call.out, found.names, found.time, found.columns)
    answer(
        call, excitation_sections(found), partial(excitation_page, found), written, json=lambda: excitation_json(found)
    )
