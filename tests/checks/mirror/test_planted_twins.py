"""Slips planted in one of two twin joints of published robots are found there, and nowhere else."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import cache
from itertools import islice
from math import pi
from pathlib import Path

import numpy as np
import pytest
from helpers.example_robots import path_of

from robodyn.checks.check import Options, check_one, found_in
from robodyn.checks.context import Context
from robodyn.checks.mirror import Pair, pairs
from robodyn.programs.vectors import rotation_from_rpy
from robodyn.robot.urdf.document import Span, read
from robodyn.robot.urdf.edits import Edit, edited
from robodyn.robot.urdf.view import JointView, value_span

OTHERS = {
    "rotated": ("g1_29dof_rev_1_0", "left_knee_joint", "RD405"),
    "half a turn": ("g1_29dof_rev_1_0", "right_hip_roll_joint", "RD405"),
    "of seven": ("talos_full_v2", "arm_left_6_joint", "RD404"),
}
ROBOTS = ("go2", "g1_29dof_rev_1_0", "talos_full_v2", "anymal", "solo12")
TWINS = Options(select=("RD404", "RD405"))
TALOS = ("talos_full_v2", "arm_left_4_link")
Edits = Iterator[tuple[Span, str]]


def _leg(side: str, sign: str) -> str:
    hip, knee, ankle = f"0 {sign}0.118 0", f"0 {sign}0.01 -0.3", "0 0 -0.3"
    rows = (("hip", "base", "thigh", hip), ("knee", f"{side}_thigh", "shank", knee))
    return "".join(
        f'''<link name="{side}_{link}"/><joint name="{side}_{joint}" type="continuous"><parent link="{parent}"/>
        <child link="{side}_{link}"/><origin xyz="{xyz}"/><axis xyz="0 1 0"/></joint>'''
        for joint, parent, link, xyz in (*rows, ("ankle", f"{side}_shank", "foot", ankle))
    )


LEGS = f'<robot name="legs"><link name="base"/>{_leg("left", "")}{_leg("right", "-")}</robot>'


def written(values: tuple[float, ...]) -> str:
    return " ".join(map(repr, values))


def sign_not_turned(pair: Pair, joint: JointView) -> Edits:
    x, y, z = pair.right_joint.origin.xyz
    if joint.origin.xyz.given and abs(y) > 0.01 and pair.D.round().tolist() == [[1, 0, 0], [0, -1, 0], [0, 0, 1]]:
        yield joint.origin.xyz.span, written((x, -y, z))


def point_shifted(pair: Pair, joint: JointView) -> Edits:
    """A decimal point slipped in the largest coordinate."""
    xyz = list(pair.right_joint.origin.xyz)
    k = max(range(3), key=lambda k: abs(xyz[k]))
    if joint.origin.xyz.given and abs(xyz[k]) > 0.05:
        xyz[k] /= 10
        yield joint.origin.xyz.span, written(tuple(xyz))


def turned_the_wrong_way(pair: Pair, joint: JointView) -> Edits:
    rpy = pair.right_joint.origin.rpy
    askew = [k for k in range(3) if 0.05 < abs(rpy[k]) % 1.5707963267948966 < 1.52]
    if joint.origin.rpy.given and askew:
        yield joint.origin.rpy.span, written(tuple(-angle if k == askew[0] else angle for k, angle in enumerate(rpy)))


def other_axis(pair: Pair, joint: JointView) -> Edits:
    if joint.axis.given:
        x, y, z = pair.right_joint.axis
        yield joint.axis.span, written((z, x, y))


def ends_of_the_other_side(pair: Pair, joint: JointView) -> Edits:
    """The range with both ends turned, where that is not the same."""
    limit = pair.right_joint.limit
    if joint.limit is None or limit is None or limit.lower is None or limit.upper is None:
        return
    if abs(limit.lower + limit.upper) > 0.1 and pair.right_joint.type == "revolute":
        yield joint.limit.lower.span, repr(-limit.upper)
        yield joint.limit.upper.span, repr(-limit.lower)


def weaker(pair: Pair, joint: JointView) -> Edits:
    if joint.limit is not None and pair.right_joint.limit is not None and pair.right_joint.limit.effort:
        yield joint.limit.effort.span, repr(pair.right_joint.limit.effort / 10)


def fixed(pair: Pair, joint: JointView) -> Edits:
    if pair.right_joint.type == "revolute":
        yield value_span(joint.element, "type"), "fixed"


KINDS: dict[Callable[[Pair, JointView], Edits], str] = {
    sign_not_turned: "RD405",
    point_shifted: "RD405",
    turned_the_wrong_way: "RD405",
    other_axis: "RD404",
    ends_of_the_other_side: "RD404",
    weaker: "RD404",
    fixed: "RD404",
}


@cache
def robot(name: str) -> tuple[bytes, Context]:
    data = LEGS.encode() if name == "LEGS" else Path(path_of(name)).read_bytes()
    return data, Context(read(data, name))


def planted(name: str, kind: Callable[[Pair, JointView], Edits]) -> Iterator[tuple[str, bytes]]:
    """Yield up to three right joints, each with the file in which the slip is planted there."""
    data, context = robot(name)
    every = ((pair, [*kind(pair, context.view.joint[pair.right_joint.name])]) for pair in context.once(pairs))
    some = ((pair, edits) for pair, edits in every if edits and pair.right_joint.type != "fixed")
    yield from ((pair.right_joint.name, replaced(data, edits)) for pair, edits in islice(some, 3))


def replaced(data: bytes, edits: Iterable[tuple[Span, str]]) -> bytes:
    return edited(data, [Edit(at.start, at.end, new) for at, new in edits], "utf-8")


@pytest.mark.parametrize("each", [1, pytest.param(3, marks=pytest.mark.slow)])
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_found_at_the_joint(kind: Callable[[Pair, JointView], Edits], each: int) -> None:
    cases = [(name, joint, text) for name in ROBOTS for joint, text in islice(planted(name, kind), each - 1, each)]
    robots = {name for name, _, _ in cases}
    assert len(robots) >= (1 if kind is turned_the_wrong_way else 3) or each > 1, robots
    for name, joint, text in cases:
        found = check_one(text, TWINS)
        names = {other.subject.name: other for other in found if other.subject is not None}
        twin = next(pair.left_joint.name for pair in robot(name)[1].once(pairs) if pair.right_joint.name == joint)
        assert names.keys() == ({joint} if kind is fixed else {joint, twin}), (name, joint)
        assert {other.code for other in found} == {KINDS[kind]}
        assert len(found) == len(names), "one for each of the two"
        one = names[joint]
        assert "twin" in one.message
        assert kind is not sign_not_turned or one.cause == "the sign of y is not that of a mirror image"
        assert one.remedy.startswith('write rpy="' if kind is turned_the_wrong_way else "correct the one of the two")


@pytest.mark.parametrize(("number", "slip"), [("0.118", "0.0118"), ("0.118", "0.128"), ("0.118", "1.18")])
def test_where_legs_are_all_there_is(number: str, slip: str) -> None:
    """Two legs and nothing else: they are mirrored in a plane between them, but not the base."""
    data = robot("LEGS")[0]
    assert check_one(data, TWINS) == ()
    text = data.replace(f'xyz="0 -{number} 0"'.encode(), f'xyz="0 -{slip} 0"'.encode())
    assert text != data
    found = {(one.code, one.subject.name) for one in check_one(text, TWINS) if one.subject is not None}
    assert found == {("RD405", "left_hip"), ("RD405", "right_hip")}


def heavier(name: str, link: str, factor: float, tensor: bool) -> bytes:
    """The robot with the mass of a link by a factor too large, to four digits; the tensor with it or not."""
    data, context = robot(name)
    inertial = context.view.link[link].inertial
    assert inertial is not None
    entries = [(each.span, repr((each.value or 0.0) * factor)) for each in inertial.entries if tensor]
    return replaced(data, [(inertial.mass.span, f"{(inertial.mass.value or 0.0) * factor:.4g}"), *entries])


@pytest.mark.parametrize(("factor", "unit"), [(2.20462, "it is in pounds"), (1000.0, "it is in grams")])
@pytest.mark.parametrize("tensor", [False, True])
@pytest.mark.parametrize(
    ("name", "link"), [("go2", "FL_calf"), ("solo12", "HR_UPPER_LEG"), pytest.param(*TALOS, marks=pytest.mark.slow)]
)
def test_a_mass_in_another_unit_is_named_at_the_one_that_has_it(
    name: str, link: str, tensor: bool, factor: float, unit: str
) -> None:
    found = found_in(heavier(name, link, factor, tensor), Options(select=("RD401", "RD208", "RD313"))).shown
    (one,) = [finding for finding in found if finding.code == "RD401"]
    assert one.subject is not None
    assert one.subject.name == link
    assert unit in (one.cause or "")
    assert link not in {finding.subject.name for finding in found if finding is not one and finding.subject}


@pytest.mark.parametrize("what", OTHERS)
def test_one_of_a_row_of_twins(what: str) -> None:
    """A frame turned by a right angle or two, with what hangs on it, is one finding, with the rpy that undoes it; so is
    one range of seven."""
    name, joint, code = OTHERS[what]
    data, context = robot(name)
    view = context.view.joint[joint]
    if code == "RD405":
        (r, p, y), by = view.origin.rpy.values or (0.0, 0.0, 0.0), pi / 2 if what == "rotated" else pi
        at, new = view.origin.rpy.span, written((r + by, p, y))
    else:
        assert view.limit is not None
        assert view.limit.upper.value is not None
        at, new = view.limit.upper.span, repr(0.5 * view.limit.upper.value)
    found = {one.subject.name: one for one in check_one(replaced(data, [(at, new)]), TWINS) if one.subject is not None}
    assert {one.code for one in found.values()} == {code}
    assert joint in found
    assert len(found) == 2, "and its twin"
    if code == "RD405":
        assert found[joint].measured == pytest.approx(by, rel=1e-3)
        rpy = tuple(map(float, found[joint].remedy.split('"')[1].split()))
        assert np.abs(rotation_from_rpy(*rpy) - rotation_from_rpy(r, p, y)).max() < 1e-3
