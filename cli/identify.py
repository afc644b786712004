"""`robodyn identify`: a description that explains measured torques."""

from __future__ import annotations

import datetime
import os
import sys
from contextlib import ExitStack
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from robodyn.cli import options
from robodyn.cli.files import TABLE, check_names, expect, robot_in_scene
from robodyn.cli.options import COVARIANCE_OUT, PATH, POSITIVE, SCENE_OUT, Call, option, takes
from robodyn.cli.screen import answer
from robodyn.errors import InputError
from robodyn.support.files import whole_file

if TYPE_CHECKING:
    from robodyn.identification.result import Identified
    from robodyn.robot.model import Model

SPLIT = 0.7


@click.command("identify", short_help="Find parameters that explain measured torques.")
@click.argument("urdf", type=PATH)
@click.argument("logs", type=PATH, nargs=-1, required=True, metavar="LOG...")
@takes(
    option("--out FILE", "Write the calibrated description: URDF.", options.URDF_OUT),
    option("--scene-out FILE", "Write friction and rotors as a scene: TOML.", SCENE_OUT),
    option("--covariance FILE", "Write parameters and their covariance: JSON.", COVARIANCE_OUT),
    option("--validate LOG*", "Hold this log out; repeatable.", PATH),
    option(
        "--split PART",
        f"Of each log that is fitted, from its beginning, where nothing is validated; default {SPLIT:g}.",
        click.FloatRange(0.05, 1.0),
        default=SPLIT,
    ),
    option("--cutoff HZ", "Of the filter on both sides; default by the noise.", POSITIVE),
    option("--no-shapes", "Do not keep bodies within ellipsoids around their shapes."),
    option("--force", "Write even what explains held-out torques worse than the description."),
    options.SCENE,
    options.READING,
    options.REPORT,
    options.FORMAT,
)
def command(
    call: Call,
    urdf: str,
    logs: tuple[str, ...],
    scene_out: str | None,
    covariance: str | None,
    validate: tuple[str, ...],
    split: float,
    cutoff: float | None,
    no_shapes: bool,
    force: bool,
) -> int:
    """Find masses, inertias, friction and rotors that explain the measured torques of logs: tables with columns
    q_JOINT and tau_JOINT, or bags of ROS. Every body found can exist. Held-out errors are told, and nothing is written
    that explains held-out torques worse than the description does.

    \b
    Examples:
      robodyn identify robot.urdf log.parquet --out calibrated.urdf
      robodyn identify robot.urdf 1.mcap 2.mcap --validate 3.mcap --out calibrated.urdf --scene-out friction.toml
    """
    from robodyn.identification.identify import identify
    from robodyn.identification.log.log import read_log
    from robodyn.identification.passes import check_size
    from robodyn.report.identification import identified_json, identified_page, identified_sections

    outputs = {"out": call.out, "scene_out": scene_out, "covariance": covariance}
    check_names()
    for output in filter(None, outputs.values()):
        if not os.path.isdir(os.path.dirname(output) or os.curdir):
            raise InputError("cannot be written: no such folder", remedy="nothing was written", file=output)
    for path in (*logs, *validate):
        expect(TABLE, path)
    model, scene = robot_in_scene(call, urdf)
    check_size(model)

    fitted, held_out = (
        [read_log(path, model, scene, cutoff=cutoff, **call.reading) for path in paths] for paths in (logs, validate)
    )
    how: dict[str, Any] = {"split": split, "cutoff": cutoff, "shapes": not no_shapes, "on_progress": _progress}
    found = identify(fitted, scene, validate=held_out, **how)
    _progress("")
    why = None
    if found.faults:
        why = "; ".join(found.faults), "mend the columns, see --map"
    elif not found.explains:
        why = "most of the torques is left unexplained", "are torques in N m, and is it a log of this robot?"
    elif not found.better:
        why = "held-out torques are explained no better than by the description", "log a more exciting motion"
    why = None if force else why
    written = _write(found, model, outputs) if not why else ""
    page, json = partial(identified_page, found), partial(identified_json, found)
    answer(call, identified_sections(found), page, written, json=json)
    if why and any(outputs.values()):
        what, remedy = why
        raise InputError(f"{what}: nothing is written", remedy=f"{remedy}, or --force", file=logs[0])
    return 0


def _progress(stage: str) -> None:
    if sys.stderr.isatty():
        click.echo(f"\r\033[K{stage}", nl=False, err=True)


def _write(found: Identified, model: Model, outputs: dict[str, str | None]) -> str:
    from robodyn.identification.result import calibrated_urdf, friction_toml, lost_meshes

    errors, what = (found.held_out, "held-out") if found.held_out else (found.train, "fitted")
    comment = [
        f"identified by robodyn, {datetime.date.today().isoformat()}",
        *(f"log {os.path.basename(path)}, sha256 {sha256}" for path, sha256 in found.hashes.items()),
        f"relative error of {what} torques {100.0 * errors.relative_error:.2f} %, filtered at {found.cutoff:g} Hz,",
        f"with the scene that was found; without it about {100.0 * found.alone:.0f} %",
    ]
    files: list[tuple[str, bytes]] = []
    notes: list[str] = []
    if out := outputs["out"]:
        text = calibrated_urdf(model, found.names, found.described, found.theta, comment=comment, friction=True)
        notes += text.notes
        if model.description is not None and (lost := lost_meshes(model.description, out)):
            notes.append(lost)
        if not outputs["scene_out"]:
            notes.append(
                f"--scene-out writes friction and motors: without them about {100.0 * found.alone:.0f}% are left"
            )
        files.append((out, text.data))
    if out := outputs["scene_out"]:
        files.append((out, friction_toml(model, found.scene, comment).encode()))
    if out := outputs["covariance"]:
        from robodyn.identification.result import covariance
        from robodyn.scene.uncertainty import covariance_json

        files.append((out, covariance_json(covariance(found))))
    with ExitStack() as stack:
        for path, data in files:
            stack.enter_context(whole_file(path)).write(data)
    lines = [f"written: {path}, {max(1, len(data) // 1000)} kB" for path, data in files]
    return "".join(f"\nnote: {note}" for note in notes) + "".join(f"\n{line}" for line in lines) + "\n" * bool(files)
