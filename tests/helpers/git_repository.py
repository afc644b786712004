"""Repositories of git in folders of tests."""

from __future__ import annotations

import subprocess
from pathlib import Path


def git(folder: Path, *words: str) -> str:
    identity = ("-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false")
    return subprocess.run(["git", *identity, *words], cwd=folder, check=True, capture_output=True, text=True).stdout


def committed(folder: Path) -> str:
    """Commit what is in a folder, in a repository of its own; the commit."""
    for words in (("init", "-q"), ("add", "."), ("commit", "-qm", "base")):
        git(folder, *words)
    return git(folder, "rev-parse", "HEAD").strip()
