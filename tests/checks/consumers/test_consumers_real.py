"""Whether MuJoCo and Drake take published robots as RD901 says: no refusal unforetold, none made up."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.consumers import Answer, answers, resolved
from helpers.robot_catalogue import FOLDER
from pinned_findings import published

from robodyn.checks.check import Options, check_one
from robodyn.checks.consumers.water import invented
from robodyn.checks.context import Asked, Context
from robodyn.robot.urdf.document import read
from robodyn.robot.urdf.packages import Search

pytestmark = pytest.mark.slow
_WITHOUT = re.compile(r"<!--.*?-->|<(visual|collision)\b[^>]*/>|<(visual|collision)\b.*?</\2>", re.DOTALL)
_MESH = re.compile(r"""<mesh\b[^>]*?filename\s*=\s*["'](.*?)["']""")
ROBOTS = [*(path for path in published() if path.name != "ur3.urdf"), *sorted(FOLDER.glob("*.urdf"))]
"""All that are installed and have a link."""


def with_new_meshes() -> list[Path]:
    """Return the robots that have a mesh that none before them has."""
    seen, found = set[Path | None](), []
    for path in ROBOTS:
        search = Search(str(path), ())
        meshes = {search.find(name) for name in _MESH.findall(path.read_text(encoding="utf-8"))}
        if not meshes <= seen:
            found.append(path)
        seen |= meshes
    return found


def as_it_is(path: Path, _: str, __: Path) -> Path:
    return path


def without_shapes(path: Path, target: str, folder: Path) -> Path:
    copy = folder / f"{target}-{ROBOTS.index(path)}.urdf"
    copy.write_text(_WITHOUT.sub("", path.read_text(encoding="utf-8")), encoding="utf-8")
    return copy


def foretold(file: Path, target: str) -> bool:
    """Whether RD901 says that a program rejects it."""
    (one,) = check_one(str(file), Options(select=("RD901",), asked=Asked(targets=(target,))))
    return one.message.startswith(f"{target} rejects it")


@pytest.mark.parametrize("made", [as_it_is, without_shapes, resolved], ids=["as it is", "no shapes", "meshes found"])
@pytest.mark.parametrize("target", ["mujoco", "drake"])
def test_refusals(target: str, made: Callable[[Path, str, Path], Path], tmp_path: Path) -> None:
    """As it is, most robots are refused for their meshes; so also without shapes, and with meshes that can be read."""
    robots = with_new_meshes() if made is resolved else ROBOTS
    files = [made(path, target, tmp_path) for path in robots]
    found = answers(target, files, robots)
    said = [foretold(file, target) for file in files]
    table = Counter(zip(said, (one.refused is not None for one in found), strict=True))
    print(f"{target}: {table[True, True]} refusals foretold, {table[False, False]} taken")
    wrong = [
        f"{path}: {one.refused}"
        for path, one, told in zip(robots, found, said, strict=True)
        if told is not bool(one.refused)
    ]
    assert not wrong, "\n".join(wrong)
    if target == "mujoco":
        weigh(files, found)


def weigh(files: list[Path], found: list[Answer]) -> None:
    """Hold the masses that MuJoCo makes up for bodies of one link against what is said of them."""
    for file, one in zip(files, found, strict=True):
        context = Context(read(str(file)))
        for name, mass in context.once(invented).items() if one.masses else ():
            if len(context.tree.group[name].links) == 1 and one.masses is not None:
                assert mass == pytest.approx(one.masses[name], rel=1e-5), (file, name)
