"""The robots of example-robot-data as tests of dynamics need them."""

from __future__ import annotations

import importlib.metadata
from functools import cache
from pathlib import Path

from robodyn.assemble import load

REFUSED = {
    "alex_psyonic_hands.urdf": "a mimic joint follows a joint that does not exist",
    "ur3.urdf": "an empty <robot>",
}
"""Files that no reader can use, and why."""


def all_paths():
    files = importlib.metadata.files("example-robot-data") or []
    return sorted(Path(str(file.locate())) for file in files if file.suffix == ".urdf")


PATHS = [path for path in all_paths() if path.name not in REFUSED]


def path_of(stem):
    return next(path for path in PATHS if path.stem == stem)


@cache
def real(stem, moving_base=False):
    return load(path_of(stem), moving_base=moving_base)
