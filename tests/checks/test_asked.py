"""Rules that are asked something beyond the file: verdicts of programs, an earlier version, a motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import run
from helpers.git_repository import committed, git
from helpers.peers import mujoco

import robodyn
from robodyn.checks.catalogue import BY_CODE
from robodyn.checks.check import Options, check_one, found_in
from robodyn.checks.context import TARGETS, Asked
from robodyn.checks.examples import a_joint, a_link, arm
from robodyn.checks.importers import FACTS
from robodyn.checks.rule import Finding
from robodyn.comparison.compare import compare
from robodyn.errors import InputError

ALONG, REGRESSION = BY_CODE["RD802"], BY_CODE["RD902"]


def found(source: str | bytes, code: str, asked: Asked) -> list[Finding]:
    return [one for one in check_one(source, Options(asked=asked)) if one.code == code]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo writes its warnings into the current folder."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def versions(tmp_path: Path) -> Path:
    """arm.urdf with the rule's good example committed and its bad one in place."""
    file = tmp_path / "arm.urdf"
    file.write_text(REGRESSION.good)
    committed(tmp_path)
    file.write_text(REGRESSION.bad)
    return file


def test_an_earlier_version(versions: Path) -> None:
    results = found(str(versions), "RD902", Asked(against="HEAD"))
    messages = " ".join(one.message for one in results)
    assert "mass 2 kg in HEAD, 2.2 kg here" in messages
    assert not found(str(versions), "RD902", Asked())
    versions.write_text(REGRESSION.good)
    assert not found(str(versions), "RD902", Asked(against="HEAD"))


@pytest.mark.parametrize("ref", ["no-such-revision", "--output=x", "", "HEAD~99", "HEAD:other"])
def test_a_revision_that_is_not_there_is_an_error(versions: Path, ref: str) -> None:
    """In words of ours: git's are about objects and trees."""
    with pytest.raises(InputError) as caught:
        found(str(versions), "RD902", Asked(against=ref))
    assert "fatal" not in str(caught.value)
    assert repr(ref) in caught.value.what
    assert str(caught.value.remedy).startswith("give one ")


def test_a_file_that_git_does_not_have(versions: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    """A new one is a note, or the check of a pull request would end with it."""
    new, outside = versions.parent / "new.urdf", tmp_path_factory.mktemp("outside") / "arm.urdf"
    for file in (new, outside):
        file.write_text(REGRESSION.bad)
    (one,) = found(str(new), "RD902", Asked(against="HEAD"))
    assert (one.severity.value, one.what) == ("note", "the dynamics are not compared with HEAD: the file is not there")
    with pytest.raises(InputError, match=r"arm.urdf is in no git repository"):
        found(str(outside), "RD902", Asked(against="HEAD"))


def test_a_xacro_file_is_expanded_as_it_was(versions: Path) -> None:
    """With what it included, from another package of the repository; arguments count then, too."""
    root = versions.parent
    head = '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    include = '<xacro:arg name="more" default="0"/><xacro:include filename="$(find parts)/mass.xacro"/>'
    texts = {
        "arm/package.xml": "<package><name>arm</name></package>",
        "parts/package.xml": "<package><name>parts</name></package>",
        "parts/mass.xacro": f'{head}<xacro:property name="m" value="2"/></robot>',
        "arm/arm.xacro": arm()
        .replace('<robot name="arm">', head + include)
        .replace('value="2"', 'value="${m + $(arg more)}"'),
    }
    for name, text in texts.items():
        (root / name).parent.mkdir(exist_ok=True)
        (root / name).write_text(text)
    git(root, "add", ".")
    git(root, "commit", "-qm", "xacro")
    file, part = str(root / "arm" / "arm.xacro"), root / "parts" / "mass.xacro"
    asked = Options(asked=Asked(against="HEAD"), xacro_args=(("more", "1"),), package_path=(str(root),))
    assert not [one for one in check_one(file, asked) if one.code == "RD902"]
    part.write_text(part.read_text().replace('"2"', '"3"'))
    said = [one.message for one in check_one(file, asked) if one.code == "RD902"]
    assert any(one.startswith("link 'upper': mass 3 kg in HEAD, 4 kg here") for one in said)
    part.write_text("<")
    git(root, "commit", "-qam", "broken")
    part.write_text(texts["parts/mass.xacro"])
    (one,) = [one for one in check_one(file, asked) if one.code == "RD902"]
    assert one.what.startswith("the dynamics are not compared with HEAD: its version cannot be read: ")


def test_another_file(versions: Path) -> None:
    other = versions.parent / "other.urdf"
    other.write_text(REGRESSION.good.replace('iyy="0.02"', 'iyy="0.04"'))
    said = [one.message for one in found(str(versions), "RD902", Asked(against=str(other)))]
    assert said[0].startswith("torques differ, most of all that of shoulder by ")
    assert said[1].startswith(f"link 'upper': mass 2 kg in {other}, 2.2 kg here")
    assert not found(str(other), "RD902", Asked(against=str(other)))


FRAME = a_link("frame", "") + a_joint("mount", "upper", "frame", more='<origin xyz="1 2 3"/>', kind="fixed")


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        (arm(), arm(), []),
        (arm(), arm().replace('effort="30"', 'effort="40"'), ["limit effort 30 N m, in B effort 40 N m"]),
        (arm(more=a_link("hand") + a_joint("wrist", "upper", "hand")), arm(), ["joint is there, in B none"]),
        (arm(), arm().replace('xyz="0 1 0"', 'xyz="0 0 1"'), ["axis 0 1 0, in B 0 0 1 (90 deg apart)"]),
        (arm(), arm(more=FRAME), []),
    ],
    ids=["nothing", "effort", "joint", "axis", "a massless frame"],
)
def test_changes(before: str, after: str, said: list[str]) -> None:
    compared = compare(robodyn.load(before.encode()), robodyn.load(after.encode()))
    assert [one.words.partition(": ")[2] for one in compared.differences] == said
    assert compared.equal == (not said)


def test_limits_along_a_motion(tmp_path: Path) -> None:
    time = np.linspace(0.0, 2.0, 201)
    file = tmp_path / "swing.csv"
    rows = "\n".join(f"{t:.17g},{np.sin(t * 3):.17g}" for t in time)
    file.write_text(f"time,q_shoulder\n{rows}\n")
    results = found(ALONG.bad.encode(), "RD802", Asked(trajectory=str(file)))
    assert {one.bound for one in results} == {-0.5, 0.5}
    assert not found(ALONG.good.encode(), "RD802", Asked(trajectory=str(file)))
    assert not found(ALONG.bad.encode(), "RD802", Asked())


LOST = '<mass value="1"/><inertia ixx="0.01" ixy="0.05" ixz="0" iyy="0.02" iyz="0" izz="0.02"/>'
MASSLESS_TIP = arm(more=a_link("tip", "") + a_joint("j", "upper", "tip"))


def test_every_target_has_a_verdict_with_a_source() -> None:
    assert {fact.target for fact in FACTS} == set(TARGETS)
    assert all(fact.source for fact in FACTS)
    assert len(found(arm().encode(), "RD901", Asked(targets=TARGETS))) == len(TARGETS)
    based = arm().replace('<link name="base"/>', a_link("base"))
    (one,) = found(based.encode(), "RD901", Asked(targets=("mujoco",)))
    assert one.message.startswith("mujoco loads it with changes")
    assert mujoco.MjModel.from_xml_string(based).body_mass.sum() == 2.0
    with pytest.raises(InputError, match="there is no target 'mujuco'"):
        Asked(targets=("mujuco",))


def test_the_command_passes_on_what_is_asked(versions: Path) -> None:
    outcome = run("check", str(versions), "--against", "HEAD", "--target", "kdl,drake", "--select", "RD9")
    assert outcome.status == 0
    assert "mass 2 kg in HEAD, 2.2 kg here" in outcome.out
    assert "drake loads it with changes" in outcome.out
    assert "mujoco" not in outcome.out
    wrong = run("check", str(versions), "--target", "drak")
    assert (wrong.status, wrong.err.count("\n")) == (2, 1)
    assert "did you mean 'drake'?" in wrong.err
    missing = run("check", str(versions), "--trajectory", "none.csv")
    assert (missing.status, missing.err.count("\n")) == (2, 1)


def test_what_a_program_refuses_is_an_error_where_it_is_asked_for(tmp_path: Path) -> None:
    file = tmp_path / "robot.urdf"
    file.write_text(arm().replace('<link name="base"/>', a_link("base", LOST)), encoding="utf-8")
    asked = run("check", str(file), "--target", "mujoco", "--select", "RD901")
    assert (asked.status, "error RD901" in asked.out) == (1, True)
    unasked = run("check", str(file), "--select", "RD901")
    assert (unasked.status, "note RD901" in unasked.out) == (0, True)


def test_without_being_asked_only_rejections_are_told_that_no_other_rule_tells() -> None:
    assert not found(arm().encode(), "RD901", Asked())
    (one,) = found(MASSLESS_TIP.encode(), "RD901", Asked())
    assert one.what == "mujoco rejects it: it requires mass and inertia in what moves"
    assert one.subject is not None
    assert one.subject.kind == "link"
    for text, told in ((MASSLESS_TIP, "RD202"), (arm().replace('izz="0.02"', 'izz="0.05"'), "RD207")):
        everything = found_in(text.encode(), Options(("ALL",))).shown
        assert told in {one.code for one in everything}
        assert "RD901" not in {one.code for one in everything}
    asked = found_in(MASSLESS_TIP.encode(), Options(("ALL",), asked=Asked(targets=("mujoco",)))).shown
    assert {"RD202", "RD901"} <= {one.code for one in asked}
