"""What `robodyn check` and simcheck make of planted defects, by the same measure.

What counts is what is said with the defect and not without it, whatever the numbers in it. A defect is *named* where
the rule that it is planted for finds it, or where simcheck has words for it (`simcheck_words`); there is *something*
where there is a warning or an error of another kind at the link or joint or at a neighbour of it, or a refusal.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path

from helpers.planted_everywhere import SMALL_ROBOT, Case
from helpers.simcheck import Verdict, unnumbered, verdicts
from helpers.simcheck_words import precise
from helpers.urdfdom import refused
from robodyn.checks.check import Options, check_one
from robodyn.checks.rule import Finding, Severity

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
