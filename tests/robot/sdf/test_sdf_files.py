"""What SDF includes, where it may be; worlds; and files that are broken, hostile or huge: one line, status 2."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
from helpers.command_line import run

from robodyn.errors import DescriptionError
from robodyn.robot.load import load_description

LINK = "<link name='a'/>"


def sdf(inside: str, version: str = "1.10") -> str:
    return f"<sdf version='{version}'>{inside}</sdf>"


def model(inside: str, name: str = "m") -> str:
    return f"<model name='{name}'>{inside}</model>"


def robot(inside: str, version: str = "1.10") -> str:
    return sdf(model(inside), version)


def include(uri: str, more: str = "") -> str:
    return f"<include><uri>{uri}</uri>{more}</include>"


def written(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def test_includes(tmp_path):
    written(tmp_path / "hand.sdf", sdf(model("\n\n\n\n<pose>9 9 9 0 0 0</pose>" + LINK, "hand")))
    versions = "<sdf version='1.5'>old.sdf</sdf><sdf version='1.10'>new.sdf</sdf>"
    written(tmp_path / "grip/model.config", f"<model>{versions}</model>")
    mesh = "<link name='a'><visual name='v'><geometry><mesh><uri>m.stl</uri></mesh></geometry></visual></link>"
    written(tmp_path / "grip/new.sdf", sdf(model(mesh, "grip")))
    written(tmp_path / "grip/m.stl", "")
    weld = "<joint name='j{0}' type='fixed'><parent>{1}</parent><child>{2}</child></joint>"
    text = LINK + "\n" + include("hand.sdf", "<pose relative_to='a'>0 0 1 0 0 0</pose>")
    text += "\n" + include("model://grip", "<name>left</name>") + "\n"
    text += include("grip", "<placement_frame>a</placement_frame><name>r</name>")
    joints = "".join(weld.format(k, "a", name) for k, name in enumerate(("hand::a", "left", "r::a")))
    found = load_description(written(tmp_path / "m.sdf", robot(text + joints)))
    assert [link.name for link in found.links] == ["a", "hand::a", "left::a", "r::a"]
    assert found.joints[0].origin.xyz == (0.0, 0.0, 1.0)
    assert found.links[2].geometries[0].filename == "grip/m.stl"
    lines = [(link.line, [shape.line for shape in link.geometries]) for link in found.links]
    assert lines == [(1, []), (2, []), (3, [3]), (4, [4])]  # of the file, not of those that it includes


def test_merged_includes(tmp_path):
    inner = "<pose>5 0 0 0 0 0</pose>" + LINK.replace("'a'", "'b'") + "<frame name='f'><pose>0 1 0 0 0 0</pose></frame>"
    written(tmp_path / "hand.sdf", sdf(model(inner, "hand")))
    joint = "<joint name='j' type='fixed'><pose relative_to='f'/><parent>a</parent><child>b</child></joint>"
    text = include("hand.sdf").replace("<include>", "<include merge='true'>")
    found = load_description(written(tmp_path / "m.sdf", robot(LINK + text + joint)))
    assert [link.name for link in found.links] == ["a", "b"]
    assert found.joints[0].origin.xyz == (5.0, 0.0, 0.0)


def test_worlds(tmp_path):
    ground = model("<static>true</static>" + LINK, "ground_plane")
    robot = model("<pose>0 0 0 1 0 0</pose>" + LINK, "robot")
    hold = "<joint name='h' type='fixed'><parent>world</parent><child>robot::a</child></joint>"
    found = load_description(sdf(f"<world name='w'>{ground}{robot}{include('model://sun')}{hold}</world>").encode())
    assert (found.name, found.root, [joint.name for joint in found.joints]) == ("robot", "world", ["h"])
    (left,) = [what for _, what in found.notes if "left out" in what]
    assert left == "left out, as nothing here is like it: 1 static model; model://sun, which is not found"
    for inside, what in (
        (robot + model(LINK, "other"), "the world has 2 models: 'robot', 'other'"),
        ("", "the world has 0 models"),
        (include("model://robot"), "'model://robot' is not found"),
    ):
        with pytest.raises(DescriptionError, match=what):
            load_description(sdf(f"<world name='w'>{inside}</world>").encode())


def test_what_lies_outside_is_not_included(tmp_path):
    written(tmp_path / "secret/hand.sdf", sdf(model(LINK, "hand")))
    written(tmp_path / "secret/model.config", "<broken, and not read")
    (tmp_path / "in").mkdir()
    os.symlink(tmp_path / "secret/hand.sdf", tmp_path / "in/link.sdf")
    os.symlink(tmp_path / "secret", tmp_path / "in/folder")
    config = "<model><sdf version='1.5'>../../secret/hand.sdf</sdf></model>"
    written(tmp_path / "in/config/model.config", config)
    relative = ("../secret/hand.sdf", "link.sdf", "folder/hand.sdf", "folder", "config", "model://folder/hand.sdf")
    for uri in (f"{tmp_path}/secret/hand.sdf", *relative):
        path = written(tmp_path / "in/m.sdf", robot(include(uri)))
        with pytest.raises(DescriptionError, match="is outside the folder of the description"):
            load_description(path)
    assert load_description(path, package_paths=[tmp_path / "secret"])
    for uri in ("http://a/b.sdf", "https://fuel.gazebosim.org/x", "file:///etc/passwd"):
        with pytest.raises(DescriptionError, match="is no file here"):
            load_description(written(tmp_path / "in/m.sdf", robot(include(uri))))


def test_circles_and_bombs_of_includes(tmp_path):
    written(tmp_path / "b.sdf", sdf(model(include("a.sdf"), "b")))
    with pytest.raises(DescriptionError, match=r"'a\.sdf' includes itself"):
        load_description(written(tmp_path / "a.sdf", sdf(model(include("b.sdf"), "a"))))
    for k in range(12):
        text = include(f"{k + 1}.sdf", "<name>x</name>") + include(f"{k + 1}.sdf", "<name>y</name>") if k < 11 else LINK
        written(tmp_path / f"{k}.sdf", sdf(model(text, f"m{k}")))
    with pytest.raises(DescriptionError, match="more than 500 files"):
        load_description(tmp_path / "0.sdf")
    assert len(load_description(tmp_path / "8.sdf").links) == 9


DEEP = "<model name='n'>" * 60 + LINK + "</model>" * 60
J = "<joint name='j' type='{}'><parent>{}</parent><child>{}</child>{}</joint>"
TWO = LINK + "<link name='b'/>"
WRONG = {
    "": "the file is empty",
    "<sdf>": "malformed XML",
    "<!DOCTYPE sdf [<!ENTITY a 'aaa'>]><sdf version='1.7'><model name='&a;'/></sdf>": "a document type",
    "<sdf version='1.7'><model name='&a;'/></sdf>": "entity",
    sdf(""): "has 0 models and worlds, not one",
    sdf(model(LINK) * 2): "has 2 models and worlds, not one",
    robot(LINK, "x"): "the version is 'x'",
    robot(""): "model 'm' has no link",
    sdf("<model>" + LINK + "</model>"): "<model> has no attribute 'name'",
    robot(DEEP): "models are nested more than 40 deep",
    "<a>" * 300: "the root element|malformed|nested more than",
    robot("<x>" * 300 + "</x>" * 300 + LINK): "nested more than 200 deep",
    robot(LINK * 2): "a second 'a', the first is in line 1",
    robot("<link name='world'/>"): "'world' is a name that SDF keeps",
    robot("<link name='a'><pose>1 2 3</pose></link>"): "<pose> of link 'a' has 3 numbers, not 6",
    robot("<link name='a'><pose>1 2 3 4 5 x</pose></link>"): "is not a number",
    robot("<link name='a'><pose>1e300 2 3 4 5 6</pose></link>"): "is too large",
    robot("<link name='a'><inertial><mass>1e31</mass></inertial></link>"): "is too large",
    robot("<link name='a'><inertial><mass>nan</mass></inertial></link>"): "is not finite",
    robot("<link name='a'><pose rotation_format='quat_xyzw'>0 0 0 0 0 0 0</pose></link>"): "quaternion of length 0",
    robot("<link name='a'><pose relative_to='x'/></link>"): "link 'a' names 'x', which does not exist",
    robot("<link name='a'><pose relative_to='a'/></link>"): "the pose of link 'a' hangs on itself",
    robot(
        "<link name='a'><pose relative_to='b'/></link><link name='b'><pose relative_to='a'/></link>"
    ): "hangs on itself",
    robot(LINK + "<frame name='f' attached_to='f'/>"): "the pose of frame 'f' hangs on itself",
    robot(TWO + J.format("revolute", "a", "b", "")): "joint 'j' has no <axis>|<joint>",
    robot(
        TWO + J.format("revolute", "a", "b", "<axis><xyz>0 0 0</xyz></axis>")
    ): "the axis of joint 'j' has the length 0",
    robot(TWO + J.format("revolut", "a", "b", "")): "unknown type 'revolut'",
    robot(TWO + J.format("fixed", "x", "b", "")): "joint 'j' names 'x', which does not exist",
    robot(TWO + J.format("fixed", "a", "a", "")): "joint 'j' ties 'a' to 'a'",
    robot(TWO + J.format("fixed", "", "a", "")): "joint 'j' has no <parent>, or an empty one",
    robot(
        TWO
        + J.format("revolute", "a", "b", "<axis><mimic joint='k'/></axis>")
        + J.format("fixed", "a", "b", "").replace("'j'", "'k'")
    ): ("joint 'j' mimics 'k', which has no coordinate"),
    robot(include("nothing.sdf")): "the included 'nothing.sdf' is not found",
    robot("<include/>"): "<include> in model 'm' has no <uri>",
    robot("<link name='a'><visual name='v'/></link>"): "<visual> of link 'a' has no <geometry>",
    robot("<link name='a'><visual name='v'><geometry><box/></geometry></visual></link>"): "has no <size>",
}


@pytest.mark.parametrize("text", WRONG, ids=lambda text: WRONG[text][:40])
def test_what_is_wrong_is_one_line(text, tmp_path):
    outcome = run("info", str(written(tmp_path / "m.sdf", text)))
    assert outcome.status == 2
    assert outcome.out == ""
    (line,) = outcome.err.splitlines()
    assert re.search(WRONG[text], line), line
    assert line.startswith("error: ")
    assert "m.sdf:" in line


def test_chains_of_thousands_of_frames_are_read():
    frames = "".join(f"<frame name='f{k}'><pose relative_to='f{k + 1}'>0 0 1 0 0 0</pose></frame>" for k in range(6000))
    text = LINK + frames + "<frame name='f6000'/><link name='b'><pose relative_to='f0'/></link>"
    found = load_description(robot(text + J.format("fixed", "a", "b", "")).encode())
    assert found.joints[0].origin.xyz == (0.0, 0.0, 6000.0)
