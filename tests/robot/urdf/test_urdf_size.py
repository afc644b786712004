"""Large descriptions: linear work, no recursion."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable

import pytest

from robodyn.errors import DescriptionError
from robodyn.robot.urdf.description import load_description


def chain(n: int, closed: bool = False) -> bytes:
    links = "".join(f"<link name='l{i}'/>\n" for i in range(n))
    joints = "".join(
        f"<joint name='j{i}' type='fixed'><parent link='l{i}'/><child link='l{(i + 1) % n}'/></joint>\n"
        for i in range(n if closed else n - 1)
    )
    return f"<robot name='chain'>\n{links}{joints}</robot>".encode()


def mimics(n: int) -> bytes:
    joints = "".join(
        f"<joint name='j{i}' type='continuous'><parent link='l{i}'/><child link='l{i + 1}'/>"
        f"<mimic joint='j{(i + 1) % n}'/></joint>\n"
        for i in range(n)
    )
    links = "".join(f"<link name='l{i}'/>" for i in range(n + 1))
    return f"<robot name='mimics'>{links}{joints}</robot>".encode()


def refused(text: bytes) -> str:
    with pytest.raises(DescriptionError) as caught:
        load_description(text)
    return str(caught.value)


def test_a_chain_of_10000_links_loads_in_any_order() -> None:
    head, *lines = chain(10_000).decode().splitlines()
    robot = load_description("\n".join([head, *reversed(lines[:-1]), lines[-1]]).encode())
    assert (len(robot.links), len(robot.joints), robot.root) == (10_000, 9_999, "l0")


@pytest.mark.slow
def test_cycles_of_10000_are_refused() -> None:
    message = refused(cycle(10_000))
    assert "10002: links are children of each other in a cycle: 'l0' -> 'l1' ->" in message
    assert "(10000 in all)" in message
    assert "'j0' -> 'j1' -> 'j2' -> 'j3' -> 'j4' -> 'j5' -> ... (10000 in all) -> 'j0'" in refused(mimics(10_000))


def calls(work: Callable[[], object]) -> int:
    """Calls of Python and C functions that the work makes."""
    count = 0

    def profile(frame: object, event: str, argument: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(profile)
    try:
        work()
    finally:
        sys.setprofile(before)
    return count


def cycle(n: int) -> bytes:
    return chain(n, closed=True)


def useless_transmissions(n: int) -> bytes:
    transmissions = "".join(f"<transmission><joint name='j{i}x'/></transmission>" for i in range(n))
    return chain(n).replace(b"</robot>", transmissions.encode() + b"</robot>")


def one_line(n: int) -> bytes:
    return chain(n).replace(b"\n", b"")


@pytest.mark.parametrize("text", [chain, cycle, mimics, useless_transmissions, one_line])
def test_work_grows_with_the_size(text: Callable[[int], bytes]) -> None:
    def load_or_refuse(data: bytes) -> None:
        with contextlib.suppress(DescriptionError):
            load_description(data)

    small, large = text(250), text(1000)
    assert calls(lambda: load_or_refuse(large)) <= 4.1 * calls(lambda: load_or_refuse(small))


def test_long_lines_and_attributes() -> None:
    size = 2_000_000
    long = b"x" * size
    mass = b"<robot name='r'><link name='a'><inertial><mass value='" + long + b"'/></inertial></link></robot>"
    assert f"({size} characters)" in refused(mass)
    assert load_description(b"<robot name='r'>" + b" " * size + b"<link name='a'/></robot>").root == "a"
    assert "unclosed token" in refused(b"<robot name='" + long)
    assert "attribute of 3000000 bytes; more than 2097152" in refused(b"<robot name='" + b"x" * 3_000_000 + b"'/>")
