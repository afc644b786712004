"""Rules that are asked something beyond the file: verdicts of programs, an earlier version, a motion."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import run
from helpers.example_robots import path_of
from helpers.peers import mujoco, peer

import robodyn
from robodyn.checks.catalogue import BY_CODE
from robodyn.checks.check import Options, check_one, found_in
from robodyn.checks.context import TARGETS, Asked
from robodyn.checks.examples import a_joint, a_link, arm
from robodyn.checks.importers import FACTS
from robodyn.checks.regression import changes
from robodyn.checks.rule import Finding
from robodyn.errors import InputError

ALONG, REGRESSION = BY_CODE["RD802"], BY_CODE["RD902"]


def found(source: str | bytes, code: str, asked: Asked) -> list[Finding]:
    return [one for one in check_one(source, Options(asked=asked)) if one.code == code]


def git(folder: Path, *words: str) -> None:
    identity = ("-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false")
    subprocess.run(["git", *identity, *words], cwd=folder, check=True, capture_output=True)


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo writes its warnings into the current folder."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def versions(tmp_path: Path) -> Path:
    """arm.urdf with the rule's good example committed and its bad one in place."""
    file = tmp_path / "arm.urdf"
    file.write_text(REGRESSION.good)
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", "arm.urdf")
    git(tmp_path, "commit", "-qm", "good")
    file.write_text(REGRESSION.bad)
    return file


def test_an_earlier_version(versions: Path) -> None:
    results = found(str(versions), "RD902", Asked(against="HEAD"))
    messages = " ".join(one.message for one in results)
    assert "mass 2 kg has become 2.2 kg" in messages
    assert not found(str(versions), "RD902", Asked())
    versions.write_text(REGRESSION.good)
    assert not found(str(versions), "RD902", Asked(against="HEAD"))


@pytest.mark.parametrize("ref", ["no-such-revision", "--output=x", "", "HEAD~99", "other.urdf", "HEAD:other"])
def test_a_revision_that_is_not_there_is_an_error(versions: Path, ref: str) -> None:
    """In words of ours: git's are about objects and trees."""
    (versions.parent / "other.urdf").touch()
    with pytest.raises(InputError) as caught:
        found(str(versions), "RD902", Asked(against=ref))
    assert "fatal" not in str(caught.value)
    assert repr(ref) in caught.value.what
    assert ("is a file" in caught.value.what) == (ref == "other.urdf")
    assert str(caught.value.remedy).startswith("give one ")


def test_a_file_that_git_does_not_have_is_an_error(versions: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    new, outside = versions.parent / "new.urdf", tmp_path_factory.mktemp("outside") / "arm.urdf"
    for file, what in (
        (new, "there is no new.urdf at the revision 'HEAD'"),
        (outside, "arm.urdf is in no git repository"),
    ):
        file.write_text(REGRESSION.bad)
        with pytest.raises(InputError, match=what) as caught:
            found(str(file), "RD902", Asked(against="HEAD"))
        assert "fatal" not in str(caught.value)


def whats(before: str, after: str) -> list[str]:
    old, new = robodyn.load(before.encode()), robodyn.load(after.encode())
    return [change.what for change in changes(old, new)]


def test_changes_of_joints() -> None:
    text = arm()
    assert not whats(text, text)
    assert whats(text, text.replace('effort="30"', 'effort="40"')) == ["effort 30 has become 40"]
    gone = whats(arm(more=a_link("hand") + a_joint("wrist", "upper", "hand")), text)
    assert gone[0] == "joint 'wrist' is gone"
    turned = whats(text, text.replace('xyz="0 1 0"', 'xyz="0 0 1"'))
    assert turned[0].startswith("axis ")


def test_what_leaves_the_dynamics_alone_is_no_change() -> None:
    """A massless frame on a fixed joint, and a link split in two."""
    frame = a_link("frame", "") + a_joint("mount", "upper", "frame", more='<origin xyz="1 2 3"/>', kind="fixed")
    assert not whats(arm(), arm(more=frame))


def test_the_torques_differ_as_much_as_the_mass() -> None:
    """All of the arm's torque is its inertia's, which is 10 % more."""
    before = arm()
    after = before.replace('iyy="0.02"', 'iyy="0.022"')
    (_, torques) = changes(robodyn.load(before.encode()), robodyn.load(after.encode()))
    assert torques.size == pytest.approx(1 - 1 / 1.1, rel=1e-12)


def test_limits_along_a_motion(tmp_path: Path) -> None:
    time = np.linspace(0.0, 2.0, 201)
    file = tmp_path / "swing.csv"
    rows = "\n".join(f"{t:.17g},{np.sin(t * 3):.17g}" for t in time)
    file.write_text(f"time,q_shoulder\n{rows}\n")
    results = found(ALONG.bad.encode(), "RD802", Asked(trajectory=str(file)))
    assert {one.bound for one in results} == {-0.5, 0.5}
    assert not found(ALONG.good.encode(), "RD802", Asked(trajectory=str(file)))
    assert not found(ALONG.bad.encode(), "RD802", Asked())


SAID = {"loads it as it is": "loads", "loads it with changes": "alters", "rejects it": "rejects"}


def verdict(text: str, target: str) -> str:
    (one,) = found(text.encode(), "RD901", Asked(targets=(target,)))
    said = one.message.removeprefix(f"{target} ")
    return next(name for start, name in SAID.items() if said.startswith(start))


LIMITED = '<axis xyz="0 1 0"/><limit lower="{}" upper="{}" effort="3" velocity="1"/>'
LOST = '<inertia ixx="0.01" ixy="0.05" ixz="0" iyy="0.02" iyz="0" izz="0.02"/>'
CASES = {
    "massless tip": arm(more=a_link("tip", "") + a_joint("j", "upper", "tip")),
    "equal": arm(LIMITED.format(1, 1)),
    "mimic": arm(
        more=a_link("tip") + a_joint("j", "upper", "tip", more=LIMITED.format(-1, 1) + '<mimic joint="shoulder"/>')
    ),
    "lost root": arm().replace('<link name="base"/>', a_link("base", f'<mass value="1"/>{LOST}')),
}


@pytest.mark.parametrize(("base", "velocities"), [("base", 7), ("world", 1)])
def test_drake_lets_the_root_float(base: str, velocities: int) -> None:
    parsing = peer("pydrake.multibody.parsing")
    plant = peer("pydrake.multibody.plant").MultibodyPlant(0.0)
    parsing.Parser(plant).AddModelsFromString(arm().replace('"base"', f'"{base}"'), "urdf")
    plant.Finalize()
    assert plant.num_velocities() == velocities


def test_mujoco_alters_as_we_say() -> None:
    based = arm().replace('<link name="base"/>', a_link("base"))
    assert verdict(based, "mujoco") == "alters"
    assert mujoco.MjModel.from_xml_string(based).body_mass.sum() == 2.0
    assert mujoco.MjModel.from_xml_string(CASES["equal"]).jnt_limited.tolist() == [False]
    assert mujoco.MjModel.from_xml_string(CASES["mimic"]).neq == 1


def test_every_target_has_a_verdict_with_a_source() -> None:
    assert {fact.target for fact in FACTS} == set(TARGETS)
    assert all(fact.source for fact in FACTS)
    results = found(path_of("talos_reduced").read_bytes(), "RD901", Asked(targets=TARGETS))
    assert len(results) == len(TARGETS)


def test_a_target_that_is_not_known_is_an_error() -> None:
    with pytest.raises(InputError, match="there is no target 'mujuco'"):
        Asked(targets=("mujuco",))


def test_the_command_passes_on_what_is_asked(versions: Path) -> None:
    outcome = run("check", str(versions), "--against", "HEAD", "--target", "kdl,drake", "--select", "RD9")
    assert outcome.status == 0
    assert "mass 2 kg has become 2.2 kg" in outcome.out
    assert "drake loads it with changes" in outcome.out
    assert "mujoco" not in outcome.out
    wrong = run("check", str(versions), "--target", "drak")
    assert (wrong.status, wrong.err.count("\n")) == (2, 1)
    assert "did you mean 'drake'?" in wrong.err
    missing = run("check", str(versions), "--trajectory", "none.csv")
    assert (missing.status, missing.err.count("\n")) == (2, 1)


def test_what_a_program_refuses_is_an_error_where_it_is_asked_for(tmp_path: Path) -> None:
    file = tmp_path / "robot.urdf"
    file.write_text(CASES["lost root"], encoding="utf-8")
    asked = run("check", str(file), "--target", "mujoco", "--select", "RD901")
    assert (asked.status, "error RD901" in asked.out) == (1, True)
    unasked = run("check", str(file), "--select", "RD901")
    assert (unasked.status, "note RD901" in unasked.out) == (0, True)


def test_without_being_asked_only_rejections_are_told() -> None:
    assert not found(arm().encode(), "RD901", Asked())
    (one,) = found(CASES["massless tip"].encode(), "RD901", Asked())
    assert one.what == "mujoco rejects it: it requires mass and inertia in what moves"
    assert one.subject is not None
    assert one.subject.kind == "link"


def test_without_being_asked_what_another_rule_tells_is_no_second_finding() -> None:
    for text, told in ((CASES["massless tip"], "RD202"), (arm().replace('izz="0.02"', 'izz="0.05"'), "RD207")):
        everything = found_in(text.encode(), Options(("ALL",))).shown
        assert told in {one.code for one in everything}
        assert "RD901" not in {one.code for one in everything}
    asked = found_in(CASES["massless tip"].encode(), Options(("ALL",), asked=Asked(targets=("mujoco",)))).shown
    assert {"RD202", "RD901"} <= {one.code for one in asked}
