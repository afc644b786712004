"""Links hung on another parent at random are found by the names of the others, and none where nothing was."""

from __future__ import annotations

import random
from collections.abc import Iterator
from functools import cache

import pytest
from helpers.example_robots import PATHS
from helpers.other_robots import other_paths

from robodyn.checks.context import Context
from robodyn.checks.rules.placement import Odd, odd_parents
from robodyn.robot.urdf.document import read
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.view import JointView

ROBOTS = ("hyq_no_sensors", "b1", "jvrc1", "g1_29dof_rev_1_0", "laikago", "xarm7", "tiago_dual", "allegro_left_hand")
"""Of those on which the thresholds were not chosen."""
HUNG = 12
"""Links of each."""


@cache
def data_of(robot: str) -> bytes:
    return next(path for path in [*PATHS, *other_paths()] if path.stem == robot).read_bytes()


def built(links: dict[str, str]) -> Context:
    """A robot of links on their parents."""
    names = dict.fromkeys((*links, *links.values()))
    joints = (
        f'<joint name="to_{child}" type="fixed"><parent link="{parent}"/><child link="{child}"/></joint>'
        for child, parent in links.items()
    )
    text = f'<robot name="r">{"".join(f"<link name={name!r}/>" for name in names)}{"".join(joints)}</robot>'
    return Context(read(text.encode(), "r.urdf"))


def found(links: dict[str, str]) -> list[tuple[str, str, str | None]]:
    return [(odd.link, odd.expected, odd.other) for odd in odd_parents(built(links))]


def rehung(data: bytes, joint: JointView, parent: str) -> Context:
    element = next(child for child in joint.element.children if child.tag == "parent")
    at = value_span(element, "link")
    return Context(read(data[: at.start] + parent.encode() + data[at.end :], "r.urdf"))


def hung_anywhere(robot: str) -> Iterator[tuple[JointView, tuple[Odd, ...]]]:
    """Yield moved links of a robot, each hung on a random link that does not hang on it, and what is then found."""
    rng, context = random.Random(robot), Context(read(data_of(robot), robot))
    moving = [joint for joint in context.view.joints if joint.moves]
    for joint in rng.sample(moving, min(HUNG, len(moving))):
        below = [joint.child]
        for name in below:
            below += [other.child for other in context.view.joints if other.parent == name]
        others = [link.name for link in context.view.links if link.name not in {*below, joint.parent}]
        if others:
            yield joint, odd_parents(rehung(data_of(robot), joint, rng.choice(others)))


def test_random_parents() -> None:
    """Of the moved links 90 in 100 are named, or one of two: 86 of 91, 74 of them alone, as measured."""
    named, of = 0, 0
    for robot in ROBOTS:
        for joint, odd in hung_anywhere(robot):
            of += 1
            named += any(joint.child in (one.link, one.other) for one in odd)
            assert all(joint.child in (one.link, one.other) for one in odd), (robot, joint.name, odd)
    assert of > 85
    assert named >= 0.9 * of, (named, of)


LEGS = {
    f"{leg}_{part}": f"{leg}_{over}"
    for leg in ("FL", "FR", "RL", "RR")
    for part, over in (("thigh", "hip"), ("calf", "thigh"))
}
LEGS |= {f"{leg}_hip": "trunk" for leg in ("FL", "FR", "RL", "RR")}
ARMS = {"LeftArm": "torso", "RightArm": "torso", "LeftHand": "LeftArm", "RightHand": "RightArm", "torso": "base"}
CHAIN = {f"link{k}": f"link{k - 1}" for k in range(2, 7)} | {"link1": "base"}
ROTORS = {f"rotor_{k}": "body" for k in range(4)} | {"camera": "body"}


@pytest.mark.parametrize("links", [LEGS, ARMS, CHAIN, ROTORS])
def test_nothing_where_all_hang_alike(links: dict[str, str]) -> None:
    assert found(links) == []


@pytest.mark.parametrize(
    ("links", "link", "parent", "expected"),
    [
        (LEGS, "FL_calf", "FR_thigh", "FL_thigh"),
        (LEGS, "RR_calf", "RR_hip", "RR_thigh"),
        (LEGS, "RL_hip", "FL_hip", "trunk"),
        (ARMS, "LeftHand", "RightArm", "LeftArm"),
        (CHAIN, "link4", "link1", "link3"),
        (CHAIN, "link6", "base", "link5"),
        (ROTORS, "rotor_2", "camera", "body"),
        (ROTORS, "rotor_3", "rotor_1", "body"),
    ],
)
def test_one_hung_elsewhere(links: dict[str, str], link: str, parent: str, expected: str) -> None:
    assert found({**links, link: parent}) == [(link, expected, None)]


def test_both_are_named_where_nothing_tells() -> None:
    assert found({**ARMS, "LeftFoot": "base", "RightFoot": "base", "LeftArm": "base"}) == [
        ("RightArm", "base", "LeftArm")
    ]


def test_two_and_two_are_a_design() -> None:
    """Cameras in front and behind stand on faces, those at the sides on the trunk: each has company."""
    cameras = {f"{side}_camera": "trunk" for side in ("left", "right")}
    faces = {f"{end}_camera": f"{end}_face" for end in ("front", "rear")} | {
        f"{k}_face": "trunk" for k in ("front", "rear")
    }
    more = {
        f"{k}_{what}": f"{k}_camera" for k in ("front", "rear", "left", "right") for what in ("lens", "optics", "led")
    }
    assert found({**cameras, **faces, **more}) == []
