"""README.md says what the software does: its examples run, its tables and its reference are complete and up to date."""

from __future__ import annotations

import re

import pytest
from benchmarks import bench_executors
from helpers.markdown_tables import cells
from helpers.readme_examples import ELSEWHERE, ROOT, blocks, commands, regenerated, same
from helpers.readme_tables import TIMED, steady_tables
from make_readme import README, tables_in

from robodyn.errors import SceneError
from robodyn.scene.read import parse_scene

TEXT = README.read_text(encoding="utf-8")
ADVICE = "run: python tests/make_readme.py"
TABLES_OF_SCENE = (
    "KEY",
    "[friction]\nj = {KEY}",
    "[rotor]\nj = {inertia = 1, KEY}",
    "[spring]\nj = {stiffness = 1, KEY}",
    '[[payload]]\nlink = "l"\nmass = 1\nKEY',
    '[[wrench]]\nlink = "l"\nKEY',
    "[fluid]\ndensity = 1\nKEY",
    '[fluid]\ndensity = 1\n[[fluid.link]]\nlink = "l"\nKEY',
    "[base]\nKEY",
    "[motor]\nj = {KEY}",
)


def test_every_example_prints_what_is_shown(tmp_path):
    now = regenerated(TEXT, tmp_path)
    for language in ("console", "pycon"):
        for shown, found in zip(blocks(TEXT, language), blocks(now, language), strict=True):
            assert same(found, shown), f"{ADVICE}\n{found}"


def test_every_block_shows_something():
    for block in blocks(TEXT, "console"):
        silent = block.replace("$ ", "")
        for command in commands(block):
            silent = silent.replace(command, "", 1)
        assert silent.strip(), block


def test_what_is_not_run_here_is_run_by_ci():
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert re.search(r'^pip install .*"\.\[test\]"$', script, re.MULTILINE)
    assert re.search(r'^ .* pytest "\$@" >', script, re.MULTILINE)
    assert re.search(r"^suite plain$", script, re.MULTILINE)
    assert set(ELSEWHERE) == {"pip install .", 'pip install ".[test]"', "pytest"}


def test_numbers_are_compared_and_rounding_errors_are_not():
    assert same("a 1.00 N  law 0.5", "a 1.00 N law 0.5")
    assert same("law 3e-16 of 64", "law 5e-16 of 64")
    assert not same("a 1.001", "a 1.002")
    assert not same("a 1.0\nb", "a 1.0")
    assert not same("a 1.0", "b 1.0")


@pytest.mark.parametrize("name", ["effects", "rules", "robots"])
def test_tables_are_up_to_date(name):
    assert tables_in(TEXT)[name] == steady_tables()[name](), ADVICE


@pytest.mark.parametrize("name", [pytest.param("accuracy", marks=pytest.mark.slow), "derivatives"])
def test_errors_are_those_measured(name):
    """Words to the letter and numbers to a factor of four: rounding errors differ from one processor to another."""
    shown, found = (cells(text) for text in (tables_in(TEXT)[name], steady_tables()[name]()))
    assert len(shown) == len(found), ADVICE
    for ours, theirs in zip(shown, found, strict=True):
        for a, b in zip(ours, theirs, strict=True):
            numbers = [re.match(r"[\d.]+(e[-+]\d+)?", cell) for cell in (a, b)]
            if numbers[0] and numbers[1]:
                assert 0.25 <= float(numbers[0][0]) / float(numbers[1][0]) <= 4, f"{ours}: {ADVICE}"
            else:
                assert a == b, ADVICE


def test_operations_of_the_speed_table_are_up_to_date():
    rows = [row[:4] for row in cells(tables_in(TEXT)["speed"])]
    joints, operations = bench_executors.joints, bench_executors.operations
    assert rows == [[name, joints(name), *map(str, operations(name))] for name in bench_executors.ROBOTS], (
        f"{ADVICE} --benchmarks"
    )


@pytest.mark.parametrize("name", TIMED)
def test_timings_say_what_they_were_measured_on(name):
    assert "Measured on " in tables_in(TEXT)[name]


@pytest.mark.parametrize("text", blocks(TEXT, "toml"))
def test_scenes_are_understood(text):
    parse_scene(text.encode())


@pytest.mark.parametrize("table", TABLES_OF_SCENE)
def test_every_key_of_a_scene_is_described(table):
    with pytest.raises(SceneError, match="unknown key") as caught:
        parse_scene(table.replace("KEY", "nonsense = 1").encode())
    reference = TEXT.partition("\n## Scene")[2].partition("\n## ")[0]
    for key in re.findall(r"[a-z_]+", str(caught.value).partition("valid keys: ")[2]):
        assert re.search(rf"`[^`]*\b{key}\b[^`]*`", reference), f"{key} is not in the section on scenes"
