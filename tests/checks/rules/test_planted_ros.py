"""Defects of what ROS reads, planted in published robots: each is found by its rule, and nothing else is."""

from __future__ import annotations

from collections import Counter
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from helpers.example_robots import path_of
from helpers.planted_ros import Edit, Texts, texts_of, write
from helpers.planted_ros_kinds import ARMS, FOLLOWERS, FOLLOWING, HEALTHY, NEIGHBOURS, PLANTED, Planted
from helpers.sampled import sampled

from robodyn.checks.check import Options, check_one
from robodyn.checks.rule import Finding

CASES = [pytest.param(each, stem, id=f"{each.kind}-{stem}") for each in PLANTED for stem in each.robots]
SOUND = [
    *((edit, stem) for edit in HEALTHY for stem in ARMS),
    *((edit, stem) for edit in FOLLOWING for stem in FOLLOWERS),
]


OPTIONS = Options(ignore=("RD901",))
"""Without what single programs make of it."""


def found(texts: Texts, options: Options = OPTIONS) -> tuple[Finding, ...]:
    with TemporaryDirectory() as folder:
        return check_one(str(write(Path(folder), texts)), options)


@cache
def codes(stem: str) -> Counter[str]:
    return Counter(one.code for one in found(texts_of(stem)))


@pytest.mark.parametrize(("planted", "stem"), sampled(CASES, 9))
def test_found_once_and_nothing_else(planted: Planted, stem: str) -> None:
    texts = planted.edit(*texts_of(stem))
    assert texts != texts_of(stem)
    new = found(texts)
    assert Counter(one.code for one in new) - codes(stem) == {planted.code: 1}


@pytest.mark.parametrize(("edit", "stem"), sampled([pytest.param(*each) for each in SOUND], 6))
def test_what_is_sound_stays_unfound(edit: Edit, stem: str) -> None:
    assert not Counter(one.code for one in found(edit(*texts_of(stem)))) - codes(stem)


@pytest.mark.parametrize("stem", sampled(NEIGHBOURS.robots, 4))
def test_neighbours_that_touch(stem: str) -> None:
    """Where their meshes are is said: what touches is known by these."""
    options = Options(select=("RD709",), package_path=(str(path_of(stem).parents[4]),))
    assert not found(texts_of(stem), options)
    (one,) = found(NEIGHBOURS.edit(*texts_of(stem)), options)
    assert one.file.endswith(".srdf")


def test_each_kind_is_planted_in_three_robots() -> None:
    kinds = (*PLANTED, NEIGHBOURS)
    assert len({each.kind for each in kinds}) == len(kinds) >= 40
    assert all(len(set(each.robots)) >= 3 for each in kinds)
