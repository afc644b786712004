"""All planted defects of the tests as files on disk: those of the small robot and those of published ones.

Each has the description as it was and with the defect, the rule that is to name it, and the links and joints that it
is about, so that other programs can be held against it, too.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import NamedTuple
from zlib import crc32

from checks.bodies.test_other_unit import ROBOTS as OTHER_UNIT
from checks.bodies.test_other_unit import UNITS, drawn
from checks.mirror.test_planted_twins import KINDS, ROBOTS, planted
from checks.rules.test_planted_in_real import PLANTS

from helpers.example_robots import path_of
from helpers.importers import packages
from helpers.planted_defects import DEFECTS, HEALTHY
from helpers.planted_ros import texts_of, write
from helpers.planted_ros_kinds import NEIGHBOURS, PLANTED

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
