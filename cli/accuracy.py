"""`robodyn accuracy`: what accuracy costs in time."""

from __future__ import annotations

import math

import click

from robodyn.accuracy.ladder import Accuracy
from robodyn.cli.files import check_names, robot_in_scene
from robodyn.cli.options import FORMAT, GRAVITY, SCENE, Vector
from robodyn.cli.screen import page, show
from robodyn.report.json_accuracy import accuracy_json
from robodyn.report.text_accuracy import accuracy_text


@click.command("accuracy")
@click.argument("files", nargs=-1, required=True, metavar="MESH|URDF TRAJECTORY")
@click.option("--target", type=float, metavar="ERROR", help="Name the quickest method within this relative error.")
@SCENE
@GRAVITY
@FORMAT
def command(
    files: tuple[str, ...], target: float | None, scene_file: str | None, gravity: Vector | None, form: str
) -> int:
    """True errors and times of every method, for a mesh or for the torques of a robot along a motion.
    A file named - is standard input. Exit status 1: no method meets the target.

    \b
    Examples:
      robodyn accuracy robots/meshes/bracket.stl --target 1e-6
      robodyn accuracy robots/puma560.urdf robots/puma560_sweep.csv
    """
    ctx = click.get_current_context()
    if target is not None and not (math.isfinite(target) and target > 0):
        raise click.BadParameter(f"{target:g} is no positive finite error", ctx, param_hint="'--target'")
    robot = len(files) == 2 or files[0].lower().endswith(".urdf")
    if len(files) != 1 + robot:
        raise click.UsageError("give one mesh, or a URDF and a trajectory", ctx)
    if not robot and (scene_file or gravity):
        raise click.UsageError("--scene and --gravity are for robots, not for a mesh", ctx)
    check_names([*files, scene_file], None)
    found = _of_robot(files[0], files[1], scene_file, gravity) if robot else _of_mesh(files[0])
    show(accuracy_json(found, target) if form == "json" else accuracy_text(found, target, page()))
    return int(target is not None and any(ladder.cheapest(target) is None for ladder in found.ladders))


def _of_mesh(mesh: str) -> Accuracy:
    from robodyn.accuracy.mesh_ladder import mesh_accuracy
    from robodyn.mesh.load import load_triangles

    return mesh_accuracy(load_triangles(mesh))


def _of_robot(urdf: str, trajectory: str, scene_file: str | None, gravity: Vector | None) -> Accuracy:
    from robodyn.accuracy.torque_ladder import file_accuracy

    return file_accuracy(*robot_in_scene(urdf, scene_file, gravity), trajectory)
