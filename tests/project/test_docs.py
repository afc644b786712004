"""README.md and docs/ say what the software does: examples run, tables, reference and links are complete and true."""

from __future__ import annotations

import ast
import re
import sys
from collections import Counter
from dataclasses import fields
from functools import cache
from importlib import import_module
from itertools import pairwise
from os.path import normpath
from pathlib import Path
from types import ModuleType
from urllib.parse import unquote

import pytest
from benchmarks import bench_executors
from helpers.doc_examples import FENCE, GENERATED, ROOT, blocks, commands, hand_written, regenerated, same
from helpers.doc_tables import TIMED, steady_tables
from helpers.example_robots import PATHS
from helpers.markdown_tables import cells
from helpers.peers import peer
from make_docs import tables_of_all

import robodyn
from robodyn.checks.catalogue import RULES
from robodyn.cli.main import COMMANDS
from robodyn.errors import SceneError
from robodyn.scene.read import parse_scene
from robodyn.support import input_file
from robodyn.support.input_file import VARIABLE, InputLimits

ADVICE = "run: python tests/make_docs.py"
PAGES = {page.relative_to(ROOT).as_posix(): page.read_text(encoding="utf-8") for page in hand_written()}
TABLES = tables_of_all()
LONGEST_README = 200
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
    "[motor.j.thermal]\n"
    "resistance = 1\ntorque_constant = 1\nwinding_housing = 1\nwinding_capacity = 1\nwinding_limit = 99\nKEY",
    "[gear.j.life]\nrated_life = 1\nrated_torque = 1\nrated_speed = 1\nKEY",
    "[limit_spring]\nstiffness = 1\nKEY",
    '[[contact]]\nname = "c"\nlink = "l"\nKEY',
)
ELSEWHERE = (
    "KEY",
    '[[payload]]\nlink = "l"\nmass = 1\nKEY',
    '[[wrench]]\nlink = "l"\nKEY',
    "[base]\nKEY",
    *TABLES_OF_SCENE[10:12],
)
"""Tables of a scene that do not say what acts in joints and on links."""
LONG = (
    *("identify", "feet_on_the_ground", "reports", "many_trajectories", "measured_logs", "export", "first_torques"),
    *("closed_chains", "uncertainty", "lint_in_ci", "linearize", "excite", "retime", "motor_sizing", "weighing_a_part"),
    *("mass_properties", "check_descriptions", "derivatives", "README", "other_formats", "glance"),
    *("free_bodies", "recursive", "systems", "momentum", "composite_bodies", "kinematics", "catalogue", "derive"),
    *("axes", "dae", "envelope", "convert", "simulate"),
)
"""Pages whose examples compute for seconds."""


def having(*languages: str) -> list[str]:
    """Return the pages that have blocks of one of these languages."""
    return [name for name, text in PAGES.items() if any(blocks(text, language) for language in languages)]


@cache
def beside_the_pages(name: str) -> ModuleType:
    sys.path.insert(0, str(ROOT / "docs"))
    return import_module(name)


def generated_pages() -> ModuleType:
    return beside_the_pages("generated_pages")


@cache
def all_pages() -> dict[str, str]:
    """Return every page by name, those included that are written when Sphinx starts."""
    return {**PAGES, **{f"docs/{name}": text for name, text in generated_pages().pages()}}


def test_every_robot_that_a_page_names_is_there():
    """Those of `--help` too, whose texts the page of commands has."""
    named = {
        path for text in all_pages().values() for path in re.findall(r"\brobots/[\w./]+\.(?:urdf|toml|csv)\b", text)
    }
    assert len(named) > 30
    assert not [path for path in sorted(named) if not (ROOT / path).exists()]


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=[pytest.mark.slow] * (Path(page).stem in LONG))
        for page in having("console", "pycon", "sh")
    ],
)
def test_every_example_prints_what_is_shown(page, tmp_path):
    for library in re.findall(r"^>>> import (casadi|jax)$", PAGES[page], re.MULTILINE):
        peer(library)
    now = regenerated(PAGES[page], tmp_path)
    for language in ("console", "pycon"):
        for shown, found in zip(blocks(PAGES[page], language), blocks(now, language), strict=True):
            assert same(found, shown), f"{ADVICE} {page}\n{found}"


def test_every_block_shows_something():
    for block in (block for text in PAGES.values() for block in blocks(text, "console")):
        silent = block.replace("$ ", "")
        for command in commands(block):
            silent = silent.replace(command, "", 1)
        assert silent.strip(), block


def test_pictures_of_the_course_are_what_is_drawn_and_all_shown():
    drawn, folder = beside_the_pages("make_course_pictures").pictures(), ROOT / "docs/course/pictures"
    assert {path.name for path in folder.iterdir()} == drawn.keys()
    text = "".join(page for name, page in PAGES.items() if name.startswith("docs/course/"))
    for name, picture in drawn.items():
        assert f"](pictures/{name})" in text
        words = [re.split(r"[\s\"<>ML,]+", each) for each in ((folder / name).read_text(encoding="utf-8"), picture)]
        assert len(words[0]) == len(words[1]), f"{name}: run python docs/make_course_pictures.py"
        for one, other in zip(*words, strict=True):  # a tenth of a pixel may be rounded up or down
            number = re.fullmatch(r"-?\d+\.\d", one) and re.fullmatch(r"-?\d+\.\d", other)
            assert abs(float(one) - float(other)) < 0.15 if number else one == other, f"{name}: {one}, {other}"


def test_every_block_of_commands_is_run():
    """There is no `bash` block, say, that nothing runs."""
    languages = {found[1] for text in PAGES.values() for found in re.finditer(r"^```+(\w+)$", text, re.MULTILINE)}
    assert languages <= {
        *["console", "pycon", "sh", "toml", "text", "python", "xml", "yaml", "csv", "json", "cmake", "markdown", "math"]
    }


def test_numbers_are_compared_and_rounding_errors_are_not():
    assert same("a 1.00 N  law 3e-16 of 64", "a 1.00 N law 5e-16 of 64")
    for one, other in (("a 1.001", "a 1.002"), ("a 1.0\nb", "a 1.0"), ("a 1.0", "b 1.0")):
        assert not same(one, other)


@pytest.mark.parametrize("name", ["effects", "robots"])
def test_tables_are_up_to_date(name):
    assert TABLES[name] == steady_tables()[name](), ADVICE


@pytest.mark.slow
@pytest.mark.parametrize("name", ["accuracy", "derivatives"])
def test_errors_are_those_measured(name):
    """Words to the letter and numbers to a factor of four: rounding errors differ from one processor to another."""
    if name == "accuracy":
        peer("pinocchio")
    shown, found = (cells(text) for text in (TABLES[name], steady_tables()[name]()))
    assert len(shown) == len(found), ADVICE
    for ours, theirs in zip(shown, found, strict=True):
        for a, b in zip(ours, theirs, strict=True):
            numbers = [re.match(r"[\d.]+(e[-+]\d+)?", cell) for cell in (a, b)]
            if numbers[0] and numbers[1]:
                assert 0.25 <= float(numbers[0][0]) / float(numbers[1][0]) <= 4, f"{ours}: {ADVICE}"
            else:
                assert a == b, ADVICE


def test_operations_of_the_speed_table_are_up_to_date():
    if not PATHS:
        pytest.skip("example-robot-data is not installed")
    rows = [row[:4] for row in cells(TABLES["speed"])]
    joints, operations = bench_executors.joints, bench_executors.operations
    assert rows == [[name, joints(name), *map(str, operations(name))] for name in bench_executors.ROBOTS], (
        f"{ADVICE} --benchmarks"
    )


def test_timings_say_what_they_were_measured_on():
    assert [name for name in TIMED if "Measured on " not in TABLES[name]] == []


def test_scenes_are_understood():
    for text in (block for page in PAGES.values() for block in blocks(page, "toml")):
        if "[tool.robodyn" not in text:
            parse_scene(text.encode())


@pytest.mark.parametrize("table", TABLES_OF_SCENE)
def test_every_key_of_a_scene_is_described(table):
    """What acts in joints and on links is said to be there, too: a new key fails here, so that whoever adds it reads
    what the page of limits denies."""
    with pytest.raises(SceneError, match="unknown key") as caught:
        parse_scene(table.replace("KEY", "nonsense = 1").encode())
    keys = set(re.findall(r"[a-z_]+", str(caught.value).partition("valid keys: ")[2]))
    assert len(keys) > 1
    for key in keys:
        assert re.search(rf"`[^`]*\b{key}\b[^`]*`", PAGES["docs/reference/scene.md"]), f"{key} is not described"
    if table not in ELSEWHERE:
        named = " ".join(word for row in cells(PAGES["docs/explanation/limits.md"]) for word in row[1].split("`")[1::2])
        assert keys - set(re.findall(r"\w+", named)) - {"link"} == set()


def test_the_number_of_rules_stands_on_the_page_that_counts_them():
    """What is typed gets stale; the changelog is history, and what commands print is run."""
    pages = {page: FENCE.sub("", text) for page, text in PAGES.items() if page != "CHANGELOG.md"}
    assert [page for page, text in pages.items() if re.search(r"\b\d+\s+rules\b", text)] == []
    assert f" has {len(RULES)} rules" in all_pages()["docs/reference/rules/index.md"]


def test_every_rule_command_and_name_has_its_page():
    pages = all_pages()
    assert {f"docs/reference/rules/{rule.code.lower()}.md" for rule in RULES} <= pages.keys()
    for rule in RULES:
        assert f"({rule.code.lower()}.md)" in pages["docs/reference/rules/index.md"], f"{rule.code} has no family"
    assert all(f"\n## robodyn {name}\n" in pages["docs/reference/commands.md"] for name in COMMANDS)
    assert all(f"\n### {name}\n" in pages["docs/reference/python.md"] for name in robodyn.__all__)


def test_generated_pages_are_ignored_by_git():
    ignored = (ROOT / ".gitignore").read_text(encoding="utf-8").splitlines()
    names = [name for name, _ in generated_pages().pages()]
    assert all(name.startswith(GENERATED) for name in names)
    assert {f"docs/{name}" for name in GENERATED} <= set(ignored)


def test_links_lead_to_pages_and_headings():
    for name, text in all_pages().items():
        bare = re.sub(r"^(```+).*?^\1$", "", text, flags=re.DOTALL | re.MULTILINE)
        for link in re.findall(r"(?<!`)\]\(([^)\s]+)\)|<img src=\"(.*?)\"", bare):
            file, _, anchor = unquote(link[0] or link[1]).partition("#")
            if re.match(r"[a-z]+:", link[0]):
                continue
            path = (ROOT / name).parent / file if file else ROOT / name
            there = Path(path).resolve().relative_to(ROOT.resolve()).as_posix()
            assert there in all_pages() or (ROOT / there).exists(), f"{name}: {link}"
            if anchor:
                headings = re.findall(r"^#+ (.*)$", all_pages()[there], re.MULTILINE)
                assert anchor in map(slug, headings), f"{name}: {link}"


def slug(heading: str) -> str:
    """Return the anchor of a heading, as GitHub and MyST make it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")


def test_every_page_is_in_a_table_of_contents():
    listed = {"docs/index.md"}
    for name, text in all_pages().items():
        for tree in re.findall(r"^```\{toctree\}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE):
            entries = [line.split("<")[-1].rstrip(">") for line in tree.splitlines() if line and line[0] != ":"]
            listed |= {normpath(f"{Path(name).parent}/{entry.removesuffix('.md')}.md") for entry in entries}
    assert {name for name in all_pages() if name.startswith("docs/")} == listed


def test_only_public_names_of_the_package_are_mentioned():
    """Deeper paths change with any version; public ones are `robodyn.NAME` and attributes of what they return."""
    rooms = {path.stem for path in (ROOT / "robodyn").iterdir()} - set(robodyn.__all__) | {"cli"}
    for name, text in all_pages().items():
        for room in re.findall(r"\brobodyn\.(\w+)\.\w+", text) + re.findall(r"(?:from|import) robodyn\.(\w+)", text):
            assert room not in rooms or name == "CONTRIBUTING.md", f"{name}: robodyn.{room}"


def test_the_walk_through_the_house_leads_where_it_says():
    walk = PAGES["CONTRIBUTING.md"].partition("## A newcomer's walk")[2].partition("\n## ")[0]
    steps = re.findall(r"^(\d)\. \[.*?\]\((.*?)\) .*: `(.*)`$", walk, re.MULTILINE)
    assert [number for number, _, _ in steps] == ["1", "2", "3"] * 5
    for _, file, text in steps:
        assert text in (ROOT / file).read_text(encoding="utf-8"), f"{file}: {text}"


def test_every_room_is_on_the_map():
    rooms = {path.name for path in (ROOT / "robodyn").iterdir() if (path / "__init__.py").exists()}
    shown = set(re.findall(r"^\| `robodyn/(\w+)/`", PAGES["CONTRIBUTING.md"], re.MULTILINE))
    assert shown == rooms


def test_files_that_pages_mention_are_there():
    for path in re.findall(r"`((?:robodyn|tests|docs|cli|\.ci)/[\w./]*)`", PAGES["CONTRIBUTING.md"]):
        assert (ROOT / path).exists() or "NNN" in path, path
    there = {path.name for room in ("robodyn", "cli", "tests", "docs") for path in (ROOT / room).rglob("*.py")}
    for name, text in PAGES.items():
        for file in re.findall(r"`(?:[\w/]*/)?(\w+\.py)`", text):
            assert file in there or "NNN" in file, f"{name}: {file}"


def test_every_extra_is_described():
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    extras = re.findall(
        r"^([\w-]+) = \[", project.partition("[project.optional-dependencies]")[2].partition("\n[")[0], re.M
    )
    assert extras
    for extra in extras:
        assert f"| `{extra}` |" in PAGES["docs/howto/install.md"]


def test_figures_of_the_readme_are_those_of_the_benchmarks():
    place = TABLES["speed"].splitlines()[0].split("|").index(" AVX2 ") - 1
    compiled = {row[0]: float(row[place].split()[0]) for row in cells(TABLES["speed"])}
    text = " ".join(PAGES["README.md"].split())
    shown = re.findall(r"([\d.]+) ns (?:per sample )?for (?:a |an )?(\w+)", text)
    assert {name: float(number) for number, name in shown} == {name: round(compiled[name]) for _, name in shown}
    assert len(shown) == 3
    errors = {row[0]: row for row in cells(TABLES["accuracy"])}
    assert f"50 digits to {errors['torques'][4]} of the largest" in text
    against = errors["torques, fixed base"]
    assert f"Pinocchio to {against[4]}, on {against[2]} robots" in text
    assert len(PAGES["README.md"].splitlines()) <= LONGEST_README


SECURITY = (ROOT / ".github" / "SECURITY.md").read_text()


def _explained() -> dict[str, str]:
    """What is written below each limit."""
    tree = ast.parse(Path(input_file.__file__).read_text())
    body = next(node.body for node in tree.body if isinstance(node, ast.ClassDef))
    return {
        ast.unparse(line.target): " ".join(ast.literal_eval(below.value).split()).rstrip(".")
        for line, below in pairwise(body)
        if isinstance(line, ast.AnnAssign) and isinstance(below, ast.Expr)
    }


def test_every_limit_is_on_the_page_on_security_and_used() -> None:
    rows = re.findall(r"^\| `(\w+)` \| (\d+) \| (.+) \|$", SECURITY, re.MULTILINE)
    what = _explained()
    assert rows == [(each.name, str(each.default), what[each.name]) for each in fields(InputLimits)]
    words = Counter(word for path in (ROOT / "robodyn").rglob("*.py") for word in re.findall(r"\w+", path.read_text()))
    assert [each.name for each in fields(InputLimits) if words[each.name] < 2] == []  # once stands in the table


def test_what_the_page_on_security_names_is_there() -> None:
    for path in re.findall(r"`(tests/[\w/.]+)`", SECURITY):
        assert (ROOT / path).exists(), path
    for link, anchor in re.findall(r"\]\(\.\./([\w/.]+)#([\w-]+)\)", SECURITY):
        assert anchor in map(slug, re.findall(r"^#+ (.*)$", (ROOT / link).read_text(), re.MULTILINE))
    assert "(.github/SECURITY.md)" in PAGES["CONTRIBUTING.md"]
    assert f"`{VARIABLE}`" in PAGES["docs/reference/environment.md"]
