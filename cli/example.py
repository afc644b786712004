"""`robodyn torques --example`: a motion to begin with, as a file."""

from __future__ import annotations

import os

import click

from robodyn.cli.files import STANDARD_INPUT
from robodyn.errors import InputError
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene


def write_example(path: str, model: Model, scene: Scene) -> None:
    """Write an example motion of a robot to a file that is not there yet; warn of limits that no example keeps.

    Raises:
        InputError: the file is there, or cannot be written.
    """
    from robodyn.loads.example_motion import example_motion, overloaded
    from robodyn.trajectory.write import open_writer

    if path == STANDARD_INPUT or os.path.lexists(path):
        what = "--example writes a new file, and this one is there already"
        raise InputError(what, remedy="leave --example out, or name another file", file=path)
    names, time, columns = example_motion(model, scene)
    with open_writer(path, names) as writer:
        writer.write(time, columns)
    for line in overloaded(model, scene, columns):
        click.echo(f"warning: {line}", err=True)
