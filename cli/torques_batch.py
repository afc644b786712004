"""`robodyn torques` on many trajectories: results in a folder, on all cores or on a Dask cluster."""

from __future__ import annotations

import os
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from importlib import import_module

import click

from robodyn.cli.batch.jobs import BETWEEN, Job, Setup, jobs_of
from robodyn.cli.batch.workers import worked_here
from robodyn.cli.call import Call, refuse
from robodyn.cli.files import STANDARD_INPUT, inputs_of, robot_in_scene
from robodyn.cli.progress import files_done
from robodyn.cli.reports import answer
from robodyn.cli.screen import complain, show
from robodyn.cli.torques import Options
from robodyn.errors import InputError
from robodyn.loads.many import Batch, Outcome
from robodyn.loads.torques import check_uncertain
from robodyn.programs.run.llvm.machine import compiler
from robodyn.report.table import printable
from robodyn.report.torques import batch_sections, outcome_line
from robodyn.report.torques_json import batch_json
from robodyn.support.extras import need
from robodyn.support.input_file import read_input
from robodyn.support.threads import processes


def run_batch(
    call: Call,
    urdf: str,
    trajectories: Sequence[str],
    out: str | None,
    options: Options,
    *,
    fail_on_limits: bool,
    jobs: int | None,
    dask: str | None,
) -> int:
    """Return the exit status: 2 if a trajectory failed, 1 if a limit is exceeded and that counts."""
    if call.report:
        refuse("--report is of one trajectory")
    if not out:
        refuse("many trajectories need --out FOLDER for their results")
    if os.path.isfile(out):
        raise InputError("is a file, many trajectories need a folder", remedy="give --out another name", file=out)
    if STANDARD_INPUT in (urdf, *call.scene_files, *trajectories):
        raise InputError("standard input serves one trajectory", remedy="name files for many", file="<stdin>")
    todo = jobs_of(trajectories, out, inputs_of(click.get_current_context()))
    lines = call.form == "text"
    if dask:
        need("clusters of Dask", "distributed")
    setup, robot = _setup(call, urdf, options)
    work = _there(setup, todo, dask) if dask else worked_here(setup, todo, processes(len(todo), jobs))
    with closing(work), files_done([job.path for job in todo]) as tick:  # type: ignore[type-var]
        outcomes = _gathered(work, todo, tick, lines)
    batch = Batch(robot, tuple(outcomes))
    if lines:
        show("\n")
    answer(call, batch_sections(batch), json=lambda: batch_json(batch))
    return 2 if batch.count("failed") else int(fail_on_limits and batch.within_limits is False)


def _setup(call: Call, urdf: str, options: Options) -> tuple[Setup, str]:
    """Return what all trajectories have in common, which is checked here once; and the robot's name."""
    model, scene = robot_in_scene(call, urdf, loops=True, contacts=True)
    assert model.description is not None, "it is read from a file"
    check_uncertain(scene, options.samples)
    if options.momentum is not None:
        options.momentum.check(model, scene)
    executor = options.executor
    if executor == "auto":  # the same everywhere and every time, so that results are equal to the bit
        executor = "numpy" if compiler().problem else "compiled"
    setup = Setup(
        robot=zlib.compress(model.description.data),
        scene=zlib.compress(BETWEEN.join(map(read_input, names))) if (names := call.scene_files) else None,
        gravity=call.gravity,
        payloads=call.payloads,
        base_held=call.base_held,
        reading=call.reading,
        options={**vars(options), "executor": executor, "threads": options.threads or 1},
    )
    return setup, model.name


def _there(setup: Setup, jobs: Sequence[Job], address: str) -> Iterator[tuple[int, Outcome]]:
    import logging

    from robodyn.cli.batch.workers import worked_there

    import_module("distributed")  # an import sets the levels of its own loggers
    # That work is given to another worker is what Dask is for, and no news.
    logging.getLogger("distributed.client").setLevel(logging.ERROR)
    return worked_there(setup, jobs, address, lambda line: click.echo(f"note: {printable(line)}", err=True))


def _gathered(
    work: Iterator[tuple[int, Outcome]], jobs: Sequence[Job], tick: Callable[[int], None], lines: bool
) -> list[Outcome]:
    """Return all outcomes; a line for each is written as soon as all before it are there, errors on standard error."""
    found: dict[int, Outcome] = {}
    printed = 0
    for number, outcome in work:
        found[number] = outcome
        tick(number)
        while (last := found.get(printed)) is not None:
            if last.status == "failed":
                complain(last.error)
            elif lines:
                print(outcome_line(last), flush=True)
            printed += 1
    return [found[number] for number in range(len(jobs))]
