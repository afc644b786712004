"""One trajectory of a batch: computed, unless its results are there."""

from __future__ import annotations

import json
import os
from contextlib import ExitStack, suppress
from typing import Any

from robodyn.cli.batch.jobs import REMEDY, VERSION, Job, Setup
from robodyn.cli.files import refuse_foreign
from robodyn.errors import InputError, RobodynError
from robodyn.loads.columns import output_names
from robodyn.loads.many import JointPeak, Outcome, Status
from robodyn.loads.torques import torques
from robodyn.report.torques_json import torques_json
from robodyn.robot.limits import Coverage, Quantity, Unchecked
from robodyn.support.caveats import Caveat
from robodyn.support.files import write_whole
from robodyn.support.input_file import read_input
from robodyn.support.threads import write_behind
from robodyn.trajectory.robot_motion import read_motion
from robodyn.trajectory.write import open_writer

KEY = "inputs"
"""Of the document, for what it was made from: `trajectory`, `digest`, and the `table` with its size in `bytes`."""


def run_job(setup: Setup, job: Job) -> Outcome:
    """Compute one trajectory and write its table, then its document, each whole or not at all.

    A document whose digest is that of robot, scene, options, version and trajectory, beside a table of the size that it
    tells, is finished: nothing is computed then. Every fault is part of the outcome.
    """
    try:
        if setup.version != VERSION:
            what = f"robodyn {VERSION} works on it, the batch is of robodyn {setup.version}"
            raise InputError(what, remedy="install the same version everywhere")
        digest = setup.digest(job.path)
        found = _finished(job, digest)
        if found is not None:
            return _outcome(job, "finished before", found)
        return _outcome(job, "computed", _computed(setup, job, digest))
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
    """Return the outcome of a job that failed."""
    return Outcome(job.name, "failed", error=" ".join(text.split()))


def _finished(job: Job, digest: str) -> dict[str, Any] | None:
    """Return the document of a job that is finished; remove results of other inputs, lest they be taken for these."""
    with suppress(OSError, ValueError, KeyError, TypeError):
        document: dict[str, Any] = json.loads(read_input(job.document))
        made = document[KEY]
        if made["digest"] == digest and os.path.getsize(job.table) == made["bytes"]:
            _outcome(job, "finished before", document)
            return document
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
        _make_folder(os.path.dirname(job.table))
        writer = stack.enter_context(open_writer(job.table, names))
        sink = stack.enter_context(write_behind(writer.write))
        result = torques(model, reader, scene, sinks=[sink], **setup.options)
    document: dict[str, Any] = json.loads(torques_json(result))
    made = {"trajectory": job.name, "digest": digest, "table": os.path.basename(job.table)}
    document[KEY] = {**made, "bytes": os.path.getsize(job.table)}
    write_whole(job.document, (json.dumps(document, indent=2, allow_nan=False) + "\n").encode())
    return document


def _make_folder(path: str) -> None:
    try:
        os.makedirs(path, exist_ok=True)
    except OSError as error:
        why = (error.strerror or str(error)).lower()
        raise InputError(f"no folder can be made: {why}", remedy="give --out another name", file=path) from None


def _outcome(job: Job, status: Status, document: dict[str, Any]) -> Outcome:
    sized = document.get("sizing", {}).get("joints", [])
    levels = [joint["level"] for joint in sized] or [None] * len(document["joints"])
    keys = ("name", "unit", "peak", "peak_time", "peak_row", "rms", "max_speed", "effort_limit", "velocity_limit")
    joints = tuple(
        JointPeak(**{key: joint[key] for key in keys}, level=level)
        for joint, level in zip(document["joints"], levels, strict=True)
    )
    return Outcome(
        job.name,
        status,
        table=job.shown,
        document=os.path.splitext(job.shown)[0] + ".json",
        samples=document["samples"],
        duration=document["duration"],
        exceeded=_exceeded(document, sized),
        limits=tuple(_coverage(*each) for each in document["limits"].items()),
        caveats=tuple(Caveat(each["clause"], each["said"]) for each in document["doubts"]),
        joints=joints,
    )


def _coverage(quantity: Quantity, found: dict[str, Any]) -> Coverage:
    return Coverage(quantity, tuple(found["checked"]), tuple(Unchecked(**each) for each in found["unchecked"]))


def _exceeded(document: dict[str, Any], sized: list[dict[str, Any]]) -> tuple[str, ...]:
    """Return joints and quantities beyond limits, those of the description first, each once."""
    found = [(excess["joint"], excess["quantity"]) for excess in document["limits_exceeded"]]
    found += [(joint["name"], excess["quantity"]) for joint in sized for excess in joint["exceeded"]]
    return tuple(dict.fromkeys(f"{joint} {quantity}" for joint, quantity in found))
