"""`robodyn linearize`: the linear equations of a robot near a state, and its modes."""

from __future__ import annotations

import io
from functools import partial
from typing import Any

import click
import numpy as np

from robodyn.cli.files import check_names, robot_in_scene
from robodyn.cli.options import AT, FORMAT, PATH, POSITIVE, QD, REPORT, SCENE, Call, Output, option, takes
from robodyn.cli.screen import answer
from robodyn.equations.linearized.linearize import linearize
from robodyn.errors import InputError
from robodyn.report.equations.linearized import linearized_json, linearized_page, linearized_sections
from robodyn.support.files import write_whole


@click.command("linearize", short_help="Linearize a robot near a state: A, B, modes, stability.")
@click.argument("urdf", type=PATH)
@takes(
    AT,
    QD,
    option("--equilibrium", "Look for the state at rest nearest to --at."),
    option("--step S", "s: A and B of steps, with inputs held in between.", POSITIVE),
    option("--fail-on-limits", "Exit with 1 if limits do not allow the state at rest."),
    option("--out FILE", "Write A, B, states and inputs: .npz.", Output("an archive")),
    SCENE,
    REPORT,
    FORMAT,
)
def command(call: Call, urdf: str, equilibrium: bool, step: float | None) -> int:
    """Linearize x' = A x + B u near a state, x being positions and speeds and u torques, with the scene's drives and
    springs closed; and list the modes: frequency, damping, time constant and what moves. Derivatives are exact.
    Without --equilibrium the robot is held where --at puts it. A file named - is standard input.

    \b
    Examples:
      robodyn linearize robots/pendulum.urdf --at 1.5707963267948966
      robodyn linearize robots/puma.urdf --scene robots/puma_servo.toml --equilibrium --step 0.001 --out linear.npz
    """
    check_names()
    if call.out is not None and not call.out.endswith(".npz"):
        raise InputError("is no .npz file", remedy="--out FILE.npz", file=call.out)
    model, scene = robot_in_scene(call, urdf, loops=True)
    found = linearize(model, scene, call.at, call.qd or (), equilibrium=equilibrium, step=step)
    text = linearized_json(found)
    written = ""
    if call.out is not None:
        arrays: dict[str, Any] = {key: getattr(found, key) for key in ("A", "B", "q", "qd", "drive", "held")}
        archive = io.BytesIO()
        np.savez(archive, states=np.array(found.states), inputs=np.array(found.inputs), **arrays)
        write_whole(call.out, archive.getvalue(), "name another file")
        written = f"\nwritten: {call.out}, A, B, states and inputs\n"
    answer(call, linearized_sections(found), partial(linearized_page, found), written, json=lambda: text)
    return int(call.fail_on_limits and bool(found.exceeded))
