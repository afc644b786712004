"""`robodyn size`: motors and gears of a catalogue that suffice for each joint."""

from __future__ import annotations

import os
from contextlib import ExitStack
from functools import partial
from typing import Any

import click

from robodyn.cli import options
from robodyn.cli.files import STANDARD_INPUT, TABLE, check_names, expect, robot_in_scene
from robodyn.cli.options import FORMAT, MOTORS_OUT, PATH, POSITIVE, REPORT, Call, option, refuse_where, takes
from robodyn.cli.screen import answer, complain
from robodyn.errors import InputError
from robodyn.sizing.catalogue import BY, size
from robodyn.sizing.catalogue_tables import GEARS_TEMPLATE, MOTORS_TEMPLATE, CatalogueError


@click.command("size", short_help="Choose motors and gears of a catalogue for each joint.")
@click.argument("urdf", type=PATH)
@click.argument("trajectories", type=PATH, nargs=-1, required=True, metavar="TRAJECTORY...")
@takes(
    option("--catalog FILE", "CSV: the motors, one a row.", PATH, required=True),
    option("--gears FILE", "CSV: the gears; without, ratios of the scene or the description.", PATH),
    option("--by", "What the best has least of; default mass.", BY, default="mass"),
    option("--joints A,B", "That are sized; default all.", options.NAMES, default=()),
    option("--masses-included", "The description's masses hold those of motors and gears."),
    option("--inertia-ratio R", "Largest inertia of the load over that of the rotor.", POSITIVE),
    option("--scene-out FILE", "Write the best as a scene, for torques: TOML.", MOTORS_OUT),
    option("--init", "First write catalogues to begin with to --catalog and --gears."),
    options.SCENE,
    options.BASE_HELD,
    options.READING,
    REPORT,
    FORMAT,
)
def command(
    call: Call,
    urdf: str,
    trajectories: tuple[str, ...],
    catalog: str,
    gears: str | None,
    scene_out: str | None,
    init: bool,
    **how: Any,
) -> int:
    """Choose for each joint the motor, gear and ratio of a catalogue that suffice along all motions: peak and RMS
    torque against their curves, speeds, peak and cubic mean of the gear. Motors load the joints before them: chosen
    from the tips to the base. Exit status 1 if nothing suffices for a joint. A file named - is standard input.

    \b
    Examples:
      robodyn size robots/puma560.urdf robots/puma560_sweep.csv --catalog robots/catalogue/motors.csv
      robodyn size robots/scara.urdf motion.csv --catalog motors.csv --gears gears.csv --init --report sizes.html
    """
    from robodyn.report.sizing.catalogue import size_json, size_page, size_sections
    from robodyn.support.files import write_whole
    from robodyn.trajectory.read import read_motion

    refuse_where((catalog == gears, "--catalog and --gears name one file"))
    check_names()
    for path in trajectories:
        expect(TABLE, path)
    model, scene = robot_in_scene(call, urdf)
    written, tables = "", {catalog: MOTORS_TEMPLATE} | ({gears: GEARS_TEMPLATE} if gears else {})
    for path in tables if init else ():
        if path == STANDARD_INPUT or os.path.lexists(path):
            what = "--init writes a new file, and this one is there already"
            raise InputError(what, remedy="leave --init out, or name another file", file=path)
    for path in tables if init else ():
        write_whole(path, tables[path].encode())
        written += f"\nwritten: {path}, invented numbers to begin with\n"
    with ExitStack() as stack:
        motions = [stack.enter_context(read_motion(path, model, scene, **call.reading)) for path in trajectories]
        try:
            found = size(model, motions, catalog, gears, scene, **how)
        except CatalogueError as error:
            for fault in error.faults[:-1]:
                complain(fault)
            raise error.faults[-1] from None
    if scene_out:
        write_whole(scene_out, found.toml.encode())
        written += f"\nwritten: {scene_out}, for robodyn torques --scene\n"
    answer(call, size_sections(found), partial(size_page, found), written, json=lambda: size_json(found))
    return int(not found.feasible)
