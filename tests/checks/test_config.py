"""Settings of a project, and which of them hold for a file."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest
from helpers.clean_arm import IDENTITY, arm

import robodyn
from robodyn.checks import check as checks
from robodyn.checks.check import Options, check_tasks, tasks_for
from robodyn.checks.config import parse_config
from robodyn.checks.context import Thresholds
from robodyn.errors import InputError

TABLE = "[tool.robodyn.check]\n"
BOUNDS = f"{TABLE}[tool.robodyn.check.thresholds]"
PLANTED = arm(upper=IDENTITY, shoulder="0 2 0")


def codes(path: Path, given: Options = Options(), config: str | None = None) -> list[str]:  # noqa: B008
    return [finding.code for finding in check_tasks(tasks_for([str(path)], given, config)).findings]


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    path = tmp_path / "robots" / "old" / "arm.urdf"
    path.parent.mkdir(parents=True)
    path.write_text(PLANTED)
    return path


@pytest.mark.parametrize(("name", "depth"), [("pyproject.toml", 0), ("robodyn.toml", 1), ("pyproject.toml", 2)])
def test_found_upwards(robot: Path, name: str, depth: int) -> None:
    assert codes(robot) == ["RD208", "RD502"]
    (robot.parents[depth] / name).write_text(f'{TABLE}ignore = ["rd208"]')
    assert codes(robot) == ["RD502"]


def test_the_nearest_wins_and_robodyn_toml_before_pyproject(robot: Path) -> None:
    (robot.parents[2] / "robodyn.toml").write_text(f'{TABLE}ignore = ["RD208"]')
    (robot.parents[1] / "pyproject.toml").write_text(f'{TABLE}ignore = ["RD5"]')
    assert codes(robot) == ["RD208"]
    (robot.parents[1] / "robodyn.toml").write_text(f'{TABLE}ignore = ["RD"]')
    assert codes(robot) == []


def test_files_without_our_table_are_passed_over(robot: Path) -> None:
    (robot.parents[2] / "robodyn.toml").write_text(f'{TABLE}ignore = ["RD208"]')
    (robot.parents[1] / "pyproject.toml").write_text('[project]\ndependencies = ["robodyn"]')
    (robot.parents[0] / "pyproject.toml").write_text("this is not TOML and none of our business")
    assert codes(robot) == ["RD502"]


def test_a_file_that_is_named_holds_for_all(robot: Path, tmp_path: Path) -> None:
    (robot.parent / "robodyn.toml").write_text(f'{TABLE}ignore = ["RD"]')
    named = tmp_path / "strict.toml"
    named.write_text(f'{TABLE}select = ["RD502"]')
    assert codes(robot, config=str(named)) == ["RD502"]


def test_the_call_wins(robot: Path) -> None:
    (robot.parent / "robodyn.toml").write_text(f'{TABLE}select = ["RD502"]')
    assert codes(robot) == ["RD502"]
    assert codes(robot, Options(select=("RD208",))) == ["RD208"]
    (robot.parent / "robodyn.toml").write_text(f'{TABLE}ignore = ["RD502"]')
    assert codes(robot, Options(ignore=("RD208",))) == []


def test_per_file(robot: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Patterns are relative to the settings, whatever the current folder."""
    settings = robot.parents[2] / "pyproject.toml"
    matching = ("robots/old/*", "robots/*", "**/old/*.urdf", "**/robots/old/arm.urdf", "arm.urdf", "a?m.ur[dx]f")
    for pattern in (*matching, "old/*", "ARM.urdf", "robots"):
        text = f'{TABLE}ignore = ["RD502"]\n[tool.robodyn.check.per-file-ignores]\n"{pattern}" = ["RD208"]'
        settings.write_text(text)
        assert codes(robot) == ([] if pattern in matching else ["RD208"]), pattern
    settings.write_text(f'{TABLE}[tool.robodyn.check.per-file-ignores]\n"robots/old/arm.urdf" = ["RD208"]')
    monkeypatch.chdir(robot.parent)
    assert codes(Path("arm.urdf")) == codes(Path("../old/arm.urdf")) == ["RD502"]


def test_standard_input_has_the_settings_of_the_current_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "robodyn.toml").write_text(f'{TABLE}ignore = ["RD208"]')
    monkeypatch.chdir(tmp_path)
    assert [one.code for one in check_tasks(tasks_for([PLANTED.encode()])).findings] == ["RD502"]


def test_the_function_of_the_package_has_them_too(robot: Path, tmp_path: Path) -> None:
    (robot.parent / "robodyn.toml").write_text(f'{TABLE}ignore = ["RD208"]')
    named = tmp_path / "strict.toml"
    named.write_text(f'{TABLE}select = ["RD208"]')

    def found(**how: Any) -> list[str]:
        return [finding.code for finding in robodyn.check(robot, **how)]

    assert found() == codes(robot) == ["RD502"]
    assert found(select=["rd2"]) == []
    assert found(ignore=["RD5"]) == []
    assert found(config=named) == codes(robot, config=str(named)) == ["RD208"]


@pytest.mark.parametrize("text", ['[check]\nignore = ["RD208"]', "[thresholds]\nmass-ratio = 3", 'ignore = ["RD208"]'])
def test_settings_that_nothing_would_read_are_refused(robot: Path, text: str) -> None:
    (robot.parent / "robodyn.toml").write_text(text)
    with pytest.raises(
        InputError, match=r"stands outside of \[tool\.robodyn\.check\], where no setting is read \(write"
    ):
        codes(robot)
    (robot.parent / "robodyn.toml").rename(robot.parent / "pyproject.toml")
    assert codes(robot) == ["RD208", "RD502"]


def test_thresholds(robot: Path) -> None:
    (robot.parent / "robodyn.toml").write_text(
        f"{TABLE}[tool.robodyn.check.thresholds]\naxis-length = 1\nmass-ratio = 3"
    )
    assert codes(robot) == ["RD208"]
    (task,) = tasks_for([str(robot)])
    thresholds = task.options.thresholds
    assert (thresholds.axis_length, thresholds.mass_ratio) == (1.0, 3.0)
    assert thresholds.triangle == Thresholds().triangle


def test_settings_reach_every_process(robot: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = robot.parents[2] / "arm.urdf"
    other.write_text(PLANTED)
    (robot.parent / "robodyn.toml").write_text(f'{TABLE}ignore = ["RD208"]')
    alone = check_tasks(tasks_for([str(other), str(robot)]))
    monkeypatch.setattr(checks, "worth_processes", lambda files: True)
    shared = check_tasks(tasks_for([str(other), str(robot)]))
    assert shared == alone
    assert [finding.code for finding in shared.findings] == ["RD208", "RD502", "RD502"]
    (unread,) = check_tasks(tasks_for([str(robot), "none.urdf"])).unread
    assert (unread.file, unread.why) == ("none.urdf", "there is no such file (check the name)")


def test_package_roots_are_relative_to_the_file(robot: Path) -> None:
    (robot.parents[1] / "robodyn.toml").write_text(f'{TABLE}package-path = ["../packages", "/opt/share"]')
    (task,) = tasks_for([str(robot)], Options(package_path=("here",)))
    assert task.options.package_path == ("here", str(robot.parents[2] / "packages"), "/opt/share")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (f"{TABLE}slect = []", "[tool.robodyn.check]: unknown key \"slect\" (valid keys: 'select', 'ignore', "),
        ("[tool.robodyn.chek]", "[tool.robodyn]: unknown key \"chek\" (valid keys: 'check'; did you mean 'check'?)"),
        (f'{TABLE}select = "RD2"', "[tool.robodyn.check]: \"select\" is 'RD2', not a list (write select = ["),
        (f"{TABLE}select = [2]", '[tool.robodyn.check]: "select" is 2, not a name'),
        (f'{TABLE}ignore = ["RD999"]', "there is no rule 'RD999' (RD9 means RD901 to RD902)"),
        (f'{TABLE}per-file-ignores = {{"*" = ["X"]}}', "there is no rule 'X' (give codes such as RD207"),
        (f"{TABLE}per-file-ignores = 1", "[tool.robodyn.check.per-file-ignores] is 1, not a table"),
        (f"{BOUNDS}\nmas-ratio = 1", '[tool.robodyn.check.thresholds]: unknown key "mas-ratio" (valid keys: \'axis-'),
        (f"{BOUNDS}\nmass-ratio = true", '[tool.robodyn.check.thresholds]: "mass-ratio" is True, not a finite number'),
        (f"{BOUNDS}\nmass-ratio = -1", '[tool.robodyn.check.thresholds]: "mass-ratio" is -1 (thresholds are positive'),
        ("[tool.robodyn.check", "is not TOML: expected"),
        ("[tool]\nrobodyn = 1", "[tool.robodyn] is 1, not a table"),
    ],
)
def test_wrong_settings_are_one_line(text: str, line: str) -> None:
    with pytest.raises(InputError) as error:
        parse_config(text.encode(), "robodyn.toml")
    assert re.match(r"robodyn\.toml:(\d+:)? ", str(error.value))
    assert line in str(error.value)
    assert "\n" not in str(error.value)


def test_a_named_file_must_be_there_and_have_the_table(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no\.toml: cannot be read: no such file"):
        tasks_for([b"<robot/>"], config="no.toml")
    path = tmp_path / "some.toml"
    path.write_text("[tool.ruff]")
    with pytest.raises(InputError, match=r"some\.toml: there is no table \[tool\.robodyn\.check\]"):
        tasks_for([b"<robot/>"], config=str(path))


def test_the_page_has_the_keys_and_its_example_holds() -> None:
    page = (Path(__file__).parents[2] / "docs" / "howto" / "check_descriptions.md").read_text(encoding="utf-8")
    example = page.partition("```toml\n")[2].partition("```")[0]
    config = parse_config(example.encode(), "robodyn.toml")
    assert config is not None
    assert (config.options.select, config.options.ignore) == (("DEFAULT", "RD110"), ("RD304",))
    assert (config.options.thresholds.mass_ratio, config.options.thresholds.least_mass) == (5000, 1e-5)
    assert config.per_file == (("legacy/*.urdf", ("RD4", "RD207")),)
    for threshold in fields(Thresholds):
        assert f"`{threshold.name.replace('_', '-')}`" in page
