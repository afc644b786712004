"""`robodyn torques`: what every joint carries along a motion."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from dataclasses import replace

import click

from robodyn.assemble import load
from robodyn.cli.options import VECTOR, Vector
from robodyn.cli.progress import watched
from robodyn.loads import output_names, torques
from robodyn.motion_input import read_motion
from robodyn.report.json_torques import torques_json
from robodyn.report.text_torques import torques_text
from robodyn.scene import DEFAULT
from robodyn.scene_file import load_scene
from robodyn.scene_fit import check_scene
from robodyn.trajectory.reader import Derivatives
from robodyn.trajectory.write import open_writer


@click.command("torques")
@click.argument("urdf")
@click.argument("trajectory")
@click.option(
    "--scene", "scene_file", metavar="FILE", help="Scene: friction, rotors, springs, payloads, wrenches, base."
)
@click.option("--gravity", type=VECTOR, metavar="X,Y,Z", help="m/s^2 in the base frame; default 0,0,-9.81.")
@click.option("--out", metavar="FILE", help="Write torques to .csv, .parquet or .npz.")
@click.option("--reactions", is_flag=True, help="With --out, write all six components of every joint's wrench too.")
@click.option(
    "--derivatives",
    type=click.Choice(["auto", "given", "spline", "savgol", "central"]),
    default="auto",
    help="How missing velocities and accelerations are derived.",
)
@click.option("--ignore-extra", is_flag=True, help="Leave columns out that the robot does not know.")
@click.option("--explain", is_flag=True, help="Say why each effect is on or off, and what it costs.")
@click.option("--fail-on-limits", is_flag=True, help="Exit with status 1 if a limit of the description is exceeded.")
@click.option("--format", "form", type=click.Choice(["text", "json"]), default="text", help="Of the report on stdout.")
def command(
    urdf: str,
    trajectory: str,
    scene_file: str | None,
    gravity: Vector | None,
    out: str | None,
    reactions: bool,
    derivatives: Derivatives,
    ignore_extra: bool,
    explain: bool,
    fail_on_limits: bool,
    form: str,
) -> int:
    """Joint torques, base loads and sizing figures along a motion.

    \b
    Example:
      robodyn torques robots/scara.urdf robots/scara_pick_and_place.csv --out tau.csv
    """
    scene = load_scene(scene_file) if scene_file else DEFAULT
    scene = scene if gravity is None else replace(scene, gravity=gravity)
    model = load(urdf, moving_base=scene.moving_base)
    check_scene(scene, model, scene_file)
    with ExitStack() as stack:
        reader = stack.enter_context(
            read_motion(trajectory, model, scene, derivatives=derivatives, ignore_extra=ignore_extra)
        )
        writer = stack.enter_context(open_writer(out, output_names(model, reactions))) if out else None
        tick = stack.enter_context(watched(reader))
        sinks = [tick] if writer is None else [writer.write, tick]
        result = torques(model, reader, scene, reactions=reactions, explain=explain, sinks=sinks)
    click.echo(torques_json(result) if form == "json" else torques_text(result, explain, sys.stdout.isatty()), nl=False)
    return int(fail_on_limits and bool(result.exceeded))
