"""`robodyn torques`: what every joint carries along a motion."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import click

from robodyn.cli.options import (
    BASE_HELD,
    EXECUTION,
    FORMAT,
    PATH,
    POINT,
    POSITIVE,
    SCENE,
    TABLE_OUT,
    Grouped,
    together,
)
from robodyn.cli.reading_options import READING
from robodyn.cli.reports import REPORT

if TYPE_CHECKING:
    from robodyn.dynamics.momenta import View

_TABLES = (".csv", ".tsv", ".txt", ".dat", ".parquet", ".pq", ".npz")


def is_batch(trajectories: Sequence[str], out: str | None, options: dict[str, Any]) -> bool:
    """Return whether the trajectories are many: by their number, wildcards, or results that go to a folder.

    The options of batches are taken out of `options` where they are not.
    """
    wild = any(set("*?[") & set(name) and not os.path.lexists(name) for name in trajectories)
    if len(trajectories) > 1 or wild or (out is not None and _is_folder(out)):
        return True
    for name in ("jobs", "dask"):
        if options.pop(name) is not None:
            what = f"--{name} goes with many trajectories: give several, or --out FOLDER/"
            raise click.UsageError(what, click.get_current_context())
    return False


def _is_folder(out: str) -> bool:
    return out[-1:] in (os.sep, "/") or (os.path.isdir(out) and not out.lower().endswith(_TABLES))


def momentum_view(options: dict[str, Any]) -> View | None:
    """Return how momenta are asked for, taken out of the values of the options; None if they are not."""
    wanted, about, frame = (options.pop(name) for name in ("momentum", "about", "frame"))
    if wanted:
        from robodyn.dynamics.momenta import GROUND, View

        return View("origin" if about is None else about, GROUND if frame is None else frame)
    for name, value in (("--about", about), ("--frame", frame)):
        if value is not None:
            raise click.UsageError(f"{name} goes with --momentum", click.get_current_context())
    return None


def refuse_beside_measured(trajectories: Sequence[str], fail_on_limits: bool, options: dict[str, Any]) -> None:
    """Raise if what goes with computed torques alone is asked for beside --measured."""
    asked = {"fail_on_limits": fail_on_limits, **{name: options[name] for name in _COMPUTED}}
    for name, value in asked.items():
        if value:
            what = f"--{name.replace('_', '-')} does not go with --measured"
            raise click.UsageError(what, click.get_current_context())
    if len(trajectories) > 1:
        raise click.UsageError("--measured compares one log", click.get_current_context())


_COMPUTED = ("out", "reactions", "sizing", "momentum", "explain", "accuracy", "example", "samples", "jobs", "dask")
_SAMPLES = "Of a scene's [uncertainty]: run the motion again with N draws of parameters, to compare."
_MOMENTUM = "Mass centre, momenta, energies, power: report them, and write them to --out."
OPTIONS = together(
    SCENE,
    click.option(
        "--out", type=TABLE_OUT, metavar="FILE", help="Write the torques: .csv, .parquet, .npz; of many a FOLDER."
    ),
    BASE_HELD,
    click.option("--reactions", is_flag=True, help="Write the wrenches of the base and of every joint to --out too."),
    click.option("--sizing", is_flag=True, help="Add duty, motors, bearings, foundation; as a scene with motors does."),
    click.option("--momentum", is_flag=True, help=_MOMENTUM),
    click.option("--about", type=POINT, metavar="POINT", help="Of L: origin (default), com or X,Y,Z."),
    click.option("--frame", metavar="LINK", help="Axes and origin of momenta; default the ground's."),
    READING,
    click.option("--explain", is_flag=True, help="Say why each effect is on or off, and what it costs."),
    click.option("--measured", is_flag=True, help="Compare with the torques of the log, and say what differs."),
    click.option("--cutoff", type=POSITIVE, metavar="HZ", help="With --measured: of the filter; default by the noise."),
    click.option("--fail-on-limits", is_flag=True, help="Exit with 1 if a limit of robot or motor is exceeded."),
    click.option("--accuracy", type=POSITIVE, metavar="E", help="Take the cheapest arithmetic of this relative error."),
    click.option("--samples", type=click.IntRange(min=2), metavar="N", help=_SAMPLES),
    click.option("--example", is_flag=True, help="First write an example motion to TRAJECTORY, within all limits."),
    REPORT,
    click.option(
        "--jobs",
        type=click.IntRange(min=1),
        metavar="N",
        help="Processes for many trajectories; default: one for each core.",
    ),
    click.option("--dask", metavar="ADDRESS", help="Compute many trajectories on this Dask cluster instead."),
    EXECUTION,
    FORMAT,
)


class TorquesCommand(Grouped):
    groups: ClassVar[Mapping[str, Sequence[str]]] = {
        "The robot and what surrounds it": (
            *("--scene", "--payload", "--gravity", "--base-held", "--package-path", "--xacro-arg", "--trust-xacro"),
        ),
        "The trajectory": (
            *("--example", "--hold", "--map", "--time-unit", "--angle-unit", "--derivatives", "--topic"),
            *("--encoder-error", "--ignore-extra"),
        ),
        "What is computed": ("--sizing", "--momentum", "--about", "--frame", "--explain", "--samples", "--accuracy"),
        "A log with measured torques": ("--measured", "--cutoff"),
        "What is written": ("--out", "--reactions", "--report", "--format", "--fail-on-limits"),
        "How it is computed": ("--executor", "--threads", "--jobs", "--dask"),
    }


@click.command("torques", cls=TorquesCommand, short_help="Compute what every joint and bearing carries along a motion.")
@click.argument("urdf", type=PATH)
@click.argument("trajectories", type=PATH, nargs=-1, required=True, metavar="TRAJECTORY...")
@OPTIONS
def command(urdf: str, trajectories: tuple[str, ...], fail_on_limits: bool, **options: Any) -> int:
    """Compute joint torques, base loads and sizing figures along a motion.
    A file named - is standard input; a trajectory then is CSV.

    \b
    Examples:
      robodyn torques robots/scara.urdf robots/scara_pick_and_place.csv --out tau.csv
      robodyn torques robots/puma560.urdf robots/puma560_sweep.csv --report puma.html
      robodyn torques robots/puma.urdf 'runs/*.parquet' --out results/
      robodyn torques robots/puma.urdf motion.csv --example --report puma.html
      robodyn torques robots/puma560.urdf log.db3 --measured --report measured.html
    """
    cutoff = options.pop("cutoff")
    if options.pop("measured"):
        refuse_beside_measured(trajectories, fail_on_limits, options)
        from robodyn.cli.torques_measured import run_measured

        run_measured(urdf, trajectories[0], cutoff)
        return 0
    if cutoff is not None:
        raise click.UsageError("--cutoff goes with --measured", click.get_current_context())
    if options["reactions"] and not options["out"]:
        raise click.UsageError("--reactions goes to a file, and --out names none", click.get_current_context())
    options |= {
        "momentum": momentum_view(options),
        "sizing": options["sizing"] or None,
        "samples": options["samples"] or 0,
    }
    if is_batch(trajectories, options["out"], options):
        from robodyn.cli.torques_batch import run_batch

        for name in ("accuracy", "example"):
            if options.pop(name):
                raise click.UsageError(f"--{name} is for one trajectory", click.get_current_context())
        return run_batch(urdf, trajectories, fail_on_limits, **options)
    from robodyn.cli.torques_single import run_single

    result = run_single(urdf, trajectories[0], **options)
    unmet = result.accuracy is not None and not result.accuracy.met
    return int(unmet or (fail_on_limits and result.within_limits is False))
