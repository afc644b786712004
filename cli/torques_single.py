"""`robodyn torques` on one trajectory."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any

import click

from robodyn.cli.files import ROBOT, STANDARD_INPUT, TABLE, check_names, expect, robot_in_scene
from robodyn.cli.progress import watched
from robodyn.cli.reading_options import reading
from robodyn.cli.reports import answer, get_ready, pictured
from robodyn.errors import InputError
from robodyn.loads.columns import output_names
from robodyn.loads.result import Result
from robodyn.loads.torques import Sink, torques
from robodyn.report.document import Document
from robodyn.report.limits import speed_use, verdict_section
from robodyn.report.torques import torques_sections
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.threads import write_behind
from robodyn.trajectory.reader import TrajectoryReader
from robodyn.trajectory.robot_motion import read_motion
from robodyn.trajectory.write import format_of, open_writer

if TYPE_CHECKING:
    from robodyn.measure.accuracy.torques_within import Arithmetic


def run_single(
    urdf: str, trajectory: str, *, out: str | None, accuracy: float | None, example: bool, **options: Any
) -> Result:
    """Return what was found, after it is shown and written.

    Args:
        options: of `robodyn.torques`.
    """
    check_names()
    expect(ROBOT, urdf)
    expect(TABLE, trajectory)
    if out:
        format_of(out)
    get_ready()
    model, scene = robot_in_scene(urdf, loops=True, contacts=True)
    lines = ""
    if example:
        write_example(trajectory, model, scene)
        lines = f"\nwritten: {trajectory}, an example motion to begin with"
    way = None
    if accuracy is not None:
        way = arithmetic_for(accuracy, trajectory, model, scene)
        options["executor"] = way.executor or options["executor"]
    names = output_names(model, options["reactions"], options["momentum"] is not None, scene)
    reader = read_motion(trajectory, model, scene, **reading())
    with reader, sinks(out, names, reader) as gather:
        result = torques(model, reader, scene, sinks=gather, history=pictured(), **options)
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

    answer(torques_sections(result, options["explain"]), document, lines, last=verdict_section(result), json=json)
    return result


@contextmanager
def sinks(out: str | None, names: Sequence[str], reader: TrajectoryReader) -> Iterator[list[Sink]]:
    """Yield functions to call with the time and the columns of each block; a file is there whole when all ends well."""
    with ExitStack() as stack:
        writers: list[Sink] = []
        if out is not None:
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
    if result.sizing is None:
        return ""
    use = max(map(speed_use, result.joints), default=0.0)
    slow = f" and reaches {100 * use:.0f} % of the limits of speed" if use else ""
    return f", which is no duty cycle{slow}: size by the motion that the robot will do"


def arithmetic_for(target: float, trajectory: str, model: Model, scene: Scene) -> Arithmetic:
    """Return the arithmetic for an accuracy, by the first block of the trajectory, which is read once more for torques.

    Raises:
        InputError: the trajectory is standard input or has no samples, or the accuracy is beyond doubles.
    """
    from robodyn.measure.accuracy.torques_within import arithmetic_within

    if trajectory == STANDARD_INPUT:
        raise InputError("--accuracy reads the trajectory twice", remedy="name a file", file="<stdin>")
    with read_motion(trajectory, model, scene, **reading()) as reader:
        for block in reader.blocks():
            if len(block):
                return arithmetic_within(model, block, scene, target)
    raise InputError("the trajectory has no samples", file=trajectory)
