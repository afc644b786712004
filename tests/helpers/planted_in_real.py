"""Defects planted in published robots: the text of one element changed, and what must then be found that was not."""

from __future__ import annotations

import re
from collections import Counter
from functools import cache
from pathlib import Path
from typing import NamedTuple

from helpers.example_robots import path_of
from robodyn.checks.catalogue import BY_CODE
from robodyn.checks.check import check_one
from robodyn.checks.groups import deduplicate
from robodyn.checks.rule import Finding


class Plant(NamedTuple):
    """In a robot's link or joint, `old`, a pattern that is in it once, is replaced by `new`; it must be found as
    `code`, at that link or joint or at `found_at`, in words that have `words` in them."""

    code: str
    robot: str
    part: str
    old: str
    new: str
    words: str = ""
    found_at: str = ""

    @property
    def path(self) -> Path:
        return path_of(self.robot)

    @property
    def name(self) -> str:
        return self.found_at or self.part.split()[1]

    @property
    def text(self) -> str:
        return planted_text(self.path.read_text(encoding="utf-8"), self.part, self.old, self.new)


def planted_text(text: str, part: str, old: str, new: str) -> str:
    """The description with `old` replaced in a part, "link NAME" or "joint NAME"."""
    kind, name = part.split()
    elements = re.finditer(rf"<{kind}\s[^>]*?/>|<{kind}\s.*?</{kind}>", text, re.DOTALL)
    named = re.compile(rf"<{kind}\s[^>]*\bname\s*=\s*[\"']{re.escape(name)}[\"']")
    element = next(found for found in elements if named.match(found[0]) and "interface" not in found[0])
    changed, count = re.subn(old, new, element[0], flags=re.DOTALL)
    assert count == 1, f"{old} is {count} times in {part}"
    return text[: element.start()] + changed + text[element.end() :]


def fresh(plant: Plant) -> list[Finding]:
    """The findings that are there with the defect and not without it, by their code and what they are about.

    Left out is what programs make of it (RD901), which is a consequence and no other finding, and what another of them
    explains.
    """
    before = Counter(map(_key, _known(plant.path)))
    found = []
    for finding in check_one(plant.text.encode(), name=str(plant.path)):
        if before[_key(finding)]:
            before[_key(finding)] -= 1
        elif finding.code != "RD901":
            found.append(finding)
    return deduplicate(found, BY_CODE)


@cache
def _known(path: Path) -> tuple[Finding, ...]:
    return check_one(str(path))


def _key(finding: Finding) -> tuple[str, str]:
    return finding.code, finding.subject.name if finding.subject else ""
