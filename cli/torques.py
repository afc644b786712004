"""`robodyn torques`: what every joint carries along a motion."""

from __future__ import annotations

from typing import Any

import click

from robodyn.cli.batch_options import is_batch
from robodyn.cli.momentum_options import momentum_view
from robodyn.cli.options import PATH, Vector
from robodyn.cli.torques_options import OPTIONS


@click.command("torques", short_help="What every joint and bearing carries along a motion.")
@click.argument("urdf", type=PATH)
@click.argument("trajectories", type=PATH, nargs=-1, required=True, metavar="TRAJECTORY...")
@OPTIONS
def command(
    urdf: str,
    trajectories: tuple[str, ...],
    scene_file: str | None,
    gravity: Vector | None,
    out: str | None,
    fail_on_limits: bool,
    accuracy: float | None,
    example: bool,
    report: str | None,
    form: str,
    **options: Any,
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
    if options["reactions"] and not out:
        raise click.UsageError("--reactions goes to a file, and --out names none", click.get_current_context())
    options["momentum"] = momentum_view(options)
    robot = urdf, scene_file, gravity, options.pop("base_held")
    if is_batch(trajectories, out, options):
        from robodyn.cli.torques_batch import run_batch

        for given, name in ((accuracy, "--accuracy"), (example, "--example")):
            if given:
                raise click.UsageError(f"{name} is for one trajectory", click.get_current_context())
        return run_batch(*robot, trajectories, out, report, options, form, fail_on_limits)
    from robodyn.cli.torques_single import run_single

    options["sizing"] = options["sizing"] or None
    result = run_single(*robot, trajectories[0], out, report, accuracy, example, form, options)
    unmet = result.accuracy is not None and not result.accuracy.met
    return int(unmet or (fail_on_limits and result.within_limits is False))
