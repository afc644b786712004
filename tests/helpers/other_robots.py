"""The robots of icub-models and jvrc-description, which the test extra installs."""

from __future__ import annotations

import importlib.metadata
from pathlib import Path

PACKAGES = ("icub-models", "jvrc-description")


def other_paths() -> list[Path]:
    """Their descriptions; none of a package that is not installed."""
    found = []
    for package in PACKAGES:
        try:
            files = importlib.metadata.files(package) or []
        except importlib.metadata.PackageNotFoundError:
            continue
        found += [Path(str(file.locate())).resolve() for file in files if file.suffix == ".urdf"]
    return sorted(found)
