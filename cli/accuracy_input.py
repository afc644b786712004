"""What the files given to `robodyn accuracy` ask for."""

from __future__ import annotations

from collections.abc import Sequence

import click

from robodyn.cli.files import check_table, robot_in_scene
from robodyn.cli.options import ROBOT_SUFFIXES, Vector, lookup, payloads
from robodyn.cli.reading_options import given, reading
from robodyn.measure.accuracy.ladder import Accuracy


def accuracy_of(
    files: Sequence[str], scene_file: str | None, gravity: Vector | None, duration: float | None, table: str | None
) -> Accuracy:
    """What accuracy costs: of one mesh; or of a URDF along a trajectory, or in a scene whose name ends in .toml or that
    is given alone."""
    ctx = click.get_current_context()
    robot = len(files) == 2 or files[0].lower().endswith(ROBOT_SUFFIXES)
    alone = scene_file if len(files) == 1 else None
    if robot and alone:
        files, scene_file = (files[0], alone), None
    if len(files) != 1 + robot:
        raise click.UsageError("give one mesh, a URDF and a trajectory, or a URDF and a scene", ctx)
    if not robot and (scene_file or gravity or payloads() or any(lookup().values())):
        raise click.UsageError("--scene, --payload, --gravity, --package-path and --xacro-arg are for robots", ctx)
    moved = robot and (alone is not None or files[1].lower().endswith(".toml"))
    if (duration is not None or table is not None) and not moved:
        raise click.UsageError("--duration and --traj are for a URDF and a scene, which make a motion", ctx)
    if given() and (moved or not robot):
        raise click.UsageError(f"{given()} is for the trajectory of a robot", ctx)
    if not robot:
        return _of_mesh(files[0])
    if not moved:
        return _of_torques(files[0], files[1], scene_file, gravity)
    if scene_file:
        raise click.UsageError(f"the scene is given twice: {files[1]} and --scene {scene_file}", ctx)
    return _of_motion(files[0], files[1], gravity, duration, table)


def _of_mesh(mesh: str) -> Accuracy:
    from robodyn.measure.accuracy.mesh_ladder import mesh_accuracy
    from robodyn.solids.mesh.load import load_triangles

    return mesh_accuracy(load_triangles(mesh))


def _of_torques(urdf: str, trajectory: str, scene_file: str | None, gravity: Vector | None) -> Accuracy:
    from robodyn.measure.accuracy.torque_ladder import file_accuracy

    return file_accuracy(*robot_in_scene(urdf, scene_file, gravity), trajectory, **reading())


def _of_motion(
    urdf: str, scene_file: str, gravity: Vector | None, duration: float | None, table: str | None
) -> Accuracy:
    from robodyn.measure.accuracy.simulation_ladder import simulation_accuracy

    model, scene = robot_in_scene(urdf, scene_file, gravity, loops=True)
    check_table(table, scene, scene_file)
    return simulation_accuracy(model, scene, duration, table)
