"""Links on another parent than their namesake's, and none where all hang alike."""

from __future__ import annotations

import pytest

from robodyn.checks.context import Context
from robodyn.checks.examples import two_elbows
from robodyn.checks.rules.placement import odd_parents
from robodyn.robot.urdf.document import read


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


LEGS = {
    f"{leg}_{part}": f"{leg}_{over}"
    for leg in ("FL", "FR", "RL", "RR")
    for part, over in (("thigh", "hip"), ("calf", "thigh"))
}
LEGS |= {f"{leg}_hip": "trunk" for leg in ("FL", "FR", "RL", "RR")}
ARMS = {"LeftArm": "torso", "RightArm": "torso", "LeftHand": "LeftArm", "RightHand": "RightArm", "torso": "base"}


@pytest.mark.parametrize("links", [LEGS, ARMS])
def test_nothing_where_all_hang_alike(links: dict[str, str]) -> None:
    assert found(links) == []


@pytest.mark.parametrize(
    ("links", "link", "parent", "expected"),
    [
        (LEGS, "FL_calf", "FR_thigh", ("FL_calf", "FL_thigh", None)),
        (LEGS, "RR_calf", "RR_hip", ("RR_calf", "RR_thigh", "RL_calf")),
        (LEGS, "RL_hip", "FL_hip", ("RR_hip", "FR_hip", "RL_hip")),
        (ARMS, "LeftHand", "RightArm", ("LeftHand", "LeftArm", None)),
    ],
)
def test_one_hung_elsewhere(links: dict[str, str], link: str, parent: str, expected: tuple[str, str, str]) -> None:
    """Where no name says the other side, both are named."""
    assert found({**links, link: parent}) == [expected]


def test_joints_at_other_places_are_a_design() -> None:
    text = two_elbows().replace('parent link="right_arm"', 'parent link="base"')
    assert len(list(odd_parents(Context(read(text.encode()))))) == 1
    assert not list(odd_parents(Context(read(text.replace("0.1 -0.05 0.3", "0.2 -0.05 0.3").encode()))))


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
