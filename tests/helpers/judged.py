"""What `robodyn check` and simcheck make of all planted defects of the tests, by the same measure.

What counts is what is said with the defect and not without it, whatever the numbers in it. A defect is *named* where
the rule that it is planted for finds it, or where simcheck has words for it; there is *something* where there is a
warning or an error of another kind at the link or joint or at a neighbour of it, or a refusal.
"""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from itertools import islice
from pathlib import Path
from typing import NamedTuple
from zlib import crc32

from checks.mirror.test_planted_twins import KINDS, ROBOTS, planted
from checks.rules.test_planted_in_real import OTHER_UNIT, PLANTS, UNITS, drawn

from helpers.example_robots import path_of
from helpers.importers import packages
from helpers.planted_defects import DEFECTS, HEALTHY
from helpers.planted_ros import NEIGHBOURS, PLANTED, texts_of, write
from helpers.simcheck import Verdict, precise, unnumbered, verdicts
from helpers.urdfdom import refused
from robodyn.checks.check import Options, check_one
from robodyn.checks.rule import Finding, Severity

ELEMENT = re.compile(r"<(link|joint)\s[^>]*?/>|<(link|joint)\s.*?</\2>", re.DOTALL)
NAME = re.compile(r"\bname\s*=\s*[\"']([^\"']*)[\"']")
ENDS = re.compile(r"<(?:parent|child)\s[^>]*\blink\s*=\s*[\"']([^\"']*)[\"']")
SMALL_ROBOT = "small robot"
UNREAD = "${not read}"
"""Stands in the small robot where nobody reads it; other programs take the file for a xacro by it."""


class Case(NamedTuple):
    """A defect planted in a robot, and its rule: the texts of description and SRDF before and after."""

    code: str
    robot: str
    before: tuple[str, str]
    after: tuple[str, str]
    packages: tuple[tuple[str, str], ...] = ()

    @property
    def about(self) -> frozenset[str]:
        """Names of the links and joints whose text is another, of the links that such a joint joins, and of the joints
        at such a link; empty if it is about none."""
        old, new = elements(self.before[0]), elements(self.after[0])
        changed = {name for name in old.keys() | new.keys() if old.get(name) != new.get(name)}
        ends = {name: ENDS.findall(old.get(name, "") + new.get(name, "")) for name in old.keys() | new.keys()}
        near = {one for name in changed for one in ends[name]}
        beside = {name for name, links in ends.items() if changed.intersection(links)}
        return frozenset(changed | near | beside)


def elements(text: str) -> dict[str, str]:
    """Return the texts of links and joints by name."""
    found: dict[str, str] = {}
    for element in ELEMENT.finditer(text):
        name = NAME.search(element[0])
        found[name[1] if name else ""] = found.get(name[1] if name else "", "") + element[0]
    return found


def small() -> Iterator[Case]:
    """Those of the small robot, which needs no other files."""
    before = HEALTHY.replace(UNREAD, "not read")
    for defect in DEFECTS:
        yield Case(defect.code, SMALL_ROBOT, (before, ""), (defect.text.replace(UNREAD, "not read"), ""))


def real() -> Iterator[Case]:
    """Those of links, joints and masses, of all lengths, of twins, and of what ROS reads, in published robots."""
    for plant in PLANTS:
        before = plant.path.read_text(encoding="utf-8")
        yield Case(plant.code, plant.robot, (before, ""), (plant.text, ""), _packages(plant.robot))
    for robot in OTHER_UNIT:
        before = path_of(robot).read_text(encoding="utf-8")
        for times in UNITS:
            yield Case("RD113", robot, (before, ""), (drawn(before, times), ""), _packages(robot))
    for kind, code in KINDS.items():
        for robot in ROBOTS:
            before = path_of(robot).read_text(encoding="utf-8")
            for _, text in islice(planted(robot, kind), 1):
                yield Case(code, robot, (before, ""), (text.decode(), ""), _packages(robot))
    for each in (*PLANTED, NEIGHBOURS):
        for robot in each.robots:
            texts = texts_of(robot)
            yield Case(each.code, robot, texts, each.edit(*texts), _packages(robot))


def _packages(robot: str) -> tuple[tuple[str, str], ...]:
    return tuple(packages(path_of(robot)).items())


def files(case: Case, folder: Path) -> tuple[Path, Path]:
    """Write the case's files, and return the paths of the description before and after."""
    names = (f"{case.robot}-{crc32(''.join(texts).encode()):08x}" for texts in (case.before, case.after))
    before, after = (write(folder / name, texts) for name, texts in zip(names, (case.before, case.after), strict=True))
    return before, after


NAMED, SOMETHING, SILENT = "named", "something", "silent"
VERDICTS = (NAMED, SOMETHING, SILENT)
Paths = tuple[Path, Path]
"""A description as it was, and with a defect."""


@cache
def _known(path: Path, packages: tuple[str, ...]) -> Counter[tuple[str, ...]]:
    return Counter(map(_key, check_one(str(path), Options(package_path=packages))))


def _key(one: Finding) -> tuple[str, ...]:
    return one.code, one.subject.name if one.subject else "", unnumbered(one.message)


def by_robodyn(case: Case, paths: Paths) -> str:
    """Judge all that it finds, remarks among it."""
    packages = tuple(str(Path(folder).parent) for _, folder in case.packages)
    found = check_one(str(paths[1]), Options(package_path=packages))
    fresh = Counter(map(_key, found)) - _known(paths[0], packages)
    if any(code == case.code for code, *_ in fresh):
        return NAMED
    about, worse = case.about, {_key(one) for one in found if one.severity is not Severity.NOTE}
    return SOMETHING if any(not about or key[1] in about for key in worse & fresh.keys()) else SILENT


def of_simcheck(case: Case, before: Verdict, after: Verdict) -> str:
    """Judge all that it says, remarks among it."""
    known, about = {one.key for one in before.said}, case.about
    fresh = [one for one in after.said if one.key not in known]
    placed = [one for one in fresh if not about or not one.target or one.names(about)]
    if any(precise(case.code, one.words) for one in placed):
        return NAMED
    return SOMETHING if any(one.severity != "info" for one in placed) else SILENT


def by_simcheck(cases: Sequence[Case], paths: Sequence[Paths], which: Iterable[int], *options: str) -> dict[int, str]:
    """Return what it makes of these of the cases, by their numbers; one process for each robot."""
    judged: dict[int, str] = {}
    by_robot: dict[str, list[int]] = {}
    for k in which:
        by_robot.setdefault(cases[k].robot, []).append(k)
    for robot, numbers in by_robot.items():
        wanted = dict.fromkeys(path for k in numbers for path in paths[k])
        found = verdicts([*wanted], *options, packages=dict(cases[numbers[0]].packages))
        judged.update({k: of_simcheck(cases[k], *(found[path] for path in paths[k])) for k in numbers})
        print("simcheck", *options, robot, len(numbers), file=sys.stderr, flush=True)
    return judged


def by_check_urdf(paths: Paths) -> str:
    """Judge urdfdom's program: it reads up to a fault, and refuses the file or takes it."""
    return SOMETHING if refused(paths[1]) and not refused(paths[0]) else SILENT


def of_robots(cases: Sequence[Case], robots: Sequence[str] = ()) -> list[int]:
    """Return the numbers of those in the small robot, and in these published ones."""
    return [k for k, case in enumerate(cases) if case.robot in (SMALL_ROBOT, *robots)]
