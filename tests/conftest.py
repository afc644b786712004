"""Compiled code of the tests is kept apart from the user's."""

import os
import tempfile

import pytest


def pytest_configure(config: pytest.Config) -> None:
    folder = tempfile.TemporaryDirectory(prefix="robodyn-cache-")
    config.add_cleanup(folder.cleanup)
    os.environ["ROBODYN_CACHE"] = folder.name
