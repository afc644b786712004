"""`--payload LINK=KG[@X,Y,Z]` is a [[payload]] of the scene, in every command that takes one."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.command_line import motion, run, shown, write_arm

TORQUES = ("torques", "arm.urdf", "arm.csv")
SIMULATE = ("simulate", "arm.urdf", "--duration", "0.02")
FBD = ("fbd", "arm.urdf", "--at", "0.1,0.2")
EQUATIONS = ("equations", "arm.urdf", "--at", "0.1,0.2")
SCENE = '[[payload]]\nlink = "fore"\nmass = 2.5\ncom = [0.1, 0.0, 0.05]\n'
OPTION = ("--payload", "fore=2.5@0.1,0,0.05")


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_arm(tmp_path)
    Path("scene.toml").write_text(SCENE)
    Path("both.toml").write_text(SCENE + '[[payload]]\nlink = "upper"\nmass = 1\n')


def test_it_is_the_payload_of_a_scene() -> None:
    for call in (TORQUES, SIMULATE, FBD, EQUATIONS):
        text = shown(*call, *OPTION)
        assert text == run(*call, "--scene", "scene.toml").out
        assert text != run(*call).out
    Path("arm.urdf").write_text(Path("arm.urdf").read_text().replace('"fore"', '"a=b@c"'))
    assert run(*TORQUES, "--payload", "a=b@c=2.5@0.1,0,0.05").status == 0, "signs in names"


def test_it_is_added_to_those_of_the_scene_and_can_be_repeated() -> None:
    both = run(*TORQUES, "--scene", "both.toml").out
    assert run(*TORQUES, "--scene", "scene.toml", "--payload", "upper=1").out == both
    assert run(*TORQUES, *OPTION, "--payload", "upper=1").out == both


@pytest.mark.slow
def test_a_batch_has_it() -> None:
    Path("more.csv").write_text(motion(6))
    assert run("torques", "arm.urdf", "arm.csv", "more.csv", "--out", "a/", "--jobs", "1", *OPTION).status == 0
    for more, out in ((OPTION, "b.csv"), ((), "c.csv")):
        assert run(*TORQUES, "--out", out, "--executor", "numpy", *more).status == 0
    tables = [Path(path).read_text() for path in ("a/arm.csv", "b.csv", "c.csv")]
    batch, alone, without = (float(text.splitlines()[-1].split(",")[1]) for text in tables)
    assert abs(batch - alone) < 1e-12
    assert abs(alone - without) > 1
