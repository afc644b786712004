"""`robodyn excite`: a motion from which parameters can be identified."""

from __future__ import annotations

from functools import partial
from typing import Any

import click

from robodyn.cli.files import check_names, robot_in_scene
from robodyn.cli.options import FORMAT, PATH, POSITIVE, REPORT, SCENE, TABLE_OUT, VALUES, Call, Parsed, takes
from robodyn.cli.reports import answer, get_ready, write_table
from robodyn.identification.excitation.excite import HARMONICS, PERIOD, RATE, excite
from robodyn.report.identification import excitation_json, excitation_page, excitation_sections
from robodyn.trajectory.write import format_of


def _names(text: str) -> tuple[str, ...]:
    names = tuple(name.strip() for name in text.split(","))
    if not all(names):
        raise ValueError(f"{text!r} is not names between commas, such as shoulder,elbow")
    return names


@click.command("excite", short_help="Find a motion that shows a robot's parameters.")
@click.argument("urdf", type=PATH)
@takes(
    click.option("--out", type=TABLE_OUT, metavar="FILE", help="Write the motion: .csv, .parquet or .npz."),
    click.option("--period", type=POSITIVE, default=PERIOD, metavar="S", help=f"s, of the motion; default {PERIOD:g}."),
    click.option("--harmonics", type=int, default=HARMONICS, metavar="N", help=f"Of its series; default {HARMONICS}."),
    click.option("--rate", type=POSITIVE, default=RATE, metavar="HZ", help=f"Rows per second; default {RATE:g}."),
    click.option("--joints", type=Parsed("joints", _names), default=(), metavar="A,B", help="That move; default all."),
    click.option("--max-acceleration", type=POSITIVE, metavar="A", help="rad/s^2; default speed limit / 0.25 s."),
    click.option(
        "--noise", type=VALUES, metavar="N", help="N m, of torques; or JOINT=N,...; default 1% of effort limits."
    ),
    click.option("--seed", type=click.IntRange(min=0), default=0, metavar="N", help="Of where the search begins."),
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
    get_ready(call)
    model, scene = robot_in_scene(call, urdf)
    limits: dict[str, Any] = {"max_acceleration": max_acceleration, "noise": noise, "seed": seed}
    found = excite(model, scene, period=period, harmonics=harmonics, rate=rate, joints=joints, **limits)
    written = write_table(call.out, found.names, found.time, found.columns)
    answer(
        call, excitation_sections(found), partial(excitation_page, found), written, json=lambda: excitation_json(found)
    )
