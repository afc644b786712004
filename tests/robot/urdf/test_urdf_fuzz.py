"""Whatever the bytes are, only a DescriptionError of one line comes out; large descriptions take linear work."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable
from xml.sax.saxutils import quoteattr

import pytest
from helpers.counted_calls import calls
from hypothesis import example, given
from hypothesis import strategies as st

from robodyn.errors import DescriptionError
from robodyn.robot.load import load_description

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


LINKS = ["a", "b", "c", "d"]


@given(st.lists(st.tuples(st.sampled_from(LINKS), st.sampled_from(LINKS)), max_size=5))
def test_random_graphs_load_exactly_if_they_are_trees(edges: list[tuple[str, str]]) -> None:
    """Three edges between four links, one into each of three, all reached from the fourth."""
    text = graph(LINKS, [(parent, child, "") for parent, child in edges])
    reached, children = set(LINKS) - {child for _, child in edges}, {child for _, child in edges}
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

    small, large = text(250), text(1000)
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
