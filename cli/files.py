"""Files that are named on the command line; `-` is standard input."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from robodyn.cli.options import ROBOT_SUFFIXES, gravity, kept_value, lookup, payloads, scene_name, scene_names
from robodyn.cli.outputs import check_outputs, inputs_of
from robodyn.errors import InputError, SceneError
from robodyn.support.input_file import read_standard_input

if TYPE_CHECKING:
    from robodyn.robot.model import Model
    from robodyn.robot.urdf.parts import Description
    from robodyn.scene.scene import Scene

STANDARD_INPUT = "-"
ROBOT, TABLE, SCENE_FILE = "a robot description", "a table", "a scene"
_KINDS = {
    ROBOT: ROBOT_SUFFIXES,
    TABLE: (".csv", ".tsv", ".parquet", ".pq", ".npz", ".db3", ".mcap", ".bag"),
    SCENE_FILE: (".toml",),
    "a mesh": (".stl", ".obj", ".ply", ".off", ".dae", ".glb", ".gltf", ".3mf"),
}
"""What files are, by suffixes that only such files have."""


def robot_in_scene(
    urdf: str, scene_file: str | None = None, *, loops: bool = False, contacts: bool = False
) -> tuple[Model, Scene]:
    """Return the robot of a URDF or xacro file, and the scene that the options of `SCENE` and `BASE_HELD` make.

    The loops that the description closes are among those of the scene.

    Args:
        scene_file: in place of --scene.
        loops, contacts: whether the scene may have some.
    """
    from robodyn.robot.load import load
    from robodyn.scene.described_loops import scene_of
    from robodyn.scene.fit import check_scene, known, refuse_constraints
    from robodyn.scene.scene import DEFAULT

    files = scene_names() if scene_file in (None, scene_name()) else (scene_file,)
    scene_file = scene_file or scene_name()
    scene = _scene(files) if files else DEFAULT
    scene = scene.changed(gravity(), held=kept_value("base_held", False))
    model = load(robot_source(urdf), moving_base=scene.moving_base, **lookup())
    scene = scene_of(model, scene)
    check_scene(scene, model, scene_file)
    for payload in payloads():
        known("--payload", "link", payload.link, model.links)
    scene = scene.changed(payloads=payloads())
    refuse_constraints(scene, scene_file, loops=loops, contacts=contacts)
    return model, scene


def check_table(table: str | None, scene: Scene, scene_file: str | None = None) -> None:
    """Raise if a table is given for a simulation and no scene names a column of it."""
    if table is None or scene.table_columns:
        return
    scene_file = scene_file or scene_name()
    remedy = 'e.g. drive.elbow = { kp = 100, kd = 10, reference = "q_elbow" }'
    if scene_file is None:
        what, remedy = f"no scene says what the columns of {table} drive", f"give --scene FILE.toml, with {remedy}"
        raise InputError(what, remedy=remedy)
    raise SceneError(f"no column of {table} is named, so that it drives nothing", remedy=remedy, file=scene_file)


def described(urdf: str) -> Description:
    """Return the description in a URDF or xacro file."""
    from robodyn.robot.urdf.description import load_description

    return load_description(robot_source(urdf), **lookup())


def robot_source(urdf: str) -> str | bytes:
    """Return what describes a robot: the name of a file, or what is on standard input.

    Raises:
        InputError: by its suffix the file is of another kind.
    """
    expect(ROBOT, urdf)
    return source_of(urdf)


def source_of(urdf: str) -> str | bytes:
    """Return the name of a file, or what is on standard input."""
    return read_standard_input() if urdf == STANDARD_INPUT else urdf


def check_names(*writes: str) -> None:
    """Raise if standard input is asked for twice or is not there, or an output is an input or no file of ours.

    Args:
        writes: as for `check_outputs`.
    """
    ctx = click.get_current_context()
    files = inputs_of(ctx)
    if files.count(STANDARD_INPUT) > 1:
        raise InputError("standard input is asked for twice", remedy="name a file for one of them", file="<stdin>")
    if STANDARD_INPUT in files and sys.stdin is None:
        raise InputError("standard input is closed", remedy="name a file, or pipe one in", file="<stdin>")
    check_outputs(ctx, writes)


def _scene(paths: Sequence[str]) -> Scene:
    from robodyn.scene.read import load_scene, parse_scene

    for path in paths:
        expect(SCENE_FILE, path)
    if STANDARD_INPUT not in paths:
        return load_scene(*paths)
    if len(paths) > 1:
        raise InputError("one of several scenes cannot be standard input", remedy="name a file", file="<stdin>")
    return parse_scene(read_standard_input(), "<stdin>")


def expect(kind: str, path: str) -> None:
    """Raise if a file is of another kind by its suffix: arguments are swapped, or an option is missing."""
    found = next((other for other, suffixes in _KINDS.items() if path.lower().endswith(suffixes)), kind)
    ctx = click.get_current_context(silent=True)
    if found == kind or ctx is None:
        return
    values = [ctx.params.get(each.name or "") for each in ctx.command.params if isinstance(each, click.Argument)]
    given = [word for value in values for word in (value if isinstance(value, tuple) else (value,))]
    right = [word for word in given if isinstance(word, str) and word.lower().endswith(_KINDS[kind])]
    order = " ".join([ctx.command_path, *(piece for piece in ctx.command.collect_usage_pieces(ctx) if piece[0] != "[")])
    remedy = "robodyn scene init URDF writes one" if kind == SCENE_FILE else f"the order: {order}"
    swapped = f"is it swapped with {right[0]}? " if right else ""
    raise InputError(f"this is {found}, and {kind} is expected here", remedy=swapped + remedy, file=path)
