"""The scenes of robots/ as plain dictionaries."""

from __future__ import annotations

import sys
from typing import Any

from helpers.robot_files import FOLDER

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


def read_scene(name: str) -> dict[str, Any]:
    return tomllib.loads((FOLDER / f"{name}.toml").read_text())
