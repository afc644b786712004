"""The process in which MuJoCo compiles: what reaches it, what comes of it, and that nothing else does."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from helpers.command_line import run

import robodyn
from robodyn.errors import DescriptionError, InputError
from robodyn.robot.mjcf import compiler
from robodyn.support import extras

pytest.importorskip("mujoco")
BODY = "<worldbody><body name='{}'>\n<joint name='j'/><geom size='.1'/></body></worldbody>"
ARM = f"<mujoco model='arm'>{BODY.format('upper')}</mujoco>"


def test_files_that_are_included_are_read_from_its_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "parts").mkdir()
    hand = BODY.format("hand").replace("'j'", "'k'")
    (tmp_path / "parts" / "hand.xml").write_text(f"<mujocoinclude>{hand}</mujocoinclude>")
    (tmp_path / "arm.xml").write_text(ARM.replace("</mujoco>", "<include file='parts/hand.xml'/></mujoco>"))
    monkeypatch.chdir(tmp_path)
    model = robodyn.load("arm.xml")
    assert (model.name, model.joint_names, sorted(model.links)) == ("arm", ("j", "k"), ["hand", "upper", "world"])
    links = {link.name: link.line for link in model.description.links}
    assert (links["hand"], links["upper"]) == (2, 1), "what is included is where it is included"
    assert (links["upper"], model.description.joints[0].line, model.description.format) == (1, 2, "mjcf")
    assert sorted(os.listdir()) == ["arm.xml", "parts"], "no log"


REFUSED = {
    "an include outside": ("<include file='../out.xml'/>", r"<include> of '../out.xml', outside of the folder"),
    "a link outside": ("<include file='link.xml'/>", r"outside of the folder"),
    "a nested include outside": ("<include file='nested.xml'/>", r"nested.xml:1: <include> of '.*, outside"),
    "a model outside": ("<asset><model file='../out.xml'/></asset>", r"<model> of '../out.xml', outside"),
    "an include that is not there": ("<include file='none.xml'/>", r"'none.xml', which is not there \(names are"),
    "a circle": ("<include file='arm.xml'/>", r"MuJoCo refuses it"),
    "an attribute": ("<option gravty='0 0 0'/>", r"arm.xml:2: MuJoCo refuses it: Schema violation: .*'gravty'"),
    "no XML": ("<option>", r"arm.xml:2: malformed XML"),
    "many bodies": (
        "<worldbody><replicate count='150'><replicate count='150'><body><geom size='1'/></body></replicate></replicate>"
        "</worldbody>",
        r"it has 22502 bodies, more than 20000",
    ),
}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name == "many bodies")) for name in REFUSED]
)
def test_what_is_refused(name: str, tmp_path: Path) -> None:
    more, message = REFUSED[name]
    folder = tmp_path / "in"
    folder.mkdir()
    (tmp_path / "out.xml").write_text("<mujocoinclude/>")
    (folder / "link.xml").symlink_to(tmp_path / "out.xml")
    (folder / "nested.xml").write_text(f"<mujocoinclude><include file='{tmp_path}/out.xml'/></mujocoinclude>")
    (folder / "arm.xml").write_text(ARM.replace("</mujoco>", f"{more}</mujoco>"))
    with pytest.raises(DescriptionError, match=message):
        robodyn.load(folder / "arm.xml")


def test_bombs_do_not_reach_it() -> None:
    bomb = "<!DOCTYPE m [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;'>]><mujoco>&b;</mujoco>"
    for text in (
        bomb,
        "<mujoco>" + "<a>" * 300,
        "<mujoco><worldbody/></mujoco>",
        "<mujoco><include file='x'/></mujoco>",
    ):
        with pytest.raises(DescriptionError):
            robodyn.load(text.encode())


def test_standard_input() -> None:
    done, wrong = (run("info", "-", stdin=text.encode()) for text in (ARM, ARM.replace("size", "sise")))
    assert (done.status, done.err) == (0, "")
    assert "upper" in done.out
    assert "check: nothing, as it comes from no file" in done.out
    assert (wrong.status, wrong.out, wrong.err.count("\n")) == (2, "", 1)
    assert "<stdin>:2: MuJoCo refuses it: Schema violation: unrecognized attribute: 'sise'" in wrong.err


def test_without_it_and_without_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiler, "PATIENCE", 0.001)
    with pytest.raises(DescriptionError, match="not done after"):
        robodyn.load(ARM.encode())
    monkeypatch.setattr(extras, "available", lambda module: module != "mujoco")
    with pytest.raises(InputError, match=r'MJCF files need mujoco-core \(pip install "robodyn\[mjcf\]"\)'):
        robodyn.load(ARM.encode())
