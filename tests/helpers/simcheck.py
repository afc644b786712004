"""simcheck, where its command is on the path: what it finds in descriptions, and in which time.

It is no dependency of the tests: benchmarks hold it beside `robodyn check`. With SIMCHECK_CACHE set to a folder it
keeps there what it found, so that a long comparison goes on where it was ended; timings never use it.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

STATIC = ("--static-only",)
ABSENT = (
    "simcheck is not installed: its columns are missing (pip install simcheck mujoco pybullet, and put it on PATH).\n"
)


def unnumbered(text: str) -> str:
    """Return what a message says, whatever the numbers."""
    return re.sub(r"\d[\d.e+-]*", "#", text)


class Said(NamedTuple):
    """One finding."""

    check: str
    severity: str
    target: str
    message: str

    @property
    def words(self) -> str:
        return f"{self.check}: {self.message}"

    @property
    def key(self) -> str:
        """What it says, whatever the numbers."""
        return unnumbered(f"{self.severity} {self.target} {self.words}")

    def names(self, names: frozenset[str]) -> bool:
        return bool(names & {*self.target.split("|"), *re.findall(r"'([^']+)'", self.message)})


class Verdict(NamedTuple):
    """What it says of a file, and how long it took [s]."""

    said: tuple[Said, ...]
    seconds: float

    def count(self, severity: str) -> int:
        return sum(one.severity == severity for one in self.said)


def command() -> str | None:
    return shutil.which("simcheck")


def version() -> str:
    """Its version and its engines', as it prints them."""
    tool = command()
    if tool is None:
        return ABSENT
    lines = subprocess.run([tool, "doctor"], capture_output=True, text=True, check=False).stdout.splitlines()
    engines = [" ".join(line.split()[:2]) for line in lines if line.endswith("(engine)")]
    return f"{lines[0]} with {' and '.join(engines) or 'no engine'}"


def verdicts(
    files: Sequence[Path], *options: str, packages: Mapping[str, str] | None = None, timed: bool = False
) -> dict[Path, Verdict]:
    """Return its verdicts, of one process for all files. A file that it says nothing of is missing."""
    tool, kept = command(), os.environ.get("SIMCHECK_CACHE")
    assert tool is not None
    given = [f"--package-path={name}={folder}" for name, folder in (packages or {}).items()]
    cache = [f"--cache={kept}"] if kept and not timed else ["--no-cache"]
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        fixed = [tool, "check", "--no-config", "--jobs=1", "--quiet", "--json", str(report)]
        done = subprocess.run(
            [*fixed, *cache, *given, *options, "--", *map(str, files)], capture_output=True, text=True, check=False
        )
        if not report.exists():
            raise RuntimeError(f"simcheck failed: {done.stderr[-300:]}")
        assets = json.loads(report.read_text(encoding="utf-8"))
    listed = assets if isinstance(assets, list) else [assets]
    return {Path(asset["asset"]): _verdict(asset) for asset in listed}


def _verdict(asset: Mapping[str, object]) -> Verdict:
    results, stats = asset["results"], asset["stats"]
    assert isinstance(results, list)
    assert isinstance(stats, dict)
    said = [
        Said(one["check"], one["severity"], one["target"], one["message"])
        for result in results
        for one in result["findings"]
    ]
    return Verdict(tuple(said), float(stats["seconds"]))
