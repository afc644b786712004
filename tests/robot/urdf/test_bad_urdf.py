"""Bad descriptions: one clear line each, with the place and the words that help."""

from __future__ import annotations

import os
from pathlib import Path
from unittest.mock import Mock

import pytest

from robodyn.errors import DescriptionError
from robodyn.robot.load import load_description

LINKS = "<link name='a'/><link name='b'/><link name='c'/>"


def robot(*lines: str) -> str:
    return "\n".join(["<robot name='r'>", *lines, "</robot>"])


def joint(inside: str = "", kind: str = "revolute", name: str = "j", parent: str = "a", child: str = "b") -> str:
    return f"<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>{inside}</joint>"


def inertial(inside: str) -> str:
    return robot("<link name='a'>", "<inertial>", inside, "</inertial></link>")


def shape(inside: str) -> str:
    return robot(f"<link name='a'><visual>\n<geometry>\n{inside}</geometry></visual></link>")


def arm(*joints: str) -> str:
    return robot(LINKS, *joints)


INERTIA = "<inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/>"
BOMB = "<!DOCTYPE x [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;&a;&a;'>]>\n"
EXTERNAL = "<!DOCTYPE x [<!ENTITY a SYSTEM 'file:///etc/passwd'>]>\n"

# name: (text or bytes, line, words of the message)
BAD: dict[str, tuple[str | bytes, int, tuple[str, ...]]] = {
    # not XML
    "empty": (b"", 1, ("empty",)),
    "blank": (b"\xef\xbb\xbf \r\n\t", 1, ("empty",)),
    "binary": (b"\x7fELF\x02\x01\x00\x00\x00", 1, ("binary",)),
    "plain text": ("joint names:\n q1", 1, ("malformed XML", "<robot>")),
    "truncated in an element": ("<robot name='r'>\n<link name='a'>\n", 3, ("no element found", "<link> of line 2")),
    "truncated in a tag": ("<robot name='r'>\n<link na", 2, ("unclosed token", "<robot> of line 1")),
    "mismatched tags": ("<robot name='r'>\n<link>\n</joint></robot>", 3, ("mismatched tag", "<link> of line 2")),
    "no quotes": ("<robot name=r/>", 1, ("malformed XML",)),
    "attribute twice": ("<robot name='r'\nname='s'/>", 2, ("duplicate attribute", "keep one")),
    "two roots": ("<robot name='r'/>\n<robot name='s'/>", 2, ("junk after document element",)),
    "declaration after a blank": (" <?xml version='1.0'?><robot/>", 1, ("declaration", "before <?xml")),
    "undefined entity": ("<robot name='r'>\n&nbsp;</robot>", 2, ("an entity", "&amp;")),
    "unknown encoding": ("<?xml version='1.0' encoding='klingon'?>\n<robot/>", 1, ("encoding", "UTF-8")),
    "wrong encoding": (b"<robot name='r'>\n<link name='\xff'/></robot>", 2, ("malformed XML",)),
    "half a UTF-16 character": ("<robot/>".encode("utf-16") + b"\0", 1, ("UTF-16",)),
    # not to be trusted
    "entity bomb": (BOMB + "<robot name='&b;'/>", 1, ("document type", "delete it")),
    "external entity": ("\n" + EXTERNAL + "<robot>&a;</robot>", 2, ("document type",)),
    "undeclared prefix": ("<robot name='r'>\n<sim:x/></robot>", 2, ("'sim:x'", "not declared", "xmlns:sim")),
    # not URDF
    "SDF": ("<!-- -->\n<sdf version='1.6'/>", 2, ("<sdf> has 0 models", "not one")),
    "xacro element": (robot("<xacro:arm side='left'/>"), 2, ("'xacro:arm'", "FILE.xacro")),
    "xacro expression": (robot("<link name='a'/>", "<link\nname='${side}_b'/>"), 4, ("'${side}_b'", "FILE.xacro")),
    "xacro substitution": (shape("<mesh filename='$(find p)/a.stl'/>"), 4, ("$(find p)", "FILE.xacro")),
    # names
    "robot without name": ("<robot>" + LINKS + "</robot>", 1, ("<robot>", "no attribute 'name'")),
    "no links": ("<robot name='r'>\n</robot>", 1, ("no links",)),
    "link without name": (robot("<link/>"), 2, ("<link>", "no attribute 'name'")),
    "joint without name": (arm("<joint type='fixed'/>"), 3, ("<joint>", "no attribute 'name'")),
    "duplicate link": (robot(LINKS, "<link name='b'/>"), 3, ("second link 'b'", "line 2", "rename")),
    "duplicate joint": (arm(joint(), joint(child="c")), 4, ("second joint 'j'", "line 3")),
    # numbers
    "NaN": (arm(joint("\n<origin xyz='0 nan 0'/>")), 4, ("'xyz'", "joint 'j'", "not finite", "0 nan 0")),
    "overflow": (inertial("<mass value='1e999'/>" + INERTIA), 4, ("not finite", "1e999")),
    "comma": (arm(joint("<origin xyz='0,1,0'/>")), 3, ("comma", "0,1,0", "blanks")),
    "two numbers": (arm(joint("<origin rpy='0 1'/>")), 3, ("'rpy'", "has 2 numbers, not 3")),
    "two masses": (inertial("<mass value='1 2'/>" + INERTIA), 4, ("has 2 numbers, not 1", "one number")),
    "a unit": (inertial("<mass value='2kg'/>" + INERTIA), 4, ("not a number", "2kg")),
    "other digits": (inertial("<mass value='\u0661'/>" + INERTIA), 4, ("U+0661", "write ASCII")),
    "hard blank": (arm(joint("<axis xyz='0 0\u00a01'/>")), 3, ("no-break space", "U+00A0")),
    "number in a later line of the tag": (arm(joint("<limit\nlower='0'\nupper='x'/>")), 5, ("'upper'", "'x'")),
    # links
    "no mass": (inertial(INERTIA), 3, ("<inertial> of link 'a'", "no <mass>")),
    "no inertia": (inertial("<mass value='1'/>"), 3, ("no <inertia>",)),
    "no iyy": (inertial("<mass value='1'/>\n" + INERTIA.replace("iyy='1'", "")), 5, ("no attribute 'iyy'",)),
    "two inertials": (robot("<link name='a'><inertial/>", "<inertial/></link>"), 3, ("2 <inertial>", "keep one")),
    "visual without geometry": (robot("<link name='a'>", "<visual/></link>"), 3, ("<visual> of link 'a'", "geom")),
    "geometry without shape": (shape(""), 3, ("no shape", "cylinder")),
    "unknown shape": (shape("<cilinder/>"), 3, ("unknown shape 'cilinder'", "did you mean 'cylinder'?")),
    "two shapes": (shape("<box size='1 1 1'/>\n<sphere radius='1'/>"), 5, ("2 shapes",)),
    "mesh without file": (shape("<mesh/>"), 4, ("<mesh> of link 'a'", "'filename'")),
    # joints
    "no type": (arm("<joint name='j'/>"), 3, ("joint 'j'", "no attribute 'type'")),
    "unknown type": (arm(joint(kind="Revolut")), 3, ("unknown type 'Revolut'", "did you mean 'revolute'?")),
    "no parent": (arm("<joint name='j' type='fixed'><child link='b'/></joint>"), 3, ("joint 'j'", "no <parent>")),
    "dangling parent": (arm(joint(parent="forarm")), 3, ("parent of joint 'j'", "'forarm'", "does not exist", "'a'")),
    "dangling child": (
        robot("<link name='forearm'/>", joint(parent="forearm", child="foream")),
        3,
        ("child of joint 'j'", "did you mean 'forearm'?"),
    ),
    "zero axis": (arm(joint("\n<axis xyz='0 -0 0.0'/>")), 4, ("axis of joint 'j'", "length 0", "direction")),
    "endless axis": (arm(joint("<axis xyz='1.7e308 1.7e308 0'/>")), 3, ("joint 'j'", "too large")),
    "axis without xyz": (arm(joint("<axis/>")), 3, ("<axis> of joint 'j'", "'xyz'")),
    "two origins": (arm(joint("<origin/>\n<origin/>")), 4, ("joint 'j' has 2 <origin>",)),
    # structure
    "several roots": (arm(joint()), 2, ("2 links have no parent: 'a', 'c'",)),
    "two parents": (arm(joint(), joint(name="k", parent="c")), 4, ("'b' is a child of two joints: 'j' (line 3)",)),
    "self loop": (arm(joint(child="a")), 3, ("cycle: 'a' -> 'a'",)),
    "all in a cycle": (
        robot(*LINKS.replace("><", ">|<").split("|"), joint(), joint(name="k", parent="b", child="c"),
              joint(name="l", parent="c", child="a")),
        5, ("cycle", "'a' -> 'b' -> 'c' -> 'a'"),
    ),
    "a cycle beside the tree": (
        arm(joint(parent="b", child="c"), joint(name="k", parent="c", child="b")), 3, ("cycle", "'b' -> 'c' -> 'b'"),
    ),
    "mimic without joint": (arm(joint("<mimic/>")), 3, ("<mimic> of joint 'j'", "'joint'")),
    "mimic of nothing": (
        arm(joint(name="left"), joint("\n<mimic joint='lefd'/>", name="k", child="c")),
        5, ("'k' mimics joint 'lefd'", "does not exist", "did you mean 'left'?"),
    ),
    "mimic of itself": (arm(joint("<mimic joint='j'/>"), joint(name="k", child="c")), 3, ("'j' mimics itself",)),
    "mimic in a cycle": (
        arm(joint("<mimic joint='k'/>"), joint("<mimic joint='j'/>", name="k", child="c")),
        3, ("mimic each other", "'j' -> 'k' -> 'j'"),
    ),
    # transmissions
    "reduction is no number": (
        robot("<link name='a'/><link name='b'/>", joint(), "<transmission name='t'><joint name='j'/>"
              "<actuator name='m'>\n<mechanicalReduction>fast</mechanicalReduction></actuator></transmission>"),
        5, ("<mechanicalReduction> of transmission 't'", "'fast'"),
    ),
    "two reductions": (
        robot("<link name='a'/><link name='b'/>", joint(), "<transmission name='t'><joint name='j'/>"
              "<mechanicalReduction>2</mechanicalReduction>\n<mechanicalReduction>3</mechanicalReduction></transmission>"),
        5, ("contradicts itself", "2 in line 4, then 3"),
    ),
}  # fmt: skip


def check(error: DescriptionError, file: str, line: int | None, words: tuple[str, ...]) -> None:
    message = str(error)
    assert type(error) is DescriptionError
    assert (error.file, error.line) == (file, line)
    assert message.isprintable()
    assert error.remedy
    for word in words:
        assert word in message


@pytest.mark.parametrize("name", BAD)
def test_bad_text(name: str) -> None:
    text, line, words = BAD[name]
    with pytest.raises(DescriptionError) as caught:
        load_description(text.encode() if isinstance(text, str) else text, name="bad.urdf")
    check(caught.value, "bad.urdf", line, words)


def test_missing_file_folder_and_odd_names(tmp_path: Path) -> None:
    for path, words in (
        (f"{tmp_path}/none.urdf", ("no such file", "check the name")),
        (f"{tmp_path}/none/none.urdf", ("no such file", "check the folder")),
        (f"{tmp_path}", ("a folder",)),
        ("/dev/zero", ("a device",)),
        ("<robot name='r'/>", ("no such file", "XML as bytes")),
        ("a\0b", ("not a file name",)),
        ("x" * 5000, ("cannot read",)),
    ):
        with pytest.raises(DescriptionError) as caught:
            load_description(path)
        check(caught.value, path, None, words)


def test_unreadable_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for failure, words in ((PermissionError(), "no permission"), (OSError(5, "I/O error"), "I/O error")):
        monkeypatch.setattr(os, "open", Mock(side_effect=failure))
        with pytest.raises(DescriptionError) as caught:
            load_description(f"{tmp_path}/a.urdf")
        check(caught.value, f"{tmp_path}/a.urdf", None, (words,))


def test_long_values_and_names_stay_short_in_messages() -> None:
    long = "x" * 100_000
    for text in (
        f"<{long}/>",
        f"<robot name='r'><{long}>",
        arm(joint(f"<axis xyz='{long}'/>")),
        arm(joint(kind=long)),
        robot(f"<link name='{long}'/><link name='{long}'/>"),
        robot(f"<link name='{long}'/><link name='b'/><link name='c'/>"),
        arm(joint(parent=long)),
        robot(f"<link name='{long}'/>", joint(parent=long, child=long)),
        arm(joint("<axis xyz='" + "1 " * 50_000 + "'/>")),
        arm(joint("<mimic/>", name=long)),
        shape(f"<{long}/>"),
        robot(*(f"<link name='{i}{long}'/>" for i in range(12))),
    ):
        with pytest.raises(DescriptionError) as caught:
            load_description(text.encode())
        assert len(str(caught.value)) < 1200
