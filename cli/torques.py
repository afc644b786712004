"""`robodyn torques`: what every joint carries along a motion."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from robodyn.cli import options
from robodyn.cli.files import ROBOT, STANDARD_INPUT, TABLE, check_names, expect, robot_in_scene
from robodyn.cli.options import PATH, POSITIVE, TABLE_OUT, Call, option, refuse_where, takes
from robodyn.cli.screen import answer
from robodyn.errors import InputError
from robodyn.programs.run.runner import EXECUTORS
from robodyn.trajectory.formats.table import FILE_TYPES

if TYPE_CHECKING:
    from robodyn.measure.accuracy.torques import Arithmetic
    from robodyn.report.document import Document
    from robodyn.robot.model import Model
    from robodyn.scene.scene import Scene
    from robodyn.trajectory.motion import Trajectory
    from robodyn.trajectory.read import TrajectoryReader

_EXECUTOR = "numpy starts at once, compiled makes machine code; default auto: the quicker."
MOST = 8
"""Motions that one report lays over each other."""
_GROUPS = {
    "The robot and what surrounds it": "package-path xacro-arg trust-xacro scene payload gravity base-held",
    "The trajectory": "hold map time-unit angle-unit derivatives encoder-error topic ignore-extra example",
    "A pose, in place of it": "at qd qdd",
    "What is computed": "sizing momentum about frame explain accuracy",
    "A log with measured torques": "measured cutoff",
    "What is written": "out reactions fail-on-limits report format",
    "How it is computed": "jobs dask executor threads",
    "Other options": "help",
}


class TorquesCommand(click.Command):
    """A command of many options, which its help lists under titles."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        options = {each.opts[-1]: each for each in self.get_params(ctx) if isinstance(each, click.Option)}
        for title, names in _GROUPS.items():
            records = [options[f"--{name}"].get_help_record(ctx) for name in names.split()]
            with formatter.section(title):
                formatter.write_dl([record for record in records if record])


@click.command("torques", cls=TorquesCommand, short_help="Compute what every joint and bearing carries along a motion.")
@click.argument("urdf", type=PATH)
@click.argument("trajectories", type=PATH, nargs=-1, metavar="TRAJECTORY...")
@takes(
    options.SCENE,
    option("--out FILE", "Write the torques: .csv, .parquet, .npz; of many a FOLDER.", TABLE_OUT),
    options.BASE_HELD,
    options.AT,
    options.QD,
    option("--qdd QDD", "Accelerations, likewise; default none.", options.VALUES),
    option("--reactions", "Write the wrenches of the base and of every joint to --out too."),
    option("--sizing", "Add duty, motors, bearings, foundation; as a scene with motors does."),
    option("--momentum", "Mass centre, momenta, energies, power: report them, and write them to --out."),
    option("--about POINT", "Of L: origin (default), com or X,Y,Z.", options.POINT),
    option("--frame LINK", "Axes and origin of momenta; default the ground's."),
    options.READING,
    option("--explain", "Say why each effect is on or off, and what it costs."),
    option("--measured", "Compare with the torques of the log, and say what differs."),
    option("--cutoff HZ", "With --measured: of the filter; default by the noise.", POSITIVE),
    option("--fail-on-limits", "Exit with 1 if a limit of robot or motor is exceeded."),
    option("--accuracy E", "Take the cheapest arithmetic of this relative error.", POSITIVE),
    option("--example", "First write an example motion to TRAJECTORY, within all limits."),
    options.REPORT,
    option("--jobs N", "Processes for many trajectories; default: one for each core.", click.IntRange(min=1)),
    option("--dask ADDRESS", "Compute many trajectories on this Dask cluster instead."),
    option("--executor", _EXECUTOR, EXECUTORS, default="auto"),
    option("--threads N", "For machine code; default all.", click.IntRange(min=1)),
    options.FORMAT,
)
def command(
    call: Call,
    urdf: str,
    trajectories: tuple[str, ...],
    reactions: bool,
    sizing: bool,
    momentum: bool,
    about: str | tuple[float, float, float] | None,
    frame: str | None,
    explain: bool,
    measured: bool,
    cutoff: float | None,
    example: bool,
    jobs: int | None,
    dask: str | None,
    qdd: Any,
) -> int:
    """Compute joint torques, base loads and sizing figures along a motion, or in the pose that --at gives.
    A file named - is standard input; a trajectory then is CSV.

    \b
    Examples:
      robodyn torques robots/scara.urdf robots/scara_pick_and_place.csv --out tau.csv
      robodyn torques robots/puma560.urdf robots/puma560_sweep.csv --report puma.html
      robodyn torques robots/puma.urdf 'runs/*.parquet' --out results/
      robodyn torques robots/puma.urdf before.csv after.csv --report both.html
      robodyn torques robots/puma.urdf motion.csv --example --report puma.html
      robodyn torques robots/puma560.urdf log.db3 --measured --report measured.html
      robodyn torques robots/puma560.urdf --at shoulder=-0.5,elbow=0.3
    """
    posed = call.at is not None
    refuse_where(
        (posed and trajectories, f"--at is of one pose, in place of {' '.join(trajectories)}"),
        (call.qd is not None and not posed, "--qd goes with --at"),
        (qdd is not None and not posed, "--qdd goes with --at"),
        (not posed and not trajectories, "Missing argument 'TRAJECTORY...', or --at for one pose."),
    )
    if posed:
        along: dict[str, object] = {"--measured": measured, "--accuracy": call.accuracy, "--example": example}
        along[call.reading_given] = call.reading_given
        refuse_where(*((value, f"{name} is for trajectories, not for one pose") for name, value in along.items()))
    if measured:
        others: dict[str, object] = {"fail-on-limits": call.fail_on_limits, "out": call.out, "reactions": reactions}
        others |= {"sizing": sizing, "momentum": momentum, "explain": explain, "accuracy": call.accuracy}
        others |= {"example": example, "jobs": jobs, "dask": dask}
        refuse_where(*((value, f"--{name} does not go with --measured") for name, value in others.items()))
        refuse_where((len(trajectories) > 1, "--measured compares one log"))
        from robodyn.identification.faults.compare import compare
        from robodyn.report.measured import measured_json, measured_page, measured_sections

        check_names()
        expect(ROBOT, urdf)
        expect(TABLE, trajectories[0])
        model, scene = robot_in_scene(call, urdf)
        found = compare(model, trajectories[0], scene, cutoff=cutoff, **call.reading)
        answer(call, measured_sections(found), partial(measured_page, found), json=lambda: measured_json(found))
        return 0
    # Many are told by their number, by wildcards, or by results that go to a folder.
    wild = any(set("*?[") & set(name) and not os.path.lexists(name) for name in trajectories)
    folder = call.out is not None and (
        call.out[-1:] in (os.sep, "/") or (os.path.isdir(call.out) and not call.out.lower().endswith((*FILE_TYPES,)))
    )
    many = len(trajectories) > 1 or wild or (folder and not posed)
    refuse_where(
        (cutoff is not None, "--cutoff goes with --measured"),
        (reactions and not call.out, "--reactions goes to a file, and --out names none"),
        (about is not None and not momentum, "--about goes with --momentum"),
        (frame is not None and not momentum, "--frame goes with --momentum"),
        (many and call.accuracy, "--accuracy is for one trajectory"),
        (many and example, "--example is for one trajectory"),
        (not many and jobs is not None, "--jobs goes with many trajectories: give several, or --out FOLDER/"),
        (not many and dask is not None, "--dask goes with many trajectories: give several, or --out FOLDER/"),
    )
    loads: dict[str, Any] = {"momentum": None, "sizing": sizing or None, "reactions": reactions}
    loads |= {"explain": explain, "executor": call.executor, "threads": call.threads}
    if momentum:
        from robodyn.dynamics.momenta import GROUND, View

        loads["momentum"] = View("origin" if about is None else about, GROUND if frame is None else frame)
    if many and call.report and not call.out:
        return _compared(call, urdf, trajectories, loads)
    if many:
        from robodyn.cli.torques_batch import run_batch

        return run_batch(call, urdf, trajectories, loads, jobs, dask)
    return _single(call, urdf, trajectories[0] if trajectories else "", qdd, loads, example)


def _single(call: Call, urdf: str, trajectory: str, qdd: Any, loads: dict[str, Any], example: bool) -> int:
    from robodyn.cli.progress import watched
    from robodyn.loads.accumulate import output_names
    from robodyn.loads.torques import torques
    from robodyn.report.limits import verdict_section
    from robodyn.report.torques import torques_json, torques_sections
    from robodyn.trajectory.read import pose, read_motion
    from robodyn.trajectory.write import format_of, open_writer

    check_names()
    expect(ROBOT, urdf)
    if trajectory:
        expect(TABLE, trajectory)
    if call.out:
        format_of(call.out)
    model, scene = robot_in_scene(call, urdf, loops=True, contacts=True)
    if example:
        _write_example(trajectory, model, scene)
    way = None if call.accuracy is None else _arithmetic(call, call.accuracy, trajectory, model, scene)
    if way is not None and way.executor:
        loads["executor"] = way.executor
    names = output_names(model, loads["reactions"], loads["momentum"] is not None, scene)
    sinks: list[Callable[..., None]] = []
    with ExitStack() as stack:
        motion: Trajectory | TrajectoryReader
        if call.at is None:
            motion = stack.enter_context(read_motion(trajectory, model, scene, **call.reading))
            sinks.append(stack.enter_context(watched(motion)))
        else:
            motion = pose(model, call.at, call.qd or (), qdd or (), scene)
        if call.out is not None:  # the file is there whole when all ends well
            from robodyn.support.threads import write_behind

            sinks.append(stack.enter_context(write_behind(stack.enter_context(open_writer(call.out, names)).write)))
        result = torques(model, motion, scene, sinks=sinks, history=call.pictured, **loads)
    result = way.fulfilled(result) if way else result
    lines = ""
    if example:
        lines = f"\nwritten: {trajectory}, an example motion to begin with"
        if result.sizing is not None:
            limited = [joint for joint in result.joints if joint.velocity_limit]
            use = max((abs(each.max_speed) / (each.velocity_limit or 1.0) for each in limited), default=0.0)
            slow = f" and reaches {100 * use:.0f} % of the limits of speed" if use else ""
            lines += f", which is no duty cycle{slow}: size by the motion that the robot will do"
        lines += "\n"
    if call.out:
        lines += f"\nwritten: {call.out}, {result.samples} rows of time and {len(names)} columns\n"

    def document(pictures: bool) -> Document:
        from robodyn.report.torques_page import torques_page

        return torques_page(result, model, scene, pictures)

    sections, last = torques_sections(result, loads["explain"]), verdict_section(result)
    answer(call, sections, document, lines, last=last, json=lambda: torques_json(result))
    unmet = result.accuracy is not None and not result.accuracy.met
    return int(unmet or (call.fail_on_limits and result.within_limits is False))


def _compared(call: Call, urdf: str, trajectories: tuple[str, ...], loads: dict[str, Any]) -> int:
    from robodyn.loads.torques import torques
    from robodyn.report.document import written
    from robodyn.report.torques import torques_json
    from robodyn.report.torques_page import compared_page, compared_sections
    from robodyn.trajectory.read import read_motion

    refuse_where((len(trajectories) > MOST, f"--report lays at most {MOST} motions over each other"))
    model, scene = robot_in_scene(call, urdf, loops=True, contacts=True)
    results = []
    for name in trajectories:
        expect(TABLE, name)
        with read_motion(name, model, scene, **call.reading) as reader:
            results.append((name, torques(model, reader, scene, history=call.pictured, **loads)))

    def json() -> str:
        from json import loads as parsed

        runs = [{"trajectory": name, **parsed(torques_json(result))} for name, result in results]
        return written({"robot": model.name, "runs": runs})

    document = partial(compared_page, results, model, scene)
    answer(call, compared_sections(results), document, json=json)
    exceeded = any(result.within_limits is False for _, result in results)
    return int(call.fail_on_limits and exceeded)


def _write_example(path: str, model: Model, scene: Scene) -> None:
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


def _arithmetic(call: Call, target: float, trajectory: str, model: Model, scene: Scene) -> Arithmetic:
    """Return the arithmetic for an accuracy, by the first block of the trajectory, which is read anew for torques."""
    from robodyn.measure.accuracy.torques import arithmetic_within, first_block

    if trajectory == STANDARD_INPUT:
        raise InputError("--accuracy reads the trajectory twice", remedy="name a file", file="<stdin>")
    return arithmetic_within(model, first_block(model, scene, trajectory, **call.reading), scene, target)
