"""`robodyn torques --example`: a motion to begin with, as a file."""

from __future__ import annotations

import os

from robodyn.cli.files import STANDARD_INPUT
from robodyn.errors import InputError
from robodyn.model import Model


def write_example(path: str, model: Model) -> None:
    """Write an example motion of a robot to a file that is not there yet.

    Raises:
        InputError: the file is there, or cannot be written.
    """
    from robodyn.example_motion import example_motion
    from robodyn.trajectory.write import open_writer

    if path == STANDARD_INPUT or os.path.lexists(path):
        what = "--example writes a new file, and this one is there already"
        raise InputError(what, remedy="leave --example out, or name another file", file=path)
    names, time, columns = example_motion(model)
    with open_writer(path, names) as writer:
        writer.write(time, columns)
