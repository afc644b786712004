"""`robodyn envelope`: the poses in which weight loads a robot most, and what it can carry in all of them."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import click

from robodyn.cli.files import check_names, robot_in_scene
from robodyn.cli.options import (
    BOX,
    CARRIED,
    DESCRIPTION,
    FORMAT,
    GRAVITY,
    PATH,
    REPORT,
    SCENE_FILES,
    Call,
    Vector,
    option,
    refuse_where,
    takes,
)
from robodyn.cli.screen import answer
from robodyn.report.sizing.envelope import envelope_json, envelope_page, envelope_sections
from robodyn.scene.scene import Payload
from robodyn.sizing.envelope import envelope

_MOST = 10**8


@click.command("envelope", short_help="Find the worst poses of a robot that holds still, and what it can carry.")
@click.argument("urdf", type=PATH)
@takes(
    option("--payload LINK[@X,Y,Z]*", "Find the largest mass there that all poses bear; LINK=KG adds one.", CARRIED),
    option("--box JOINT=A..B,...", "Narrower ranges, rad or m.", BOX),
    option("--samples N", "Hold so many random poses against the bounds.", click.IntRange(0, _MOST), default=0),
    option("--fail-on-limits", "Exit with 1 if a pose passes a limit of robot or motor."),
    DESCRIPTION,
    SCENE_FILES,
    GRAVITY,
    REPORT,
    FORMAT,
)
def command(
    call: Call,
    urdf: str,
    payload: tuple[Payload | tuple[str, Vector], ...],
    box: dict[str, tuple[float, float]] | None,
    samples: int,
) -> int:
    """Find for every joint the pose within the position limits in which weight loads it most, and a bound that no pose
    exceeds; likewise for bearings and for the base's tipping moment. Gravity, payloads, springs and forces along
    gravity count, friction at rest does not. A robot named - is standard input.

    \b
    Examples:
      robodyn envelope robots/puma560.urdf
      robodyn envelope robots/puma560.urdf --payload tool0@0,0,0.1 --samples 100000 --report puma.html
      robodyn envelope robots/puma560.urdf --box shoulder=-1..0.5,elbow=0..1.5 --scene robots/puma560_sizing.toml
    """
    check_names()
    wanted = [each for each in payload if not isinstance(each, Payload)]
    refuse_where((len(wanted) > 1, "--payload looks for one mass; give the others as LINK=KG"))
    call = replace(call, payloads=tuple(each for each in payload if isinstance(each, Payload)))
    model, scene = robot_in_scene(call, urdf)
    found = envelope(model, scene, box=box, payload=wanted[0] if wanted else None, samples=samples)
    answer(call, envelope_sections(found), partial(envelope_page, found), json=lambda: envelope_json(found))
    beaten = found.samples is not None and found.samples.share > 1.0
    return int(beaten or (call.fail_on_limits and bool(found.exceeded)))
