"""What urdfdom refuses is an error: planted slips, random ones in published robots, and these as they are."""

from __future__ import annotations

import importlib.metadata
import os
import random
import re
import subprocess
from pathlib import Path

import pytest
from helpers.example_robots import path_of
from helpers.planted_defects import HEALTHY
from helpers.sampled import sampled
from pinned_findings import name_of, published

from robodyn.checks.rule import Severity
from robodyn.checks.run import Options, check_one

PATIENCE = 10.0
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


@pytest.fixture(scope="module")
def check_urdf() -> list[str]:
    """The program, with the folder of its libraries."""
    try:
        files = importlib.metadata.files("cmeel-urdfdom") or []
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("urdfdom is not installed")
    (program,) = (
        Path(str(file.locate())).resolve()
        for file in files
        if file.name == "check_urdf" and "cmeel.prefix" in str(file)
    )
    return [str(program), str(program.parents[1] / "lib")]


def refused(check_urdf: list[str], file: Path) -> bool:
    program, libraries = check_urdf
    environment = {**os.environ, "LD_LIBRARY_PATH": libraries}
    done = subprocess.run([program, str(file)], env=environment, capture_output=True, timeout=PATIENCE, check=False)
    return done.returncode != 0


def has_errors(file: Path) -> bool:
    return any(one.severity is Severity.ERROR for one in check_one(str(file), Options(ignore=("RD901",))))


@pytest.mark.parametrize(("old", "new"), SLIPS)
def test_slips(check_urdf: list[str], tmp_path: Path, old: str, new: str) -> None:
    file = tmp_path / "picker.urdf"
    file.write_text(HEALTHY.replace(old, new, 1), encoding="utf-8")
    assert refused(check_urdf, file)
    assert has_errors(file)


@pytest.mark.parametrize("path", sampled(published()), ids=name_of)
def test_published_robots(check_urdf: list[str], path: Path) -> None:
    assert not refused(check_urdf, path) or has_errors(path)


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
def test_random_slips_in_published_robots(check_urdf: list[str], tmp_path: Path, stem: str) -> None:
    chance, file, refusals = random.Random(stem), tmp_path / f"{stem}.urdf", 0
    text = re.sub(r"<!--.*?-->", "", path_of(stem).read_text(encoding="utf-8"), flags=re.DOTALL)
    for _ in range(120):
        changed = slip(text, chance)
        file.write_text(changed, encoding="utf-8")
        if refused(check_urdf, file):
            refusals += 1
            assert has_errors(file), changed
    assert refusals > 10
