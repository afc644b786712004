"""MuJoCo and Drake on published robots: the table makes no refusal up."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.importers import answers
from helpers.robot_catalogue import FOLDER
from pinned_findings import published

from robodyn.checks.context import Context
from robodyn.checks.importers import FACTS, Verdict
from robodyn.robot.urdf.document import read

pytestmark = pytest.mark.slow
_WITHOUT = re.compile(r"<!--.*?-->|<(visual|collision)\b[^>]*/>|<(visual|collision)\b.*?</\2>", re.DOTALL)
ROBOTS = [*(path for path in published() if path.name != "ur3.urdf"), *sorted(FOLDER.glob("*.urdf"))][::3]
"""Of those that are installed and have a link."""


def as_it_is(path: Path, _: str, __: Path) -> Path:
    return path


def without_shapes(path: Path, target: str, folder: Path) -> Path:
    copy = folder / f"{target}-{ROBOTS.index(path)}.urdf"
    copy.write_text(_WITHOUT.sub("", path.read_text(encoding="utf-8")), encoding="utf-8")
    return copy


def foretold(file: Path, target: str) -> bool:
    context = Context(read(str(file)))
    facts = [fact for fact in FACTS if (fact.target, fact.verdict) == (target, Verdict.REJECTS)]
    return any(any(True for _ in fact.find(context)) for fact in facts)


@pytest.mark.parametrize("made", [as_it_is, without_shapes])
@pytest.mark.parametrize("target", ["mujoco", "drake"])
def test_refusals(target: str, made: Callable[[Path, str, Path], Path], tmp_path: Path) -> None:
    """As it is, most robots are refused for their meshes; so also without shapes."""
    files = [made(path, target, tmp_path) for path in ROBOTS]
    found = answers(target, files, ROBOTS)
    said = [foretold(file, target) for file in files]
    assert not [path for path, one, told in zip(ROBOTS, found, said, strict=True) if told and one.refused is None]
