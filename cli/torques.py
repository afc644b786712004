"""`robodyn torques`: what every joint carries along a motion."""

from __future__ import annotations

from typing import Any

import click

from robodyn.cli.batch_options import BATCH, is_batch
from robodyn.cli.files import check_names, robot_in_scene
from robodyn.cli.momentum_options import MOMENTUM, momentum_view
from robodyn.cli.options import EXECUTION, FORMAT, GRAVITY, PATH, POSITIVE, SCENE, Vector
from robodyn.cli.reports import REPORT, drawing, pictured, reported
from robodyn.cli.screen import page, show
from robodyn.cli.sinks import sinks
from robodyn.loads import torques
from robodyn.motion_input import read_motion
from robodyn.one_pass import output_names
from robodyn.report.json_torques import torques_json
from robodyn.report.text_torques import torques_text
from robodyn.trajectory.reader import MODES, Derivatives


@click.command("torques", short_help="What every joint and bearing carries along a motion.")
@click.argument("urdf", type=PATH)
@click.argument("trajectories", type=PATH, nargs=-1, required=True, metavar="TRAJECTORY...")
@SCENE
@GRAVITY
@click.option("--out", type=PATH, metavar="FILE", help="Write the torques: .csv, .parquet, .npz; of many: a FOLDER.")
@click.option("--reactions", is_flag=True, help="Write the wrenches of the base and of every joint to --out too.")
@click.option("--sizing", is_flag=True, help="Add duty, motors, bearings, foundation; as a scene with motors does.")
@MOMENTUM
@click.option("--derivatives", type=click.Choice(MODES), default="auto", help="Of missing columns; default auto.")
@click.option("--ignore-extra", is_flag=True, help="Leave out columns that the robot does not know.")
@click.option("--explain", is_flag=True, help="Say why each effect is on or off, and what it costs.")
@click.option("--fail-on-limits", is_flag=True, help="Exit with 1 if a limit of robot or motor is exceeded.")
@click.option("--accuracy", type=POSITIVE, metavar="E", help="Take the cheapest arithmetic for this relative error.")
@click.option("--example", is_flag=True, help="First write an example motion to TRAJECTORY, within all limits.")
@REPORT
@BATCH
@EXECUTION
@FORMAT
def command(
    urdf: str,
    trajectories: tuple[str, ...],
    scene_file: str | None,
    gravity: Vector | None,
    out: str | None,
    reactions: bool,
    sizing: bool,
    derivatives: Derivatives,
    ignore_extra: bool,
    fail_on_limits: bool,
    accuracy: float | None,
    example: bool,
    report: str | None,
    form: str,
    **how: Any,
) -> int:
    """Joint torques, base loads and sizing figures along a motion.
    A file named - is standard input; a trajectory then is CSV.

    \b
    Examples:
      robodyn torques robots/scara.urdf robots/scara_pick_and_place.csv --out tau.csv
      robodyn torques robots/puma560.urdf robots/puma560_sweep.csv --report puma.html
      robodyn torques robots/puma.urdf 'runs/*.parquet' --out results/
      robodyn torques robots/puma.urdf motion.csv --example --report puma.html
    """
    if reactions and not out:
        raise click.UsageError("--reactions goes to a file, and --out names none", click.get_current_context())
    view = momentum_view(how)
    options: dict[str, Any] = {"reactions": reactions, "sizing": sizing, "momentum": view}
    if is_batch(trajectories, out, how):
        from robodyn.cli.torques_batch import run_batch

        for given, name in ((accuracy, "--accuracy"), (example, "--example")):
            if given:
                raise click.UsageError(f"{name} is for one trajectory", click.get_current_context())
        options |= {"derivatives": derivatives, "ignore_extra": ignore_extra, **how}
        return run_batch(urdf, trajectories, scene_file, gravity, out, report, options, form, fail_on_limits)
    (trajectory,) = trajectories
    check_names([urdf, trajectory, scene_file], out)
    check_names([urdf, trajectory, scene_file], report)
    model, scene = robot_in_scene(urdf, scene_file, gravity)
    if example:
        from robodyn.cli.example import write_example

        write_example(trajectory, model)
    names = output_names(model, reactions, view is not None)
    way = None
    if accuracy is not None:
        from robodyn.cli.accuracy_asked import arithmetic_for

        way = arithmetic_for(accuracy, trajectory, model, scene, derivatives, ignore_extra)
        how["executor"] = way.executor or how["executor"]
    reader = read_motion(trajectory, model, scene, derivatives=derivatives, ignore_extra=ignore_extra)
    with drawing(report, reader.size_bytes) as draw:
        with reader, sinks(out, names, reader) as gather:
            options |= {"history": pictured(report), "sizing": sizing or None}
            result = torques(model, reader, scene, sinks=gather, **options, **how)
        result = way.fulfilled(result) if way else result
        written = f"\nwritten: {out}, {result.samples} rows of time and {len(names)} columns\n" if out else ""
        if example:
            written = f"\nwritten: {trajectory}, an example motion to begin with\n{written}"
        if report:
            from robodyn.report.page_torques import torques_page

            written += reported(report, lambda pictures: torques_page(result, model, scene, pictures, draw))
    show(torques_json(result) if form == "json" else torques_text(result, how["explain"], page()) + written)
    unmet = result.accuracy is not None and not result.accuracy.met
    return int(unmet or (fail_on_limits and not result.within_limits))
