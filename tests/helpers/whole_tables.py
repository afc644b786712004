"""Trajectories read whole."""

from __future__ import annotations

import os
from typing import Any

from robodyn.trajectory.columns.signals import Signals
from robodyn.trajectory.motion import Trajectory, join
from robodyn.trajectory.read import open_trajectory


def read_trajectory(path: str | os.PathLike[str], signals: Signals, **options: Any) -> Trajectory:
    """The whole trajectory in a file at once; arguments and errors as of `open_trajectory`."""
    with open_trajectory(path, signals, **options) as reader:
        return join(list(reader.blocks()))
