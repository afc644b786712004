"""Which files are checked, by which rules and settings, and which findings are shown."""

from __future__ import annotations

import os
import re
from dataclasses import fields
from pathlib import Path

import pytest
from helpers.clean_arm import IDENTITY, arm
from helpers.planted_defects import HEALTHY

import robodyn
from robodyn.checks import check as checks
from robodyn.checks import sources
from robodyn.checks.catalogue import ALL, BY_CODE, DEFAULT, rules_for
from robodyn.checks.check import Checked, Options, Task, check, check_one, check_tasks, found_in, tasks_for
from robodyn.checks.context import Asked, Thresholds
from robodyn.checks.sources import parse_config
from robodyn.errors import InputError, RobodynWarning

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


@pytest.mark.parametrize(
    ("files", "given", "expected"),
    [
        ({"robots/old/pyproject.toml": 'ignore = ["rd208"]'}, Options(), ["RD502"]),
        ({"robots/robodyn.toml": 'ignore = ["RD208"]'}, Options(), ["RD502"]),
        ({"pyproject.toml": 'ignore = ["RD208"]'}, Options(), ["RD502"]),
        ({"robodyn.toml": 'ignore = ["RD208"]', "robots/pyproject.toml": 'ignore = ["RD5"]'}, Options(), ["RD208"]),
        ({"robots/robodyn.toml": 'ignore = ["RD"]', "robots/pyproject.toml": 'ignore = ["RD5"]'}, Options(), []),
        ({"robodyn.toml": 'select = ["RD502"]'}, Options(select=("RD208",)), ["RD208"]),
        ({"robodyn.toml": 'ignore = ["RD502"]'}, Options(ignore=("RD208",)), []),
        ({}, Options(), ["RD208", "RD502"]),
    ],
)
def test_the_nearest_hold_and_the_call_wins(
    robot: Path, files: dict[str, str], given: Options, expected: list[str]
) -> None:
    """Files without our table are passed over, whatever they are."""
    for name, text in files.items():
        (robot.parents[2] / name).write_text(TABLE + text)
    if "robots/old/pyproject.toml" not in files:
        (robot.parent / "pyproject.toml").write_text("this is not TOML and none of our business")
    assert codes(robot, given) == expected


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
    for how, expected in (
        ({}, ["RD502"]),
        ({"select": ["rd2"]}, []),
        ({"ignore": ["RD5"]}, []),
        ({"config": named}, ["RD208"]),
    ):
        assert [finding.code for finding in robodyn.check(robot, **how)] == expected  # type: ignore[arg-type]


@pytest.mark.parametrize("text", ['[check]\nignore = ["RD208"]', "[thresholds]\nmass-ratio = 3", 'ignore = ["RD208"]'])
def test_settings_that_nothing_would_read_are_refused(robot: Path, text: str) -> None:
    (robot.parent / "robodyn.toml").write_text(text)
    with pytest.raises(
        InputError, match=r"stands outside of \[tool\.robodyn\.check\], where no setting is read \(write"
    ):
        codes(robot)
    (robot.parent / "robodyn.toml").rename(robot.parent / "pyproject.toml")
    assert codes(robot) == ["RD208", "RD502"]


def test_settings_reach_every_process(robot: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = robot.parents[2] / "arm.urdf"
    other.write_text(PLANTED)
    (robot.parent / "robodyn.toml").write_text(f'{TABLE}ignore = ["RD208"]')
    alone = check_tasks(tasks_for([str(other), str(robot)]))
    monkeypatch.setattr(checks, "worth_processes", lambda files: True)
    shared = check_tasks(tasks_for([str(other), str(robot)]))
    assert shared == alone
    assert [(finding.code, len(finding.places)) for finding in shared.findings] == [("RD208", 1), ("RD502", 2)]
    (unread,) = check_tasks(tasks_for(["none.urdf"])).unread
    assert (unread.file, unread.why) == ("none.urdf", "there is no such file (check the name)")


def test_thresholds_and_package_roots(robot: Path) -> None:
    """Roots are relative to the file."""
    (robot.parents[1] / "robodyn.toml").write_text(
        f'{TABLE}package-path = ["../packages", "/opt/share"]\n'
        "[tool.robodyn.check.thresholds]\naxis-length = 1\nmass-ratio = 3"
    )
    assert codes(robot) == ["RD208"]
    (task,) = tasks_for([str(robot)], Options(package_path=("here",)))
    thresholds = task.options.thresholds
    assert (thresholds.axis_length, thresholds.mass_ratio, thresholds.triangle) == (1.0, 3.0, Thresholds().triangle)
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


BAD = '<robot name="r"><link name="a"/><link name="a"/></robot>'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "more").mkdir()
    (tmp_path / "b.urdf").write_text(HEALTHY)
    (tmp_path / "a.urdf").write_text(BAD)
    (tmp_path / "more" / "c.urdf").write_text(BAD)
    (tmp_path / "notes.xml").write_text("<a>")
    return tmp_path


def check_all(*given: Path | str) -> Checked:
    return check_tasks([Task(file, Options()) for file in sources.files_of(given)])


def test_folders_patterns_and_several_files(folder: Path) -> None:
    """An empty folder among others is passed over; a file's name may look like a pattern."""
    names = [os.path.relpath(file, folder) for file in check_all(folder).files]
    assert names == ["a.urdf", "b.urdf", os.path.join("more", "c.urdf")]
    assert check_all(f"{folder}/*.urdf").files == (f"{folder}/a.urdf", f"{folder}/b.urdf")
    (folder / "empty").mkdir()
    odd = folder / "empty" / "arm[1].urdf"
    with pytest.warns(RobodynWarning, match=r"empty: no \.urdf and no \.xacro in the folder .*: skipped"):
        assert check_all(folder / "empty", folder / "a.urdf").files == (str(folder / "a.urdf"),)
    odd.write_text(BAD)
    assert check_all(odd).files == (str(odd),)
    checked = check_all(f"{folder}/more/c.urdf", f"{folder}/a.urdf", f"{folder}/more/c.urdf")
    assert checked.files == (f"{folder}/more/c.urdf", f"{folder}/a.urdf")
    assert [place.file for finding in checked.findings for place in finding.places] == list(checked.files)


def test_what_is_not_there(folder: Path) -> None:
    for missing, why in (("x.urdf", "no such file"), ("*.sdf", "nothing matches"), ("empty", "no .urdf")):
        (folder / "empty").mkdir(exist_ok=True)
        with pytest.raises(InputError, match=why):
            check(folder / missing)


PACKAGED = '<robot name="arm"><link name="a"><visual><geometry><mesh filename="{}"/></geometry></visual></link></robot>'


@pytest.mark.parametrize("manifest", [True, False])
def test_of_a_mesh_or_an_srdf_the_descriptions_that_name_it(tmp_path: Path, manifest: bool) -> None:
    package = tmp_path / "arm_description"
    for name in ("urdf", "meshes", "srdf"):
        (package / name).mkdir(parents=True)
    if manifest:
        (package / "package.xml").write_text("<package><name>arm_description</name></package>")
    (package / "urdf" / "arm.urdf").write_text(PACKAGED.format("../meshes/arm.stl"))
    (package / "urdf" / "leg.urdf").write_text(PACKAGED.format("../meshes/leg.stl").replace('"arm"', '"leg"'))
    (package / "srdf" / "arm.srdf").write_text('<robot name="arm"/>')
    for name in ("arm.stl", "leg.stl", "alone.stl"):
        (package / "meshes" / name).touch()
    arm, leg = (str(package / "urdf" / name) for name in ("arm.urdf", "leg.urdf"))
    assert sources.files_of([package / "meshes" / "arm.stl"]) == [arm]
    assert sources.files_of([package / "meshes" / "leg.stl"]) == [leg]
    assert sources.files_of([package / "srdf" / "arm.srdf", arm]) == [arm]
    with pytest.warns(RobodynWarning, match=r"alone\.stl: no description in its package names it .*: skipped"):
        assert sources.files_of([package / "meshes" / "alone.stl"]) == []


def test_findings_stand_in_the_order_of_the_text(folder: Path) -> None:
    text = HEALTHY.replace('value="3.5"', 'value="-3.5"').replace('axis xyz="0 0 1"', 'axis xyz="0 0 0"')
    findings = check_one(text.encode())
    assert {"RD211", "RD201", "RD501"} <= {finding.code for finding in findings}
    assert sorted(findings, key=lambda finding: finding.start) == list(findings)


def test_rules_by_code_or_beginning() -> None:
    for select, ignore, expected in (
        (("RD105",), (), {"RD105"}),
        (("RD1", "RD207"), ("RD11",), {f"RD10{k}" for k in range(1, 10)} | {"RD207"}),
        (("RD2",), ("RD2",), set()),
    ):
        assert {rule.code for rule in rules_for(select, ignore)} == expected
    for code in ("RD999", "X", "", "rd207"):
        for given in (((code,), ()), ((), (code,))):
            with pytest.raises(InputError, match="there is no rule"):
                rules_for(*given)


def test_a_rule_finds_the_same_alone(folder: Path) -> None:
    text = HEALTHY.replace('value="3.5"', 'value="nan"').replace('child link="wrist"', 'child link="wirst"').encode()
    for finding in check_one(text):
        assert finding in check_one(text, Options(select=(finding.code,)))


ODD = arm(upper=IDENTITY).replace('"shoulder"', '"shoulder/1"')
"""A warning of RD208 and a remark of RD110."""


def shown_and_hidden(text: str, options: Options) -> tuple[list[str], list[str]]:
    found = found_in(text.encode(), options)
    return [one.code for one in found.shown], [one.code for one in found.hidden]


@pytest.mark.parametrize(
    ("select", "ignore", "shown", "hidden"),
    [
        ((), (), ["RD208"], ["RD110"]),
        ((ALL,), (), ["RD208", "RD110"], []),
        (("RD110",), (), ["RD110"], []),
        (("RD1",), (), ["RD110"], []),
        ((DEFAULT, "RD110"), (), ["RD208", "RD110"], []),
        ((DEFAULT, "RD5"), (), ["RD208"], ["RD110"]),
        ((), ("RD110",), ["RD208"], []),
        ((ALL,), ("RD2",), ["RD110"], []),
    ],
)
def test_what_is_shown(select: tuple[str, ...], ignore: tuple[str, ...], shown: list[str], hidden: list[str]) -> None:
    assert shown_and_hidden(ODD, Options(select, ignore)) == (shown, hidden)


def test_what_is_minor_is_shown_when_asked_for() -> None:
    """A remark on a robot without defects, warnings of taste, and what an option asks for."""
    assert shown_and_hidden(HEALTHY, Options()) == ([], ["RD211"])
    assert robodyn.check(HEALTHY.encode()) == ()
    assert shown_and_hidden(HEALTHY, Options(asked=Asked(targets=("kdl",))))[0] == ["RD901"]
    for code in ("RD803", "RD804"):
        shown, hidden = shown_and_hidden(BY_CODE[code].bad, Options())
        assert (shown, code in hidden, BY_CODE[code].in_default) == ([], True, False)
        assert shown_and_hidden(BY_CODE[code].bad, Options((code,))) == ([code], [])
    with pytest.raises(robodyn.RobodynError, match="there is no rule 'NONE'"):
        found_in(b"<robot/>", Options(("NONE",)))
    with pytest.raises(robodyn.RobodynError, match="there is no rule 'ALL'"):
        robodyn.check(HEALTHY.encode(), ignore=[ALL])
