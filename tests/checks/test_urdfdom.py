"""What urdfdom refuses is an error: planted slips, random ones in published robots, and these as they are."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest
from helpers.example_robots import path_of
from helpers.planted_defects import HEALTHY
from helpers.sampled import sampled
from helpers.urdfdom import check_urdf, refused
from pinned_findings import name_of, published

from robodyn.checks.check import Options, check_one
from robodyn.checks.rule import Severity

SLIPS = (
    ('<robot name="picker">', '<robot name="picker" version="2.0">'),
    ('<robot name="picker">', '<robot name="picker" version="1">'),
    ('<robot name="picker">', '<robot name="picker">' + 2 * '<material name="red"><color rgba="1 0 0 1"/></material>'),
    ('effort="120" ', ""),
    (' velocity="3"', ""),
    ('<joint name="mount" type="fixed">', '<joint name="mount" type="fixed"><limit effort="1"/>'),
    (' k_velocity="10"', ""),
    ('<dynamics damping="0.4" friction="0.6"/>', "<dynamics/>"),
    ('<mimic joint="grip" ', "<mimic "),
    ('xyz="0.05 0 0.02"', 'xyz="0.05\u00a00 0.02"'),
    ("<child link=", "<offspring link="),
    ('name="lens"/>', 'name=" lens"/>'),
    ('<limit lower="-2.9" upper="2.8" effort="120" velocity="2.5"/>', ""),
)


pytestmark = pytest.mark.skipif(check_urdf() is None, reason="urdfdom is not installed")


def has_errors(file: Path) -> bool:
    return any(one.severity is Severity.ERROR for one in check_one(str(file), Options(ignore=("RD901",))))


@pytest.mark.parametrize(("old", "new"), SLIPS)
def test_slips(tmp_path: Path, old: str, new: str) -> None:
    file = tmp_path / "picker.urdf"
    file.write_text(HEALTHY.replace(old, new, 1), encoding="utf-8")
    assert refused(file)
    assert has_errors(file)


@pytest.mark.parametrize("path", sampled(published()), ids=name_of)
def test_published_robots(path: Path) -> None:
    assert not refused(path) or has_errors(path)


def slip(text: str, chance: random.Random) -> str:
    """The text with an attribute or an element deleted, an element twice, or a value that is another."""
    start = text.index("<robot")
    if chance.random() < 0.4:
        element = chance.choice(list(re.finditer(r"<\w+\b[^<>]*/>", text)))
        return text[: element.start()] + element[0] * chance.choice((0, 2)) + text[element.end() :]
    found = chance.choice(list(re.finditer(r'\s(\w+)="[^"]*"', text[start:])))
    value = chance.choice(("", "x", "1 2", "-1", "0", "nan", "1,5"))
    new = chance.choice(("", f' {found[1]}="{value}"'))
    return text[: start + found.start()] + new + text[start + found.end() :]


@pytest.mark.parametrize("stem", ["z1", "panda", "a1"])
def test_random_slips_in_published_robots(tmp_path: Path, stem: str) -> None:
    chance, file, refusals = random.Random(stem), tmp_path / f"{stem}.urdf", 0
    text = re.sub(r"<!--.*?-->", "", path_of(stem).read_text(encoding="utf-8"), flags=re.DOTALL)
    for _ in range(120):
        changed = slip(text, chance)
        file.write_text(changed, encoding="utf-8")
        if refused(file):
            refusals += 1
            assert has_errors(file), changed
    assert refusals > 10
