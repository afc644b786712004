"""Bad descriptions: one clear line each, with the place and the words that help; whatever the bytes are, only a
DescriptionError of one line comes out; large descriptions take linear work."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from unittest.mock import Mock
from xml.sax.saxutils import quoteattr

import pytest
from helpers.counted_calls import calls
from hypothesis import example, given
from hypothesis import strategies as st

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


VALID = b"""<?xml version="1.0" encoding="utf-8"?>
<robot name="r" xmlns:x="u">
  <link name="a"><inertial><origin xyz="0 0 1"/><mass value="2"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><geometry><box size="1 2 3"/></geometry></visual></link>
  <link name="b"/> <link name="c"/> <!-- \xc3\xa9 -->
  <joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/><dynamics damping="1" friction="0"/></joint>
  <joint name="k" type="prismatic"><parent link="b"/><child link="c"/><mimic joint="j"/></joint>
  <transmission name="t"><joint name="j"/>
    <actuator><mechanicalReduction>5</mechanicalReduction></actuator></transmission>
</robot>
"""
TOKENS = [b"", b"<", b"/>", b'"', b"&", b"\0", b"\xff", b"nan", b"-1e999", b"${a}", b"x:", b"y:", b"0", b" "]
TOKENS += [b"<![CDATA[", b"a"]
ENCODINGS = [b"utf-8", b"utf-16", b"latin-1", b"cp037", b"utf-7", b"idna", b"rot13", b"hex", b"cp1006", b"big5"]
ENCODINGS += [b"\xff", b""]
TAGS = [
    "robot", "link", "joint", "inertial", "mass", "inertia", "origin", "visual", "collision", "geometry", "box", "mesh",
    "sphere", "cylinder", "parent", "child", "axis", "limit", "dynamics", "mimic", "transmission", "actuator",
    "mechanicalReduction", "rotorInertia", "gazebo", "x:y",
]  # fmt: skip
NAMES = [
    "name", "type", "link", "joint", "xyz", "rpy", "value", "ixx", "ixy", "ixz", "iyy", "iyz", "izz", "size", "radius",
    "length", "filename", "scale", "lower", "upper", "effort", "velocity", "damping", "friction", "multiplier",
]  # fmt: skip
VALUES = ["a", "b", "c", "", "0", "1", "-1e-3", "1 0 0", "0 0 0", "nan", "1,2", "1_0", "revolute", "fixed", "${a}"]
VALUES += ["é\n<"]


def survive(data: bytes) -> None:
    error = error_of(data)
    if error is not None:
        assert str(error).isprintable()
        assert error.line is not None
        assert 1 <= error.line <= len(data) + 1


def error_of(data: bytes) -> DescriptionError | None:
    try:
        load_description(data)
    except DescriptionError as error:
        return error
    return None


CHANGES = st.lists(
    st.tuples(st.integers(0, len(VALID)), st.integers(0, 30), st.sampled_from(TOKENS) | st.binary(max_size=3)),
    max_size=4,
)


@given(CHANGES, st.sampled_from(["utf-8", "utf-16", "utf-16-le", "utf-16-be", "utf-32"]), st.sampled_from(ENCODINGS))
@example([(160, 2, b"\x00\x0b")], "utf-32", b"utf-8")
def test_mutated_bytes_in_any_encoding_whatever_is_declared(
    changes: list[tuple[int, int, bytes]], encoding: str, declared: bytes
) -> None:
    data = VALID.replace(b"utf-8", declared, 1)
    data = data if encoding == "utf-8" else VALID.decode().replace('encoding="utf-8"', "").encode(encoding)
    for start, length, token in changes:
        data = data[:start] + token + data[start + length :]
    survive(data)


@given(st.binary(max_size=200))
@example(b"<\0")
@example(" <robot a:b='c'/>".encode("utf-16-be"))
@example(" <robot a:b='c'/>".encode("utf-16-le"))
@example(b"\xff\xfe")
@example(b"\xef\xbb\xbf")
def test_any_bytes(data: bytes) -> None:
    survive(data)


def element(tag: str, attributes: dict[str, str], children: list[str]) -> str:
    written = "".join(f" {name}={quoteattr(value)}" for name, value in attributes.items())
    return f"<{tag}{written}>{''.join(children)}</{tag}>"


ATTRIBUTES = st.dictionaries(st.sampled_from(NAMES), st.sampled_from(VALUES), max_size=5)
TREES = st.recursive(
    st.sampled_from(["", "1", " -2 ", "x", "<!-- -->"]),
    lambda children: st.builds(element, st.sampled_from(TAGS), ATTRIBUTES, st.lists(children, max_size=4)),
    max_leaves=25,
)


@given(st.lists(TREES, max_size=6), st.sampled_from([VALID, b"<robot name='r'></robot>"]))
def test_random_trees(trees: list[str], base: bytes) -> None:
    survive(base.replace(b"</robot>", "".join(trees).encode() + b"</robot>"))


NODES = ["a", "b", "c", "d"]


@given(st.lists(st.tuples(st.sampled_from(NODES), st.sampled_from(NODES)), max_size=5))
def test_random_graphs_load_exactly_if_they_are_trees(edges: list[tuple[str, str]]) -> None:
    """Three edges between four links, one into each of three, all reached from the fourth."""
    text = graph(NODES, [(parent, child, "") for parent, child in edges])
    reached, children = set(NODES) - {child for _, child in edges}, {child for _, child in edges}
    for _ in edges:
        reached |= {child for parent, child in edges if parent in reached}
    if len(edges) == len(children) == 3 and len(reached) == 4:
        assert len(load_description(text).joints) == 3
    else:
        assert error_of(text) is not None


def graph(links: Iterable[str], edges: Iterable[tuple[str, str, str]]) -> bytes:
    """Of continuous joints j0, j1, .. between parent and child, each with something inside."""
    joints = "".join(
        f"<joint name='j{i}' type='continuous'><parent link='{parent}'/><child link='{child}'/>{more}</joint>\n"
        for i, (parent, child, more) in enumerate(edges)
    )
    names = "".join(f"<link name='{name}'/>\n" for name in links)
    return f"<robot name='r'>\n{names}{joints}</robot>".encode()


def chain(n: int) -> bytes:
    return graph((f"l{i}" for i in range(n)), ((f"l{i}", f"l{i + 1}", "") for i in range(n - 1)))


def cycle(n: int) -> bytes:
    return graph((f"l{i}" for i in range(n)), ((f"l{i}", f"l{(i + 1) % n}", "") for i in range(n)))


def mimics(n: int) -> bytes:
    edges = ((f"l{i}", f"l{i + 1}", f"<mimic joint='j{(i + 1) % n}'/>") for i in range(n))
    return graph((f"l{i}" for i in range(n + 1)), edges)


def refused(text: bytes) -> str:
    with pytest.raises(DescriptionError) as caught:
        load_description(text)
    return str(caught.value)


def test_a_chain_of_10000_links_loads_in_any_order() -> None:
    head, *lines = chain(10_000).decode().splitlines()
    robot = load_description("\n".join([head, *reversed(lines[:-1]), lines[-1]]).encode())
    assert (len(robot.links), len(robot.joints), robot.root) == (10_000, 9_999, "l0")


def test_long_cycles_are_named_shortly() -> None:
    message = refused(cycle(1000))
    assert "1002: links are children of each other in a cycle: 'l0' -> 'l1' ->" in message
    assert "(1000 in all)" in message
    assert "'j0' -> 'j1' -> 'j2' -> 'j3' -> 'j4' -> 'j5' -> ... (1000 in all) -> 'j0'" in refused(mimics(1000))


def one_line_with_useless_transmissions(n: int) -> bytes:
    useless = "".join(f"<transmission><joint name='j{i}x'/></transmission>" for i in range(n))
    return chain(n).replace(b"</robot>", useless.encode() + b"</robot>").replace(b"\n", b"")


@pytest.mark.parametrize("text", [chain, cycle, mimics, one_line_with_useless_transmissions])
def test_work_grows_with_the_size(text: Callable[[int], bytes]) -> None:
    def load_or_refuse(data: bytes) -> None:
        with contextlib.suppress(DescriptionError):
            load_description(data)

    small, large = text(100), text(400)
    most, few = (calls(lambda each=each: load_or_refuse(each)).total() for each in (large, small))
    assert most <= 4.1 * few


def test_long_lines_and_attributes() -> None:
    size = 2_000_000
    long = b"x" * size
    mass = b"<robot name='r'><link name='a'><inertial><mass value='" + long + b"'/></inertial></link></robot>"
    assert f"({size} characters)" in refused(mass)
    assert load_description(b"<robot name='r'>" + b" " * size + b"<link name='a'/></robot>").root == "a"
    assert "unclosed token" in refused(b"<robot name='" + long)
    assert "attribute of 3000000 bytes; more than 2097152" in refused(b"<robot name='" + b"x" * 3_000_000 + b"'/>")
