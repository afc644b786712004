"""`robodyn torques` on one trajectory."""

from __future__ import annotations

from typing import Any

from robodyn.cli.files import ROBOT, TABLE, check_names, expect, robot_in_scene
from robodyn.cli.options import Vector
from robodyn.cli.reading_options import reading
from robodyn.cli.reports import drawing, pictured, reported
from robodyn.cli.screen import page, show
from robodyn.cli.sinks import sinks
from robodyn.loads.accumulate import output_names
from robodyn.loads.result import Result
from robodyn.loads.torques import torques
from robodyn.trajectory.robot_motion import read_motion


def run_single(
    urdf: str,
    scene_file: str | None,
    gravity: Vector | None,
    base_held: bool,
    trajectory: str,
    out: str | None,
    report: str | None,
    accuracy: float | None,
    example: bool,
    form: str,
    options: dict[str, Any],
) -> Result:
    """What was found, after it is shown and written."""
    for place in (out, report):
        check_names([urdf, trajectory, scene_file], place)
    expect(ROBOT, urdf)
    expect(TABLE, trajectory)
    with drawing(report, trajectory) as draw:
        model, scene = robot_in_scene(urdf, scene_file, gravity, base_held=base_held)
        said = ""
        if example:
            from robodyn.cli.example import write_example

            write_example(trajectory, model, scene)
            said = f"\nwritten: {trajectory}, an example motion to begin with\n"
        way = None
        if accuracy is not None:
            from robodyn.cli.accuracy_asked import arithmetic_for

            way = arithmetic_for(accuracy, trajectory, model, scene)
            options["executor"] = way.executor or options["executor"]
        names = output_names(model, options["reactions"], options["momentum"] is not None)
        reader = read_motion(trajectory, model, scene, **reading())
        with reader, sinks(out, names, reader) as gather:
            result = torques(model, reader, scene, sinks=gather, history=pictured(report), **options)
        result = way.fulfilled(result) if way else result
        if out:
            said += f"\nwritten: {out}, {result.samples} rows of time and {len(names)} columns\n"
        if report:
            from robodyn.report.page_torques import torques_page

            said += reported(report, lambda pictures: torques_page(result, model, scene, pictures, draw))
    if form == "json":
        from robodyn.report.json_torques import torques_json

        show(torques_json(result))
    else:
        from robodyn.report.text_torques import torques_text

        show(torques_text(result, options["explain"], page()) + said)
    return result
