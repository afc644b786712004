"""`robodyn accuracy`: what accuracy costs in time."""

from __future__ import annotations

import click

from robodyn.cli.accuracy_input import accuracy_of
from robodyn.cli.files import check_names
from robodyn.cli.options import DESCRIPTION, FORMAT, GRAVITY, PATH, POSITIVE, SCENE, Vector
from robodyn.cli.reading_options import READING
from robodyn.cli.reports import REPORT, reported
from robodyn.cli.screen import page, show
from robodyn.report.json_accuracy import accuracy_json
from robodyn.report.plotting import form_of, rendered
from robodyn.report.text_accuracy import accuracy_text
from robodyn.support.files import write_whole


@click.command("accuracy", short_help="What each further digit costs in time.")
@click.argument("files", nargs=-1, type=PATH, required=True, metavar="MESH|URDF TRAJECTORY|URDF SCENE.toml")
@click.option("--target", type=POSITIVE, metavar="ERROR", help="Name the quickest method within this relative error.")
@click.option("--duration", type=POSITIVE, metavar="S", help="s, of a simulated motion; default 2, or the table's.")
@click.option("--traj", "table", type=PATH, metavar="FILE", help="The table whose columns the scene names.")
@click.option("--plot", type=PATH, metavar="FILE", help="Draw error against time: .svg, .png or .pdf.")
@READING
@DESCRIPTION
@SCENE
@GRAVITY
@REPORT
@FORMAT
def command(
    files: tuple[str, ...],
    target: float | None,
    duration: float | None,
    table: str | None,
    plot: str | None,
    scene_file: str | None,
    gravity: Vector | None,
    report: str | None,
    form: str,
) -> int:
    """True errors and times of every method: for a mesh, for the torques of a robot along a motion, or for the motion
    that a scene makes. A file named - is standard input. Exit status 1: no method meets the target.

    \b
    Examples:
      robodyn accuracy robots/meshes/bracket.stl --target 1e-6
      robodyn accuracy robots/puma560.urdf robots/puma560_sweep.csv --report accuracy.html
      robodyn accuracy robots/two_link_planar.urdf robots/two_link_planar_swing_down.toml --plot front.svg
    """
    for place in (plot, report):
        check_names([*files, scene_file, table], place)
    picture = form_of(plot) if plot else ""
    found = accuracy_of(files, scene_file, gravity, duration, table)
    written = ""
    if plot:
        from robodyn.report.plot_accuracy import accuracy_figure

        write_whole(plot, rendered(accuracy_figure(found, target), picture), remedy="name another file")
        written = f"\nwritten: {plot}\n"
    if report:
        from robodyn.report.page_accuracy import accuracy_page

        written += reported(report, lambda pictures: accuracy_page(found, target, pictures))
    show(accuracy_json(found, target) if form == "json" else accuracy_text(found, target, page()) + written)
    return int(target is not None and any(ladder.cheapest(target) is None for ladder in found.ladders))
