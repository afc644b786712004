"""Things kept in a cache, and the files that hold them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from robodyn.support.cache import Key

KEY, OTHER = Key("a program", "a machine"), Key("another program", "a machine")
CONTENT = bytes(range(256)) * 20
posix = pytest.mark.skipif(os.name == "nt", reason="owners, permissions, links and pipes are those of POSIX")


def files(folder):
    return sorted(path for path in Path(folder).rglob("*") if path.is_file())


def the_file(folder):
    (path,) = files(folder)
    return path
