"""`robodyn torques` on many trajectories: results in a folder, on all cores or on a Dask cluster."""

from __future__ import annotations

import json
import logging
import os
import threading
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass, replace
from functools import partial
from glob import glob, has_magic
from hashlib import blake2b
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import click

import robodyn
from robodyn.cli.files import STANDARD_INPUT, inputs_of, refuse_foreign, robot_in_scene
from robodyn.cli.options import Call, refuse_where
from robodyn.cli.progress import files_done
from robodyn.cli.screen import answer, complain, show
from robodyn.errors import Caveat, InputError, RobodynError
from robodyn.loads.accumulate import output_names
from robodyn.loads.many import Batch, JointPeak, Outcome, Status
from robodyn.loads.torques import check_uncertain, torques
from robodyn.programs.run.llvm.machine import compiler_problem
from robodyn.report.table import printable
from robodyn.report.torques import batch_json, batch_sections, outcome_line, torques_json
from robodyn.robot.limits import Coverage, Unchecked
from robodyn.robot.load import assemble
from robodyn.robot.model import Model
from robodyn.robot.urdf.parts import Description
from robodyn.robot.urdf.sources import Search
from robodyn.scene.fit import scene_of
from robodyn.scene.read import scene_from, scene_tables
from robodyn.scene.scene import DEFAULT, Payload, Scene
from robodyn.support.cache import code_digest
from robodyn.support.extras import need
from robodyn.support.files import remove_abandoned, write_whole
from robodyn.support.input_file import open_input, read_input
from robodyn.support.libraries import version_of
from robodyn.support.processes import Death, in_processes
from robodyn.support.threads import processes, write_behind
from robodyn.trajectory.formats.table import FILE_TYPES, READABLE, log_kind
from robodyn.trajectory.read import read_motion
from robodyn.trajectory.write import open_writer

REMEDY = "give --out another folder"
_SUFFIXES = {"csv": ".csv", "parquet": ".parquet", "npz": ".npz"}
VERSION = f"{version_of('robodyn')}, code {code_digest(Path(robodyn.__file__).parent, without='cli')[:12]}"
"""Of robodyn as this process has loaded it; the command line, which computes nothing, does not count."""
_KEPT = threading.local()
KEY = "inputs"
"""Of the document, for what it was made from: `trajectory`, `digest`, and the `table` with its size in `bytes`."""
PATIENCE = 10
"""Seconds within which the scheduler must answer."""


class Job(NamedTuple):
    """One trajectory: its name as given, absolute paths of it and its results, and the table's name as printed."""

    name: str
    path: str
    table: str
    document: str
    shown: str


def jobs_of(patterns: Sequence[str], out: str, beside: Sequence[str] = ()) -> list[Job]:
    """Return the jobs of names and patterns (`runs/**/*.csv`) in their order, each file once; `beside` are other files
    that are read. Results keep name and type of their trajectory, and the folders that differ. InputError: a pattern
    fits no file, a type is not known, two results would have one name, or one would overwrite an input."""
    found = []
    for pattern in patterns:
        files = [pattern]
        if has_magic(pattern) and not os.path.lexists(pattern):
            files = sorted(name for name in glob(pattern, recursive=True) if not os.path.isdir(name))
        if not files:
            remedy = "it is sought from the current folder"
            raise InputError("no file fits this pattern", remedy=remedy, file=pattern)
        found += files
    names = list(dict.fromkeys(found))
    paths = [os.path.abspath(name) for name in names]
    common = os.path.commonpath([os.path.dirname(path) for path in paths])
    jobs: dict[str, Job] = {}
    for name, path in zip(names, paths, strict=True):
        stem, suffix = os.path.splitext(os.path.relpath(path, common))
        kind = FILE_TYPES.get(suffix.lower(), "csv" if log_kind(path) else None)
        if kind is None:
            remedy = f"suffixes: {' '.join(READABLE)}"
            raise InputError("unknown type of table by this suffix", remedy=remedy, file=name)
        if kind == "parquet":
            need("tables written as Parquet", "pyarrow", file=name)
        shown = os.path.join(out, stem + _SUFFIXES[kind])
        table = os.path.abspath(shown)
        job = Job(name, path, table, os.path.splitext(table)[0] + ".json", shown)
        if job.document in jobs and jobs[job.document].path != path:
            what = f"the results of '{jobs[job.document].name}' would have the same name"
            raise InputError(what, remedy="rename one of them, or give each a --out of its own", file=name)
        jobs[job.document] = job
    read = {_identity(name): name for name in [*names, *beside]}
    for job in jobs.values():
        over = read.get(_identity(job.table)) or read.get(_identity(job.document))
        if over is not None:
            raise InputError("the output would overwrite an input", remedy=REMEDY, file=over)
    return list(jobs.values())


def _identity(path: str) -> tuple[int, int] | str:
    with suppress(OSError, ValueError):
        status = os.stat(path)
        return status.st_dev, status.st_ino
    return os.path.realpath(path)


@dataclass(frozen=True)
class Setup:
    """Robot, scene and options.

    Attributes:
        robot: as it was read; scenes: the files' bytes; gravity [m/s^2] is in place of the scene's, payloads beside.
        reading: as for `read_motion`; options: as for `torques`, with the threads of each process.
        version: of robodyn and its code, which all machines must have.
    """

    robot: Description
    scenes: tuple[bytes, ...]
    gravity: tuple[float, float, float] | None
    payloads: tuple[Payload, ...]
    base_held: bool
    reading: Mapping[str, Any]
    options: Mapping[str, Any]
    version: str = VERSION

    def loaded(self) -> tuple[Model, Scene]:
        """Return the robot and its scene, read once by each thread, which then has programs of its own."""
        if getattr(_KEPT, "setup", None) != self:
            tables = scene_tables(sources) if (sources := [(data, "<scene>") for data in self.scenes]) else {}
            scene = scene_from(tables, sources) if sources else DEFAULT
            model = assemble(self.robot, moving_base=scene.moving_base)
            scene = scene_of(model, scene, tables)
            _KEPT.robot = model, scene.changed(self.gravity, self.payloads, held=self.base_held)
            _KEPT.setup = self
        robot: tuple[Model, Scene] = _KEPT.robot
        return robot

    def digest(self, path: str) -> str:
        """Return a hash of all that a trajectory's results depend on: its bytes, robot, scene, options, version."""
        options = dict(sorted({**self.options, "threads": 1}.items()))  # they come in the order of the call
        hashed = blake2b(repr(replace(self, options=options)).encode(), digest_size=20)
        with open_input(path) as stream:
            while piece := stream.read(1 << 20):
                hashed.update(piece)
        return hashed.hexdigest()


def run_job(setup: Setup, job: Job) -> Outcome:
    """Compute one trajectory and write its table, then its document, each whole or not at all, unless a document of
    this digest stands beside a table of the size that it tells. Every fault is part of the outcome."""
    try:
        if setup.version != VERSION:
            what = f"robodyn {VERSION} works on it, the batch is of robodyn {setup.version}"
            raise InputError(what, remedy="install the same version everywhere")
        digest = setup.digest(job.path)
        return _finished(job, digest) or _outcome(job, "computed", _computed(setup, job, digest))
    except RobodynError as error:
        named = error.file in (None, job.path)
        file = job.name if named else error.file
        text = str(type(error)(error.what, remedy=error.remedy, file=file, line=error.line))
    except OSError as error:
        text = f"{job.name}: cannot be read: {(error.strerror or str(error)).lower()}"
    except MemoryError:
        text = f"{job.name}: out of memory"
    except Exception as error:
        text = f"{job.name}: internal error: {type(error).__name__}: {error}"
    return failed(job, text)


def failed(job: Job, text: str) -> Outcome:
    return Outcome(job.name, "failed", error=" ".join(text.split()))


def _finished(job: Job, digest: str) -> Outcome | None:
    """Return the outcome of a job that is finished; remove results of other inputs, lest they be taken for these."""
    with suppress(OSError, ValueError, KeyError, TypeError):
        document = json.loads(read_input(job.document))
        made = document[KEY]
        if made["digest"] == digest and os.path.getsize(job.table) == made["bytes"]:
            return _outcome(job, "finished before", document)
        for path in (job.document, job.table):
            os.unlink(path)
    return None


def _computed(setup: Setup, job: Job, digest: str) -> dict[str, Any]:
    for place, kind in ((job.table, "a table"), (job.document, "a result of a batch")):
        refuse_foreign(place, kind, REMEDY)
    model, scene = setup.loaded()
    names = output_names(model, setup.options["reactions"], setup.options["momentum"] is not None, scene)
    with ExitStack() as stack:
        reader = stack.enter_context(read_motion(job.path, model, scene, **setup.reading))
        folder = os.path.dirname(job.table)
        try:
            os.makedirs(folder, exist_ok=True)
        except OSError as error:
            why = (error.strerror or str(error)).lower()
            raise InputError(f"no folder can be made: {why}", remedy="give --out another name", file=folder) from None
        writer = stack.enter_context(open_writer(job.table, names))
        sink = stack.enter_context(write_behind(writer.write))
        result = torques(model, reader, scene, sinks=[sink], **setup.options)
    document: dict[str, Any] = json.loads(torques_json(result))
    made = {"trajectory": job.name, "digest": digest, "table": os.path.basename(job.table)}
    document[KEY] = {**made, "bytes": os.path.getsize(job.table)}
    write_whole(job.document, (json.dumps(document, indent=2, allow_nan=False) + "\n").encode())
    return document


def _outcome(job: Job, status: Status, document: dict[str, Any]) -> Outcome:
    sized = document.get("sizing", {}).get("joints", [])
    levels = [joint["level"] for joint in sized] or [None] * len(document["joints"])
    keys = ("name", "unit", "peak", "peak_time", "peak_row", "rms", "max_speed", "effort_limit", "velocity_limit")
    joints = tuple(
        JointPeak(**{key: joint[key] for key in keys}, level=level)
        for joint, level in zip(document["joints"], levels, strict=True)
    )
    exceeded = [(excess["joint"], excess["quantity"]) for excess in document["limits_exceeded"]]
    exceeded += [(joint["name"], excess["quantity"]) for joint in sized for excess in joint["exceeded"]]
    limits = [
        Coverage(quantity, tuple(found["checked"]), tuple(Unchecked(**each) for each in found["unchecked"]))
        for quantity, found in document["limits"].items()
    ]
    return Outcome(
        job.name,
        status,
        table=job.shown,
        document=os.path.splitext(job.shown)[0] + ".json",
        samples=document["samples"],
        duration=document["duration"],
        exceeded=tuple(dict.fromkeys(f"{joint} {quantity}" for joint, quantity in exceeded)),
        limits=tuple(limits),
        caveats=tuple(Caveat(each["clause"], each["said"]) for each in document["doubts"]),
        joints=joints,
    )


def run_batch(
    call: Call, urdf: str, trajectories: Sequence[str], loads: Mapping[str, Any], jobs: int | None, dask: str | None
) -> int:
    out = call.out or ""
    refuse_where(
        (call.report, "--report is of one trajectory"),
        (not out, "many trajectories need --out FOLDER for their results"),
    )
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
    batch = Batch(robot, tuple(found[number] for number in range(len(todo))))
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
        robot=replace(model.description, file="<stdin>", search=Search("<stdin>")),
        scenes=tuple(map(read_input, call.scene_files)),
        gravity=call.gravity,
        payloads=call.payloads,
        base_held=call.base_held,
        reading=call.reading,
        options={**loads, "executor": executor, "threads": loads["threads"] or 1},
    )
    return setup, model.name


def worked_here(setup: Setup, jobs: Sequence[Job], count: int) -> Iterator[tuple[int, Outcome]]:
    """Yield (number, outcome) of every job as they are done, by `count` processes, which remove what they have
    half-written when the iterator is closed early."""

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


def worked_there(setup: Setup, jobs: Sequence[Job], address: str) -> Iterator[tuple[int, Outcome]]:
    """Yield (number, outcome) of every job as they are done, by the workers of the cluster whose scheduler has this
    address; InputError without one. They need robodyn of this version, and the files of this machine under the same
    names. Jobs of a worker that dies go to others; those that have not begun are cancelled at an early end."""
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
