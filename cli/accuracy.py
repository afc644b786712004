"""`robodyn accuracy`: what accuracy costs in time."""

from __future__ import annotations

from functools import partial

import click

from robodyn.cli import options
from robodyn.cli.files import check_names, check_table, robot_in_scene
from robodyn.cli.options import PATH, POSITIVE, Call, option, refuse, refuse_where, takes
from robodyn.cli.screen import answer
from robodyn.report.accuracy import accuracy_json, accuracy_page, accuracy_sections


@click.command("accuracy", short_help="Measure what each further digit costs in time.")
@click.argument("files", nargs=-1, type=PATH, required=True, metavar="MESH|URDF TRAJECTORY|URDF SCENE.toml")
@takes(
    option("--target ERROR", "Name the quickest method within this relative error.", POSITIVE),
    option("--duration S", "s, of a simulated motion; default 2, or the table's.", POSITIVE),
    option("--traj FILE", "The table whose columns the scene names.", PATH, "table"),
    options.READING,
    options.SCENE,
    options.REPORT,
    options.FORMAT,
)
def command(
    call: Call,
    files: tuple[str, ...],
    target: float | None,
    duration: float | None,
    table: str | None,
) -> int:
    """Measure true errors and times of every method: for a mesh, for the torques of a robot along a motion, or for the
    motion that a scene makes. A file named - is standard input. Exit status 1: no method meets the target.

    \b
    Examples:
      robodyn accuracy robots/meshes/bracket.stl --target 1e-6
      robodyn accuracy robots/puma560.urdf robots/puma560_sweep.csv --report accuracy.html
      robodyn accuracy robots/two_link_planar.urdf robots/two_link_planar_swing_down.toml --target 1e-8
    """
    check_names()
    scene_file = call.scene_name  # a URDF moves in a scene whose name ends in .toml, or that is given alone
    robot = len(files) == 2 or files[0].lower().endswith(options.ROBOT_SUFFIXES)
    alone = scene_file if len(files) == 1 else None
    if robot and alone:
        files, scene_file = (files[0], alone), None
    if len(files) != 1 + robot:
        refuse("give one mesh, a URDF and a trajectory, or a URDF and a scene")
    moved = robot and (alone is not None or files[1].lower().endswith(".toml"))
    around = scene_file or call.gravity or call.payloads or any(call.lookup.values())
    of_robots = "--scene, --payload, --gravity, --package-path, --xacro-arg and --trust-xacro are for robots"
    of_motions = "--duration and --traj are for a URDF and a scene, which make a motion"
    refuse_where(
        (around and not robot, of_robots),
        ((duration is not None or table is not None) and not moved, of_motions),
        (call.reading_given and (moved or not robot), f"{call.reading_given} is for the trajectory of a robot"),
    )
    if not robot:
        from robodyn.measure.accuracy.meshes import mesh_accuracy
        from robodyn.solids.mesh.read.load import load_triangles

        found = mesh_accuracy(load_triangles(files[0], typed=True))
    elif not moved:
        from robodyn.measure.accuracy.torques import file_accuracy

        found = file_accuracy(*robot_in_scene(call, files[0]), files[1], **call.reading)
    else:
        from robodyn.measure.accuracy.simulation import simulation_accuracy

        if scene_file:
            refuse(f"the scene is given twice: {files[1]} and --scene {scene_file}")
        model, scene = robot_in_scene(call, files[0], files[1], loops=True)
        check_table(call, table, scene, files[1])
        found = simulation_accuracy(model, scene, duration, table)
    sections, document = accuracy_sections(found, target), partial(accuracy_page, found, target)
    answer(call, sections, document, json=lambda: accuracy_json(found, target))
    return int(target is not None and any(ladder.cheapest(target) is None for ladder in found.ladders))
