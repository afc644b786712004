"""`robodyn torques`: what every joint carries along a motion."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, ClassVar

import click

from robodyn.cli.call import (
    BASE_HELD,
    EXECUTION,
    FORMAT,
    PATH,
    POINT,
    POSITIVE,
    READING,
    REPORT,
    SCENE,
    TABLE_OUT,
    Call,
    Grouped,
    Loads,
    refuse,
    takes,
)
from robodyn.cli.files import ROBOT, STANDARD_INPUT, TABLE, check_names, expect, robot_in_scene
from robodyn.cli.reports import answer, get_ready
from robodyn.errors import InputError

if TYPE_CHECKING:
    from robodyn.dynamics.momenta import View
    from robodyn.loads.result import Result
    from robodyn.loads.torques import Sink
    from robodyn.measure.accuracy.torques import Arithmetic
    from robodyn.report.document import Document
    from robodyn.robot.model import Model
    from robodyn.scene.scene import Scene
    from robodyn.trajectory.reader import TrajectoryReader

_TABLES = (".csv", ".tsv", ".txt", ".dat", ".parquet", ".pq", ".npz")
_MOMENTUM = "Mass centre, momenta, energies, power: report them, and write them to --out."


class TorquesCommand(Grouped):
    groups: ClassVar[Mapping[str, Sequence[str]]] = {
        "The robot and what surrounds it": (
            *("--scene", "--payload", "--gravity", "--base-held", "--package-path", "--xacro-arg", "--trust-xacro"),
        ),
        "The trajectory": (
            *("--example", "--hold", "--map", "--time-unit", "--angle-unit", "--derivatives", "--topic"),
            *("--encoder-error", "--ignore-extra"),
        ),
        "What is computed": ("--sizing", "--momentum", "--about", "--frame", "--explain", "--accuracy"),
        "A log with measured torques": ("--measured", "--cutoff"),
        "What is written": ("--out", "--reactions", "--report", "--format", "--fail-on-limits"),
        "How it is computed": ("--executor", "--threads", "--jobs", "--dask"),
    }


@click.command("torques", cls=TorquesCommand, short_help="Compute what every joint and bearing carries along a motion.")
@click.argument("urdf", type=PATH)
@click.argument("trajectories", type=PATH, nargs=-1, required=True, metavar="TRAJECTORY...")
@takes(
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
def command(
    call: Call,
    urdf: str,
    trajectories: tuple[str, ...],
    out: str | None,
    reactions: bool,
    sizing: bool,
    momentum: bool,
    about: str | tuple[float, float, float] | None,
    frame: str | None,
    explain: bool,
    measured: bool,
    cutoff: float | None,
    fail_on_limits: bool,
    accuracy: float | None,
    example: bool,
    jobs: int | None,
    dask: str | None,
    executor: str,
    threads: int | None,
) -> int:
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
    if measured:
        alone: dict[str, object] = {
            "fail-on-limits": fail_on_limits,
            "out": out,
            "reactions": reactions,
            "sizing": sizing,
        }
        alone |= {"momentum": momentum, "explain": explain, "accuracy": accuracy, "example": example}
        alone |= {"jobs": jobs, "dask": dask}
        if asked := [name for name, value in alone.items() if value]:
            refuse(f"--{asked[0]} does not go with --measured")
        if len(trajectories) > 1:
            refuse("--measured compares one log")
        _measured(call, urdf, trajectories[0], cutoff)
        return 0
    if cutoff is not None:
        refuse("--cutoff goes with --measured")
    if reactions and not out:
        refuse("--reactions goes to a file, and --out names none")
    options = Loads(_view(momentum, about, frame), sizing or None, reactions, explain, executor, threads)
    if _is_batch(trajectories, out):
        from robodyn.cli.torques_batch import run_batch

        for name, value in (("accuracy", accuracy), ("example", example)):
            if value:
                refuse(f"--{name} is for one trajectory")
        return run_batch(call, urdf, trajectories, out, options, fail_on_limits=fail_on_limits, jobs=jobs, dask=dask)
    for name, given in (("jobs", jobs), ("dask", dask)):
        if given is not None:
            refuse(f"--{name} goes with many trajectories: give several, or --out FOLDER/")
    result = _single(call, urdf, trajectories[0], out, options, accuracy=accuracy, example=example)
    unmet = result.accuracy is not None and not result.accuracy.met
    return int(unmet or (fail_on_limits and result.within_limits is False))


def _is_batch(trajectories: Sequence[str], out: str | None) -> bool:
    """Return whether the trajectories are many: by their number, wildcards, or results that go to a folder."""
    wild = any(set("*?[") & set(name) and not os.path.lexists(name) for name in trajectories)
    folder = out is not None and (
        out[-1:] in (os.sep, "/") or (os.path.isdir(out) and not out.lower().endswith(_TABLES))
    )
    return len(trajectories) > 1 or wild or folder


def _view(momentum: bool, about: str | tuple[float, float, float] | None, frame: str | None) -> View | None:
    """Return how momenta are asked for; None if they are not."""
    if momentum:
        from robodyn.dynamics.momenta import GROUND, View

        return View("origin" if about is None else about, GROUND if frame is None else frame)
    for name, value in (("--about", about), ("--frame", frame)):
        if value is not None:
            refuse(f"{name} goes with --momentum")
    return None


def _measured(call: Call, urdf: str, log: str, cutoff: float | None) -> None:
    """Show what explains the difference of measured and computed torques.

    Args:
        cutoff: of the filter [Hz]; None: by the noise.
    """
    from robodyn.identification.faults.compare import compare
    from robodyn.report.measured import measured_json, measured_page, measured_sections

    check_names()
    expect(ROBOT, urdf)
    expect(TABLE, log)
    get_ready(call)
    model, scene = robot_in_scene(call, urdf)
    found = compare(model, log, scene, cutoff=cutoff, **call.reading)
    answer(call, measured_sections(found), partial(measured_page, found), json=lambda: measured_json(found))


def _single(
    call: Call,
    urdf: str,
    trajectory: str,
    out: str | None,
    options: Loads,
    *,
    accuracy: float | None,
    example: bool,
) -> Result:
    """Return what was found, after it is shown and written."""
    from robodyn.loads.accumulate import output_names
    from robodyn.loads.torques import torques
    from robodyn.report.limits import verdict_section
    from robodyn.report.torques import torques_sections
    from robodyn.trajectory.read import read_motion

    check_names()
    expect(ROBOT, urdf)
    expect(TABLE, trajectory)
    if out:
        from robodyn.trajectory.write import format_of

        format_of(out)
    get_ready(call)
    model, scene = robot_in_scene(call, urdf, loops=True, contacts=True)
    lines = ""
    if example:
        write_example(trajectory, model, scene)
        lines = f"\nwritten: {trajectory}, an example motion to begin with"
    way = None
    if accuracy is not None:
        way = arithmetic_for(call, accuracy, trajectory, model, scene)
        options = replace(options, executor=way.executor or options.executor)
    names = output_names(model, options.reactions, options.momentum is not None, scene)
    reader = read_motion(trajectory, model, scene, **call.reading)
    with reader, sinks(out, names, reader) as gather:
        result = torques(model, reader, scene, sinks=gather, history=call.pictured, **vars(options))
    result = way.fulfilled(result) if way else result
    if example:
        lines += f"{example_caution(result)}\n"
    if out:
        lines += f"\nwritten: {out}, {result.samples} rows of time and {len(names)} columns\n"

    def document(pictures: bool) -> Document:
        from robodyn.report.torques_page import torques_page

        return torques_page(result, model, scene, pictures)

    def json() -> str:
        from robodyn.report.torques_json import torques_json

        return torques_json(result)

    answer(call, torques_sections(result, options.explain), document, lines, last=verdict_section(result), json=json)
    return result


@contextmanager
def sinks(out: str | None, names: Sequence[str], reader: TrajectoryReader) -> Iterator[list[Sink]]:
    """Yield functions to call with the time and the columns of each block; a file is there whole when all ends well."""
    from robodyn.cli.progress import watched
    from robodyn.support.threads import write_behind

    with ExitStack() as stack:
        writers: list[Sink] = []
        if out is not None:
            from robodyn.trajectory.write import open_writer

            writer = stack.enter_context(open_writer(out, names))
            writers.append(stack.enter_context(write_behind(writer.write)))
        yield [*writers, stack.enter_context(watched(reader))]


def write_example(path: str, model: Model, scene: Scene) -> None:
    """Write an example motion of a robot to a file that is not there yet; warn of limits that no example keeps.

    Raises:
        InputError: the file is there, or cannot be written.
    """
    from robodyn.loads.example_motion import example_motion, overloaded
    from robodyn.trajectory.write import open_writer

    if path == STANDARD_INPUT or os.path.lexists(path):
        what = "--example writes a new file, and this one is there already"
        raise InputError(what, remedy="leave --example out, or name another file", file=path)
    names, time, columns = example_motion(model, scene)
    with open_writer(path, names) as writer:
        writer.write(time, columns)
    for line in overloaded(model, scene, columns):
        click.echo(f"warning: {line}", err=True)


def example_caution(result: Result) -> str:
    """Return that an example is no duty cycle, where it is used for sizing, and how fast it is."""
    from robodyn.report.limits import speed_use

    if result.sizing is None:
        return ""
    use = max(map(speed_use, result.joints), default=0.0)
    slow = f" and reaches {100 * use:.0f} % of the limits of speed" if use else ""
    return f", which is no duty cycle{slow}: size by the motion that the robot will do"


def arithmetic_for(call: Call, target: float, trajectory: str, model: Model, scene: Scene) -> Arithmetic:
    """Return the arithmetic for an accuracy, by the first block of the trajectory, which is read once more for torques.

    Raises:
        InputError: the trajectory is standard input or has no samples, or the accuracy is beyond doubles.
    """
    from robodyn.measure.accuracy.torques import arithmetic_within
    from robodyn.trajectory.read import read_motion

    if trajectory == STANDARD_INPUT:
        raise InputError("--accuracy reads the trajectory twice", remedy="name a file", file="<stdin>")
    with read_motion(trajectory, model, scene, **call.reading) as reader:
        for block in reader.blocks():
            if len(block):
                return arithmetic_within(model, block, scene, target)
    raise InputError("the trajectory has no samples", file=trajectory)
