"""`robodyn torques` on many trajectories: results in a folder, on all cores or on a Dask cluster."""

from __future__ import annotations

import logging
import os
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from functools import partial
from importlib import import_module
from typing import Any

import click

from robodyn.cli.batch import Job, Setup, failed, jobs_of, run_job
from robodyn.cli.files import STANDARD_INPUT, inputs_of, robot_in_scene
from robodyn.cli.options import Call, refuse
from robodyn.cli.progress import files_done
from robodyn.cli.reports import answer
from robodyn.cli.screen import complain, show
from robodyn.errors import InputError
from robodyn.loads.many import Batch, Outcome
from robodyn.loads.torques import check_uncertain
from robodyn.programs.run.llvm.machine import compiler_problem
from robodyn.report.table import printable
from robodyn.report.torques import batch_sections, outcome_line
from robodyn.report.torques_json import batch_json
from robodyn.support.extras import need
from robodyn.support.files import remove_abandoned
from robodyn.support.input_file import read_input
from robodyn.support.processes import Death, in_processes
from robodyn.support.threads import processes


def run_batch(
    call: Call, urdf: str, trajectories: Sequence[str], loads: Mapping[str, Any], jobs: int | None, dask: str | None
) -> int:
    """Return the exit status: 2 if a trajectory failed, 1 if a limit is exceeded and that counts."""
    out = call.out
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
    setup, robot = _setup(call, urdf, loads)
    work = worked_there(setup, todo, dask) if dask else worked_here(setup, todo, processes(len(todo), jobs))
    found: dict[int, Outcome] = {}
    printed = 0
    with closing(work), files_done([job.path for job in todo]) as tick:  # type: ignore[type-var]
        for number, outcome in work:
            found[number] = outcome
            tick(number)
            while (last := found.get(printed)) is not None:  # in their order, as soon as all before it are there
                if last.status == "failed":
                    complain(last.error)
                elif lines:
                    print(outcome_line(last), flush=True)
                printed += 1
    outcomes = [found[number] for number in range(len(todo))]
    batch = Batch(robot, tuple(outcomes))
    if lines:
        show("\n")
    answer(call, batch_sections(batch), json=lambda: batch_json(batch))
    return 2 if batch.count("failed") else int(call.fail_on_limits and batch.within_limits is False)


def _setup(call: Call, urdf: str, loads: Mapping[str, Any]) -> tuple[Setup, str]:
    model, scene = robot_in_scene(call, urdf, loops=True, contacts=True)
    assert model.description is not None, "it is read from a file"
    check_uncertain(scene)
    if loads["momentum"] is not None:
        loads["momentum"].check(model, scene)
    executor = loads["executor"]
    if executor == "auto":  # the same everywhere and every time, so that results are equal to the bit
        executor = "numpy" if compiler_problem() else "compiled"
    setup = Setup(
        robot=model.description.data,
        scenes=tuple(map(read_input, call.scene_files)),
        gravity=call.gravity,
        payloads=call.payloads,
        base_held=call.base_held,
        reading=call.reading,
        options={**loads, "executor": executor, "threads": loads["threads"] or 1},
    )
    return setup, model.name


def worked_here(setup: Setup, jobs: Sequence[Job], count: int) -> Iterator[tuple[int, Outcome]]:
    """Yield (number, outcome) of every job as they are done, by `count` processes.

    When the iterator is closed early, by an interruption for example, processes remove what they have half-written.
    """

    def clear(number: int) -> None:
        """Remove what the process has not: killed, or under Windows, it cannot."""
        for path in (jobs[number].table, jobs[number].document):
            remove_abandoned(path)

    with closing(in_processes(partial(_run_quietly, setup), [(job,) for job in jobs], count, clear)) as work:
        for number, found in work:
            job = jobs[number]
            yield number, failed(job, f"{job.name}: {found}") if isinstance(found, Death) else found


def _run_quietly(setup: Setup, job: Job) -> Outcome:
    warnings.simplefilter("ignore")
    return run_job(setup, job)


PATIENCE = 10
"""Seconds within which the scheduler must answer."""


def worked_there(setup: Setup, jobs: Sequence[Job], address: str) -> Iterator[tuple[int, Outcome]]:
    """Yield (number, outcome) of every job as they are done, by the workers of the cluster at this address.

    The workers need robodyn of this version, and the files of this machine under the same names. Jobs of a worker that
    dies go to others. When the iterator is closed early, jobs that have not begun are cancelled.

    Args:
        address: of the scheduler, such as tcp://10.0.0.1:8786.

    Raises:
        InputError: there is no scheduler at the address.
    """
    distributed: Any = import_module("distributed")  # which sets the levels of its own loggers
    logging.getLogger("distributed.client").setLevel(logging.ERROR)  # work given to another worker is no news
    try:
        client = distributed.Client(address, timeout=PATIENCE)
    except (OSError, ValueError, TypeError) as error:
        what = f"no Dask scheduler answers: {' '.join(str(error).split()) or type(error).__name__}"
        raise InputError(what, remedy="an address is like tcp://10.0.0.1:8786", file=address) from None
    with client:
        if not client.scheduler_info(n_workers=-1)["workers"]:
            click.echo(f"note: {printable(address)} has no workers yet; waiting for them", err=True)
        futures = [client.submit(run_job, setup, job, pure=False) for job in jobs]
        numbers = {future: number for number, future in enumerate(futures)}
        try:
            for future in distributed.as_completed(futures):
                number = numbers[future]
                try:
                    outcome = future.result()
                except Exception as problem:
                    outcome = failed(jobs[number], _why(jobs[number], problem))
                yield number, outcome
        finally:
            client.cancel(futures)


def _why(job: Job, problem: BaseException) -> str:
    name = type(problem).__name__
    if name == "KilledWorker":
        return f"{job.name}: every worker that it was given to died (is there enough memory?)"
    if isinstance(problem, ModuleNotFoundError):
        return f"{job.name}: {problem} on the worker (install robodyn there)"
    if name.endswith("CancelledError"):
        return f"{job.name}: the scheduler went away (the same command again goes on with what is not finished)"
    return f"{job.name}: {name}: {problem}"
